"""Certified maps: bounds for many unit pushes on one body from few solves.

γ(w) = 1/R(w) is a gauge: convex, and γ(t w) = t γ(w). So cutting planes proved by the duals of earlier solves bound it
from below, for every load on every body, and combinations of solved loads bound it from above: on a flat face, where
pushes share their direction, by interpolation on a triangulation; elsewhere by non-negative combinations of nearby
solved loads, with what they miss paid for along the axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.progress import report
from holdfast.base.ranges import SUM
from holdfast.base.rigid import tangents
from holdfast.engines.limit.balance import DOWN, UP, gamma
from holdfast.engines.limit.proof import LoadLimit
from holdfast.engines.mechanism import moving_bodies
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import qhull, search_tree
from holdfast.native import core

FLAT_GROUP = 12  # smallest number of pushes along one direction for which a triangulation pays off


def by_body(W: Float, least: int) -> list[tuple[int, Int]]:
    """Group columns of W (6J, n) that load a single body each: the number of the body, and those of its columns.

    Columns that load several bodies, or none, are in no group, nor are fewer than ``least`` columns of a body.
    """
    loaded = (W.reshape(len(W) // 6, 6, W.shape[1]) != 0).any(1)
    single = loaded & (loaded.sum(0) == 1)
    return [(int(body), np.flatnonzero(single[body])) for body in np.flatnonzero(single.sum(1) >= least)]


def flat_groups(loads: Float) -> tuple[list[Int], Int]:
    """Group loads (n, 6) by their force.

    Returns the numbers of the members of each group of at least FLAT_GROUP loads, and the numbers of all other loads.
    """
    _, group, size = np.unique(np.round(loads[:, :3], 9) + 0.0, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    groups = [np.flatnonzero(group == number) for number in np.flatnonzero(size >= FLAT_GROUP)]
    return groups, np.flatnonzero(size[group] < FLAT_GROUP)


@dataclass
class CuttingPlanes:
    """Lower bounds for loads on single bodies: γ(w) >= row @ w for each of ``rows`` (6J,) and any such w (6J,).

    ``motions`` (6J,) are the collapse mechanisms of the solved loads that the rows come from. ``certain`` says whether
    the lower bounds of all loads that were learned are proved. ``scale`` (6J,) are units of the motion of every body.

    A row is zero for bodies that hardly move. A motion that lifts nothing, as that of a body that rolls, costs no more
    than rounding. What the solver leaves of another body's motion beside it would then bound pushes on that body, and
    by up to 9 % too low.
    """

    scale: Float
    rows: list[Float] = field(default_factory=list)
    motions: list[Float] = field(default_factory=list)
    certain: bool = True

    def learn(self, limits: Sequence[LoadLimit]) -> list[int | None]:
        """Add the cutting planes that solved loads prove; returns the number of each, None where there is none."""
        self.certain &= all(limit.certain for limit in limits)
        first = len(self.rows)
        numbers: list[int | None] = []
        rows: list[Float] = []
        for limit in limits:
            proves = limit.twists is not None and limit.upper > 0
            numbers.append(first + len(rows) if proves else None)
            if limit.twists is not None and proves:
                rows.append(np.zeros_like(limit.twists) if limit.proof is None else limit.proof / limit.upper)
                self.motions.append(limit.twists)
        if rows:
            every = np.array(rows)
            every[np.repeat(~moving_bodies(every, self.scale), 6, axis=1)] = 0.0
            self.rows += list(every)
        return numbers


@dataclass
class GaugeBounds:
    """Bounds ``low`` (n,) and ``high`` (n,) of γ at ``loads`` (n, 6) on one body.

    The body's rows of a load column (6J,) start at ``first``. ``plane`` (n,) is the number of the cutting plane that
    gives ``low``, or -1 if none does. ``solved`` (n,) is True for loads that were solved themselves, and ``undecided``
    (n,) for those of them for which the solver found no answer. ``endless`` (n,) is True where any multiple of the load
    is carried; for those that were solved, ``spare`` (n, 6) is the slope of LoadLimit. The first ``seen`` cutting
    planes have already been applied.
    """

    loads: Float
    first: int
    planes: CuttingPlanes
    low: Float
    high: Float
    plane: Int
    spare: Float
    solved: Bool
    undecided: Bool
    endless: Bool
    seen: int = 0

    def rise(self) -> None:
        """Raise ``low`` to the values that the cutting planes added since the last call prove."""
        fresh = self.planes.rows[self.seen :]
        if fresh:
            rows = np.array(fresh)[:, self.first : self.first + 6].T
            values = self.loads @ rows
            values -= gamma(6) * (np.abs(self.loads) @ np.abs(rows))
            best = np.argmax(values, axis=1)
            top = values[np.arange(len(values)), best]
            better = top > self.low
            self.low[better] = top[better]
            self.plane[better] = self.seen + best[better]
            self.seen += len(fresh)

    def doubtful(self, members: Int, accuracy: float) -> Bool:
        """Say which of the loads ``members`` (k,) are unsolved with bounds that are further apart than ``accuracy``.

        The distance is (upper - lower) / upper of the factor.
        """
        low, high = self.low[members], self.high[members]
        return np.asarray(~self.solved[members] & ~self.endless[members] & ~(low >= (1 - accuracy) * high))


NEIGHBOURS = 10  # solved loads, the nearest, that are combined for a bound at another one

SLIGHT = 1e-13  # smaller shares in a combination count as none
ALIKE = 1e-9  # of the loads that make another one up: what it may miss of it to be endless like them, if not proved

Solve = Callable[[Float], list[LoadLimit]]  # of load columns (6J, k)
Elsewhere = Callable[[Float], tuple[Float, Float, Bool]]  # of loads (m, 6): values, spare and endless as in ``_Face``


def certify(
    columns: Float, first: int, solve: Solve, planes: CuttingPlanes, accuracy: float, lever: float, slope: Float
) -> GaugeBounds:
    """Bounds for load columns (6J, n) that load one body, at rows ``first`` to ``first + 6``, within ``accuracy``.

    ``lever`` [m] makes torques comparable with forces. ``slope`` (6,) bounds γ of any wrench r on the body by the sum
    of slope |r|: it pays for what rounding hides.
    """
    count = columns.shape[1]
    loads = np.ascontiguousarray(columns[first : first + 6].T)
    bounds = GaugeBounds(
        loads,
        first,
        planes,
        np.zeros(count),
        np.full(count, np.inf),
        np.full(count, -1),
        np.full((count, 6), np.inf),
        *np.zeros((3, count), dtype=bool),
    )

    def at(chosen: Int) -> None:
        limits = solve(columns[:, chosen])
        for k, limit, plane in zip(chosen.tolist(), limits, planes.learn(limits), strict=True):
            bounds.solved[k] = True
            bounds.undecided[k] = limit.status is Status.UNDECIDED
            bounds.endless[k] = limit.status is Status.INFINITE
            bounds.high[k] = _gauge_above(limit)
            bounds.spare[k] = _slope_beside(limit, bounds.first)
            bounds.low[k] = (
                0.0 if limit.status is not Status.FINITE else 1 / limit.upper * DOWN if limit.upper > 0 else np.inf
            )
            if plane is not None:
                bounds.plane[k] = plane

    def elsewhere(wanted: Float) -> tuple[Float, Float, Bool]:
        full = np.zeros((len(columns), len(wanted)))
        full[first : first + 6] = wanted.T
        limits = solve(full)
        planes.learn(limits)
        spare = [_slope_beside(limit, first) for limit in limits]
        endless = np.array([limit.status is Status.INFINITE for limit in limits], dtype=bool)
        return np.array([_gauge_above(limit) for limit in limits]), np.array(spare).reshape(-1, 6), endless

    groups, rest = flat_groups(loads)
    _bound_flat_faces(bounds, groups, at, elsewhere, accuracy, slope)
    if len(rest):
        _bound_others(bounds, rest, at, elsewhere, accuracy, lever)
    return bounds


def _gauge_above(limit: LoadLimit) -> float:
    """The upper bound of γ that one solved load proves."""
    if limit.status is Status.INFINITE and limit.lower == np.inf:
        return 0.0
    return 1 / limit.lower * UP if limit.lower > 0 else np.inf


def _slope_beside(limit: LoadLimit, first: int) -> Float:
    """The slope (6,) of a wrench on the rows from ``first`` that is carried beside an endless load; inf for none."""
    return np.full(6, np.inf) if limit.slope is None else limit.slope[first : first + 6]


@dataclass
class _Face:
    """The pushes ``members`` (n,) of one direction, at ``points`` (n, 2) of a unit square of their moments.

    At ``places`` (m, 2) of the square are ``loads`` (m, 6), at which γ is at most ``values`` (m,). Those in ``endless``
    (m,) were found to be carried up to any multiple; ``spare`` (m, 6) is the slope of what one of them takes besides.
    """

    members: Int
    points: Float
    places: Float
    loads: Float
    values: Float
    spare: Float
    endless: Bool

    @classmethod
    def of(cls, members: Int, loads: Float) -> _Face:
        """The pushes ``loads`` (n, 6), in a square whose corners are solved next."""
        force = loads[0, :3]
        frame = np.array(tangents(force / np.linalg.norm(force)))  # axes of the moments of all pushes along the force
        chart = loads[:, 3:] @ frame.T
        low, high = chart.min(0), chart.max(0)
        pad = 1e-6 * max(float((high - low).max()), 1e-12)
        low, high = low - pad, high + pad
        places = np.array([(x, y) for x in (0.0, 1.0) for y in (0.0, 1.0)])
        corners = np.column_stack([np.tile(force, (4, 1)), (low + places * (high - low)) @ frame])
        return cls(
            members,
            (chart - low) / (high - low),
            places,
            corners,
            np.empty(0),
            np.empty((0, 6)),
            np.empty(0, dtype=bool),
        )

    def lowered(self, bounds: GaugeBounds, accuracy: float, slope: Float) -> Int:
        """Interpolate over the face; returns one of its doubtful pushes for each facet that has any, as places (k,)."""
        doubtful = np.flatnonzero(bounds.doubtful(self.members, accuracy))
        undone, facet = self.members[doubtful], np.arange(len(doubtful))
        if len(undone) and np.isfinite(self.values).all():
            above, endless, facet = self.envelope(doubtful, bounds.loads[undone], slope)
            bounds.high[undone] = np.minimum(bounds.high[undone], above)
            bounds.endless[undone] |= endless
        still = bounds.doubtful(undone, accuracy)
        high = bounds.high[undone[still]]
        # in γ, absolute, so that the points which weigh most in neighbours come first
        doubt = np.where(np.isfinite(high), high - bounds.low[undone[still]], np.inf)
        order = np.lexsort((-doubt, facet[still]))
        return doubtful[still][order[np.flatnonzero(np.diff(facet[still][order], prepend=-1))]]

    def envelope(self, chosen: Int, wanted: Float, slope: Float) -> tuple[Float, Bool, Int]:
        """Upper bounds (n,) of γ at the loads ``wanted`` (n, 6) of the pushes at places ``chosen`` (n,).

        Each is a combination of the loads at the corners of the facet of the lower hull below it, with no negative
        shares, and a difference that ``slope`` (6,) pays for; so a hull that was joggled gives valid bounds, too.

        What endless corners make up is endless, for the forces that balance them alone add up, too. The bound of γ is 0
        if all of that is proved and one corner takes the difference besides. Also returns where (n,) a load is made up
        of endless ones, and the facets (n,).
        """
        points, values = self.points[chosen], self.values
        height = max(float(np.ptp(values)), 1e-300)
        lifted = np.column_stack([self.places, (values - values.min()) / height])
        hull = qhull(np.vstack([lifted, [[0.5, 0.5, 1e3]]]), "QJ Pp")
        facets = hull.simplices[(hull.simplices < len(self.places)).all(1) & (hull.equations[:, 2] < 0)]
        a, u, v = self.places[facets[:, 0]], *(self.places[facets[:, k]] - self.places[facets[:, 0]] for k in (1, 2))
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        proper = np.abs(area) > 1e-10
        facets, a, u, v, area = facets[proper], a[proper], u[proper], v[proper], area[proper]
        x, y = (points[:, k, None] - a[:, k] for k in range(2))  # (n, facets)
        second, third = (x * v[:, 1] - y * v[:, 0]) / area, (y * u[:, 0] - x * u[:, 1]) / area
        best = np.argmax(np.minimum(np.minimum(second, third), 1 - second - third), axis=1)
        row = np.arange(len(points))
        second, third = second[row, best], third[row, best]
        shares = np.column_stack([1 - second - third, second, third])
        shares = np.where(shares > SLIGHT, shares, 0.0)
        at = facets[best]  # the three corners (n, 3) of each
        corners = self.loads[at]
        summed = np.einsum("nk,nk->n", shares, values[at])
        size = np.abs(wanted) + np.einsum("nk,nkc->nc", shares, np.abs(corners))
        missing = np.abs(wanted - np.einsum("nk,nkc->nc", shares, corners)) + SUM * size
        above = (summed + _price_of(slope, missing)) * (1 + SUM)
        if not self.endless.any():
            return above, np.zeros(len(points), dtype=bool), best
        made = (self.endless[at] | (shares == 0)).all(1) & (missing <= ALIKE * size).all(1)
        held = np.stack([_price_of(self.spare[at[:, k]], missing) <= shares[:, k] * (1 - SUM) for k in range(3)])
        proved = made & (summed == 0) & held.any(0)
        return np.where(proved, 0.0, above), made, best

    def learn(self, bounds: GaugeBounds, chosen: Int) -> None:
        """Take the pushes at places ``chosen`` (k,) as corners of facets, now that they are solved."""
        solved = self.members[chosen]
        self.places = np.vstack([self.places, self.points[chosen]])
        self.loads = np.vstack([self.loads, bounds.loads[solved]])
        self.values = np.concatenate([self.values, bounds.high[solved]])
        self.spare = np.vstack([self.spare, bounds.spare[solved]])
        self.endless = np.concatenate([self.endless, bounds.endless[solved]])


def _bound_flat_faces(
    bounds: GaugeBounds,
    groups: list[Int],
    at: Callable[[Int], None],
    elsewhere: Elsewhere,
    accuracy: float,
    slope: Float,
) -> None:
    """Pushes of one direction each: γ is convex over the plane of their moments; refine a triangulation of it.

    All faces are refined in step, since proving the bounds of a round costs more than proving those of a load.
    """
    count = len(bounds.loads)
    faces = [_Face.of(members, bounds.loads[members]) for members in groups]
    if faces:
        values, spare, endless = elsewhere(np.vstack([face.loads for face in faces]))
        for k, face in enumerate(faces):
            four = slice(4 * k, 4 * k + 4)
            face.values, face.spare, face.endless = values[four], spare[four], endless[four]
    while faces:
        bounds.rise()
        chosen = [(face, face.lowered(bounds, accuracy, slope)) for face in faces]
        chosen = [(face, places) for face, places in chosen if len(places)]
        if chosen:
            at(np.concatenate([face.members[places] for face, places in chosen]))
        for face, places in chosen:
            face.learn(bounds, places)
        faces = [face for face, _ in chosen]
        report("certified bounds", count - int(bounds.doubtful(np.arange(count), accuracy).sum()), count)


def _price_of(slope: Float, missing: Float) -> Float:
    """The sums (n,) of slopes (6,) or (n, 6) times what is missing (n, 6); nothing is paid for nothing."""
    paid = np.where(missing > 0, missing * np.where(missing > 0, slope, 0.0), 0.0)
    return np.asarray(paid.sum(1) * (1 + SUM))


def _bound_others(
    bounds: GaugeBounds, members: Int, at: Callable[[Int], None], elsewhere: Elsewhere, accuracy: float, lever: float
) -> None:
    """Pushes in many directions: non-negative combinations of the nearest solved loads."""
    loads = bounds.loads[members]
    scale = np.repeat([1.0, lever], 3)
    unit = loads / scale
    axes = elsewhere(np.vstack([np.diag(scale), -np.diag(scale)]))[0].reshape(2, 6)
    batch = max(12, len(members) // 100)
    at(members[_farthest_apart(unit, np.empty((0, 6)), batch)])
    while True:
        bounds.rise()
        undone = np.flatnonzero(bounds.doubtful(members, accuracy))
        known = np.flatnonzero(bounds.solved[members] & np.isfinite(bounds.high[members]))
        if len(undone) and len(known) >= NEIGHBOURS:
            near = np.asarray(search_tree(unit[known]).query(unit[undone], k=NEIGHBOURS)[1], dtype=np.int64)
            above = core.combined(unit[undone], unit[known], near, bounds.high[members[known]], axes, SUM)
            bounds.high[members[undone]] = np.minimum(bounds.high[members[undone]], above)
            undone = undone[bounds.doubtful(members[undone], accuracy)]
        report("certified bounds", len(members) - len(undone), len(members))
        if not len(undone):
            return
        at(members[undone[_farthest_apart(unit[undone], unit[known], batch)]])


def _farthest_apart(candidates: Float, chosen: Float, count: int) -> Int:
    """Indices of up to ``count`` candidates, each the farthest from those chosen before."""
    if len(chosen):
        distance = search_tree(chosen).query(candidates)[0]
    else:
        distance = np.linalg.norm(candidates - candidates.mean(0), axis=1)
    picked: list[int] = []
    while len(picked) < min(count, len(candidates)):
        k = int(np.argmax(distance))
        picked.append(k)
        distance = np.minimum(distance, np.linalg.norm(candidates - candidates[k], axis=1))
        distance[picked] = -1
    return np.array(picked, dtype=np.int64)
