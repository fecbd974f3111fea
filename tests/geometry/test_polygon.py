"""Flat polygons: straight corners left out, and unions of pieces."""

from __future__ import annotations

import numpy as np
import pytest

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
