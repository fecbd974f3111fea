"""The cubic between two points of a load path, against its values at many places."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from holdfast.native import core

X = np.linspace(0, 1, 100_001)
ENDS = [  # height and slope at the first end, height and slope at the second
    (1.0, 1.0, 1.0, -1.0),
    (1.0, 0.3, 1.2, -5.0),
    (1.0, 5.0, 0.9, -0.1),
    (1.0, 1e-20, 1.5, -1e-3),
    (1.0, 1.0, 1.0, -1e-20),
    (1.0, 2.0, 1.1, -3.0),
    (1.0, 9.0, 0.5, 1.0),  # a maximum and a minimum
    (1.0, 6.0, 0.9, 0.1),
    (1.0, -2.0, 1.5, -3.0),  # a minimum and a maximum
]


def heights(start: float, a: float, end: float, b: float) -> NDArray[np.float64]:
    """By Hermite's basis."""
    return (
        (2 * X**3 - 3 * X**2 + 1) * start + (X**3 - 2 * X**2 + X) * a + (3 * X**2 - 2 * X**3) * end + (X**3 - X**2) * b
    )


@pytest.mark.parametrize("ends", ENDS)
def test_it_has_the_heights_and_slopes_of_its_ends(ends: tuple[float, float, float, float]) -> None:
    y = heights(*ends)
    for at in (0, 12_345, 50_000, 99_000, 100_000):
        assert core.cubic(X[at], *ends) == pytest.approx(y[at], abs=1e-12)
    assert core.least_slope(*ends) == pytest.approx(np.gradient(y, X).min(), abs=1e-3)


@pytest.mark.parametrize("ends", ENDS)
def test_its_extrema_are_where_it_is_highest_and_lowest(ends: tuple[float, float, float, float]) -> None:
    start, a, end, b = ends
    y = heights(*ends)
    assert core.cubic(core.maximum_at(*ends), *ends) == pytest.approx(y.max(), abs=1e-9)
    upside_down = -start, -a, -end, -b
    assert core.minimum_at(*upside_down) == core.maximum_at(*ends)
    if a * b > 0:
        assert core.cubic(core.minimum_at(*ends), *ends) == pytest.approx(y.min(), abs=1e-9)
    else:
        assert core.minimum_at(*ends) == -1.0


@pytest.mark.parametrize(
    "ends",
    [
        (1.0, 1.0, 2.0, 1.0),  # straight
        (1.0, 1.0, 1.5, 0.5),
        (1.0, 0.5, 1.5, 1.0),
        (1.0, -1.0, 1.0, 1.0),  # a minimum alone
        (1.0, 1.0, 2.5, 3.0),
    ],
)
def test_it_may_have_no_maximum(ends: tuple[float, float, float, float]) -> None:
    assert core.maximum_at(*ends) == -1.0


@pytest.mark.parametrize(("bend", "counts"), [(0.05, True), (0.11, False), (0.5, False)])
def test_where_one_bend_explains_both_slopes_no_maximum_is_suspected(bend: float, counts: bool) -> None:
    """From the slope 1 to the slope 0.01 at ``bend``: the cubic goes higher and comes back."""
    ends = 0.0, 1.0, bend + 0.01 * (1 - bend), 0.01
    assert (core.maximum_at(*ends) > 0) == counts


@pytest.mark.parametrize(
    ("ends", "x", "height"),
    [
        ((1.0, 1.0, 1.0, -1.0), 0.5, 1.5),  # the tangents meet
        ((1.0, 0.1, 1.2, -1.0), None, None),  # they would meet beyond the second end
        ((1.0, -2.0, 1.5, -3.0), None, None),
        ((1.0, 0.5, 1.3, 0.2), 0.5, 1.5),  # nothing tells
    ],
)
def test_the_summit_is_where_tangents_meet_or_the_cubic_has_it(
    ends: tuple[float, float, float, float], x: float | None, height: float | None
) -> None:
    y = heights(*ends)
    expected = (X[y.argmax()], y.max()) if x is None else (x, height)
    assert core.summit(*ends) == pytest.approx(expected, abs=2e-5)
