"""How often a surface winds around a point."""

from __future__ import annotations

import numpy as np
import trimesh

import holdfast as hf
from holdfast.geometry.distance import winding_number
from holdfast.geometry.surface import Surface


def test_a_closed_surface_winds_once_around_what_is_inside_and_turned_over_minus_once() -> None:
    torus = trimesh.creation.torus(1.0, 0.3)
    points = np.random.default_rng(2).uniform(-1.4, 1.4, (500, 3))
    inside = (np.hypot(*points[:, :2].T) - 1) ** 2 + points[:, 2] ** 2
    sure = np.abs(np.sqrt(inside) - 0.3) > 0.02  # the mesh is inside the torus
    faces = np.array(torus.faces, dtype=np.int64)
    for sense, corners in ((1.0, faces), (-1.0, faces[:, ::-1])):
        found = winding_number(points[sure], Surface(np.array(torus.vertices), corners))
        np.testing.assert_allclose(found, sense * (inside[sure] < 0.09), atol=1e-9)


def test_two_surfaces_one_in_the_other_wind_twice() -> None:
    large, small = hf.Box((2, 2, 2)).surface, hf.Box((1, 1, 1)).surface
    both = Surface(
        np.vstack([large.vertices, small.vertices]), np.vstack([large.faces, small.faces + len(large.vertices)])
    )
    np.testing.assert_allclose(
        winding_number(np.array([[0.1, 0.2, 0.3], [0.8, 0.2, 0], [3, 0, 0]]), both), [2, 1, 0], atol=1e-12
    )


def test_a_cap_is_seen_under_its_solid_angle() -> None:
    """From its centre, a square of side 2 at height h is seen under 4 asin(1 / (1 + h²))."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    square = Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    for height in (0.01, 0.5, 3.0):
        expected = np.arcsin(1 / (1 + height**2)) / np.pi
        points = np.array([[0, 0, -height], [0, 0, height]])
        np.testing.assert_allclose(winding_number(points, square), [expected, -expected])
