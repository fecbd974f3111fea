"""Hulls of points whose gauge was asked: of a ball, where it is exact, and of a star, where it must be lowered."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.base.arrays import Float
from holdfast.geometry.hull import hull_gauge
from holdfast.queries.checked_hull import checked_hull

DRAWN_IN = 1.05  # by which the value stays below what was asked


@pytest.mark.parametrize(("power", "convex"), [(2.0, True), (0.5, False)], ids=["ball", "star"])
def test_the_value_stays_a_twentieth_below_all_that_was_asked(power: float, convex: bool) -> None:
    """The set is that of loads whose absolute values to this power add to 1 at most."""
    asked = []

    def lower(loads: Float) -> Float:
        asked.append(loads)
        return np.asarray((np.abs(loads) ** power).sum(1) ** (-1 / power))

    found = checked_hull(lower, np.zeros((0, 3)), 0.0, 240, "test")
    loads = np.vstack(asked)
    value = 1 / hull_gauge(found.hull.known, found.hull.price, loads)[0]
    share = value * DRAWN_IN / lower(loads)
    assert share.max() == pytest.approx(1, abs=1e-6)
    assert share[:6] == pytest.approx(np.ones(6), abs=1e-6) or not convex
    assert (found.failed > 0) is not convex
    assert len(loads) == found.hull.solves
