"""Machine code on disk: never older than its sources, never run where damaged."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import holdfast
from holdfast.base.code_store import _CheckedFile
from holdfast.base.machine_code import compiled_sources

PACKAGE = Path(holdfast.__file__).parent

LIBRARY = """
from holdfast.base.compiled import compiled
from holdfast.toy.numbers import SHARE
@compiled
def share(x: float) -> float:
    return SHARE * x
"""
CALLER = """
from holdfast.base.compiled import compiled
from holdfast.toy.library import share
@compiled
def answer(x: float) -> float:
    return share(x) + 1.0
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A copy of ``base`` with a compiled function that calls another one in another file."""
    copy = tmp_path / "src" / "holdfast"
    shutil.copytree(PACKAGE / "base", copy / "base", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "__init__.py").write_text("")
    toy = copy / "toy"
    toy.mkdir()
    (toy / "__init__.py").write_text("")
    (toy / "numbers.py").write_text("SHARE = 2.0\n")
    (toy / "library.py").write_text(LIBRARY)
    (toy / "caller.py").write_text(CALLER)
    return copy


UNKNOWN = "import numba\nnumba.version_info = numba.version_info._replace(short=(9, 9))\n"


@pytest.fixture(params=["this", "unknown"])
def start(request: pytest.FixtureRequest) -> str:
    """What a process begins with: this version of Numba, or one whose internals holdfast does not know."""
    return "" if request.param == "this" else UNKNOWN


def run(package: Path, environment: Mapping[str, str] | None = None, start: str = "") -> tuple[float, int, str]:
    """``answer(3.0)`` in a new process, how many functions it had to compile, and what it said on stderr."""
    code = "from holdfast.toy.caller import answer\nprint(answer(3.0), sum(answer.stats.cache_misses.values()))\n"
    known = dict(os.environ, PYTHONPATH=str(package.parent), HOLDFAST_CACHE_DIR=str(package.parent / "cache"))
    known["PYTHONDONTWRITEBYTECODE"] = "1"  # Python takes a file of the same second and size for the same
    known |= environment or {}
    done = subprocess.run([sys.executable, "-c", start + code], env=known, capture_output=True, text=True, check=True)
    value, missed = done.stdout.split()
    return float(value), int(missed), done.stderr


def test_machine_code_is_found_again(package: Path, start: str) -> None:
    assert run(package, start=start)[:2] == (7.0, 1)
    assert run(package, start=start)[:2] == (7.0, 0)


@pytest.mark.parametrize(
    ("module", "old", "new", "expected"),
    [("library", "SHARE * x", "SHARE * x / 2", 4.0), ("numbers", "2.0", "5.0", 16.0)],
)
def test_a_change_in_another_file_changes_the_answer(
    package: Path, start: str, module: str, old: str, new: str, expected: float
) -> None:
    assert run(package, start=start)[0] == 7.0
    path = package / "toy" / f"{module}.py"
    path.write_text(path.read_text().replace(old, new))
    assert run(package, start=start)[0] == expected


@pytest.mark.parametrize("kind", ["nbc", "nbi"])
@pytest.mark.parametrize("damage", ["cut", "changed", "empty"])
def test_a_damaged_file_costs_a_compilation(package: Path, kind: str, damage: str) -> None:
    run(package)
    files = list((package.parent / "cache").rglob(f"caller*.{kind}"))
    assert len(files) == (2 if kind == "nbc" else 1)  # the function, and what Python calls it by
    for file in files:
        content = file.read_bytes()
        middle = len(content) // 2
        changed = content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :]
        file.write_bytes({"cut": content[:middle], "changed": changed, "empty": b""}[damage])
    value, missed, said = run(package)
    assert (value, missed) == (7.0, 1)
    if kind == "nbc" or damage != "changed":
        assert "compiled again" in said
    assert run(package) == (7.0, 0, "")


def test_what_two_processes_compile_at_once_is_not_mixed_up(tmp_path: Path) -> None:
    """One saves its code for another type between the moments at which the other names its file and writes it."""
    one, two = (_CheckedFile(str(tmp_path), "answer", "stamp") for _ in range(2))
    write = one._save_data

    def interrupted(name: str, data: object) -> None:
        (tmp_path / "answer.nbi").unlink()  # the other looked before there was an index
        two.save("of a matrix", "code for a matrix")
        write(name, data)

    one._save_data = interrupted
    one.save("of a number", "code for a number")
    assert two.load("of a matrix") == "code for a matrix"


def test_a_folder_that_cannot_be_written_is_said_once(package: Path, tmp_path: Path, start: str) -> None:
    (tmp_path / "file").write_text("")
    value, missed, said = run(package, {"HOLDFAST_CACHE_DIR": str(tmp_path / "file" / "below")}, start)
    assert (value, missed) == (7.0, 1)
    assert said.count("cannot be written") == 1
    assert "HOLDFAST_CACHE_DIR" in said


def test_a_folder_that_others_can_write_is_not_used(package: Path, start: str) -> None:
    """What another user put there would be run."""
    cache = package.parent / "cache"
    cache.mkdir()
    cache.chmod(0o777)
    for _ in range(2):
        value, _, said = run(package, start=start)
        assert value == 7.0
        assert said.count("may be written by others") == 1
        assert "chmod go-w" in said
    assert not [path for path in cache.rglob("*") if path.is_file()]


def test_others_cannot_enter_a_folder_of_numba_alone(package: Path) -> None:
    """Numba makes the folders below it with the mode that the user's umask gives."""
    run(
        package, start="import os, numba\nnumba.version_info = numba.version_info._replace(short=(9, 9))\nos.umask(0)\n"
    )
    (folder,) = (package.parent / "cache").iterdir()
    assert folder.stat().st_mode & 0o777 == 0o700


def test_the_sources_of_all_kernels_count() -> None:
    names = {path.relative_to(PACKAGE).as_posix() for path in compiled_sources(PACKAGE)}
    assert {"elastic/law.py", "elastic/newton.py", "base/compiled.py"} <= names


def test_of_many_folders_the_newest_stay(package: Path) -> None:
    cache = package.parent / "cache"
    for k in range(30):
        folder = cache / f"compiled-{k:02d}"
        folder.mkdir(parents=True)
        os.utime(folder, (k, k))
    run(package)
    made = {f"compiled-{k:02d}" for k in range(30)}
    left = {path.name for path in cache.iterdir()}
    assert len(left) == 16
    assert left & made == {f"compiled-{k}" for k in range(15, 30)}
