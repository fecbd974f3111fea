"""The command ``rest``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import trimesh
from calling import column, command

rest = command("rest")


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "box.obj")
    return tmp_path / "box.obj"


def test_a_mesh_file_needs_no_more(rest: Any, mesh: Path, tmp_path: Path) -> None:
    code, out, err = rest(mesh, "--png", tmp_path / "poses.png")
    assert (code, err) == (0, "")
    assert "box: rests in 6 poses" in out
    assert "mesh files have no units" in " ".join(out.split())
    assert (tmp_path / "poses.png").stat().st_size > 10_000
    code, out, _ = rest(mesh, "--mass", 2, "--mu", 0.4, "--json")
    least = column(out, "least_push")
    assert (code, max(least)) == (0, pytest.approx(0.4 * 2 * 9.81))


def test_a_body_of_a_scene_has_its_own_mass(rest: Any) -> None:
    code, out, _ = rest("tabletop", "mug", "--json")
    assert (code, json.loads(out)["details"]["body"]["mass"]) == (0, 0.35)
    code, _, err = rest("tabletop")
    assert code == 2
    assert "has 7 bodies that can move: name one" in " ".join(err.split()).replace("; name", ": name")


def test_a_mass_of_zero_is_refused(rest: Any) -> None:
    code, _, err = rest("cube", "--mass", "0")
    assert code == 2
    assert "mass: is 0; needs a finite number > 0" in " ".join(err.split())


def test_friction_is_that_of_the_scene_unless_given(rest: Any, mesh: Path) -> None:
    for asked, mu in ((["--friction", 0.05], 0.05), (["--friction", 0.05, "--mu", 0.3], 0.3), ([], 0.5)):
        _, out, _ = rest(mesh, *asked, "--json")
        assert json.loads(out)["details"]["mu"] == mu
    _, out, _ = rest("cube", "--json")
    assert json.loads(out)["details"]["mu"] == 0.6
    assert json.loads(out)["details"]["body"]["name"] == "cube"
