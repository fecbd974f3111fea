"""Whether an equilibrium exists, STABLE only where it needs no self-stress, and whether a body comes loose."""

from typing import Any

import numpy as np
import pytest
from engine_scenes import G0, X, Z, block, shipped
from limit_scenes import push

import holdfast as hf
from holdfast import Scene, Status, assemble, stability
from holdfast.engines.limit_engine import comes_loose
from holdfast.scene.shipped.blocks import at, box, floor


@pytest.mark.parametrize("name", ["cube", "stack", "table", "wall2x2", "slope", "arch", "v_groove", "cantilever"])
def test_scenes_that_stand_have_no_self_stress(name: str) -> None:
    result = stability(shipped(name), engine="limit")
    assert result.status is Status.STABLE
    assert result.equilibrium_exists is True
    assert result.self_stress is False


@pytest.mark.parametrize("cone", ["exact", "inscribed", "circumscribed"])
def test_wedged_between_walls(cone: Any) -> None:
    result = stability(shipped("wedged"), engine=hf.Limit(cone))
    assert (result.status, result.equilibrium_exists, result.self_stress) == (Status.UNDECIDED, True, True)
    assert "pressed together" in result.reason
    result = stability(shipped("wedged_floor"), engine=hf.Limit(cone))
    assert (result.status, result.equilibrium_exists, result.self_stress) == (Status.STABLE, True, True)


@pytest.mark.parametrize(("beyond", "stands"), [(-0.02, True), (-0.001, True), (0.001, False), (0.02, False)])
@pytest.mark.parametrize("cone", ["exact", "inscribed", "circumscribed"])
def test_a_box_over_an_edge_is_not_held_by_neighbours_that_nothing_presses(
    beyond: float, stands: bool, cone: Any
) -> None:
    """Neighbours that squeeze it could be held apart by friction on the plate, but nothing brings that about."""
    plate = block("plate", (2, 2, 0.1), (-1, 0, -0.05), fixed=True)
    beside = [block(f"beside{side}", (0.6, 0.4, 0.3), (-0.3, 0.35 * side, 0.15), 5) for side in (-1, 1)]
    scene = Scene([plate, block("over", (0.4, 0.3, 0.3), (beyond, 0, 0.15), 20), *beside], 0.5)
    result = stability(assemble(scene), engine=hf.Limit(cone))
    expected = (Status.STABLE, True, False) if stands else (Status.UNDECIDED, True, True)
    assert (result.status, result.equilibrium_exists, result.self_stress) == expected
    assert push(assemble(scene), "over", (beyond, 0, 0.3), X).force[0] > 0  # the answer that the claim is about


def test_a_scene_that_rests_on_self_stress_still_gets_the_factor_that_the_claim_is_about() -> None:
    """The walls can press without bound."""
    got = push(shipped("wedged"), "cube", (0, 0, 0.2), -Z)
    assert got.status[0] is Status.INFINITE


def test_frictionless_walls_do_not_hold_a_cube() -> None:
    result = stability(assemble(Scene(shipped("wedged").bodies, 0.0)), engine="limit")
    assert result.status is Status.UNSTABLE
    assert result.moving == ("cube",)


@pytest.mark.parametrize(("shift", "stands"), [(0.049, True), (0.051, False)])
def test_overhang(shift: float, stands: bool) -> None:
    shelf = block("shelf", (0.1, 0.1, 0.1), (0, 0, 0.05), fixed=True)
    assembly = assemble(Scene([shelf, block("cube", (0.1, 0.1, 0.1), (shift, 0, 0.15))], 0.6))
    result = stability(assembly, engine="limit")
    assert result.equilibrium_exists is stands
    assert result.status is (Status.STABLE if stands else Status.UNSTABLE)
    if stands:
        return
    assert result.moving == ("cube",)
    assert result.mechanism is not None
    assert result.certificate is not None
    twist = result.mechanism.twists[0]
    assert result.certificate.power == pytest.approx(-G0 * twist[2])  # the power of weight along the twist
    assert result.certificate.power > 0
    assert result.certificate.violation < 1e-6
    for y in (-0.05, 0.05):  # neither corner of the edge it leans on is pressed in
        for x in (shift - 0.05, 0.05):
            arm = np.array([x - shift, y, -0.05])
            u = twist[:3] + np.cross(twist[3:], arm)
            assert u[2] >= 0.6 * np.hypot(u[0], u[1]) - 1e-6
    assert push(assembly, "cube", (shift - 0.05, 0, 0.15), -Z).force[0] == 0  # even a push that would hold it


def test_forces_of_the_verdict_balance_the_weights() -> None:
    for name in ("table", "arch", "slope_two"):
        assembly = shipped(name)
        forces = stability(assembly, engine="limit").forces
        assert forces is not None
        total = np.zeros((len(assembly.movable), 3))
        for f, i in zip(forces.force, forces.interface, strict=True):
            a, b = assembly.ends[i]
            if a >= 0:
                total[a] -= f
            if b >= 0:
                total[b] += f
        expected = [-b.mass * assembly.scene.gravity for b in assembly.movable]
        np.testing.assert_allclose(total, expected, atol=1e-6 * assembly.weight)
        assert forces.usage.max() <= 1 + 1e-6


@pytest.mark.parametrize(("mu", "loose"), [(0.9, True), (1.1, False)])
def test_beside_one_neighbour_nothing_clamps_below_friction_1(mu: float, *, loose: bool) -> None:
    """A block on a floor and against a wall: its wall holds it down by friction only if μ² >= 1."""
    wall = hf.Body("wall", hf.Box(np.array([0.1, 0.5, 0.5])), pose=at(-0.05, 0, 0.25), fixed=True)
    assembly = hf.assemble(hf.Scene([floor(), wall, box("cube", (0.1, 0.1, 0.1), 1, (0.05, 0, 0.05))], mu))
    assert comes_loose(assembly, "cube", Z) is loose
    assert hf.Limit("inscribed", 4).comes_loose(assembly, "cube", Z) is loose, "over the exact cone in any case"


def test_a_body_without_contacts_is_loose() -> None:
    assembly = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.6))
    assert comes_loose(assembly, "cube", Z)
