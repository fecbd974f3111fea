"""The set of loads that an assembly carries, between two polyhedra that grow towards each other.

Along a ray from 0 one solve gives a point that is carried, which the inner polytope takes as a corner, and a mechanism.
A mechanism limits every load: it is a half-space, one row of the outer polyhedron.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, SolverError, message
from holdfast.base.progress import report
from holdfast.engines.capabilities import LoadSet
from holdfast.engines.limit.load_limit import LoadLimit
from holdfast.engines.limit.rounding import DOWN, gamma
from holdfast.engines.verdict import Status
from holdfast.geometry.half_spaces import largest_row

BUDGET = {3: 240, 6: 240}  # solves by dimension; in six dimensions the facets of a hull cost more than the solves
BATCH = {3: 6, 6: 40}  # solves by dimension before both polyhedra are computed again
SMALLEST = 1e-6  # share of the box: a set that reaches less far along an axis counts as flat
ALIKE = 0.995  # two rays with a larger cosine are too close for one batch


def find_set(
    solve: Callable[[Float], list[LoadLimit]], slope: Float, columns: Float, gap: float, where: str
) -> LoadSet:
    """The x (d,) in the box |x_k| <= 1 for which ``columns`` @ x (6J,) is carried, to within ``gap`` if it can.

    ``solve`` takes load columns (6J, k). 1/R of any wrench w is at most the sum of ``slope`` (6J,) times |w|.
    """
    search = _Search(where, solve, slope, columns)
    reached = search.run(gap)
    cuts = np.array(search.cuts).reshape(-1, columns.shape[1])
    return LoadSet(search.inner, np.unique(cuts, axis=0), search.vertices, reached, search.solves)


@dataclass(eq=False)
class _Search:
    """Corners and cuts in units of the box [-1, 1]^d, one of each from every solve along a ray from 0.

    A cut is kept as its row a of a·x <= 1. The gap along rays is largest at a vertex of the outer polytope, because
    the inner gauge is convex: a solve along that vertex either confirms it or cuts it off.
    """

    where: str
    solve: Callable[[Float], list[LoadLimit]]
    slope: Float
    columns: Float
    points: list[Float] = field(default_factory=list)
    cuts: list[Float] = field(default_factory=list)
    failed: list[Float] = field(default_factory=list)
    solves: int = 0
    inner: Float = field(default_factory=lambda: np.empty(0))
    vertices: Float = field(default_factory=lambda: np.empty(0))

    def run(self, wanted: float) -> float:
        """Ask until the gap is at most ``wanted`` or the budget is used up; returns the gap reached."""
        dimension = self.columns.shape[1]
        budget = BUDGET[dimension]
        self._ask([*np.eye(dimension), *-np.eye(dimension)], self._check_inside)
        while True:
            vertices, gauge = self._corners()
            gap = max(1 - 1 / float(gauge.max()), 0.0)
            report(self.where, min(self.solves, budget), budget)
            left = budget - self.solves
            chosen = self._worst(
                vertices, gauge, 1 / (1 - wanted) if wanted < 1 else np.inf, min(BATCH[dimension], left)
            )
            if gap <= wanted or not chosen:
                report(self.where, budget, budget)
                return gap
            self._ask(chosen)

    def _ask(self, directions: list[Float], check: Callable[[Float], None] | None = None) -> None:
        """Solve along these directions; ``check`` is called with each of them in turn."""
        self.solves += len(directions)
        limits = self.solve(np.column_stack([self.columns @ direction for direction in directions]))
        for direction, limit in zip(directions, limits, strict=True):
            self._learn(direction, limit)
            if check is not None:
                check(direction)

    def _learn(self, direction: Float, limit: LoadLimit) -> None:
        if limit.status is Status.UNDECIDED:
            self.failed.append(direction / np.linalg.norm(direction))
            return
        reach = 1 / float(np.abs(direction).max())
        self.points.append(min(self._certain(limit.lower, direction), reach) * direction)
        if limit.proof is not None:
            normal = self.columns.T @ limit.proof
            unknown = gamma(len(limit.proof)) * float((np.abs(self.columns.T) @ np.abs(limit.proof)).sum())
            self.cuts.append(normal / (limit.upper + unknown))

    def _certain(self, lower: float, direction: Float) -> float:
        """The reach along a direction, less what rounding of the load and of the point may take from ``lower``."""
        if not lower > 0:
            return 0.0
        unknown = gamma(len(direction)) * (np.abs(self.columns) @ np.abs(direction))
        paid = np.where(unknown > 0, unknown, 0.0) @ np.where(unknown > 0, self.slope, 0.0)
        total = 1 / lower + float(paid)
        return 1 / total * DOWN if total > 0 else np.inf

    def _check_inside(self, direction: Float) -> None:
        if self.failed:
            problem = f"the solver found no answer along {_shown(direction)}"
            raise SolverError(message(self.where, problem, "ask for load_factor along single loads"))
        if np.abs(self.points[-1]).max() < SMALLEST:
            problem = f"0 is not inside the set: less than {SMALLEST:g} of the bound along {_shown(direction)} moves it"
            remedy = "the set is flat or ends at 0; ask for load_factor along single loads, or give a smaller bound"
            raise HoldfastError(message(self.where, problem, remedy))

    def _corners(self) -> tuple[Float, Float]:
        """Vertices (k, d) of outer polyhedron and box, and the inner gauge (k,) there: outer over inner reach."""
        dimension = self.columns.shape[1]
        box = np.vstack([np.eye(dimension), -np.eye(dimension)])
        rows = np.vstack([box, np.array(self.cuts).reshape(-1, dimension)])
        vertices = _rows(self._hull(rows))  # a row of the polar set's hull is a vertex of the set itself
        hull = self._hull(np.array(self.points))
        self.inner = _drawn_in(hull)
        self.vertices = np.array(self.points)[hull.vertices]
        return vertices, largest_row(self.inner, vertices)

    def _hull(self, points: Float) -> ConvexHull:
        """Cuts that nearly coincide defeat exact arithmetic in many dimensions: there the points are joggled."""
        last: QhullError | None = None
        for options in ("Qt", "QJ") if self.columns.shape[1] <= 3 else ("QJ",):
            try:
                return ConvexHull(points, qhull_options=options)
            except QhullError as error:
                last = error
        problem = f"no convex hull of the points found ({str(last).splitlines()[0]})"
        raise SolverError(message(self.where, problem, "give a bound closer to the set's size")) from last

    def _worst(self, vertices: Float, gauge: Float, enough: float, count: int) -> list[Float]:
        """Up to ``count`` vertices to ask along: largest gauge first, no two alike, none that failed before."""
        chosen: list[Float] = []
        taken = list(self.failed)
        for k in np.argsort(-gauge, kind="stable"):
            if len(chosen) >= count or gauge[k] <= enough:
                break
            way = vertices[k] / np.linalg.norm(vertices[k])
            if not taken or float((np.array(taken) @ way).max()) < ALIKE:
                taken.append(way)
                chosen.append(vertices[k])
        return chosen


def _drawn_in(hull: ConvexHull) -> Float:
    """Rows of a hull, drawn in by as much as its facets miss the points that they go through.

    No facet is then outside any of its corners, so that a ray leaves the rows before it leaves the facets.
    """
    rows = hull.equations[:, :-1] / -hull.equations[:, -1:]
    corners = hull.points[hull.simplices]
    missed = float(np.abs(np.einsum("fkd,fd->fk", corners, rows) - 1).max())
    rounding = gamma(rows.shape[1]) * float(np.einsum("fkd,fd->fk", np.abs(corners), np.abs(rows)).max())
    return _rows(hull) * (1 + 2 * (missed + rounding))


def _rows(hull: ConvexHull) -> Float:
    """Rows a of a·x <= 1 of a hull around 0, each once."""
    rows = np.asarray(hull.equations[:, :-1] / -hull.equations[:, -1:])
    return np.asarray(rows[np.unique(np.round(rows, 9), axis=0, return_index=True)[1]])


def _shown(direction: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in direction) + ")"
