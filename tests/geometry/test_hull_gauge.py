"""The gauge of a hull beside scipy's linear programs, and what holds whatever a program is stopped at."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import linprog

from holdfast.geometry.hull import hull_gauge


def hull(size: int, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points along the axes and anywhere, some of them directions without an end."""
    rng = np.random.default_rng(seed)
    axes = np.vstack([np.diag(rng.uniform(0.2, 2, size)), -np.diag(rng.uniform(0.2, 2, size))])
    known = np.vstack([axes, rng.normal(size=(count, size))])
    price = np.where(rng.random(len(known)) < 0.02, 0.0, 1.0)
    return known, price


@pytest.mark.parametrize(("size", "count"), [(2, 5), (3, 40), (6, 20), (6, 300)])
def test_it_is_the_least_price_of_a_combination(size: int, count: int) -> None:
    known, price = hull(size, count, seed=count)
    points = np.random.default_rng(1).normal(size=(40, size))
    bounds, facets = hull_gauge(known, price, points)
    for point, bound, facet in zip(points, bounds, facets, strict=True):
        least = linprog(price, A_eq=known.T, b_eq=point).fun
        assert bound == pytest.approx(least, abs=1e-8)
        assert bound >= least - 1e-12
        assert facet @ point == pytest.approx(bound, abs=1e-9)
        assert (known @ facet <= price + 1e-8).all()


def test_zero_is_free_and_a_direction_without_an_end_is_nearly_so() -> None:
    known = np.vstack([np.eye(3), -np.eye(3)])
    price = np.array([1.0, 1, 1, 1, 1, 0])
    bounds, _ = hull_gauge(known, price, np.array([[0.0, 0, 0], [0, 0, -5], [0, 0, 5]]))
    assert bounds[0] == 0
    assert 0 <= bounds[1] < 1e-12
    assert bounds[2] == pytest.approx(5)


def test_coincident_points_do_not_stop_it() -> None:
    """Degenerate programs: every point four times, and points on the axes."""
    known, price = hull(6, 60, seed=3)
    many = np.vstack([known, known, known, known])
    points = np.vstack([np.eye(6), known[12:30]])
    once = hull_gauge(known, price, points)[0]
    np.testing.assert_allclose(hull_gauge(many, np.tile(price, 4), points)[0], once, rtol=1e-9, atol=1e-12)


def least_in_the_plane(known: np.ndarray, point: np.ndarray) -> Fraction:
    """The gauge of a hull around the origin, exactly: of all pairs of points, the least Σ λ that reaches ``point``."""
    rows = [[Fraction(x) for x in row] for row in known.tolist()]
    x, y = (Fraction(each) for each in point.tolist())
    found = []
    for (a, b), (c, d) in itertools.combinations(rows, 2):
        area = a * d - b * c
        if area:
            shares = (x * d - y * c) / area, (a * y - b * x) / area
            found += [sum(shares, Fraction(0))] if min(shares) >= 0 else []
    return min(found)


@pytest.mark.parametrize("seed", [74, 110, 115, 131, 147, 158, 217, 260])
@pytest.mark.parametrize("mirrored", [False, True])
def test_it_is_a_bound_in_exact_arithmetic_where_points_nearly_coincide(seed: int, mirrored: bool) -> None:
    """Their combinations miss a point by much of it, which the near points along the axes make dear."""
    rng = np.random.default_rng(seed)
    apart, near = 10.0 ** -rng.uniform(3, 13), 10.0 ** -rng.uniform(0, 6)
    angle = rng.uniform(0, 2 * np.pi)
    known = np.vstack(
        [near * np.eye(2), -near * np.eye(2), (np.cos(angle), np.sin(angle)) + apart * rng.normal(size=(6, 2))]
    )
    points = known[4:] * rng.uniform(0.5, 2, (6, 1)) + apart * rng.normal(size=(6, 2)) * rng.integers(0, 2)
    if mirrored:
        known[4:], points = -known[4:], -points
    bounds, _ = hull_gauge(known, np.ones(len(known)), points)
    for point, bound in zip(points, bounds.tolist(), strict=True):
        assert Fraction(bound) >= least_in_the_plane(known, point)
