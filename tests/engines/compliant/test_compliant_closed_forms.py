"""Closed forms at the default nodes, and convergence where there is torsion."""

import numpy as np
import pytest
from compliant_scenes import strength
from engine_scenes import G0, X, Y, Z, block, cube, floor, shipped

import holdfast as hf
from holdfast import Body, Cylinder, Scene, Status, assemble, robustness, stability
from holdfast.engines.answers import Bound
from holdfast.engines.contract import FORCES_ONLY
from holdfast.scene.shipped import shipped_scene

CLOSE = 5e-3


def near(value: float) -> object:
    return pytest.approx(value, rel=CLOSE)


@pytest.mark.parametrize("x", [0.02941, 0.03529])
def test_pulled_off_over_a_corner_until_the_last_contact_opens(x: float) -> None:
    """On the diagonal: no contact is left beyond the peak, and no stiffness that a path could follow."""
    assert strength(cube(), "cube", (x, x, 0), Z) == pytest.approx(G0 * 0.05 / (0.05 + x), rel=1e-3)


def test_table() -> None:
    table = shipped("table")
    sway = robustness(table, "slab", (-0.25, 0, 0.225), X, engine="compliant")
    assert sway.force[0] == near(7.3575)
    assert set(sway.moving[0]) == {"slab", "leg_left", "leg_right"}


@pytest.mark.parametrize(("nodes", "expected"), [(5, 5.27), (7, 5.23), (15, 5.22)])
def test_table_pushed_along_y_at_its_end(nodes: int, expected: float) -> None:
    """Legs twist on the floor: the prototype's own figures; its weights differ, which five nodes show most."""
    found = strength(shipped("table"), "slab", (0.2, -0.1, 0.225), Y, nodes=nodes)
    assert found == pytest.approx(expected, rel=0.008 if nodes == 5 else 0.005)


def test_tall_table_racks_as_limit_says() -> None:
    answers = [
        robustness(shipped("tall_table"), "slab", (-0.25, 0, 0.625), X, engine=engine).force[0]
        for engine in ("compliant", "limit")
    ]
    assert answers[0] == near(answers[1]) == near(2.4525)


OFF_CENTRE = ("cube", (-0.05, 0.045, 0.02), X)


@pytest.mark.parametrize(("nodes", "within"), [(7, 0.02), (21, 0.003)])
def test_off_centre_push_converges_to_the_limit_surface(nodes: int, within: float) -> None:
    assert strength(shipped("cube"), *OFF_CENTRE, nodes=nodes) == pytest.approx(3.544, rel=within)


def test_a_light_body_beside_a_heavy_one_is_solved_too() -> None:
    heavy = block("heavy", (0.5, 0.5, 0.5), (0.5, 0, 0.25), 1e4)
    light = block("light", (0.01, 0.01, 0.01), (0, 0, 0.005), 1e-3)
    assembly = assemble(Scene([floor(), heavy, light], 0.5))
    assert strength(assembly, "light", (-0.005, 0, 0.001), X) == near(0.5 * 1e-3 * G0)
    for beyond, status in ((-1e-4, Status.STABLE), (1e-4, Status.UNSTABLE)):  # of its centre over the heavy one's edge
        over = block("light", (0.01, 0.01, 0.01), (0.75 + beyond, 0, 0.505), 1e-3)
        assert stability(assemble(Scene([floor(), heavy, over], 0.5)), engine="compliant").status is status


def test_pulling_straight_up_is_bounded_closely_from_below() -> None:
    """All nodes open at once: the path has no next point there, on coarse nodes or fine."""
    found = robustness(shipped("cube"), "cube", (0, 0, 0.1), (0, 0, 1))
    assert found.force[0] == pytest.approx(9.81, rel=1e-3)
    assert 0.99 * 9.81 < found.lower[0] <= 9.81 * (1 + 1e-6)


def test_without_any_friction_nothing_is_claimed_and_nothing_fails() -> None:
    """Level ice: the cube rests, and no sideways push has an answer above 0."""
    assembly = cube(0.0)
    assert stability(assembly).status is Status.STABLE
    found = robustness(assembly, "cube", (-0.05, 0, 0.05), (1, 0, 0))
    assert found.force[0] == 0


def test_a_vase_tips_over_its_round_rim_from_any_side() -> None:
    """At the peak it stands on one point, about which nothing resists it, and paths are often lost there."""
    vase = Body("vase", Cylinder(0.03, 0.2), mass=0.4, position=(0, 0, 0.1))
    assembly = assemble(Scene([floor(), vase], 0.5))
    turns = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    for height in (0.12, 0.15, 0.19):
        along = np.column_stack([np.cos(turns), np.sin(turns), 0 * turns])
        found = robustness(assembly, "vase", [0, 0, height] - 0.03 * along, along)
        most = 0.4 * G0 * 0.03 / height  # less over an edge of the polygon that is its foot
        assert (found.force <= (1 + 1e-4) * most).all()
        assert (found.force >= 0.98 * most).all()
        assert (found.lower > 0.9 * found.force).all()
        assert list(found.mode).count("topple") >= 30  # where it stands on one point rounding has a say


def test_forces_only_saves_the_bounds_and_keeps_the_peaks() -> None:
    assembly = hf.assemble(shipped_scene("table"))
    W = np.zeros((6 * len(assembly.movable), 2))
    W[0, 0], W[8, 1] = 1.0, -1.0
    state = hf.Compliant().prepare(assembly)
    with_bounds, without = state.load_factor(W), state.load_factor(W, FORCES_ONLY)
    np.testing.assert_array_equal(with_bounds.force, without.force)
    np.testing.assert_array_equal(with_bounds.status, without.status)
    assert with_bounds.lower[0] > 0.9 * with_bounds.force[0]
    assert (with_bounds.lower_bound, without.lower_bound) == (Bound.ESTIMATED, Bound.NONE)
    assert without.lower[np.isfinite(without.force)].tolist() == [0.0] * int(np.isfinite(without.force).sum())
