"""What a scene needs, and what it says when that is missing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor, table


def body(name: str, **options: Any) -> hf.Body:
    return hf.Body(name, hf.Box((1, 1, 1)), **(options or {"mass": 1}))


FLOOR = body("floor", fixed=True)


@pytest.mark.parametrize(
    ("build", "match"),
    [
        (lambda: hf.Scene([], 0.5), r"scene: has no bodies; needs at least one fixed body"),
        (lambda: hf.Scene(None, 0.5), r"scene: bodies.*; needs"),
        (lambda: hf.Scene([FLOOR, "cube"], 0.5), r"bodies holds a str; needs Body"),
        (lambda: hf.Scene([FLOOR, body("a"), body("a")], 0.5), r"several bodies are named 'a'; names are unique"),
        (lambda: hf.Scene([body("a"), body("b")], 0.5), r"none of its 2 bodies is fixed; mark .* fixed=True"),
        (lambda: hf.Scene([FLOOR], 0.5, gravity=(0, 0, 0)), r"gravity is zero; .*give a vector such as"),
        (lambda: hf.Scene([FLOOR], 0.5, gravity=(0, -9.81)), r"scene: gravity: has shape \(2,\); needs shape"),
        (
            lambda: hf.Scene([FLOOR], 0.5, gravity=(0, 0, np.nan)),
            r"scene: gravity: contains nan at index \(2,\); needs",
        ),
    ],
)
def test_what_is_refused(build: Any, match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        build()


def test_an_unknown_body_suggests_the_nearest_name() -> None:
    scene = hf.Scene([FLOOR, body("leg_left"), body("slab")], 0.5)
    with pytest.raises(hf.errors.SceneError, match=r"no body named 'leg_lef'; did you mean 'leg_left'\?"):
        scene.body("leg_lef")
    with pytest.raises(hf.errors.SceneError, match=r"no body named 'x'; known: floor, leg_left, slab"):
        scene.body("x")


@pytest.mark.parametrize(
    "ask",
    [
        lambda a: hf.robustness(a, "slb", (0, 0, 0), (0, 0, 1), engine="graph"),
        lambda a: hf.robustness_map(a, ["slb"], engine="graph"),
        lambda a: hf.load_factor(a, [hf.Load("slb", moment=(0, 0, 1))], engine="graph"),
        lambda a: hf.stability(a, loads=[hf.Load("slb", moment=(0, 0, 1))], engine="graph"),
    ],
)
def test_every_question_names_the_nearest_body(ask: Any) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"'slb'; did you mean 'slab'\?"):
        ask(hf.assemble(table()))


def test_movable_bodies_keep_their_order_and_gravity_its_value() -> None:
    scene = hf.Scene([body("b"), FLOOR, body("a")], 0.5, gravity=(0, 1, -2), name="mine")
    assert [b.name for b in scene.movable] == ["b", "a"]
    np.testing.assert_array_equal(scene.gravity, [0, 1, -2])
    assert scene.name == "mine"
    assert scene.mu("a", "b") == 0.5


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
def test_a_scene_in_which_nothing_can_move_is_not_said_to_stand(engine: str) -> None:
    found = hf.stability(hf.assemble(hf.Scene([FLOOR], 0.5)), engine=engine)
    assert found.status == hf.Status.UNDECIDED
    assert found.reason.startswith("nothing here can move")


def sunk(depth: float) -> hf.Scene:
    return hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05 - depth))], 0.5)


def test_overlapping_bodies_warn_with_their_names_and_the_depth() -> None:
    with pytest.warns(hf.errors.HoldfastWarning, match=r"overlap.*'floor' and 'cube'.* 3\.72 mm.*; correct") as caught:
        assembly = hf.assemble(sunk(0.00372))
    assert len(caught) == 1
    assert assembly.overlaps[0].bodies == ("floor", "cube")
    assert assembly.overlaps[0].depth == pytest.approx(0.00372, rel=0.01)
    assert hf.stability(assembly, engine="graph").status == hf.Status.UNDECIDED


def test_an_overlap_within_the_gap_does_not_warn(recwarn: pytest.WarningsRecorder) -> None:
    assembly = hf.assemble(sunk(0.0009), gap=1e-3)
    assert not recwarn.list
    assert len(assembly.interfaces) == 1


def test_up_is_against_gravity() -> None:
    gravity = np.array([3.0, 0.0, -4.0])
    assert hf.Scene([FLOOR], 0.5, gravity=gravity).up.tolist() == [-0.6, 0.0, 0.8]
    assert hf.Scene([FLOOR], 0.5).up.tolist() == [0, 0, 1]
