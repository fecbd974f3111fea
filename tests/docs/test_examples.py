"""Every example and notebook runs from a clean folder, and the gallery of the site finds a picture for it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
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
    assert gallery_bodies.bodies_and_movers(values) is not None
"""
NAMES = re.compile(r'^(?:import|from) (\w+)|(?:import_module|find_spec)\("(\w+)"\)', re.MULTILINE)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(path: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", RUN, ROOT / "docs" / "_site", path, tmp_path]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def installed(extra: str, extras: dict[str, list[str]]) -> set[str]:
    """The names of the packages that an extra installs, with those of the extras that it names."""
    found: set[str] = set()
    for requirement in extras[extra]:
        name, _, rest = requirement.partition("[")
        more = rest.partition("]")[0].split(",") if name == "holdfast-robotics" else []
        found |= {re.split("[^a-zA-Z0-9-]", name)[0].lower()}.union(*(installed(each, extras) for each in more))
    return found


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_extra_of_the_site_installs_what_an_example_imports(path: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = {**project["optional-dependencies"], "itself": project["dependencies"]}
    there = {*installed("docs", extras), *installed("itself", extras), "holdfast", *sys.stdlib_module_names}
    named = {name for found in NAMES.findall(path.read_text()) for name in found if name}
    assert {name.lower() for name in named} <= there


def test_an_example_whose_package_is_missing_has_no_picture_and_no_error(tmp_path: Path) -> None:
    lacking = RUN.replace("site, *", "sys.modules['mujoco'] = None\nsite, *").replace("is not None", "is None")
    path = ROOT / "examples" / "16_monitor_mujoco.py"
    command = [sys.executable, "-W", "error", "-c", lacking, ROOT / "docs" / "_site", path, tmp_path]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stderr
    assert "mujoco" in done.stdout.lower()


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 9
