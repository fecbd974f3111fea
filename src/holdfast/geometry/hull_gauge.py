"""Upper bounds of the gauge of a convex set from known points, by small linear programs, thousands in a second."""

from __future__ import annotations

from typing import Final

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.ranges import SUM
from holdfast.native import core

SLIGHT: Final = core.SLIGHT  # a point that violates a facet by less does not count


def hull_gauge(known: Float, price: Float, points: Float) -> tuple[Float, Float]:
    """Return upper bounds (n,) of a gauge γ at ``points`` (n, d), and the facets (n, d) that give them.

    A gauge is convex and positively homogeneous. So γ(Σ λ x) <= Σ λ γ(x) for every combination of the ``known`` points
    (m, d) with λ >= 0, and γ of each known point is at most its ``price`` (m,): 1 for a point on the boundary of the
    set, 0 for a direction in which the set is unbounded. The first 2 d known points are along the positive and then the
    negative axes; a remainder that a combination does not reach is paid for along these.

    A facet is a y with y·x <= price at all known points for which y·point is the bound, up to rounding. Where the bound
    is differentiable, y is its derivative by the point.
    """
    return core.hull_gauge(np.ascontiguousarray(known), price, np.ascontiguousarray(points), SUM)
