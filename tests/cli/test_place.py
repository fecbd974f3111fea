"""The command ``place``: what can be placed, exit codes, files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from calling import called

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Any:
    """Call the command in a folder with a scene of two blocks, one that falls, and a mesh."""
    monkeypatch.chdir(tmp_path)
    blocks = [
        floor(0.4, 0.3),
        box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)),
        box("b", (0.05, 0.05, 0.05), 0.2, (0.1, 0, 0.025)),
    ]
    friction = hf.Friction(default=0.5, pairs={("a", "b"): 0.7, ("b", "floor"): 0.2})
    hf.save_scene(hf.Scene(blocks, friction, name="blocks"), "blocks.yaml")
    hf.save_scene(hf.Scene([floor(0.1, 0.1), box("a", (0.1, 0.1, 0.1), 1, (0.07, 0, 0.05))], 0.5), "falls.yaml")
    trimesh.creation.box((0.05, 0.04, 0.03)).export("brick.stl")

    def call(*arguments: object) -> tuple[int, str, str]:
        return called(monkeypatch, capsys, "place", *arguments, "--engine", "graph")

    return call


def test_a_mesh_is_placed_and_the_scene_saved(place: Any) -> None:
    code, out, err = place(
        "blocks.yaml", "brick.stl", "--mass", 0.3, "--supports", "a", "--save", "after.yaml", "--json"
    )
    assert (code, err) == (0, "")
    data = json.loads(out)
    assert data["verdict"] == "stable"
    assert data["details"]["contacts"][0]["bodies"] == ["a", "brick"]
    after = hf.load_scene("after.yaml")
    assert after.body("brick").pose == pytest.approx(np.array(data["rows"][0]["pose"]))
    assert after.body("brick").mass == 0.3
    assert hf.stability(hf.assemble(after)).status is hf.Status.STABLE
    assert {"engine", "robustness", "weakest", "attempts", "faults"} <= set(data["details"])
    assert {row["body"] for row in data["rows"]} == {"brick"}


def test_a_body_of_the_scene_is_moved_with_its_friction(place: Any) -> None:
    code, out, _ = place("blocks.yaml", "b", "--supports", "a", "--save", "after.yaml", "--json")
    assert code == 0
    after = hf.load_scene("after.yaml")
    assert after.body("b").pose[2, 3] == pytest.approx(0.125, abs=1e-6)
    assert json.loads(out)["details"]["contacts"][0]["mu"] == 0.7
    assert len(after.bodies) == 3


def test_a_body_of_another_file(place: Any) -> None:
    code, out, _ = place("cube", "blocks.yaml:b", "--from-above", "--box", "-0.05,-0.05,0.05,0.05")
    assert code == 0
    assert "stands" in out
    assert "touches cube" in out


def test_one_friction_of_several_objects(place: Any) -> None:
    code, out, err = place("cube", "blocks.yaml:a", "blocks.yaml:b", "--object-friction", 0.4, "--solves", 3, "--json")
    assert (code, err) == (0, "")
    assert {row["body"] for row in json.loads(out)["rows"]} == {"a", "b"}


def test_exit_codes_and_reasons(place: Any) -> None:
    code, out, _ = place("falls.yaml", "brick.stl", "--mass", 1)
    assert code == 1
    assert "does not stand" in out
    code, out, _ = place("blocks.yaml", "brick.stl", "--mass", 1, "--box", "5,5,6,6")
    assert code == 3
    assert "no place found" in out
    for arguments, words in (
        (("blocks.yaml", "brick.stl"), "--mass"),
        (("blocks.yaml", "nobody"), "no body named"),
        (("blocks.yaml", "b", "--mass", 1), "mesh files"),
        (("blocks.yaml", "b", "--box", "1,2,3"), "needs X0,Y0,X1,Y1 or"),
        (("blocks.yaml", "b", "--png", "x.jpg"), "does not end in .png"),
    ):
        code, out, err = place(*arguments)
        assert (code, out) == (2, "")
        assert words in err


def test_the_picture_shows_the_object(place: Any) -> None:
    image = pytest.importorskip("matplotlib.image", reason="pictures need matplotlib")
    assert place("blocks.yaml", "brick.stl", "--mass", 0.3, "--supports", "a", "--png", "p.png")[0] == 0
    pixels = image.imread("p.png")[..., :3]
    assert pixels.shape[1] > 1200
    blue = (pixels[..., 2] > pixels[..., 0] + 0.2) & (pixels[..., 2] > 0.6)
    assert blue[:, pixels.shape[1] // 2 :].mean() > 0.005
    assert blue[:, pixels.shape[1] // 2 :].sum() > 3 * blue[:, : pixels.shape[1] // 2].sum()


BARE = """
format: holdfast-scene/1
bodies:
  - {name: shelf, shape: {type: box, size: [0.6, 0.3, 0.02]}, position: [0, 0, -0.01], fixed: true, material: oak}
  - {name: book, shape: {type: box, size: [0.15, 0.21, 0.03]}, mass: 0.7, position: [-0.1, 0, 0.015]}
friction: {pairs: [{between: [oak, book], mu: 0.4}]}
"""
CUP = """
format: holdfast-scene/1
bodies:
  - {name: cup, shape: {type: cylinder, radius: 0.03, height: 0.08}, mass: 0.2, material: clay}
  - {name: foot, shape: {type: box, size: [1, 1, 1]}, position: [0, 0, -2], fixed: true}
friction: {default: 0.9}
"""


@pytest.mark.parametrize(
    ("said", "on_the_shelf", "on_the_book"),
    [(["0.3"], 0.3, 0.3), (["cup:oak=0.2", "0.3"], 0.2, 0.3), (["clay:oak=0.2", "clay:book=0.5"], 0.2, 0.5)],
)
def test_an_object_that_the_table_does_not_know_brings_its_friction(
    place: Any, said: list[str], on_the_shelf: float, on_the_book: float
) -> None:
    Path("bare.yaml").write_text(BARE)
    Path("cup.yaml").write_text(CUP)
    options = [part for each in said for part in ("--object-friction", each)]
    asked = ("bare.yaml", "cup.yaml:cup", "--candidates", 1, "--spacing", 0.04)
    code, _, told = place(*asked)
    assert code == 2, told
    assert "no friction of 'cup' with 'shelf'" in told
    assert "--object-friction MU" in told
    assert place(*asked, *options, "--save", "after.yaml")[0] == 0
    after = hf.load_scene("after.yaml")
    assert after.mu("cup", "shelf") == on_the_shelf
    assert after.mu("cup", "book") == on_the_book
    assert after.mu("book", "shelf") == 0.4
