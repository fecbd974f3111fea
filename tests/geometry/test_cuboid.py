"""Which surfaces are cuboids, and where these lie."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from holdfast.base.arrays import Float, Int
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body
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
