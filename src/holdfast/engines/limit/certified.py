"""Certified maps: bounds for many unit pushes on one body from few solves.

γ(w) = 1/R(w) is a gauge: convex, and γ(t w) = t γ(w). So cuts proved by the duals of earlier solves bound it from
below, for every load on every body, and combinations of solved loads bound it from above: on a flat face, where pushes
share their direction, by interpolation on a triangulation; elsewhere by non-negative combinations of nearby solved
loads, with what they miss paid for along the axes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled
from holdfast.base.progress import report
from holdfast.engines.directions import flat_groups, moment_frame
from holdfast.engines.limit.solved import Solved
from holdfast.engines.verdict import Status

NEIGHBOURS = 10

Solve = Callable[[Float], Solved]


@dataclass
class Cuts:
    """Half-spaces of loads, shared by all bodies: γ(w) >= rows @ w for w (6J,)."""

    rows: list[Float] = field(default_factory=list)

    def learn(self, solved: Solved) -> int | None:
        """Take the cut of a solve; returns its number, None where it proves none."""
        if solved.twists is None or not solved.upper > 0:
            return None
        self.rows.append(solved.twists / solved.upper)
        return len(self.rows) - 1


@dataclass
class Field:
    """Bounds of γ at n unit pushes (n, 6) on the body whose first row is ``first``: ``low`` and ``high`` (n,).

    ``cut`` (n,) is the number of the cut that gives ``low`` (-1: none), ``solved`` (n,) whether a point was solved.
    """

    loads: Float
    first: int
    cuts: Cuts
    low: Float
    high: Float
    cut: Int
    solved: Bool
    undecided: Bool
    seen: int = 0

    def rise(self) -> None:
        """Raise ``low`` by the cuts learnt since the last time."""
        fresh = self.cuts.rows[self.seen :]
        if fresh:
            values = self.loads @ np.array(fresh)[:, self.first : self.first + 6].T
            best = np.argmax(values, axis=1)
            top = values[np.arange(len(values)), best]
            better = top > self.low
            self.low[better] = top[better]
            self.cut[better] = self.seen + best[better]
            self.seen += len(fresh)

    def doubtful(self, members: Int, gap: float) -> Bool:
        """Which of these points have bounds further apart than ``gap``, (upper - lower) / upper."""
        low, high = self.low[members], self.high[members]
        return np.asarray(~self.solved[members] & (high > 0) & ~(low >= (1 - gap) * high))


def certify(columns: Float, first: int, solve: Solve, cuts: Cuts, gap: float, lever: float) -> Field:
    """Bounds for load columns (6J, n) that load one body, at rows ``first`` to ``first + 6``, within ``gap``.

    ``lever`` [m] makes torques comparable with forces.
    """
    count = columns.shape[1]
    loads = np.ascontiguousarray(columns[first : first + 6].T)
    field_ = Field(
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
        _enter(field_, k, solve(columns[:, k]))

    def elsewhere(load: Float) -> float:
        full = np.zeros(len(columns))
        full[first : first + 6] = load
        solved = solve(full)
        cuts.learn(solved)
        return _high(solved)

    groups, rest = flat_groups(loads)
    for members in groups:
        _flat(field_, members, at, elsewhere, gap)
        report("certified bounds", count - int(field_.doubtful(np.arange(count), gap).sum()), count)
    if len(rest):
        _curved(field_, rest, at, elsewhere, gap, lever)
    return field_


def _high(solved: Solved) -> float:
    """The upper bound of γ that a solve proves."""
    if solved.status is Status.INFINITE:
        return 0.0
    return 1 / solved.lower if solved.lower > 0 else np.inf


def _enter(field_: Field, k: int, solved: Solved) -> None:
    number = field_.cuts.learn(solved)
    field_.solved[k] = True
    field_.undecided[k] = solved.status is Status.UNDECIDED
    field_.high[k] = _high(solved)
    field_.low[k] = 0.0 if solved.status is not Status.FINITE else 1 / solved.upper if solved.upper > 0 else np.inf
    if number is not None:
        field_.cut[k] = number


def _flat(
    field_: Field, members: Int, at: Callable[[int], None], elsewhere: Callable[[Float], float], gap: float
) -> None:
    """Pushes of one direction: γ is convex over the plane of their moments; refine a triangulation of it."""
    force = field_.loads[members[0], :3]
    frame = moment_frame(force)
    chart = field_.loads[members, 3:] @ frame.T
    low, high = chart.min(0), chart.max(0)
    pad = 1e-6 * max(float((high - low).max()), 1e-12)
    low, high = low - pad, high + pad
    unit = (chart - low) / (high - low)
    places = [np.array([x, y], dtype=float) for x in (0, 1) for y in (0, 1)]
    values = [elsewhere(np.concatenate([force, (low + place * (high - low)) @ frame])) for place in places]
    while True:
        field_.rise()
        undone = np.flatnonzero(field_.doubtful(members, gap))
        if not len(undone):
            return
        facet = np.arange(len(undone))
        if np.isfinite(values).all():
            above, facet = _envelope(np.array(places), np.array(values), unit[undone])
            field_.high[members[undone]] = np.minimum(field_.high[members[undone]], above)
        still = field_.doubtful(members[undone], gap)
        undone, facet = undone[still], facet[still]
        for index in undone[_worst_of_each(facet, _doubt(field_, members[undone]))]:
            at(int(members[index]))
            places.append(unit[index])
            values.append(float(field_.high[members[index]]))


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


def _doubt(field_: Field, members: Int) -> Float:
    """How much bounds disagree: absolute, in γ, so that the points which weigh most in neighbours come first."""
    high = field_.high[members]
    return np.where(np.isfinite(high), high - field_.low[members], np.inf)


def _worst_of_each(group: Int, doubt: Float) -> Int:
    """One index a group: the largest doubt."""
    order = np.lexsort((-doubt, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))]


def _curved(
    field_: Field,
    members: Int,
    at: Callable[[int], None],
    elsewhere: Callable[[Float], float],
    gap: float,
    lever: float,
) -> None:
    """Pushes in many directions: non-negative combinations of the nearest solved loads."""
    loads = field_.loads[members]
    scale = np.repeat([1.0, lever], 3)
    unit = loads / scale
    axes = np.array([[elsewhere(sign * e * scale) for e in np.eye(6)] for sign in (1.0, -1.0)])
    batch = max(12, len(members) // 100)
    for k in _spread(unit, np.empty((0, 6)), batch):
        at(int(members[k]))
    while True:
        field_.rise()
        undone = np.flatnonzero(field_.doubtful(members, gap))
        known = np.flatnonzero(field_.solved[members] & np.isfinite(field_.high[members]))
        if len(undone) and len(known) >= NEIGHBOURS:
            near = np.asarray(cKDTree(unit[known]).query(unit[undone], k=NEIGHBOURS)[1], dtype=np.int64)
            above = _combined(unit[undone], unit[known], near, field_.high[members[known]], axes)
            field_.high[members[undone]] = np.minimum(field_.high[members[undone]], above)
            undone = undone[field_.doubtful(members[undone], gap)]
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


@compiled
def _combined(points: Float, known: Float, near: Int, values: Float, axes: Float) -> Float:
    """Upper bounds (n,) of γ: each point as a non-negative combination of its neighbours among the known loads.

    Whatever the combination misses, component by component, costs γ of that axis (2, 6), positive and negative.
    """
    result = np.empty(len(points))
    for i in range(len(points)):
        columns = np.empty((6, near.shape[1]))
        for a in range(near.shape[1]):
            for c in range(6):
                columns[c, a] = known[near[i, a], c]
        share = _non_negative(columns, points[i])
        total = 0.0
        for a in range(len(share)):
            total += share[a] * values[near[i, a]]
        for c in range(6):
            missing = points[i, c]
            for a in range(len(share)):
                missing -= columns[c, a] * share[a]
            if missing > 0.0:
                total += missing * axes[0, c]
            elif missing < 0.0:
                total -= missing * axes[1, c]
        result[i] = total
    return result


@compiled
def _non_negative(columns: Float, target: Float) -> Float:
    """Shares x >= 0 that bring columns @ x close to target (Lawson & Hanson); any x serves, a good one is tight."""
    count = columns.shape[1]
    gram = columns.T @ columns
    pull = columns.T @ target
    x = np.zeros(count)
    active = np.zeros(count, dtype=np.bool_)
    for _ in range(3 * count):
        slope = pull - gram @ x
        best, most = -1, 1e-12
        for a in range(count):
            if not active[a] and slope[a] > most:
                best, most = a, slope[a]
        if best < 0:
            break
        active[best] = True
        for _ in range(count):
            chosen = np.flatnonzero(active)
            size = len(chosen)
            small = np.empty((size, size))
            right = np.empty(size)
            for a in range(size):
                right[a] = pull[chosen[a]]
                for b in range(size):
                    small[a, b] = gram[chosen[a], chosen[b]]
                small[a, a] *= 1 + 1e-13
            z = np.linalg.solve(small, right)
            step = 1.0
            for a in range(size):
                if z[a] <= 0.0:
                    step = min(step, x[chosen[a]] / (x[chosen[a]] - z[a]) if x[chosen[a]] > z[a] else 0.0)
            for a in range(size):
                x[chosen[a]] += step * (z[a] - x[chosen[a]])
            if step >= 1.0:
                break
            for a in range(size):
                if z[a] <= 0.0 and x[chosen[a]] <= 1e-14:
                    x[chosen[a]] = 0.0
                    active[chosen[a]] = False
    return np.maximum(x, 0.0)
