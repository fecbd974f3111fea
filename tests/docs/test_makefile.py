"""The Makefile finds a Python that is recent enough, whatever it is called (finding X4)."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MAKE = shutil.which("make")

pytestmark = pytest.mark.skipif(MAKE is None, reason="there is no make on this system")


def make(folder: Path, names: dict[str, bool], *arguments: str) -> subprocess.CompletedProcess[str]:
    """Call make where the only programs are pythons of these names, recent enough or not."""
    programs = folder / "programs"
    programs.mkdir()
    for name, recent in names.items():
        content = f'#!/bin/sh\nexec {sys.executable} "$@"\n' if recent else "#!/bin/sh\nexit 1\n"
        (programs / name).write_text(content)
        (programs / name).chmod(0o755)
    assert MAKE is not None
    command = [MAKE, "-f", str(ROOT / "Makefile"), f"VENV={folder / 'venv'}", *arguments, "lint"]
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("MAKE", "PYTHON"))}
    return subprocess.run(
        command, cwd=ROOT, env=environment | {"PATH": str(programs)}, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ({"python3.11": True, "python3": True}, "python3.11"),
        ({"python3": True}, "python3"),
        ({"python3": False, "python3.13": True}, "python3.13"),
        ({"python3.11": False, "python": True}, "python"),
    ],
)
def test_x4_a_python_that_is_recent_enough_is_found(names: dict[str, bool], found: str, tmp_path: Path) -> None:
    assert f"\n{found} -m venv " in make(tmp_path, names, "-n").stdout


@pytest.mark.parametrize("names", [{}, {"python3": False, "python3.11": False}])
def test_x4_without_one_the_message_says_what_to_do(names: dict[str, bool], tmp_path: Path) -> None:
    done = make(tmp_path, names)
    assert done.returncode != 0
    assert "needs Python 3.11 or later: install one, or name it, as in make lint PYTHON=" in done.stdout
    assert not (tmp_path / "venv").exists()
