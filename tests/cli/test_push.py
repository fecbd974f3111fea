"""``holdfast push``: the headline question as a command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calling import Call, column

import holdfast as hf

SIDE = ("--at", "-0.05", "0", "0.05", "--along", "1", "0", "0")


def test_a_cube_is_pushed_and_the_answer_is_that_of_the_library(call: Call) -> None:
    code, text, _ = call("push", "cube", "cube", *SIDE)
    assert code == 0
    assert "5.886 N before something moves" in text
    assert "proved to hold up to 5.8" in text
    assert "above" in text
    code, text, _ = call("push", "cube", "cube", *SIDE, "--engine", "limit", "--json")
    found = hf.robustness(hf.assemble(hf.shipped_scene("cube")), "cube", (-0.05, 0, 0.05), (1, 0, 0), engine="limit")
    assert code == 0
    assert column(text, "force") == pytest.approx(found.force.tolist())


def test_points_and_directions_may_be_the_bodys_own(call: Call, tmp_path: Path) -> None:
    pose = np.array([[0.0, -1, 0, 3], [1, 0, 0, 2], [0, 0, 1, 0.05], [0, 0, 0, 1]])
    box = hf.Body("box", hf.Box((0.2, 0.1, 0.1)), mass=1, pose=pose)
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), box], 0.4)
    hf.save_scene(scene, tmp_path / "scene.yaml")
    where = ("push", str(tmp_path / "scene.yaml"), "box", "--engine", "limit", "--json")
    _, own, _ = call(*where, "--local", "--at", "-0.1", "0.02", "0", "--along", "1", "0.1", "0")
    _, world, _ = call(*where, "--at", "2.98", "1.9", "0.05", "--along", "-0.1", "1", "0")
    assert column(own, "force") == pytest.approx(column(world, "force"), rel=1e-9)
    assert column(own, "point") == [pytest.approx([2.98, 1.9, 0.05])]


def test_uncertain_poses_lower_what_is_promised(call: Call) -> None:
    sure, unsure = (
        column(call("push", "cube", "cube", *SIDE, "--engine", "limit", "--json", *more)[1], "lower")[0]
        for more in ((), ("--pose-sigma", "0.0005", "0.2"))
    )
    assert 0.3 * sure < unsure < sure


def test_pressing_down_moves_nothing(call: Call) -> None:
    code, text, _ = call("push", "cube", "cube", "--local", "--at", "0", "0", "0.05", "--along", "0", "0", "-1")
    assert code == 0
    assert "however hard: nothing moves" in text


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("cub", *SIDE), "did you mean 'cube'"),
        (("cube", "--at", "-0.05", "0", "0.2", "--along", "1", "0", "0"), "from the surface"),
        (("cube", "--at", "-0.05", "0", "0.05", "--along", "0", "0", "0"), "zero"),
        (("cub", "--local", *SIDE), "did you mean 'cube'"),
    ],
)
def test_what_cannot_be_asked_is_told(call: Call, arguments: tuple[str, ...], told: str) -> None:
    code, _, text = call("push", "cube", *arguments)
    assert code == 2
    assert told in text
