"""The list of deliberate breaks fits the sources, and the tool that tries them tells caught from survived."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

import mutants

LIST = """
tests = ["tests/test_toy.py"]

[[break]]
name = "sum-sign"
file = "src/toy/sums.py"
old = "a + b"
new = "a - b"
stands_for = "A difference for a sum."

[[break]]
name = "product"
file = "src/toy/sums.py"
old = "a * b"
new = "a / b"
stands_for = "A quotient for a product, which no test asks for."

[[break]]
name = "endless"
file = "src/toy/sums.py"
old = "while False:"
new = "while True:"
stands_for = "A loop that never ends."
tests = ["tests/test_toy.py::test_loop"]
"""
SOURCE = (
    "import time\n\n\ndef add(a, b):\n    return a + b\n\n\ndef times(a, b):\n    return a * b\n\n\n"
    "def loop():\n    while False:\n        time.sleep(1)\n    return 1\n"
)
TESTS = """
import pytest
from toy.sums import add, loop

@pytest.mark.parametrize("b", [1, 2, 0])
def test_add(b):
    assert add(1, b) == 1 + b

def test_loop():
    assert loop() == 1

@pytest.mark.slow
def test_of_another_round():
    assert False
"""
SETTINGS = '[tool.pytest.ini_options]\nmarkers = ["slow", "referee"]\n'


@pytest.fixture
def toy(tmp_path: Path) -> Path:
    files = {
        "tools/mutants/sums.toml": LIST, "src/toy/__init__.py": "", "src/toy/sums.py": SOURCE,
        "tests/test_toy.py": TESTS, "pyproject.toml": SETTINGS,
    }  # fmt: skip
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=tmp_path, check=True)
    return tmp_path


def test_the_list_fits_the_sources() -> None:
    found = mutants.breaks(mutants.ROOT)  # raises if a name is there twice, or words are gone
    assert len(found) >= 80
    assert all(one.stands_for.endswith(".") for one in found)


def test_caught_survived_and_out_of_time(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mutants.main(["run", "--limit", "20", "--jobs", "2"], toy) == 1
    caught, survived, endless, *_, last = capsys.readouterr().out.splitlines()
    assert caught == "caught sum-sign by 1 tests: tests/test_toy.py::test_add (2)"
    assert survived == "survived product"
    assert endless == "caught endless by 0 tests: out of time"
    assert last == "caught 2, survived: 1"
    assert (toy / "src/toy/sums.py").read_text() == SOURCE


def test_all_caught_is_success(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mutants.main(["run", "sum-sign"], toy) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "caught 1, survived: 0"


def test_a_copy_that_fails_unbroken_proves_nothing(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (toy / "tests/test_toy.py").write_text(TESTS.replace("== 1 + b", "== 2 + b"))
    assert mutants.main(["run", "product"], toy) == 2
    assert "unbroken copy does not pass its tests: tests/test_toy.py::test_add (3)" in capsys.readouterr().err
    (toy / "tests/test_toy.py").write_text("import nothing_of_that_name")
    assert mutants.main(["run", "product"], toy) == 2
    assert "tests/test_toy.py" in capsys.readouterr().err


@pytest.mark.parametrize(("old", "new", "says"), [
    ('"a * b"', '"b * a"', "product: its words are 0 times"),
    ('"a * b"', '"return"', "product: its words are 3 times"),
    ('"a / b"', '"(a * b)"', "product: changes nothing but how"),
    ('"a / b"', '"a /"', "product: leaves src/toy/sums.py with a syntax error"),
    ('"product"', '"sum-sign"', "sum-sign: is there twice"),
    ("src/toy/sums.py", "src/toy/gone.py", "product: there is no src/toy/gone.py"),
    ("tests/test_toy.py::test_loop", "tests/test_gone.py", "endless: there is no tests/test_gone.py"),
    ('stands_for = "A loop that never ends."', "", "endless: missing or unknown: stands_for"),
    ('new = "a / b"', 'now = "a / b"', "product: missing or unknown: new, now"),
])  # fmt: skip
def test_a_list_that_does_not_fit_is_told_before_anything_runs(
    toy: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, says: str
) -> None:
    (toy / "tools/mutants/sums.toml").write_text(LIST.replace(old, new))
    assert mutants.main(["run"], toy) == 2
    told = capsys.readouterr()
    assert says in told.err
    assert told.out == ""


def test_what_is_listed_and_drawn(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mutants.main(["list"], toy) == 0
    first, second, third, *_ = capsys.readouterr().out.splitlines()
    assert (first, second) == ("sums (3)", "  sum-sign  src/toy/sums.py")
    assert third == "    A difference for a sum."
    drawn = set()
    for seed in range(20):
        assert mutants.main(["list", "--sample", "1", "--seed", str(seed)], toy) == 0
        head, name, *_ = capsys.readouterr().out.splitlines()
        assert head == "sums (1)"
        drawn.add(name.split()[0])
    assert drawn == {"sum-sign", "product", "endless"}
    assert mutants.main(["list", "--rooms", "none"], toy) == 2
    assert "known are sums" in capsys.readouterr().err


NATIVE_LIST = """
tests = ["tests/test_native.py"]

