"""What is to be in a wheel, and what the tool that builds wheels says of one that has something else."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import wheels

NAME = "holdfast_robotics-1.0"


def wheel(folder: Path, tag: str, core: str, *more: str) -> Path:
    """A wheel that has the committed files of the package without the sources of its core, a core, and more."""
    listed = subprocess.run(["git", "ls-files", "src"], cwd=wheels.ROOT, capture_output=True, text=True, check=True)
    files = [line.removeprefix("src/") for line in listed.stdout.splitlines()]
    kept = [each for each in files if not (each.startswith("holdfast/native/") and each.endswith(wheels.SOURCES))]
    path = folder / f"{NAME}-{tag}-linux_x86_64.whl"
    with zipfile.ZipFile(path, "w") as into:
        for each in [*kept, f"{wheels.CORE}{core}", f"{NAME}.dist-info/METADATA", *more]:
            into.writestr(each, "")
    return path


def test_folders_are_no_files_of_a_wheel(tmp_path: Path) -> None:
    whole = wheel(tmp_path, "cp311-cp311", "cpython-311-x86_64-linux-gnu.so", "holdfast/", f"{wheels.CORE}pyi")
    assert wheels.different(whole) == []
    assert wheels.different(wheel(tmp_path, "cp311-cp311", "so", "holdfast/left.py")) == ["holdfast/left.py"]


def test_the_core_of_a_wheel_for_later_pythons_is_for_the_stable_interface(tmp_path: Path) -> None:
    assert wheels.different(wheel(tmp_path, "cp312-abi3", "abi3.so")) == []
    alone = "cpython-312-x86_64-linux-gnu.so"
    assert wheels.different(wheel(tmp_path, "cp312-abi3", alone)) == [f"{wheels.CORE}{alone}", "0 compiled cores"]


def test_a_call_that_fails_is_told_with_what_it_printed() -> None:
    code = "import sys; print('to stdout'); sys.exit('to stderr')"
    with pytest.raises(subprocess.CalledProcessError) as failed:
        wheels.called(sys.executable, "-c", code)
    said = wheels.words(failed.value)
    assert "returned 1" in said
    assert "to stdout\nto stderr" in said.replace("\n\n", "\n")
