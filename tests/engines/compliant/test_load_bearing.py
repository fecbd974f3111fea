"""Loads that few bodies carry alone: what the others do, and presses on a dense pallet that have no end."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from compliant_scenes import grid_of as grid_at_rest
from engine_scenes import block, floor
from numpy.typing import ArrayLike

import holdfast as hf
from holdfast.assembly.assembly import body_forces
from holdfast.base.arrays import Float
from holdfast.engines.compliant.grid import Grid
from holdfast.queries.request import push_columns

MU, SIDE = 0.5, 0.1
DOWN = np.array([0.0, 0.0, -1.0])


def grid_of(*bodies: hf.Body) -> Grid:
    return grid_at_rest(hf.assemble(hf.Scene([floor(), *bodies], MU)))


def column(grid: Grid, body: str, point: ArrayLike, direction: ArrayLike) -> Float:
    toward = np.asarray(direction, dtype=float)
    where = np.asarray(point, dtype=float)[None]
    return push_columns(grid.assembly, grid.assembly.index[body], where, (toward / np.linalg.norm(toward))[None])


def carried(grid: Grid, body: str, point: ArrayLike, direction: ArrayLike) -> bool:
    return grid.load_bearing.balance(grid.loads(column(grid, body, point, direction))[0])


@cache
def two_towers() -> Grid:
    """Two cubes on each other, and two others flush beside them."""
    side = (SIDE, SIDE, SIDE)
    return grid_of(*(block(f"c{i}_{k}", side, (SIDE * i, 0, SIDE * (k + 0.5))) for i in range(2) for k in range(2)))


@pytest.mark.parametrize("degrees", [0, 10, 20, 28, 35])
def test_a_tower_carries_a_press_within_the_friction_cone_and_its_foot_alone(degrees: float) -> None:
    """Away from its neighbour, it is held exactly as long as tan(angle) is below mu and the line meets the foot."""
    slope = np.tan(np.radians(degrees))
    for x in (-0.035, 0.0, 0.02, 0.045):
        foot = abs(x - 2 * SIDE * slope)  # where the line meets the floor
        if 0.4 * SIDE < foot < 0.5 * SIDE:  # nodes do not reach the edge
            continue
        found = carried(two_towers(), "c0_1", (x, 0, 2 * SIDE), (-slope, 0, -1))
        assert found == (foot < SIDE / 2 and slope < MU)


def test_a_neighbour_that_cannot_leave_is_no_reason_to_say_anything() -> None:
    """Between the tower and a wall the neighbour cannot get out of the way of both; without the wall it can."""
    side = (SIDE, SIDE, SIDE)
    tower = [block(f"c{k}", side, (0, 0, SIDE * (k + 0.5))) for k in range(2)]
    beside = block("beside", side, (SIDE, 0, SIDE * 0.5))
    wall = block("wall", side, (2 * SIDE, 0, SIDE * 0.5), fixed=True)
    press = ("c1", (0, 0, 2 * SIDE), DOWN)
    assert carried(grid_of(*tower, beside), *press)
    assert not carried(grid_of(*tower, beside, wall), *press)


def held_plank(*more: hf.Body) -> Grid:
    """A plank that reaches beyond its support, x = 0.1, is held down by a block: a press on its free end tips both."""
    support, plank = block("support", (0.2, 0.1, 0.1), (0, 0, 0.05)), block("plank", (0.4, 0.1, 0.02), (0.1, 0, 0.11))
    return grid_of(support, plank, block("on it", (0.1, 0.1, 0.1), (-0.05, 0, 0.17), 5.0), *more)


@pytest.mark.parametrize("beyond", [0.18, 1e-3, 1e-4, 1e-5])
def test_what_the_weight_of_others_holds_is_not_carried_alone(beyond: float) -> None:
    """It ends at up to 10,000 times the weight, where a hundred-thousandth of its moment is left: that is no rest."""
    assert not carried(held_plank(), "plank", (0.1 + beyond, 0, 0.12), DOWN)
    for x in (0.05, 0.09):
        assert carried(held_plank(), "plank", (x, 0, 0.12), DOWN)


@pytest.mark.parametrize("beyond", [-0.002, 0.004, 0.006])
def test_a_press_that_leads_far_ends_where_the_lever_says(beyond: float) -> None:
    """A plank tips over its support, which its lever decides: here at 15 and 22 times the weight of all bodies."""
    grid = held_plank(*(block(f"r{i}", (0.05,) * 3, (-0.125 - 0.05 * i, 0, 0.025), 0.1) for i in range(14)))
    assert grid.system.fronts is not None
    peak = grid.paths(column(grid, "plank", (0.1 + beyond, 0, 0.12), DOWN)).factor[0]
    expected = 5 * 9.81 * 0.15 / beyond if beyond > 0 else np.inf
    assert peak == pytest.approx(expected, rel=1e-3)
    assert peak > 10 * grid.assembly.weight


def test_what_counts_beside_a_press_is_the_weight_that_its_carriers_bear() -> None:
    """Their own and that of a block which rests on one of them; not that of bodies that only touch them."""
    grid = held_plank(*(block(f"r{i}", (0.05,) * 3, (-0.125 - 0.05 * i, 0, 0.025), 3.0) for i in range(4)))
    load = grid.loads(column(grid, "plank", (0.05, 0, 0.12), DOWN))[0]
    expected = (1.0 + 1.0 + 5.0) / grid.assembly.mass.sum()
    assert expected < grid.load_bearing.weight(load) < 1.03 * expected  # faces are sheared a little, too
    all_of_them = grid.loads(body_forces(grid.assembly.mass[:, None] * DOWN)[:, None])[0]
    assert grid.load_bearing.weight(all_of_them) == 1.0


def test_loads_on_several_bodies_and_torques_are_left_to_others() -> None:
    grid = two_towers()
    assert not grid.load_bearing.balance(grid.loads(body_forces(grid.assembly.mass[:, None] * DOWN)[:, None])[0])
    torque = np.zeros((6 * len(grid.assembly.movable), 1))
    torque[5] = 1.0
    assert not grid.load_bearing.balance(grid.loads(torque)[0])
    assert not carried(grid, "c0_0", (-SIDE / 2, 0, SIDE / 2), (0, 0, 1))  # nothing is above that it would be held by


@pytest.mark.parametrize(("shift", "name"), [((0, 0), "b2_1_2"), ((0.1, 0.05), "b2_2_2")])
def test_presses_on_a_dense_pallet_end_at_some_weights_or_not_at_all(shift: tuple[float, float], name: str) -> None:
    """Sixty boxes, one of them pressed all over, in columns or with every other layer shifted.

    Of 70 presses on columns ten were undecided and ten ended far out, at more than 200 weights of the box. On shifted
    layers bodies that carry nothing float, and whether they touch those that do is decided last: 23 were undecided and
    13 ended far out.
    """
    size = np.array([0.3, 0.2, 0.15])
    places = [np.array([i, j, k]) for i in range(5) for j in range(4) for k in range(3)]
    feet = [size * (i, j, k + 0.5) + np.array([*shift, 0.0]) * (k % 2) for i, j, k in places]
    boxes = [block("b{}_{}_{}".format(*at), size, foot, 5.0) for at, foot in zip(places, feet, strict=True)]
    ground = block("floor", (10, 10, 0.1), (0, 0, -0.05), fixed=True)
    assembly = hf.assemble(hf.Scene([ground, *boxes], MU))
    found = hf.robustness_map(assembly, [name], spacing=0.06)
    proved = hf.robustness_map(assembly, [name], spacing=0.06, engine="limit")
    assert len(found.force) > 12
    assert not (found.status == hf.Status.UNDECIDED).any()
    endless = np.isinf(found.force)
    assert endless.sum() > 0.9 * len(endless)
    assert (found.force[~endless] < 10 * assembly.weight).all()
    assert (found.force <= proved.upper).all()
