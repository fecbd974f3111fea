"""Which surfaces are cuboids, and where these lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from holdfast.base.arrays import Float, Int
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body, place_cuboids
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.shapes import Box, Cylinder, Mesh

SIZE = np.array([0.3, 0.2, 0.1])


def turned(vertices: Float) -> Float:
    turn = trimesh.transformations.random_rotation_matrix(np.array([0.2, 0.7, 0.4]))
    return np.asarray(vertices @ turn[:3, :3].T + [1, 2, 3])


def test_a_box_of_many_triangles_in_any_pose_is_one() -> None:
    mesh = trimesh.creation.box(SIZE).subdivide().subdivide()
    found = Surface(turned(np.array(mesh.vertices)), np.array(mesh.faces, dtype=np.int64)).cuboid
    assert found is not None
    np.testing.assert_allclose(np.sort(found.half), np.sort(SIZE / 2), atol=1e-15)
    np.testing.assert_allclose(found.centre, (1, 2, 3), atol=1e-12)
    np.testing.assert_allclose(found.axes @ found.axes.T, np.eye(3), atol=1e-14)
    corners = found.centre + np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * found.half @ (
        found.axes
    )
    expected = turned(Box(SIZE).surface.vertices)
    assert np.linalg.norm(corners[:, None] - expected, axis=2).min(1).max() < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_what_a_box_knows_is_what_its_triangles_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 10 ** rng.uniform(-3, 3, 3)
    for known in (Box(size).surface, HalfSpace(float(size[0])).surface):
        found = Surface(known.vertices, known.faces)
        assert (found.cuboid, found.reduced, found.closed) == (known.cuboid, known.reduced, known.closed)
        assert (found.diagonal, found.thickness, found.bends) == (known.diagonal, known.thickness, known.bends)
        assert (found.curved == known.curved).all()


def test_a_box_that_is_a_sheet_knows_nothing() -> None:
    sheet = Box((1.0, 1.0, 1e-6)).surface
    assert sheet.thickness == Surface(sheet.vertices, sheet.faces).thickness == 0.0


def test_boxes_placed_together_lie_where_each_lies_alone() -> None:
    rng = np.random.default_rng(3)
    poses = [trimesh.transformations.random_rotation_matrix(rng.random(3)) for _ in range(30)]
    poses[7] = np.round(poses[7], 6)
    bodies = [Body(f"b{k}", Box(rng.uniform(0.01, 1, 3)), mass=1.0, pose=pose) for k, pose in enumerate(poses)]
    together = [replace(body) for body in bodies]
    place_cuboids(together)
    for alone, body in zip(bodies, together, strict=True):
        corners = alone.surface_world.vertices
        assert (body.box[0] == corners.min(0)).all()
        assert (body.box[1] == corners.max(0)).all()
        assert (body.size, body.across, body.cuboid) == (alone.size, alone.across, alone.cuboid)
    assert together[7].cuboid is None
    assert None not in [body.cuboid for body in together[:7]]


def flattened(vertices: Float, faces: Int) -> tuple[Float, Int]:
    moved = vertices.copy()
    moved[moved[:, 2] > 0, 0] *= 0.9
    return moved, faces


def sheared(vertices: Float, faces: Int) -> tuple[Float, Int]:
    return vertices + 1e-6 * vertices[:, [2, 0, 1]] * [1, 0, 0], faces


def inside_out(vertices: Float, faces: Int) -> tuple[Float, Int]:
    return vertices, faces[:, ::-1]


def opened(vertices: Float, faces: Int) -> tuple[Float, Int]:
    return vertices, faces[1:]


@pytest.mark.parametrize("change", [flattened, sheared, inside_out, opened])
def test_what_is_nearly_a_box_is_none(change: Callable[[Float, Int], tuple[Float, Int]]) -> None:
    surface = Box(SIZE).surface
    vertices, faces = change(np.array(surface.vertices), np.array(surface.faces))
    assert Surface(vertices, np.ascontiguousarray(faces)).cuboid is None
    assert surface.cuboid is not None


def test_round_bodies_are_none() -> None:
    assert Cylinder(0.05, 0.1).surface.cuboid is None
    assert Cylinder(0.05, 0.1, segments=4).surface.cuboid is not None


def test_a_pose_to_six_digits_shears_it() -> None:
    pose = trimesh.transformations.rotation_matrix(0.3, (1, 2, 3))
    exact = Body("box", Box(SIZE), mass=1.0, pose=pose)
    assert exact.cuboid is not None
    vertices = exact.surface_world.vertices
    np.testing.assert_allclose(np.abs((vertices - exact.cuboid.centre) @ exact.cuboid.axes.T), [exact.cuboid.half] * 8)
    assert Body("box", Box(SIZE), mass=1.0, pose=np.round(pose, 6)).cuboid is None
    assert Body("box", Mesh(vertices, Box(SIZE).surface.faces), mass=1.0).cuboid is not None
