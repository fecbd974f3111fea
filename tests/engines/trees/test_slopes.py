"""Derivatives of loads at which trees give way: by hand, and beside differences of moved scenes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.scene.shipped.blocks import box, floor
from holdfast.sets import gradients

G = 9.81
STEP = 1e-5  # [m]


def solved(scene: hf.Scene, *push: Any) -> hf.answers.Derivatives:
    assembly = hf.assemble(scene)
    found = gradients(assembly, hf.robustness(assembly, *push))
    assert found.from_multipliers.all(), "in closed form"
    return found


def cube(x: float = 0.0) -> hf.Scene:
    """A cube of 2 kg on a table of 40 cm, centred there or at ``x``."""
    table = hf.Body("table", hf.Box((0.4, 0.4, 0.1)), position=(0, 0, -0.05), fixed=True)
    return hf.Scene([table, box("cube", (0.1, 0.1, 0.1), 2.0, (x, 0, 0.05))], 0.6)


def test_a_cube_slides_at_mu_m_g() -> None:
    found = solved(cube(), "cube", (-0.05, 0, 0.01), (1, 0, 0)).slopes
    assert found.friction["table", "cube"][0] == pytest.approx(2 * G, rel=1e-5)
    assert found.mass["cube"][0] == pytest.approx(0.6 * G, rel=1e-5)
    assert found.pose["cube"][0, :3] == pytest.approx(0, abs=2e-3)
    assert found.direction[0, 2] == pytest.approx(-(0.6**2) * 2 * G, rel=1e-5)  # R = μ (m g - R e_z) / e_x


def test_a_cube_tips_about_its_own_edge_or_that_of_the_table() -> None:
    """Pushed at height h along x, it tips at m g d / h for the distance d of its centre of mass from the edge."""
    push = ("cube", (-0.05, 0, 0.09), (1, 0, 0))
    found = solved(cube(), *push).slopes
    assert found.mass["cube"][0] == pytest.approx(G * 0.05 / 0.09, rel=1e-6)
    assert found.friction["table", "cube"][0] == 0
    assert found.point[0] == pytest.approx([0, 0, -2 * G * 0.05 / 0.09**2], rel=1e-6, abs=1e-6)
    assert found.pose["cube"][0, :2] == pytest.approx([0, 0], abs=1e-6)  # it takes edge and push along
    assert found.pose["cube"][0, 2] == pytest.approx(-G * 0.05 / 0.09**2, rel=1e-6)  # half of it: so does the contact
    over = solved(cube(0.18), "cube", (0.13, 0, 0.09), (1, 0, 0)).slopes
    assert over.pose["cube"][0, 0] == pytest.approx(-2 * G / 0.09, rel=1e-6)
    assert over.pose["table"][0, 0] == pytest.approx(2 * G / 0.09, rel=1e-6)


def stack(size: Float, at: Float) -> hf.Scene:
    lower = box("lower", (0.2, 0.16, 0.1), 2.0, (0.01, 0.02, 0.05))
    return hf.Scene([floor(), lower, box("upper", tuple(size), 1.0, (*at, 0.15))], 0.4)


PUSHES = [
    ("upper", (-0.02, 0.05, 0.12), (1, 0.3, 0)),  # slides and turns on a bed that presses everywhere
    ("upper", (-0.02, 0.05, 0.17), (1, 0.3, 0)),  # ... and on one that has lifted in part
    ("upper", (-0.02, 0.035, 0.19), (1, 0.05, 0)),  # tips
    ("lower", (-0.09, 0.05, 0.03), (1, 0.05, 0)),  # takes the upper one along
]


@pytest.mark.parametrize("push", PUSHES)
@pytest.mark.parametrize("at", [(0.03, 0.03), (0.07, 0.05)], ids=["inside", "beyond two edges"])
def test_slopes_are_those_of_moved_scenes(push: tuple[str, Any, Any], at: tuple[float, float]) -> None:
    """Every pose, as the difference of answers of scenes whose contacts are found anew."""
    scene = stack(np.array([0.1, 0.12, 0.1]), np.array(at))
    name, point, way = push
    shift = np.array([*(np.array(at) - (0.03, 0.03)), 0]) if name == "upper" else np.zeros(3)
    found = solved(scene, name, point + shift, way).slopes
    for body in ("lower", "upper"):
        for axis in range(3):
            sides = []
            for sign in (-1, 1):
                step = sign * STEP * np.eye(3)[axis]
                moved = scene.body(body).moved(
                    np.array(scene.body(body).pose) + np.pad(step[:, None], ((0, 1), (3, 0)))
                )
                there = hf.assemble(hf.Scene([moved if b.name == body else b for b in scene.bodies], 0.4))
                pushed = point + shift + (step if body == name else 0)
                sides.append(float(hf.robustness(there, name, pushed, way)))
            slope = (sides[1] - sides[0]) / (2 * STEP)
            assert found.pose[body][0, axis] == pytest.approx(slope, rel=1e-3, abs=0.02)


def test_flush_edges_are_kinks_of_which_both_sides_are_known() -> None:
    """Of two equal cubes, the upper one turns: whichever way it moves, the area of contact shrinks."""
    scene = stack(np.array([0.2, 0.16, 0.1]), np.array([0.01, 0.02]))
    found = solved(scene, "upper", (-0.09, 0.08, 0.12), (1, 0, 0))
    kink = next(one for one in found.kinks if one.by == "pose of upper, along y")
    here = float(hf.robustness(hf.assemble(scene), "upper", (-0.09, 0.08, 0.12), (1, 0, 0)))
    for side, sign in ((kink.before, -1), (kink.after, 1)):
        there = stack(np.array([0.2, 0.16, 0.1]), np.array([0.01, 0.02 + sign * STEP]))
        moved = float(hf.robustness(hf.assemble(there), "upper", (-0.09, 0.08 + sign * STEP, 0.12), (1, 0, 0)))
        assert side == pytest.approx((moved - here) / (sign * STEP), rel=2e-3)
    assert kink.before > 0 > kink.after
