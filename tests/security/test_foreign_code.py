"""Machine code that others may have put there is never loaded: to load it is to run it."""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "holdfast"
STRANGER = 54321
TOY = """from holdfast.base.compiled import compiled

@compiled
def answer(x: float) -> float:
    return 2.0 * x

@compiled
def other(x: float) -> float:
    return 3.0 * x
"""

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs owners of files, as systems like Unix have")
as_root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    copy = tmp_path_factory.mktemp("made") / "src" / "holdfast"
    shutil.copytree(PACKAGE / "base", copy / "base", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "__init__.py").write_text("")
    (copy / "toy.py").write_text(TOY)
    assert run(copy) == ("6.0 9.0 2", "")
    assert run(copy) == ("6.0 9.0 0", "")
    return copy


@pytest.fixture
def package(made: Path, tmp_path: Path) -> Path:
    """A package with two compiled functions, and the folder in which they are kept."""
    shutil.copytree(made.parent, tmp_path / "src")
    return tmp_path / "src" / "holdfast"


def run(package: Path) -> tuple[str, str]:
    """What ``answer`` and ``other`` say, how many of them had to be compiled, and what is said on stderr."""
    code = "from holdfast.toy import answer, other\n"
    code += "print(answer(3.0), other(3.0), *[sum(sum(f.stats.cache_misses.values()) for f in (answer, other))])"
    known = {**os.environ, "PYTHONPATH": str(package.parent), "HOLDFAST_CACHE_DIR": str(cache(package))}
    done = subprocess.run([sys.executable, "-c", code], env=known, capture_output=True, text=True, check=True)
    return done.stdout.strip(), done.stderr


def cache(package: Path) -> Path:
    return package.parent / "cache"


def kept(package: Path, pattern: str) -> list[Path]:
    return sorted(cache(package).rglob(pattern))


class Command:
    """Runs a command when it is read, as any pickled value may."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.system, (self.text,)


def poison(package: Path, kind: str) -> Path:
    """Put a command into the kept files, with a checksum that fits; return the file that it would make."""
    mark = package.parent / "ran"
    content = pickle.dumps(Command(f"touch {mark}"))
    for path in kept(package, f"toy.*.{kind}"):
        path.write_bytes((hashlib.sha256(content).digest() if kind == "nbc" else b"") + content)
    return mark


@pytest.mark.parametrize("kind", ["nbc", "nbi"])
def test_the_poison_works_where_files_are_the_users_own(package: Path, kind: str) -> None:
    mark = poison(package, kind)
    run(package)
    assert mark.exists()


@as_root
@pytest.mark.parametrize("kind", ["nbc", "nbi"])
def test_files_of_others_are_dropped_and_compiled_again(package: Path, kind: str) -> None:
    mark = poison(package, kind)
    for path in kept(package, f"toy.*.{kind}"):
        os.chown(path, STRANGER, STRANGER)
    said, told = run(package)
    assert said == "6.0 9.0 2"
    assert f"belongs to user {STRANGER}" in told
    assert not mark.exists()
    assert run(package) == ("6.0 9.0 0", "")


@pytest.mark.parametrize(
    ("level", "who"),
    [(0, "all"), (1, "group"), (2, "all"), *(pytest.param(k, "stranger", marks=as_root) for k in (0, 2))],
)
def test_a_folder_that_others_may_write_is_not_used_and_that_is_said_once(package: Path, level: int, who: str) -> None:
    mark = poison(package, "nbc")
    folder = kept(package, "toy.answer*.nbc")[0].parents[level]
    if who == "stranger":
        os.chown(folder, STRANGER, STRANGER)
    else:
        folder.chmod(0o775 if who == "group" else 0o777)
    before = kept(package, "*")
    said, told = run(package)
    assert said == "6.0 9.0 2"
    assert not mark.exists()
    assert told.count("every process compiles for itself") == 1, told
    assert str(folder) in told
    assert "HOLDFAST_CACHE_DIR" in told
    assert kept(package, "*") == before, "nothing is left there"


def test_what_is_kept_can_be_used_again_where_new_files_are_for_a_group(package: Path) -> None:
    """Under the umask 002, which some systems set, files that are made may be written by a group: not these."""
    shutil.rmtree(cache(package))
    before = os.umask(0o002)
    try:
        assert run(package) == ("6.0 9.0 2", "")
        assert run(package) == ("6.0 9.0 0", "")
    finally:
        os.umask(before)
