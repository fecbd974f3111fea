"""Holds as values: what is refused, how they follow edits of a scene, and how files keep them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.rigid import transform

INF = float("inf")
FRAME = hf.pose(0.1, 0.2, 1.0, yaw=30)


def scene(*holds: hf.Hold | hf.Grip) -> hf.Scene:
    """A cup in the air and a box on the floor."""
    bodies = [
        hf.Body("floor", hf.Box((1, 1, 0.1)), fixed=True, position=(0, 0, -0.05)),
        hf.Body("cup", hf.Box((0.1, 0.1, 0.1)), mass=0.3, position=(0, 0, 1)),
        hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=0.3, position=(0.3, 0, 0.05)),
    ]
    return hf.Scene(bodies, 0.5, holds=holds)


EVERY = (
    hf.Hold("cup", FRAME, forces=((-3, 7), 2, (-INF, 40)), moments=INF),
    hf.Hold("cup", FRAME, 4.0, (0.1, 0, (0, 2))),
    hf.Grip("cup", [(0.05, 0, 1), (-0.05, 0, 1)], [(-1, 0, 0), (1, 0, 0)], 0.5, (20, INF), pull=3.0),
    hf.Grip.suction("box", hf.pose(0.3, 0, 0.1), force=40.0, radius=0.02, mu=0.6, sides=8),
)


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: hf.Hold("cup", FRAME), "holds nothing"),
        (lambda: hf.Hold("cup", FRAME, forces=-1), "forces"),
        (lambda: hf.Hold("cup", FRAME, forces=(1, 2)), "2 entries"),
        (lambda: hf.Hold("cup", FRAME, moments=((2, 1), 1, 1)), r"range \(2, 1\)"),
        (lambda: hf.Hold("cup", FRAME, moments=((INF, INF), 1, 1)), "moments"),
        (lambda: hf.Hold("cup", FRAME, forces=float("nan")), "forces"),
        (lambda: hf.Hold("cup", np.eye(3), forces=1), "frame"),
        (lambda: hf.Hold("cup", 2 * np.eye(4), forces=1), "frame"),
        (lambda: hf.Hold("", FRAME, forces=1), "body"),
        (lambda: hf.Hold("cup", FRAME, forces="strong"), "forces"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 0)], 0.5), "direction is zero"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 1), (0, 0, 1)], 0.5), "1 points and 2 normals"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 1)], -0.5), "mu"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 1)], 0.5, 0.0), "holds nothing"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 1)], 0.5, (1, 2)), "2 numbers"),
        (lambda: hf.Grip("cup", [(0, 0, 1)], [(0, 0, 1)], 0.5, pull=-1), "pull"),
        (lambda: scene(hf.Hold("cap", FRAME, 1.0)), "did you mean 'cup'"),
        (lambda: scene(hf.Hold("floor", FRAME, 1.0)), "which is fixed"),
        (lambda: scene("cup"), "holds has a str"),  # type: ignore[arg-type]
    ],
)
def test_what_is_wrong_is_named(make: Any, problem: str) -> None:
    with pytest.raises(hf.HoldfastError, match=problem):
        make()


def test_holds_move_with_their_bodies_and_leave_with_them() -> None:
    whole, motion = scene(*EVERY), hf.pose(0.2, -0.1, 0.5, yaw=90)
    there = whole.moved({"cup": motion @ whole.body("cup").pose})
    assert np.allclose(there.holds[0].frame, motion @ FRAME)  # type: ignore[union-attr]
    assert np.allclose(there.holds[2].points, transform(motion, EVERY[2].points))  # type: ignore[union-attr]
    assert there.holds[3] == EVERY[3]
    assert whole.without("cup").holds == EVERY[3:]
    other = hf.Scene([whole.body("floor"), hf.Body("jar", hf.Box((0.1, 0.1, 0.1)), mass=1, position=(0, 0, 2))], 0.5)
    assert (whole + other).holds == EVERY
    assert hf.assemble(scene()).with_holds(*EVERY).scene == whole


@pytest.mark.parametrize("name", ["scene.yaml", "scene.json"])
def test_files_keep_holds(tmp_path: Path, name: str) -> None:
    whole = scene(*EVERY)
    hf.save_scene(whole, tmp_path / name)
    assert hf.load_scene(tmp_path / name) == whole
    assert "holds" not in (hf.save_scene(scene(), tmp_path / name), (tmp_path / name).read_text())[1]


def test_a_file_by_hand(tmp_path: Path) -> None:
    text = """
format: holdfast-scene/1
friction: 0.5
bodies:
  - {name: floor, shape: {type: box, size: [1, 1, 0.1]}, position: [0, 0, -0.05], fixed: true}
  - {name: cup, shape: {type: box, size: [0.1, 0.1, 0.1]}, mass: 0.3, position: [0, 0, 1]}