[[break]]
name = "quotient"
file = "src/holdfast/native/core.hpp"
old = "a * 2"
new = "a / 2"
stands_for = "Half for twice."

[[break]]
name = "sum-of-both"
file = "src/holdfast/native/core.cpp"
old = "return twice(a);"
new = "return twice(a) + 0;"
stands_for = "Nothing that anybody could see."
"""
NATIVE = {
    "tools/mutants/core.toml": NATIVE_LIST,
    "src/holdfast/__init__.py": "",
    "src/holdfast/native/__init__.py": "",
    "src/holdfast/native/core.hpp": "inline int twice(int a) { return a * 2; }\n",
    "src/holdfast/native/core.cpp": '#include "core.hpp"\nextern "C" int doubled(int a) {\n    return twice(a);\n}\n',
    "src/holdfast/native/CMakeLists.txt": (
        "cmake_minimum_required(VERSION 3.18...4.0)\nproject(toy LANGUAGES CXX)\nadd_library(core MODULE core.cpp)\n"
        'set_target_properties(core PROPERTIES PREFIX "" SUFFIX ".so"\n'
        '                      LIBRARY_OUTPUT_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")\n'
    ),
    "tests/test_native.py": (
        "import ctypes\nfrom pathlib import Path\nimport holdfast.native\n\n\ndef test_doubled():\n"
        "    core = ctypes.CDLL(Path(holdfast.native.__file__).with_name('core.so'))\n    assert core.doubled(4) == 8\n"
    ),
    ".gitignore": "core.so\n",
}


@pytest.fixture
def native(toy: Path) -> Path:
    if not (shutil.which("cmake") and shutil.which("c++")):
        pytest.skip("needs cmake and a compiler")
    for name, text in NATIVE.items():
        (toy / name).parent.mkdir(parents=True, exist_ok=True)
        (toy / name).write_text(text)
    source = toy / "src/holdfast/native"
    command = ["c++", "-shared", "-fPIC", "-o", str(source / "core.so"), str(source / "core.cpp")]
    subprocess.run(command, check=True)
    return toy


def test_breaks_of_the_core_are_compiled(native: Path, capsys: pytest.CaptureFixture[str]) -> None:
    core = native / "src/holdfast/native/core.so"
    compiled = core.read_bytes()
    assert mutants.main(["run", "--rooms", "core", "sums", "--limit", "20"], native) == 1
    caught, survived, after, *_ = capsys.readouterr().out.splitlines()
    assert caught == "caught quotient by 1 tests: tests/test_native.py::test_doubled"
    assert survived == "survived sum-of-both"  # so the break before it was repaired, and its object with it
    assert after == "caught sum-sign by 1 tests: tests/test_toy.py::test_add (2)"
    assert core.read_bytes() == compiled


def test_a_broken_core_that_does_not_compile_is_an_error_of_the_list(
    native: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (native / "tools/mutants/core.toml").write_text(NATIVE_LIST.replace('"a / 2"', '"a / two"'))
    assert mutants.main(["run", "quotient", "--trust"], native) == 2
    said = capsys.readouterr()
    assert "quotient: the broken core does not compile" in said.err
    assert "two" in said.err
    assert not said.out


def test_a_checkout_without_a_core_proves_nothing(native: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (native / "src/holdfast/native/core.so").unlink()
    assert mutants.main(["run", "quotient", "--trust"], native) == 2
    assert "there is no compiled core" in capsys.readouterr().err
