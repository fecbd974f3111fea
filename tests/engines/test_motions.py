"""The motion that begins: closed forms and symmetry where pressure gathers on few nodes, and one rule for modes."""

from __future__ import annotations

import re

import numpy as np
import pytest
from placed import at

import holdfast as hf
from holdfast.engines.mechanism import Mechanism

ENGINES = ("compliant", "limit")
GROUND = hf.Body("ground", hf.HalfSpace(), fixed=True)
SIDEWAYS = [(1, 1, 0), (1, -1, 0), (-1, 1, 0), (-1, -1, 0)]


def pile(count: int, height: float, mass: float) -> hf.Scene:
    size = (0.4, 0.4, height)
    boxes = [hf.Body(f"b{k}", hf.Box(size), mass=mass, pose=at(0, 0, (k + 0.5) * height)) for k in range(count)]
    return hf.Scene([GROUND, *boxes], friction=0.5)


def tips_over(mechanism: Mechanism | None, corner: tuple[float, float, float], axis: np.ndarray) -> None:
    """All bodies turn as one about the axis (3,) through the corner."""
    assert mechanism is not None
    assert mechanism.mode == "topple"
    turn = axis / np.linalg.norm(axis)
    rate = mechanism.twists[0, 3:] @ turn
    assert rate > 0
    for twist, com in zip(mechanism.twists / rate, mechanism.kinematics.com, strict=True):
        np.testing.assert_allclose(twist[3:], turn, atol=0.02)
        np.testing.assert_allclose(twist[:3], np.cross(turn, com - np.array(corner)), atol=0.02)


@pytest.mark.parametrize("engine", ENGINES)
def test_p1_two_boxes_pushed_along_their_diagonal_tip_over_the_corner(engine: str) -> None:
    found = hf.robustness(pile(2, 1.0, 50), "b1", (-0.2, -0.2, 1.9), (1, 1, 0), engine=engine)
    assert found.force[0] == pytest.approx(981 * 0.2 * np.sqrt(2) / 1.9, rel=1e-3)
    tips_over(found.mechanism[0], (0.2, 0.2, 0), np.array([-1.0, 1, 0]))
    assert "slides" not in found.mechanism[0].text
    assert "b0, b1 turn about the axis through (0.2, 0.2, 0) along (-0.707, 0.707, 0)" in found.mechanism[0].text
    assert "opens: ground-b0" in found.mechanism[0].text


@pytest.mark.parametrize(("x", "y", "yaw"), [(0.7, -0.4, 0.0), (-1.3, 0.2, 30.0), (2.0, 2.0, 215.0)])
def test_words_name_the_edge_over_which_a_box_tips_wherever_it_stands(x: float, y: float, yaw: float) -> None:
    """The point of the axis that is named lies on the line of the lower edge in front, and the axis is along it."""
    tower = hf.Body("tower", hf.Box((0.1, 0.4, 0.6)), mass=2, pose=hf.pose(x, y, 0.3, yaw=yaw))
    way, along = tower.pose[:3, 0], tower.pose[:3, 1]
    top = tower.pose[:3, 3] + 0.25 * np.array([0, 0, 1]) - 0.05 * way
    found = hf.robustness(hf.Scene([GROUND, tower], 0.5), "tower", top, way, engine="limit")
    said = re.search(r"tower turns about the axis through \((.*?)\) along \((.*?)\)", found.mechanism[0].text)
    assert said is not None
    through, axis = (np.array([float(each) for each in part.split(", ")]) for part in said.groups())
    edge = tower.pose[:3, 3] + 0.05 * way - [0, 0, 0.3]
    np.testing.assert_allclose(axis, along, atol=2e-3)
    np.testing.assert_allclose(np.cross(through - edge, along), 0, atol=5e-3)  # three digits


@pytest.mark.parametrize("engine", ENGINES)
def test_p1_twenty_boxes_carried_along_diagonals_tip_over_the_corner_behind(engine: str) -> None:
    found = hf.transport_limits(pile(20, 0.1, 5), directions=SIDEWAYS, engine=engine)
    np.testing.assert_allclose(found.acceleration, 9.81 * 0.2 * np.sqrt(2), rtol=1e-3)
    for (x, y, _), mechanism in zip(SIDEWAYS, found.mechanism, strict=True):
        tips_over(mechanism, (-0.2 * x, -0.2 * y, 0), np.array([y, -x, 0.0]))


@pytest.mark.parametrize("count", [1, 2, 5])
def test_p1_flat_piles_slide_alike_in_all_directions(count: int) -> None:
    """Every contact is at its limit at once: friction is the same share of what lies on each."""
    found = hf.transport_limits(pile(count, 0.1, 5), directions=[*SIDEWAYS, (1, 0, 0), (0, -1, 0)])
    assert set(found.mode) == {"slip"}
    for way, mechanism in zip(found.directions, found.mechanism, strict=True):
        for twist in mechanism.twists:
            np.testing.assert_allclose(twist[:3] / np.linalg.norm(twist[:3]), -way, atol=1e-3)
            np.testing.assert_allclose(twist[3:], 0, atol=1e-3)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("turn", [0.0, 0.1, 2.0])
def test_p1_a_tall_can_tips_over_its_rim_whatever_side_it_is_pushed_from(engine: str, turn: float) -> None:
    """As the can on the book: tipping needs less than sliding, about the horizontal tangent of the rim."""
    can = hf.Body("can", hf.Cylinder(0.033, 0.1), mass=0.4, pose=at(0, 0, 0.05))
    way = np.array([np.cos(turn), np.sin(turn), 0.0])
    found = hf.robustness(hf.Scene([GROUND, can], 0.5), "can", -0.033 * way + [0, 0, 0.09], way, engine=engine)
    assert found.force[0] == pytest.approx(0.4 * 9.81 * 0.033 / 0.09, rel=0.03)
    assert found.mode[0] == "topple"
    spin = found.mechanism[0].twists[0, 3:]
    assert spin @ np.cross([0, 0, 1], way) > np.cos(np.radians(12)) * np.linalg.norm(spin)  # between rim nodes


@pytest.mark.parametrize("engine", ENGINES)
def test_p1_a_ball_rolls_in_push_map_and_transport(engine: str) -> None:
    scene = hf.Scene([GROUND, hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05))], friction=0.5)
    pushed = hf.robustness(scene, "ball", (-0.05, 0, 0.05), (1, 0, 0), engine=engine)
    assert pushed.mode[0] == "roll"
    assert pushed.mechanism[0].text.endswith("rolls: ground-ball")
    assert set(hf.transport_limits(scene, directions=SIDEWAYS, engine=engine).mode) == {"roll"}
    mapped = hf.robustness_map(scene, spacing=0.03, engine=engine)
    assert set(mapped.mode[mapped.force == 0]) == {"roll"}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_slab_that_spins_under_an_eccentric_push_slips(engine: str) -> None:
    """A dual motion lifts a rigid slab by at least μ times its sliding everywhere, which is no opening."""
    slab = hf.Body("slab", hf.Box((0.2, 0.2, 0.02)), mass=1, pose=at(0, 0, 0.01))
    found = hf.robustness(hf.Scene([GROUND, slab], 0.5), "slab", (-0.1, 0.08, 0.001), (1, 0, 0), engine=engine)
    assert found.mode[0] == "slip"
    assert "opens" not in found.mechanism[0].text
