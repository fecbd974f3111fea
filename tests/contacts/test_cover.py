"""What a face that was found covers: points and lines that lie on it, to within the gap and no further."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from holdfast.contacts.interface import Patch
from holdfast.contacts.patches import Cover
from holdfast.contacts.search_mesh import Features

GAP = 1e-3
UP = np.array([0.0, 0, 1])
SQUARE = Patch(np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]), UP)


def features(*ends: list[tuple[float, float]]) -> Features:
    """Points, or lines between two, in the plane of the square with normals up."""
    both = np.array([[(*pair[0], 0.0), (*pair[-1], 0.0)] for pair in ends])
    count = len(both)
    normals = np.tile(UP, (count, 1))
    return Features(both, normals, np.zeros((count, 2)), np.full(count, np.inf), np.zeros(count, dtype=bool))


@pytest.mark.parametrize(
    ("x", "y", "free"),
    [
        (0.5, 0.5, False),
        (1.0, 0.5, False),
        (1.0009, 0.5, False),
        (1.0011, 0.5, True),
        (-0.0009, 0.5, False),
        (-0.0011, 0.5, True),
        (1.0006, 1.0006, False),
        (1.0008, 1.0008, True),
    ],
)
def test_a_point_is_covered_up_to_the_gap_from_the_edge(x: float, y: float, free: bool) -> None:
    """Beyond a corner the distance is that of the corner: 0.85 mm and 1.13 mm."""
    assert Cover([SQUARE], GAP).free(features([(x, y)])).tolist() == [free]


def test_a_line_is_covered_only_if_all_of_it_is() -> None:
    lines = features([(0.1, 0.5), (1.0009, 0.5)], [(0.1, 0.5), (1.01, 0.5)], [(1.01, 0.2), (1.01, 0.8)])
    assert Cover([SQUARE], GAP).free(lines).tolist() == [False, True, True]


def test_a_line_across_a_notch_is_not_covered_though_its_ends_are() -> None:
    notched = [(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0.6, 1, 0), (0.6, 0.2, 0), (0.4, 0.2, 0), (0.4, 1, 0), (0, 1, 0)]
    cover = Cover([Patch(np.array(notched), UP)], GAP)
    assert cover.free(features([(0.2, 0.5), (0.8, 0.5)], [(0.2, 0.1), (0.8, 0.1)])).tolist() == [True, False]


def test_what_is_left_of_a_line_begins_at_the_gap_from_the_edge() -> None:
    (left,) = Cover([SQUARE], GAP).left_of(np.array([(0.5, 0.5, 0.0), (1.5, 0.5, 0.0)]), UP, 1e-4, False)
    np.testing.assert_allclose(left, [(1 + GAP, 0.5, 0), (1.5, 0.5, 0)], atol=1e-8)


def test_a_point_beside_a_line_is_free() -> None:
    """A line has no inside: it covers nothing on either side of it beyond the gap."""
    slanted = Patch(np.array([(0.0, 0, 0), (1, 1, 0)]), UP)
    points = features([(0.2, 0.5)], [(0.5, 0.2)], [(0.5, 0.501)], [(1.0005, 1.0005)])
    assert Cover([slanted], GAP).free(points).tolist() == [True, True, False, False]


def test_each_of_many_patches_covers_what_lies_on_it() -> None:
    """Squares in rows, apart by their width, and points and lines in and between them."""
    corners = SQUARE.polygon * 0.1
    places = [np.array([0.2 * i, 0.2 * k, 0]) for i in range(12) for k in range(9)]
    cover = Cover([Patch(corners + place, UP) for place in places], GAP)
    on = [(x + 0.03, y + 0.03) for x, y, _ in places]
    beside = [(x + 0.15, y) for x, y in on]
    ends = [(x + 0.06, y) for x, y in on]
    assert not cover.free(features(*([point] for point in on))).any()
    assert cover.free(features(*([point] for point in beside))).all()
    lines = [*map(list, zip(on, ends, strict=True)), *map(list, zip(on, beside, strict=True))]
    assert np.flatnonzero(cover.free(features(*lines))).tolist() == list(range(len(on), 2 * len(on)))
    line = np.array([(-0.05, 0.05, 0.0), (0.35, 0.05, 0.0)])
    left = np.array(cover.left_of(line, UP, 1e-4, False))[:, :, 0]
    np.testing.assert_allclose(left, [(-0.05, -GAP), (0.1 + GAP, 0.2 - GAP), (0.3 + GAP, 0.35)], atol=1e-8)
    above = line + np.array([0, 0, 3 * GAP])
    assert cover.left_of(above, UP, 1e-4, False)[0].tolist() == above.tolist()


def test_a_star_of_needles_covers_what_is_within_reach() -> None:
    """Points at random, and their distances from all sides by hand."""
    angle = 2 * np.pi * np.arange(1200) / 1200
    radius = np.where(np.arange(1200) % 4 < 2, 1.0, 0.3)
    ring, by = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), 0.02
    points = np.random.default_rng(5).uniform(-1.1, 1.1, size=(400, 2))
    start, along = ring, np.roll(ring, -1, axis=0) - ring
    share = ((points[:, None] - start) * along).sum(2) / (along * along).sum(1)
    feet = start + np.clip(share, 0, 1)[..., None] * along
    away = np.linalg.norm(points[:, None] - feet, axis=2).min(1)
    away[shapely.intersects_xy(shapely.Polygon(ring), *points.T)] = 0.0
    star = Patch(np.column_stack([ring, np.zeros(len(ring))]), UP)
    free = Cover([star], by).free(features(*([(x, y)] for x, y in points)))
    assert free.tolist() == (away > by).tolist()
    assert 20 < free.sum() < 380
