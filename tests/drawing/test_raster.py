"""The z-buffer: what hides what, and where lines run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing.render import CREASE, OUTLINE, PLAIN, Layer, rasterise

FACING = np.array([0.0, 0.0, 1.0])


def draw(pixels: list[list[float]], triangles: list[list[int]], **more: NDArray[np.float64]) -> Layer:
    normals = more.get("normals", np.tile(FACING, (len(triangles), 1)))
    body = np.asarray(more.get("body", np.zeros(len(triangles)))).astype(np.int64)
    return rasterise(np.array(pixels), np.array(triangles), normals, body, 10.0, (20, 30))


def test_the_nearer_triangle_hides_the_farther_whatever_the_order() -> None:
    far = [[0.0, 0.0, 5.0], [30.0, 0.0, 5.0], [0.0, 20.0, 5.0]]
    near = [[0.0, 0.0, 2.0], [10.0, 0.0, 2.0], [0.0, 10.0, 2.0]]
    for order, front in (([[0, 1, 2], [3, 4, 5]], 1), ([[3, 4, 5], [0, 1, 2]], 0)):
        layer = draw(far + near, order)
        assert layer.triangle[2, 2] == front
        assert layer.triangle[2, 20] == 1 - front
        assert layer.triangle[19, 29] == -1
        assert layer.depth[2, 2] == 2.0
        assert np.isinf(layer.depth[19, 29])


def test_depth_is_interpolated_between_crossing_triangles() -> None:
    tilted = [[0.0, 0.0, 0.0], [60.0, 0.0, 6.0], [0.0, 60.0, 0.0]]
    flat = [[0.0, 0.0, 1.5], [60.0, 0.0, 1.5], [0.0, 60.0, 1.5]]
    layer = draw(tilted + flat, [[0, 1, 2], [3, 4, 5]])
    assert np.all(layer.triangle[:15, :14] == 0)
    assert np.all(layer.triangle[:15, 16:28] == 1)


def test_of_two_faces_in_one_place_the_one_towards_the_viewer_is_seen() -> None:
    corners = [[0.0, 0.0, 1.0], [30.0, 0.0, 1.0], [0.0, 20.0, 1.0]]
    for order in ([1.0, -1.0], [-1.0, 1.0]):
        layer = draw(corners + corners, [[0, 1, 2], [3, 4, 5]], normals=np.outer(order, FACING))
        assert layer.triangle[3, 3] == order.index(1.0)


def test_shared_edges_leave_no_gap() -> None:
    square = [[3.3, 2.1, 1.0], [26.7, 2.1, 1.0], [26.7, 17.9, 1.0], [3.3, 17.9, 1.0]]
    layer = draw(square, [[0, 1, 2], [0, 2, 3]])
    assert np.all(layer.triangle[2:18, 3:27] >= 0)
    assert np.count_nonzero(layer.triangle >= 0) == 16 * 24


def test_lines_tell_bodies_bends_and_flat_cells_apart() -> None:
    corners = [[0.0, 0.0, 1.0], [15.0, 0.0, 1.0], [15.0, 20.0, 1.0], [0.0, 20.0, 1.0], [30.0, 0.0, 1.0], [30.0, 20, 1]]
    triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]
    bent = np.array([FACING, FACING, [0.8, 0.0, 0.6], [0.8, 0.0, 0.6]])
    at = (10, 15)
    assert draw(corners, triangles).line[at] == PLAIN
    assert draw(corners, triangles, body=np.array([0.0, 0.0, 1.0, 1.0])).line[at] == OUTLINE
    bent_corners = [*corners[:4], [30.0, 0.0, 3.0], [30.0, 20.0, 3.0]]
    assert draw(bent_corners, triangles, normals=bent).line[at] == CREASE


def test_a_step_between_parallel_faces_of_one_body_is_outlined() -> None:
    low = [[0.0, 0.0, 5.0], [15.0, 0.0, 5.0], [15.0, 20.0, 5.0]]
    high = [[15.0, 0.0, 1.0], [30.0, 0.0, 1.0], [15.0, 20.0, 1.0]]
    layer = draw(low + high, [[0, 1, 2], [3, 4, 5]])
    assert layer.line[5, 15] == OUTLINE