holds:
  - {type: hold, body: cup, frame: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]], forces: [9, 9, [-inf, 40]]}
  - {type: grip, body: cup, points: [[0.05, 0, 1]], normals: [[-1, 0, 0]], mu: 0.5, force: 20}
"""
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    found = hf.load_scene(path)
    assert found.holds[0] == hf.Hold("cup", hf.pose(0, 0, 1), forces=(9, 9, (-INF, 40)))
    assert found.holds[1] == hf.Grip("cup", [(0.05, 0, 1)], [(-1, 0, 0)], 0.5, 20.0)
    path.write_text(text.replace("mu: 0.5", "grip: 0.5"))
    with pytest.raises(hf.HoldfastError, match="holds"):
        hf.load_scene(path)


QUESTIONS = {
    "engine 'compliant'": lambda s, _: hf.stability(s),
    "engine 'graph'": lambda s, _: hf.robustness(s, "box", (0.3, 0, 0.1), (0, 0, -1), engine="graph"),
    "settle": lambda s, _: hf.settle(s),
    "view": lambda s, _: hf.view(s, engine="limit", browser=False),
    "stability_of_poses": lambda s, _: hf.stability_of_poses(s, "box", s.body("box").pose[None], engine="limit"),
    "robustness_of_poses": lambda s, _: hf.robustness_of_poses(
        s, "box", s.body("box").pose[None], (0.3, 0, 0.1), (0, 0, -1), engine="limit"
    ),
    "plan_placement": lambda s, _: hf.plan_placement(
        s, hf.Body("jar", hf.Box((0.1, 0.1, 0.1)), mass=1), engine="limit"
    ),
    "place_all": lambda s, _: hf.place_all(s, [hf.Body("jar", hf.Box((0.1, 0.1, 0.1)), mass=1)], engine="limit"),
    "certificate": lambda s, p: hf.stability(s, engine="limit").save_certificate(p / "c.json"),
    "format 'MJCF'": lambda s, p: hf.save_scene(s, p / "s.xml"),
    "format 'glTF'": lambda s, p: hf.save_scene(s, p / "s.glb"),
    "pose_sigma": lambda s, _: hf.stability(hf.assemble(s, pose_sigma=1e-3), engine="limit"),
}


@pytest.mark.parametrize("what", QUESTIONS)
def test_who_does_not_take_holds_says_so(what: str, tmp_path: Path) -> None:
    with pytest.raises(hf.HoldfastError, match=re.escape(what)):
        QUESTIONS[what](scene(*EVERY), tmp_path)


def test_who_takes_holds_answers_with_them() -> None:
    """Each question as if the cup stood on a table that carries what the hold does."""
    held = hf.assemble(scene(hf.Hold("cup", hf.pose(0, 0, 1), forces=5.0, moments=1.0)))
    limit = {"engine": "limit"}
    assert hf.stability(held, **limit).stable
    assert not hf.stability(scene(), **limit).stable
    assert hf.transport_limits(held, bodies=["cup"], **limit).acceleration.min() == pytest.approx(
        np.sqrt(5**2 - (0.3 * 9.81) ** 2) / 0.3, rel=1e-5
    )
    carried = hf.carry(held, hf.Profile([0, 1], [(0, 0, 0), (1, 0, 0)]), **limit)
    assert (carried.lower >= 1).all()
    assert not carried.holds  # an equilibrium exists
    for ask in (hf.Monitor, hf.sets.sustainable_accelerations):
        with pytest.raises(hf.errors.SceneError, match="does not take holds, and the scene holds cup"):
            ask(held)
    assert hf.sets.sustainable_accelerations(held, exists=True, accuracy=0.3).exists((1, 0, 0)) is True
    assert hf.can_remove(held, "box", **limit).safe
    assert set(hf.disassembly_order(held, **limit).order) == {"cup", "box"}


def test_infinity_of_yaml_is_read(tmp_path: Path) -> None:
    held = hf.Scene(
        [hf.Body("floor", hf.HalfSpace(), fixed=True), hf.Body("cup", hf.Box((0.1, 0.1, 0.1)), mass=1)],
        0.5,
        holds=[hf.Hold("cup", hf.pose(0, 0, 1), forces=INF, moments=((-INF, 4), INF, 2), on="floor")],
    )
    hf.save_scene(held, tmp_path / "held.yaml")
    text = (tmp_path / "held.yaml").read_text()
    assert "inf" in text
    (tmp_path / "held.yaml").write_text(text.replace("'inf'", "inf").replace("-inf", "-.inf").replace(" inf", " .inf"))
    assert ".inf" in (tmp_path / "held.yaml").read_text()
    assert hf.load_scene(tmp_path / "held.yaml") == held
