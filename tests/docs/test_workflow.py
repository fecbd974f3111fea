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


def test_both_ends_of_the_range_of_numba_are_tested() -> None:
    assert WORKFLOW["jobs"]["numba"]["strategy"]["matrix"]["numba"] == ["oldest", "newest"]
    assert MAKE.findall(commands("numba")) == ["test-numba"]
    assert "\ntest-numba:\n" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_the_own_check_calls_what_readme_knows() -> None:
    called = MAKE.findall((ROOT / ".ci" / "run").read_text(encoding="utf-8"))
    assert called
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [target for target in called if f"make {target} " not in readme] == []
