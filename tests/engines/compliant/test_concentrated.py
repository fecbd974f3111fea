"""Bodies that tip over a round foot or a corner: forces are concentrated there, and ``lower`` allows for that."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from engine_scenes import G0, Array
from placed import at

import holdfast as hf
from bench.scenes.random_pushes import Push, random_pushes
from bench.scenes.real_pallets import pallet, pallets
from holdfast.assembly.assembly import body_forces
from holdfast.engines.compliant.elastic_model import Places
from holdfast.engines.compliant.grid import concentrated

RADIUS, HEIGHT, MASS = 0.04, 0.14, 1.0


def turned(degrees: float, about: float = 0.0) -> Array:
    """The axes of a ramp that falls by ``degrees`` along the direction ``about`` degrees from x, as columns."""
    a, b = np.radians([degrees, about])
    slope = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    return np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]]) @ slope


def placed(axes: Array, x: float, y: float, z: float) -> Array:
    return at(*(axes @ (x, y, z)), axes)


def on_board(axes: Array, *bodies: hf.Body, mu: float) -> hf.answers.Assembly:
    board = hf.Body("board", hf.Box((0.4, 0.4, 0.1)), pose=placed(axes, 0, 0, -0.05), fixed=True)
    return hf.assemble(hf.Scene([board, *bodies], friction=mu))


def jar(axes: Array) -> hf.Body:
    return hf.Body("jar", hf.Cylinder(RADIUS, HEIGHT), mass=MASS, pose=placed(axes, 0, 0, HEIGHT / 2))


@pytest.mark.parametrize("slope", [0.0, 12.0])
@pytest.mark.parametrize("corner", [0, 1, 2, 3, 6])
def test_a_jar_tips_over_its_rim_where_statics_says(slope: float, corner: int) -> None:
    """A push through the axis tips the jar over a corner of its prism: R h = m g (r cos a - c sin a cos φ).

    The weight's moment about the tipping corner is taken in the plane of the push; across it, the push passes through
    the axis and friction is ample. Downhill alone the ramp turns nothing else, so φ is 0 there.
    """
    phi = 2 * np.pi * corner / 64 if slope == 0 else 0.0
    axes = turned(slope, 90.0 * corner)  # the whole scene about the vertical: another way for nodes to lie
    way = axes @ (np.cos(phi), np.sin(phi), 0)
    at = 0.13
    tilt = np.radians(slope)
    exact = MASS * G0 * (RADIUS * np.cos(tilt) - HEIGHT / 2 * np.sin(tilt)) / at
    point = axes @ (0, 0, at) - RADIUS * way
    found = hf.robustness(on_board(axes, jar(axes), mu=0.8), "jar", point, way)
    assert found.lower[0] <= found.force[0] <= exact * (1 + 1e-6)
    assert found.force[0] == pytest.approx(exact, rel=0.03)  # 24 of 64 corners are nodes
    many = hf.robustness(on_board(axes, jar(axes), mu=0.8), "jar", point, way, engine=hf.Compliant(nodes=28))
    assert many.force[0] == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("sides", [3, 5, 6, 8])
def test_prisms_tip_over_an_edge_where_statics_says_on_few_nodes(sides: int) -> None:
    """All corners of the foot are nodes, whatever the grid is, so that no tipping edge is cut short."""
    foot = hf.Body("foot", hf.Cylinder(0.05, 0.3, segments=sides), mass=1.0, pose=placed(np.eye(3), 0, 0, 0.15))
    way = np.array([np.cos(np.pi / sides), np.sin(np.pi / sides), 0])
    exact = G0 * 0.05 * np.cos(np.pi / sides) / 0.28
    point = (0, 0, 0.28) - 0.05 * np.cos(np.pi / sides) * way
    found = hf.robustness(on_board(np.eye(3), foot, mu=0.7), "foot", point, way)
    assert found.force[0] == pytest.approx(exact, rel=1e-4)


@cache
def population() -> list[tuple[hf.answers.Assembly, Push]]:
    """Random pushes on random jars and cups: level, on ramps, over an edge of the board, and on each other."""
    pairs = []
    for seed in range(24):
        rng = np.random.default_rng(seed)
        mu = rng.uniform(0.3, 0.8)
        axes = turned(rng.uniform(0, 0.7) * np.degrees(np.arctan(mu)), rng.uniform(0, 360))
        radius = rng.uniform(0.02, 0.06)
        height = radius * rng.uniform(1.5, 4)
        over = 0.2 - radius * rng.uniform(0, 0.8) if seed % 3 == 0 else 0.0
        shape = hf.Cylinder(radius, height, segments=int(rng.choice([6, 32, 64])))
        bodies = [hf.Body("low", shape, mass=1.0, pose=placed(axes, over, 0, height / 2))]
        if seed % 3 == 1:
            there = placed(axes, 0.4 * radius, 0, 1.5 * height)
            bodies.append(hf.Body("high", shape, mass=rng.uniform(0.3, 2), pose=there))
        assembly = on_board(axes, *bodies, mu=mu)
        if hf.stability(assembly).status is hf.Status.STABLE:
            pairs += [(assembly, push) for push in random_pushes(assembly, rng, 4, slant=50)]
    return pairs


def excess() -> Array:
    """By what share ``lower`` lies above the answer on 56 nodes a side, for all pushes of the population."""
    shares = []
    for assembly, push in population():
        found, many = (hf.robustness(assembly, *push, engine=hf.Compliant(nodes=nodes)) for nodes in (7, 56))
        if 0 < many.force[0] < np.inf:
            assert found.lower[0] <= found.force[0]
            shares.append(found.lower[0] / many.force[0] - 1)
    return np.array(shares)


def test_lower_is_below_the_answer_on_many_nodes() -> None:
    found = excess()
    assert len(found) >= 60
    assert found.max() <= 1e-3
    assert np.median(found) >= -0.012  # and it is not low for nothing


def test_a_ball_on_one_node_has_not_gathered() -> None:
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1.0, pose=placed(np.eye(3), 0, 0, 0.05))
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=placed(np.eye(3), 0.15, 0, 0.05))

    assembly = on_board(np.eye(3), ball, cube, mu=0.5)
    grid = hf.Compliant().on(assembly, assembly.weight_wrench()).refined.grid
    assert not concentrated(grid.places, grid.system.model, grid.settled.q[None]).any()


def test_contacts_without_nodes_change_nothing() -> None:
    """Of three jars the one in the middle has none: the other two are told as with it."""
    jars = [
        replace(jar(np.eye(3)), name=f"jar{k}", pose=placed(np.eye(3), 0.1 * k - 0.1, 0, HEIGHT / 2)) for k in range(3)
    ]
    assembly = on_board(np.eye(3), *jars, mu=0.5)
    grid = hf.Compliant().on(assembly, assembly.weight_wrench()).refined.grid
    kept = Places.at(assembly, grid.nodes.chosen(grid.nodes.interface != 1))
    model = grid.springs.model(kept, assembly.weight_wrench())
    push = np.zeros((18, 1))
    push[12:, 0] = (1, 0, 0, 0, 0.06, 0)  # on the last jar, above its middle: it tips over its rim
    tipping = grid.paths(push).q[0]
    for q, few in ((grid.settled.q, False), (tipping, True)):
        assert concentrated(grid.places, grid.system.model, q[None]).any(1).tolist() == [few]
        assert concentrated(kept, model, q[None]).any(1).tolist() == [few]


def test_the_edge_of_a_rectangle_is_enough_to_tip_over_and_its_corner_is_not() -> None:
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=placed(np.eye(3), 0, 0, 0.05))
    assembly = on_board(np.eye(3), cube, mu=0.9)
    grid = hf.Compliant().on(assembly, assembly.weight_wrench()).refined.grid
    for way, few in ((np.array([1.0, 0, 0]), False), (np.array([1.0, 1, 0]) / np.sqrt(2), True)):
        load = np.concatenate([way, np.cross((0, 0, 0.05), way)])
        assert grid.concentrated(grid.paths(load[:, None]).q).any(1).tolist() == [few]


def test_only_contacts_that_gather_get_more_nodes() -> None:
    jars = [replace(jar(np.eye(3)), name=f"jar{k}", pose=placed(np.eye(3), 0.1 * k, 0, HEIGHT / 2)) for k in range(2)]
    assembly = on_board(np.eye(3), *jars, mu=0.5)
    grid = hf.Compliant().on(assembly, assembly.weight_wrench()).refined.grid
    some, most = grid.with_more(np.array([1]), 28), grid.with_more(np.array([1]), 56, 2)
    many = hf.Compliant(nodes=28).on(assembly, assembly.weight_wrench()).refined.grid
    for local, others in ((some, grid), (most, grid.finer)):
        here, there = (np.bincount(each.nodes.interface, each.nodes.weights) for each in (local, others))
        np.testing.assert_allclose(here, there, rtol=1e-9)
        assert np.bincount(local.nodes.interface)[0] == np.bincount(others.nodes.interface)[0]
    assert np.bincount(some.nodes.interface)[1] == np.bincount(many.nodes.interface)[1]
    way = np.array([np.cos(0.3), np.sin(0.3), 0])
    push = np.zeros((12, 2))
    push[6:, 0] = push[:6, 1] = np.concatenate([way, np.cross((0, 0.01, 0.06), way)])  # it tips beside a corner
    coarse, fine, mixed = (each.paths(push).peak for each in (grid, many, some))
    assert (coarse > 1.01 * fine).all()
    assert mixed[0] == pytest.approx(fine[0], rel=1e-4)  # of the jar with many nodes as with many everywhere
    assert mixed[1] == pytest.approx(coarse[1], rel=1e-4)
    assert grid.with_more(np.array([1]), 28) is some


def test_concentrated_forces_are_looked_at_on_large_pallets_too() -> None:
    """25 boxes, braked along 135 degrees: 3.97 m/s² on seven nodes a side, 3.40 to 3.41 on 10, 14, 20 and 28."""
    loads = pallets()
    if not loads:
        pytest.skip("the pallets of shared/cases are not beside this checkout")
    assembly = hf.assemble(pallet(loads[29]))
    way = np.array([-np.sqrt(0.5), np.sqrt(0.5), 0])
    W = body_forces(-assembly.mass[:, None] * way)[:, None]
    state = hf.Compliant().prepare(assembly)
    found = state.load_factor(W)
    many = hf.Compliant(nodes=20).prepare(assembly).grid.paths(W).peak[0]
    assert state.grid.paths(W).peak[0] > 1.1 * many
    assert found.lower[0] <= many
    assert found.force[0] == pytest.approx(many, rel=0.01)
