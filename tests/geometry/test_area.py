"""Areas and normals of triangles and outlines."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.geometry.triangles import areas_of, normals_of, outline_vector

CORNERS = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])


def test_a_triangle_of_sides_3_4_5() -> None:
    faces = np.array([[0, 1, 2], [0, 2, 1]])
    assert areas_of(CORNERS, faces).tolist() == [6, 6]
    assert normals_of(CORNERS, faces).tolist() == [[0, 0, 1], [0, 0, -1]]


def test_a_needle_has_no_area_and_no_normal() -> None:
    faces = np.array([[0, 1, 1]])
    assert areas_of(CORNERS, faces).tolist() == [0]
    assert normals_of(CORNERS, faces).tolist() == [[0, 0, 0]]


def test_the_surface_of_a_box() -> None:
    surface = hf.Box((0.1, 0.2, 0.3)).surface
    assert surface.area == pytest.approx(2 * (0.1 * 0.2 + 0.2 * 0.3 + 0.3 * 0.1), rel=1e-14)
    assert surface.areas.sum() == surface.area


def test_an_outline_is_wound_around_its_vector_wherever_it_lies() -> None:
    ell = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)], dtype=float)
    ring = np.column_stack([ell, np.zeros(6)])
    assert outline_vector(ring) == pytest.approx([0, 0, 4])
    assert outline_vector(ring[::-1] + np.array([5, 6, 7])) == pytest.approx([0, 0, -4])


def test_outlines_that_face_each_axis_have_its_vector() -> None:
    """A rectangle of 2 x 3 in each of the three planes, and an oblique one by the cross product of its sides."""
    for axis in range(3):
        along, across = np.roll(np.eye(3), axis, axis=1)[[1, 2]]
        ring = np.array([0 * along, 2 * along, 2 * along + 3 * across, 3 * across]) + np.array([1.0, -2, 5])
        assert outline_vector(ring) == pytest.approx(6 * np.eye(3)[axis])
    a, b = np.array([1.0, 2, -1]), np.array([0.5, -1, 3])
    assert outline_vector(np.array([0 * a, a, a + b, b])) == pytest.approx(np.cross(a, b))
