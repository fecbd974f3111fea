"""The commands are imported when they are called; what the help says of them is what they say of themselves."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from calling import Call

import holdfast as hf
from holdfast.cli.main import COMMANDS
from holdfast.scene.shipped.blocks import wall


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_begins_as_the_command_does(name: str) -> None:
    place, text = COMMANDS[name]
    module, _, function = place.partition(":")
    said = getattr(import_module(f"holdfast.cli.{module}"), function).__doc__
    assert said.split()[:3] == text.split()[:3]


def test_the_help_imports_no_engine() -> None:
    code = (
        "import sys; sys.argv = ['holdfast', '--help']\n"
        "from holdfast.cli.main import run\n"
        "try: run()\n"
        "except SystemExit: print([m for m in ("
        "'holdfast.native.core', 'numpy', 'scipy', 'trimesh', 'pydantic') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert all(name in done.stdout for name in COMMANDS)


def test_a_map_of_many_bodies_says_what_engine_limit_would_cost(call: Call, tmp_path: Path) -> None:
    """On stderr, so that the table and JSON are as they were; never where it is no choice."""
    path = tmp_path / "wall.yaml"
    many = wall(6, 5, 0.5, "wall")
    hf.save_scene(many, path)
    options = ("--bodies", many.movable[0].name, "--spacing", 1.0)
    told = call("map", path, *options)[2]
    assert f"{len(many.movable)} bodies hold each other here: --engine limit takes about" in told
    assert call("map", path, *options, "--engine", "limit")[2] == ""
    assert call("map", "table", "--spacing", 0.5)[2] == ""


def test_doctor_tells_versions_and_extras(monkeypatch: pytest.MonkeyPatch, call: Call) -> None:
    """An extra whose package is missing is named with the command that installs it."""
    monkeypatch.setattr("holdfast.cli.light_commands._version", lambda name: None if name == "pyarrow" else "1.2.3")
    code, out, _ = call("doctor", "--json")
    found = json.loads(out)["details"]
    assert code == 0
    assert {"core", "viewer", "tables"} <= set(found["packages"])
    assert "test" not in found["packages"]
    assert found["packages"]["core"]["numpy"] == "1.2.3"
    assert found["packages"]["tables"] == {"pyarrow": None}
    monkeypatch.setenv("COLUMNS", "120")
    assert "missing: pip install 'holdfast-robotics[tables]'" in call("doctor")[1]
