"""Convex hulls in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.geometry.hull import (
    convex_hull,
    corner_numbers,
    hull_edges,
    hull_facets,
    outline_numbers,
    smallest_rectangle,
)
from holdfast.geometry.polygon import signed_area

BOX = hf.Box((0.1, 0.2, 0.3)).surface.vertices


@pytest.mark.parametrize("seed", range(5))
def test_the_three_ways_to_a_hull_in_the_plane_agree(seed: int) -> None:
    points = np.random.default_rng(seed).random((40, 2))
    corners = convex_hull(points, 0.0)
    assert signed_area(corners) > 0
    assert signed_area(points[corner_numbers(points)]) == pytest.approx(signed_area(corners), rel=1e-12)
    expected = {tuple(p) for p in corners.tolist()}
    assert {tuple(p) for p in points[corner_numbers(points)].tolist()} == expected
    assert {tuple(p) for p in points[outline_numbers(points)].tolist()} == expected


def test_points_along_an_edge_are_no_corners() -> None:
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5)), 2).reshape(-1, 2)
    assert len(convex_hull(grid, 1e-9)) == 4
    assert sorted(corner_numbers(grid).tolist()) == [0, 4, 20, 24]


@pytest.mark.parametrize("seed", range(8))
def test_no_rectangle_around_a_hull_is_smaller(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(30, 2)) * [1, 3]
    hull = convex_hull(points, 1e-9)
    axes, low, high = smallest_rectangle(hull)
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)
    along = points @ axes.T
    np.testing.assert_allclose([along.min(0), along.max(0)], [low, high])
    length, width = high - low
    assert length >= width
    angles = np.linspace(0, np.pi, 5000)
    one, other = np.stack([np.cos(angles), np.sin(angles)]), np.stack([-np.sin(angles), np.cos(angles)])
    areas = np.ptp(hull @ one, axis=0) * np.ptp(hull @ other, axis=0)
    assert length * width <= areas.min()
    assert length * width == pytest.approx(areas.min(), rel=1e-2)


def test_of_equal_rectangles_the_one_along_the_first_edge_is_taken() -> None:
    """Rounding leaves the four sides of a square by no more than 1e-15 apart."""
    for k in range(4):
        ring = np.roll(np.array([(0.1, 0), (0.4, 0), (0.4, 0.3), (0.1, 0.3)]), -k, axis=0)
        axes, _, _ = smallest_rectangle(ring)
        np.testing.assert_allclose(axes[0], (ring[1] - ring[0]) / 0.3, atol=1e-12)


def test_a_box_has_twelve_edges_and_six_facets() -> None:
    edges = hull_edges(BOX, 1e-6)
    assert len(edges) == 12
    lengths = np.linalg.norm(BOX[edges[:, 0]] - BOX[edges[:, 1]], axis=1)
    assert np.sort(lengths) == pytest.approx([0.1] * 4 + [0.2] * 4 + [0.3] * 4)
    facets = hull_facets(BOX, 1e-3)
    assert len(facets) == 6
    for normal, corners in facets:
        assert np.abs(normal).max() == pytest.approx(1)
        assert len(corners) == 4
        assert np.ptp(BOX[corners] @ normal) == pytest.approx(0)
        assert (BOX @ normal).max() == pytest.approx((BOX[corners] @ normal).min())


def test_what_lies_inside_is_no_part_of_a_hull() -> None:
    points = np.vstack([BOX, 0.5 * BOX])
    assert hull_edges(points, 1e-6).max() < 8
    assert all(corners.max() < 8 for _, corners in hull_facets(points, 1e-3))
