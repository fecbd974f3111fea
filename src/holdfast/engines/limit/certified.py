"""Certified maps: bounds for many unit pushes on one body from few solves.

γ(w) = 1/R(w) is a gauge: convex, and γ(t w) = t γ(w). So cuts proved by the duals of earlier solves bound it from
below, for every load on every body, and combinations of solved loads bound it from above: on a flat face, where pushes
share their direction, by interpolation on a triangulation; elsewhere by non-negative combinations of nearby solved
loads, with what they miss paid for along the axes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from holdfast.base.arrays import Float, Int
from holdfast.base.progress import report
from holdfast.engines.directions import flat_groups, moment_frame
from holdfast.engines.limit.combination import combined
from holdfast.engines.limit.gauge import Cuts, Field
from holdfast.engines.limit.load_limit import LoadLimit
from holdfast.engines.verdict import Status

NEIGHBOURS = 10  # solved loads, the nearest, that are combined for a bound at another one

Solve = Callable[[Float], LoadLimit]


def certify(columns: Float, first: int, solve: Solve, cuts: Cuts, gap: float, lever: float) -> Field:
    """Bounds for load columns (6J, n) that load one body, at rows ``first`` to ``first + 6``, within ``gap``.

    ``lever`` [m] makes torques comparable with forces.
    """
    count = columns.shape[1]
    loads = np.ascontiguousarray(columns[first : first + 6].T)
    bounds = Field(
        loads,
        first,
        cuts,
        np.zeros(count),
        np.full(count, np.inf),
        np.full(count, -1),
        np.zeros(count, dtype=bool),
        np.zeros(count, dtype=bool),
    )

    def at(k: int) -> None:
        _enter(bounds, k, solve(columns[:, k]))

    def elsewhere(load: Float) -> float:
        full = np.zeros(len(columns))
        full[first : first + 6] = load
        limit = solve(full)
        cuts.learn(limit)
        return _high(limit)

    groups, rest = flat_groups(loads)
    for members in groups:
        _flat(bounds, members, at, elsewhere, gap)
        report("certified bounds", count - int(bounds.doubtful(np.arange(count), gap).sum()), count)
    if len(rest):
        _curved(bounds, rest, at, elsewhere, gap, lever)
    return bounds


def _high(limit: LoadLimit) -> float:
    """The upper bound of γ that one solved load proves."""
    if limit.status is Status.INFINITE:
        return 0.0
    return 1 / limit.lower if limit.lower > 0 else np.inf


def _enter(bounds: Field, k: int, limit: LoadLimit) -> None:
    """Take load ``k`` as solved."""
    number = bounds.cuts.learn(limit)
    bounds.solved[k] = True
    bounds.undecided[k] = limit.status is Status.UNDECIDED
    bounds.high[k] = _high(limit)
    bounds.low[k] = 0.0 if limit.status is not Status.FINITE else 1 / limit.upper if limit.upper > 0 else np.inf
    if number is not None:
        bounds.cut[k] = number


def _flat(
    bounds: Field, members: Int, at: Callable[[int], None], elsewhere: Callable[[Float], float], gap: float
) -> None:
    """Pushes of one direction: γ is convex over the plane of their moments; refine a triangulation of it."""
    force = bounds.loads[members[0], :3]
    frame = moment_frame(force)
    chart = bounds.loads[members, 3:] @ frame.T
    low, high = chart.min(0), chart.max(0)
    pad = 1e-6 * max(float((high - low).max()), 1e-12)
    low, high = low - pad, high + pad
    unit = (chart - low) / (high - low)
    places = [np.array([x, y], dtype=float) for x in (0, 1) for y in (0, 1)]
    values = [elsewhere(np.concatenate([force, (low + place * (high - low)) @ frame])) for place in places]
    while True:
        bounds.rise()
        undone = np.flatnonzero(bounds.doubtful(members, gap))
        if not len(undone):
            return
        facet = np.arange(len(undone))
        if np.isfinite(values).all():
            above, facet = _envelope(np.array(places), np.array(values), unit[undone])
            bounds.high[members[undone]] = np.minimum(bounds.high[members[undone]], above)
        still = bounds.doubtful(members[undone], gap)
        undone, facet = undone[still], facet[still]
        for index in undone[_worst_of_each(facet, _doubt(bounds, members[undone]))]:
            at(int(members[index]))
            places.append(unit[index])
            values.append(float(bounds.high[members[index]]))


def _envelope(places: Float, values: Float, points: Float) -> tuple[Float, Int]:
    """Upper bounds (n,) of a convex function known at ``places`` (m, 2) of a square, and the facet that gives each.

    The planes through the facets of the lower hull; over each facet its own plane interpolates, so the largest of all
    planes is never below the function, however the hull was joggled.
    """
    height = max(float(np.ptp(values)), 1e-300)
    lifted = np.column_stack([places, (values - values.min()) / height])
    hull = ConvexHull(np.vstack([lifted, [[0.5, 0.5, 1e3]]]), qhull_options="QJ Pp")
    facets = hull.simplices[(hull.simplices < len(places)).all(1) & (hull.equations[:, 2] < 0)]
    a, b, c = (places[facets[:, k]] for k in range(3))
    u, v = b - a, c - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    kept = np.abs(area) > 1e-10
    facets, a, u, v, area = facets[kept], a[kept], u[kept], v[kept], area[kept]
    rise_u, rise_v = values[facets[:, 1]] - values[facets[:, 0]], values[facets[:, 2]] - values[facets[:, 0]]
    slope_x = (rise_u * v[:, 1] - rise_v * u[:, 1]) / area
    slope_y = (rise_v * u[:, 0] - rise_u * v[:, 0]) / area
    level = values[facets[:, 0]] - slope_x * a[:, 0] - slope_y * a[:, 1]
    heights = np.outer(points[:, 0], slope_x) + np.outer(points[:, 1], slope_y) + level
    best = np.argmax(heights, axis=1)
    top = heights[np.arange(len(points)), best]
    return np.maximum(np.where(top > 1e-12 * values.max(), top, 0.0), 0.0), best


def _doubt(bounds: Field, members: Int) -> Float:
    """How much bounds disagree: absolute, in γ, so that the points which weigh most in neighbours come first."""
    high = bounds.high[members]
    return np.where(np.isfinite(high), high - bounds.low[members], np.inf)


def _worst_of_each(group: Int, doubt: Float) -> Int:
    """One index a group: the largest doubt."""
    order = np.lexsort((-doubt, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))]


def _curved(
    bounds: Field,
    members: Int,
    at: Callable[[int], None],
    elsewhere: Callable[[Float], float],
    gap: float,
    lever: float,
) -> None:
    """Pushes in many directions: non-negative combinations of the nearest solved loads."""
    loads = bounds.loads[members]
    scale = np.repeat([1.0, lever], 3)
    unit = loads / scale
    axes = np.array([[elsewhere(sign * e * scale) for e in np.eye(6)] for sign in (1.0, -1.0)])
    batch = max(12, len(members) // 100)
    for k in _spread(unit, np.empty((0, 6)), batch):
        at(int(members[k]))
    while True:
        bounds.rise()
        undone = np.flatnonzero(bounds.doubtful(members, gap))
        known = np.flatnonzero(bounds.solved[members] & np.isfinite(bounds.high[members]))
        if len(undone) and len(known) >= NEIGHBOURS:
            near = np.asarray(cKDTree(unit[known]).query(unit[undone], k=NEIGHBOURS)[1], dtype=np.int64)
            above = combined(unit[undone], unit[known], near, bounds.high[members[known]], axes)
            bounds.high[members[undone]] = np.minimum(bounds.high[members[undone]], above)
            undone = undone[bounds.doubtful(members[undone], gap)]
        report("certified bounds", len(members) - len(undone), len(members))
        if not len(undone):
            return
        for k in undone[_spread(unit[undone], unit[known], batch)]:
            at(int(members[k]))


def _spread(candidates: Float, chosen: Float, count: int) -> Int:
    """Indices of up to ``count`` candidates, each the farthest from those chosen before."""
    if len(chosen):
        distance = cKDTree(chosen).query(candidates)[0]
    else:
        distance = np.linalg.norm(candidates - candidates.mean(0), axis=1)
    picked: list[int] = []
    while len(picked) < min(count, len(candidates)):
        k = int(np.argmax(distance))
        picked.append(k)
        distance = np.minimum(distance, np.linalg.norm(candidates - candidates[k], axis=1))
        distance[picked] = -1
    return np.array(picked, dtype=np.int64)
