"""Every example and notebook runs from a clean folder, and the gallery of the site finds a picture for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").rglob("*.py"))
RUN = """
import pathlib, runpy, sys
site, *sys.argv = sys.argv[1:]
values = runpy.run_path(sys.argv[0], run_name="__main__")
if not list(pathlib.Path(sys.argv[1]).glob("*.png")):
    sys.path.insert(0, site)
    import gallery_bodies
    gallery_bodies.bodies_and_movers(values)
"""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(path: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", RUN, ROOT / "docs" / "_site", path, tmp_path]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 9
