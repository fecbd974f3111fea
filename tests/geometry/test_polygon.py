"""Flat polygons: straight corners left out, and unions of pieces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from holdfast.geometry import polygon as flat
from holdfast.geometry.polygon import signed_area, union, without_collinear

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def test_points_along_the_sides_are_left_out_and_corners_stay() -> None:
    steps = np.arange(10)[:, None] / 10
    ring = np.vstack([(1 - steps) * SQUARE[k] + steps * SQUARE[(k + 1) % 4] for k in range(4)])
    left = without_collinear(np.roll(ring, 3, axis=0), 1e-9)
    np.testing.assert_allclose(left, SQUARE, atol=1e-15)


def test_no_vertex_that_is_left_is_nearer_to_its_neighbours_line_than_the_tolerance() -> None:
    rng = np.random.default_rng(4)
    for tolerance in (1e-3, 0.03, 0.2):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 60))
        ring = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(0.9, 1, (60, 1))
        kept = without_collinear(ring, tolerance)
        assert 3 <= len(kept) < 60
        before, after = np.roll(kept, 1, axis=0), np.roll(kept, -1, axis=0)
        chord, back = after - before, kept - before
        height = np.abs(chord[:, 0] * back[:, 1] - chord[:, 1] * back[:, 0]) / np.hypot(*chord.T)
        assert len(kept) == 3 or (height > tolerance).all()


def test_pieces_of_a_square_with_a_hole_join_to_it() -> None:
    corners = np.arange(6) / 6
    cells = [SQUARE / 6 + [x, y] for x in corners for y in corners]
    hollow = [SQUARE / 6 + 1 / 3, SQUARE[::-1] / 18 + 7 / 18]
    pieces = [[cell] for cell in cells if not np.allclose(cell[0], 1 / 3)]
    ((outline, hole),) = union([*pieces, hollow], 1e-9, 1e-3)
    assert signed_area(outline) == pytest.approx(1, rel=1e-12)
    assert signed_area(hole) == pytest.approx(-1 / 18**2, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_moments_of_a_triangle_are_those_at_the_middles_of_its_sides(seed: int) -> None:
    """A third of the area times the values there: exact for polynomials of the second degree."""
    ring = flat.oriented(np.random.default_rng(seed).normal(size=(3, 2)))
    (a, b), (c, d) = ring[1] - ring[0], ring[2] - ring[0]
    x, y = ((ring + np.roll(ring, 1, axis=0)) / 2).T
    values = np.array([np.ones(3), x, y, x * x, x * y, y * y])
    np.testing.assert_allclose(
        flat.polynomial_moments([ring]), (a * d - b * c) / 6 * values.sum(1), rtol=1e-12, atol=1e-13
    )


def test_moments_of_a_rectangle_with_a_hole_are_their_difference() -> None:
    """Of x from a to b and y from c to d: (b^m - a^m) (d^n - c^n) / (m n), m and n one more than the powers."""

    def moments(a: float, b: float, c: float, d: float) -> list[float]:
        powers = [(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (1, 3)]
        return [(b**m - a**m) * (d**n - c**n) / (m * n) for m, n in powers]

    outer, inner = (-0.2, 1.3, 0.4, 2.0), (0.3, 0.9, 1.1, 1.4)
    rings = [np.array([[a, c], [b, c], [b, d], [a, d]]) for a, b, c, d in (outer, inner)]
    found = flat.polynomial_moments([rings[0], rings[1][::-1]])
    np.testing.assert_allclose(found, np.subtract(moments(*outer), moments(*inner)), rtol=1e-12)


def test_thousands_of_wedges_join_to_their_disc() -> None:
    """Wedges of a disc, cut in rings, overlap nowhere; their union is the whole polygon, with its area and no holes."""
    count, radii = 600, (0.0, 0.5, 1.0)
    angle = 2 * np.pi * np.arange(count + 1) / count
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    pieces = [
        [np.array([a * way[k], b * way[k], b * way[k + 1], a * way[k + 1]])[int(a == 0) :]]
        for a, b in itertools.pairwise(radii)
        for k in range(count)
    ]
    (outline,) = flat.union(pieces, 1e-9, 1e-6)
    assert len(outline) == 1
    assert flat.shapely_polygon(outline).area == pytest.approx(count / 2 * np.sin(2 * np.pi / count), rel=1e-6)


@pytest.mark.parametrize("count", [40, 1500])
@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
def test_needles_that_meet_at_a_point_keep_the_gaps_between_them(count: int, share: float) -> None:
    """Each is a triangle of two sides of length 1 and the angle 2 π share / count: its area is half the sine of it."""
    angle, half = 2 * np.pi * np.arange(count) / count, np.pi * share / count
    ends = [np.column_stack([np.cos(angle + turn), np.sin(angle + turn)]) for turn in (-half, half)]
    pieces = [[np.array([[0.0, 0.0], one, other])] for one, other in zip(*ends, strict=True)]
    found = flat.union(pieces, 1e-9, 1e-6)
    area = sum(signed_area(ring) for rings in found for ring in rings)
    assert area == pytest.approx(count / 2 * np.sin(2 * half), rel=1e-4)
