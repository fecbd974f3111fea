"""The gauge of the convex hull of known points, as a linear program so small that thousands are solved in a second."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled

MOST_PIVOTS = 400  # of one program; whatever it is stopped at is a valid bound, for it is feasible throughout
SLIGHT = 1e-9  # a point that violates a facet by less does not count
ROUNDING = 1e-14  # of the terms of a sum: more than the rounding of every step of it


@compiled
def hull_gauge(known: Float, price: Float, points: Float) -> tuple[Float, Float]:
    """Return upper bounds (n,) of a gauge γ at ``points`` (n, d), and the facets (n, d) that give them.

    A gauge is convex and positively homogeneous, so a combination of the ``known`` points (m, d) with shares λ >= 0
    has γ <= Σ λ γ(known), and γ of each known point is at most its ``price`` (m,): 1 for a point on the border of the
    hull, 0 for a direction in which the hull has no end. The first 2 d known points lie along the positive and then
    the negative axes, and what a combination misses is paid for along these. The least Σ λ price is found by the
    simplex method, from the shares of the axes on, entering the point that a facet misses most (Dantzig's rule).

    A facet is the multiplier y of the least: y·x <= price at all known points, and y·point is the bound, up to
    rounding. It is the derivative of the bound by the point where that is differentiable.
    """
    count, size = points.shape
    total = len(known)
    bounds, facets = np.zeros(count), np.zeros((count, size))
    reach = np.empty((2, size))  # price of one unit along each axis
    for k in range(size):
        reach[0, k] = price[k] / known[k, k]
        reach[1, k] = -price[size + k] / known[size + k, k]
    for i in range(count):
        inverse, share, basis = np.zeros((size, size)), np.zeros(size), np.zeros(size, dtype=np.int64)
        for k in range(size):
            basis[k] = k if points[i, k] >= 0.0 else size + k
            inverse[k, k] = 1.0 / known[basis[k], k]
            share[k] = points[i, k] * inverse[k, k]
        facet = np.zeros(size)
        for _ in range(MOST_PIVOTS):
            for c in range(size):
                facet[c] = 0.0
                for k in range(size):
                    facet[c] += price[basis[k]] * inverse[k, c]
            enters, most = -1, SLIGHT
            for j in range(total):
                missed = -price[j]
                for c in range(size):
                    missed += facet[c] * known[j, c]
                if missed > most:
                    enters, most = j, missed
            if enters < 0 or not _exchanged(inverse, share, basis, known[enters], enters):
                break
        bounds[i] = _paid(inverse, basis, known, price, points[i], reach)
        facets[i] = facet
    return bounds, facets


@compiled
def _exchanged(inverse: Float, share: Float, basis: Int, entering: Float, number: int) -> bool:
    """Exchange the basis point whose share vanishes first for the entering one; tell whether there is one."""
    size = len(share)
    column = np.empty(size)
    largest = 0.0
    for k in range(size):
        column[k] = 0.0
        for c in range(size):
            column[k] += inverse[k, c] * entering[c]
        largest = max(largest, abs(column[k]))
    leaves, step = -1, np.inf
    for k in range(size):
        if column[k] > 1e-11 * largest:
            ratio = max(share[k], 0.0) / column[k]
            if ratio < step or (ratio == step and leaves >= 0 and column[k] > column[leaves]):
                leaves, step = k, ratio
    if leaves < 0:
        return False
    for c in range(size):
        inverse[leaves, c] /= column[leaves]
    for k in range(size):
        if k != leaves:
            share[k] -= step * column[k]
            for c in range(size):
                inverse[k, c] -= column[k] * inverse[leaves, c]
    share[leaves] = step
    basis[leaves] = number
    return True


@compiled
def _paid(inverse: Float, basis: Int, known: Float, price: Float, point: Float, reach: Float) -> float:
    """Return what the basis pays for a point: shares once refined and none negative, and what they miss."""
    size = len(point)
    share, missing = np.zeros(size), point.copy()
    for _ in range(2):
        for k in range(size):
            for c in range(size):
                share[k] += inverse[k, c] * missing[c]
            share[k] = max(share[k], 0.0)
        for c in range(size):
            missing[c] = point[c]
            for k in range(size):
                missing[c] -= share[k] * known[basis[k], c]
    total = 0.0
    for k in range(size):
        total += share[k] * price[basis[k]]
    for c in range(size):
        terms = abs(point[c])
        for k in range(size):
            terms += share[k] * abs(known[basis[k], c])
        total += max(missing[c], 0.0) * reach[0, c] + max(-missing[c], 0.0) * reach[1, c]
        total += ROUNDING * terms * max(reach[0, c], reach[1, c])
    return total * (1.0 + ROUNDING)
