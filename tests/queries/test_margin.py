"""The margin of a verdict, beside closed forms of a block on a plane."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

G0 = 9.81  # [m/s²]
WIDE = hf.Body("ground", hf.HalfSpace(), fixed=True)


def on_slope(mu: float, breadth: float, height: float, tilt: float = 0.0, yaw: float = 0.0) -> hf.Scene:
    """A square block on a plane that falls towards +x by ``tilt`` degrees, turned by ``yaw`` degrees."""
    block = hf.Body(
        "block", hf.Box((breadth, breadth, height)), mass=2.0, position=(0, 0, height / 2), rpy_degrees=(0, 0, yaw)
    )
    slope = np.radians(tilt)
    return hf.Scene([floor(), block], mu, G0 * np.array([np.sin(slope), 0, -np.cos(slope)]))


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.parametrize(
    ("scene", "exact"),
    [
        (on_slope(0.3, 0.2, 0.2), 0.3),  # slides at μ
        (on_slope(0.8, 0.1, 0.3), 1 / 3),  # tips at b / h
        (on_slope(0.8, 0.1, 0.3, yaw=33), 1 / 3),
        (on_slope(0.5, 0.3, 0.1, tilt=17), np.tan(np.arctan(0.5) - np.radians(17))),  # slides down, not up
        (on_slope(0.5, 0.1, 0.4, tilt=9), np.tan(np.arctan(0.25) - np.radians(9))),  # tips down
        (on_slope(2.0, 0.3, 0.02, tilt=20), 1 - np.tan(np.radians(20)) / 2),  # friction that is lower by a share
        (on_slope(3.0, 0.3, 0.02), 1.0),  # needs no friction
    ],
)
def test_block_on_a_plane(scene: hf.Scene, exact: float, engine: str) -> None:
    found = hf.stability(scene, engine=engine).margin
    assert 0.985 * exact <= found <= exact + 1e-9


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_the_margin_is_where_verdicts_under_leaning_gravity_end(engine: str) -> None:
    """Two cubes tip together about the edge that the upper one leans to, 0.04 m from their centre of mass."""
    stack = [box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0.02, 0, 0.15))]

    def leaning(x: float, y: float) -> hf.Status:
        return hf.stability(hf.Scene([floor(), *stack], 0.5, G0 * np.array([x, y, -1])), engine=engine).status

    margin = hf.stability(hf.Scene([floor(), *stack], 0.5), engine=engine).margin
    assert 0.985 * 0.4 <= margin <= 0.4
    for angle in np.radians(np.arange(0, 360, 45)):
        assert leaning(*(margin * np.array([np.cos(angle), np.sin(angle)]))) is hf.Status.STABLE
    assert leaning(1.03 * margin, 0) is hf.Status.UNSTABLE
    assert leaning(-1.03 * margin, 0) is hf.Status.STABLE


def test_the_margin_is_promised_where_forces_are_estimated() -> None:
    """Of the 36 ways that are asked it is the least that holds for certain, less what may be lost between two."""
    scene = shipped_scene("tall_table")
    limits = hf.transport_limits(scene, scene.horizontal_directions(36))
    shorter = np.cos(np.radians(5)) / G0
    assert hf.stability(scene).margin == pytest.approx(limits.lower.min() * shorter, rel=1e-9)
    assert hf.stability(scene).margin < 0.999 * limits.acceleration.min() * shorter


ORANGE = hf.Body("orange", hf.Sphere(0.04), mass=0.2, position=(0.3, 0, 0.04))


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_an_orange_elsewhere_changes_nothing_and_is_named(engine: str) -> None:
    """A block beside it tips at b / h, to the last digit as without the orange; the orange alone has no margin."""
    alone = on_slope(0.8, 0.1, 0.3)
    beside = hf.stability(hf.Scene([*alone.bodies, ORANGE], 0.8), engine=engine)
    with pytest.warns(hf.errors.HoldfastWarning, match="margin: leaves out orange, which is only balanced"):
        margin = beside.margin
    assert margin == hf.stability(alone, engine=engine).margin == pytest.approx(1 / 3, rel=0.015)
    assert beside.balanced == ("orange",)
    assert "orange" in beside.reason
    assert dict(zip([g.bodies for g in beside.groups], beside.margins, strict=True)) == {
        ("block",): margin,
        ("orange",): 0.0,
    }
    assert hf.stability(hf.Scene([WIDE, ORANGE], 0.8), engine=engine).margin == 0.0


@pytest.mark.parametrize("engine", ["limit", "compliant"])
@pytest.mark.filterwarnings("ignore:.*leaves out orange")
def test_an_orange_on_a_tray_leaves_the_margin_of_what_stands_beside_it(engine: str) -> None:
    """A tall can on the tray tips at b / h, before the tray slides at mu."""
    tray, can = box("tray", (0.5, 0.3, 0.02), 1, (0, 0, 0.01)), box("can", (0.06, 0.06, 0.3), 0.5, (-0.1, 0, 0.17))
    orange = hf.Body("orange", hf.Sphere(0.04), mass=0.2, position=(0.1, 0, 0.06))
    found = hf.stability(hf.Scene([floor(), tray, can, orange], 0.5), engine=engine)
    assert found.margin == pytest.approx(0.06 / 0.3, rel=0.02)
    assert found.margins == (found.margin,)


def test_each_group_has_its_own_margin_whatever_becomes_of_others() -> None:
    wide, tall = box("wide", (0.3, 0.3, 0.1), 1, (0, 0, 0.05)), box("tall", (0.1, 0.1, 0.5), 1, (1, 0, 0.25))
    both = hf.stability(hf.Scene([WIDE, wide, tall], 0.4), engine="limit")
    assert both.margins == pytest.approx((0.4, 0.2), rel=0.01)
    assert both.margin == pytest.approx(min(both.margins), abs=1e-3)
    falls = box("falls", (0.1, 0.1, 0.1), 1, (2, 0, 0.5))
    three = hf.stability(hf.Scene([WIDE, wide, tall, falls], 0.4), engine="limit")
    assert (three.margin, three.margins) == (0.0, (*both.margins, 0.0))


def test_what_does_not_stand_has_no_margin() -> None:
    assert hf.stability(on_slope(0.2, 0.2, 0.2, tilt=20)).margin == 0.0
    assert hf.stability(hf.Scene([floor()], 0.5)).margin == 0.0


def test_loads_that_act_throughout_count() -> None:
    scene = on_slope(0.3, 0.2, 0.1)
    load = hf.Load("block", (0, 0, 0.0), (0.1 * 2.0 * G0, 0, 0))
    assert hf.stability(scene, loads=[load], engine="limit").margin == pytest.approx(0.2, rel=0.01)


def test_an_engine_without_lower_bounds_is_refused() -> None:
    with pytest.raises(hf.HoldfastError, match="margin: engine 'graph' promises no lower bound; ask engine"):
        _ = hf.stability(on_slope(0.3, 0.2, 0.2), engine="graph").margin


def test_a_copy_says_that_it_has_lost_the_question() -> None:
    found = hf.stability(on_slope(0.3, 0.2, 0.2))
    other = copy.deepcopy(found)
    assert other == found
    with pytest.raises(hf.HoldfastError, match="margin: was lost when the answer was saved or copied"):
        _ = other.margin
