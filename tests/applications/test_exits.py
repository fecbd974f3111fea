"""Straight-line motion: closed forms, and the distance found by an independent search on solids."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.applications.exits import clear_path, first_hit
from holdfast.rigid import pose_from
from holdfast.scene.surface import Surface

UP = np.array([0.0, 0.0, 1.0])


def box(size, centre, turn=(1.0, 0, 0, 0), name="box"):
    return hf.Body(name, hf.Box(size), mass=1, pose=pose_from(np.array(centre, float), np.array(turn)))


def hit(moving, still, direction, **options):
    return first_hit(moving.surface_world, still.surface_world, np.array(direction, float), **options)


def solid(surface: Surface) -> manifold3d.Manifold:
    return manifold3d.Manifold(
        manifold3d.Mesh64(np.array(surface.vertices, order="C"), surface.faces.astype(np.uint64, order="C"))
    )


def by_bisection(moving: Surface, still: Surface, direction: np.ndarray, reach: float) -> float:
    """The least distance at which the solids share volume, by a fine march and halving; inf where they never do."""

    def meets(t: float) -> bool:
        return (solid(moving).translate(tuple(t * direction)) ^ solid(still)).volume() > 1e-15

    steps = np.linspace(0, reach, 100)
    first = next((k for k, t in enumerate(steps) if meets(t)), None)
    if first is None:
        return np.inf
    low, high = steps[max(first - 1, 0)], steps[first]
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if meets(middle) else (middle, high)
    return float(high)


def test_a_box_falls_onto_a_box() -> None:
    lower, upper = box((1, 1, 0.1), (0, 0, -0.05)), box((0.1, 0.1, 0.1), (0.2, 0.1, 0.35))
    assert hit(upper, lower, -UP) == pytest.approx(0.3, abs=1e-12)
    assert hit(lower, upper, UP) == pytest.approx(0.3, abs=1e-12)
    assert hit(upper, lower, UP) == np.inf


def test_edge_on_edge() -> None:
    """Two bars on their edges, crossed: their edges meet, no corner of either is over the other."""
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    low = box((0.5, 0.1, 0.1), (0, 0, 0), (c, s, 0, 0))  # turned by 45 degrees about x
    high = box((0.1, 0.5, 0.1), (0, 0, 1), (c, 0, s, 0))
    assert hit(high, low, -UP) == pytest.approx(1 - 2 * 0.05 * np.sqrt(2), abs=1e-12)


def test_what_touches_moves_away_and_along_but_not_into() -> None:
    floor, cube = box((1, 1, 0.1), (0, 0, -0.05)), box((0.1, 0.1, 0.1), (0, 0, 0.05))
    assert hit(cube, floor, UP) == np.inf
    assert hit(cube, floor, (1, 0, 0)) == np.inf
    assert hit(cube, floor, (1, 0, -0.01)) == 0


def test_a_flush_neighbour_lets_pass_and_an_overhang_does_not() -> None:
    cube = box((0.1, 0.1, 0.1), (0, 0, 0.05))
    beside = box((0.1, 0.1, 0.3), (0.1, 0, 0.15))
    over = box((0.1, 0.1, 0.1), (0.09, 0, 0.25))
    assert hit(cube, beside, UP) == np.inf
    assert hit(cube, over, UP) == pytest.approx(0.1, abs=1e-12)
    near = box((0.1, 0.1, 0.3), (0.0995, 0, 0.25))  # overlaps by 0.5 mm, seen from above
    assert hit(cube, near, UP, slack=1e-4) == pytest.approx(0, abs=1e-12)
    assert hit(cube, near, UP, slack=1e-3) == np.inf


def test_slack_is_for_outlines_not_for_slivers() -> None:
    """A fan of 2,000 slivers, each narrower than the slack, stops what comes at it."""
    mesh = trimesh.creation.cylinder(0.1, 0.2, sections=2000)
    disc = Surface(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64))
    ball = hf.Body("ball", hf.Sphere(0.02, 4), mass=1, pose=pose_from(np.array([0.01, 0.0, 0.5]), np.eye(4)[0]))
    lowest = ball.surface_world.vertices[:, 2].min()
    assert first_hit(ball.surface_world, disc, -UP, slack=1e-3) == pytest.approx(lowest - 0.1, abs=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_as_the_solids_say(seed: int) -> None:
    """Random convex and non-convex solids along random directions, against marching with boolean volumes."""
    rng = np.random.default_rng(seed)
    bodies = []
    for place in ((0, 0, 0), (0.35, 0.0, 0.0)):
        kind = rng.integers(3)
        if kind == 0:
            mesh = trimesh.creation.torus(0.08, 0.03, major_sections=12, minor_sections=8)
        elif kind == 1:
            mesh = trimesh.convex.convex_hull(rng.normal(size=(12, 3)) * 0.05)
        else:
            mesh = trimesh.creation.box((0.1, 0.06, 0.16))
        turn = rng.normal(size=4)
        bodies.append(hf.Body("x", mesh, mass=1, pose=pose_from(np.array(place, float), turn)).surface_world)
    direction = np.array([1.0, 0, 0]) + 0.25 * rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    found = first_hit(bodies[0], bodies[1], direction)
    expected = by_bisection(bodies[0], bodies[1], direction, 0.8)
    if np.isfinite(expected):
        assert found == pytest.approx(expected, abs=5e-4)  # the solids need some volume to be seen
        assert found <= expected + 1e-9
    else:
        assert found == np.inf or found > 0  # a touch without volume


def test_rigid_motion_changes_nothing() -> None:
    rng = np.random.default_rng(3)
    a = hf.Body("a", trimesh.convex.convex_hull(rng.normal(size=(20, 3)) * 0.05), mass=1).surface_world
    b = box((0.2, 0.1, 0.1), (0.3, 0.02, 0.01)).surface_world
    way = np.array([1.0, 0.05, -0.02])
    pose = pose_from(rng.normal(size=3), rng.normal(size=4))
    moved = [Surface(s.vertices @ pose[:3, :3].T + pose[:3, 3], s.faces) for s in (a, b)]
    assert first_hit(*moved, pose[:3, :3] @ way) == pytest.approx(first_hit(a, b, way), rel=1e-9)


def test_clear_path_out_of_a_stack() -> None:
    lower = box((0.1, 0.1, 0.1), (0, 0, 0.05), name="lower")
    upper = box((0.1, 0.1, 0.1), (0, 0, 0.15), name="upper")
    both = (lower, upper)
    assert clear_path(upper, both, UP)
    assert not clear_path(lower, both, UP)
    assert clear_path(lower, both, np.array([1.0, 0, 0]))
    far = box((0.1, 0.1, 0.1), (0, 0, 0.5), name="far")
    assert clear_path(upper, (far,), UP, distance=0.2)
    assert not clear_path(upper, (far,), UP, distance=0.3)


def test_what_lies_in_each_other_has_no_way_in() -> None:
    """A tilted box sunk into a floor: its lower side crosses the floor's top, and no further way is free."""
    floor = box((1, 1, 0.1), (0, 0, -0.05))
    sunk = box((0.1, 0.1, 0.1), (0, 0, 0.04), (np.cos(0.2), np.sin(0.2), 0, 0))
    assert hit(sunk, floor, -UP) == 0
    assert hit(sunk, floor, UP) == np.inf
