"""The workflow asks for what pyproject.toml and the Makefile have, and the own check for what README knows."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8"))
MAKE = re.compile(r"^make ([\w-]+)", re.MULTILINE)


def commands(job: str) -> str:
    return "\n".join(step["run"] for step in WORKFLOW["jobs"][job]["steps"] if "run" in step)


def test_every_python_of_the_metadata_is_tested() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [line.rpartition(" ")[2] for line in project["classifiers"] if re.search(r":: 3\.\d+$", line)]
    assert WORKFLOW["jobs"]["test"]["strategy"]["matrix"]["python"] == named
    assert project["requires-python"] == f">={named[0]}"
    assert MAKE.findall(commands("test")) == ["test"]


def test_wheels_are_for_every_python_and_tried_with_both_ends_of_numpy() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "wheels.yml").read_text(encoding="utf-8"))
    job = workflow["jobs"]["wheels"]
    assert {name.partition("-")[0] for name in job["strategy"]["matrix"]["os"]} == {"ubuntu", "macos", "windows"}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["tool"]["cibuildwheel"]["build"] == "cp311-* cp312-*"  # the latter for all later ones, too
    assert project["tool"]["scikit-build"]["wheel"]["py-api"] == "cp312"
    assert any("numpy==2.0.*" in command for command in project["tool"]["cibuildwheel"]["test-command"])


def test_the_own_check_calls_what_readme_knows() -> None:
    called = MAKE.findall((ROOT / ".ci" / "run").read_text(encoding="utf-8"))
    assert called
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [target for target in called if f"make {target} " not in readme] == []
