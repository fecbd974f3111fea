"""The set of loads that an assembly carries, between two polyhedra that grow towards each other.

Along a ray from 0 one solve gives a point that is carried, which the inner polytope takes as a corner, and a mechanism.
A mechanism limits every load: it is a half-space, one row of the outer polyhedron.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, SolverError, message
from holdfast.base.progress import report
from holdfast.engines.capabilities import LoadSet
from holdfast.engines.limit.load_limit import LoadLimit
from holdfast.engines.verdict import Status
from holdfast.geometry.half_spaces import largest_row

BUDGET = {3: 240, 6: 240}  # solves by dimension; in six dimensions the facets of a hull cost more than the solves
BATCH = {3: 6, 6: 40}  # solves by dimension before both polyhedra are computed again
SMALLEST = 1e-6  # share of the box: a set that reaches less far along an axis counts as flat
CUT_MARGIN = 1e-7  # share of the box by which cuts are moved outwards, for the solver's error in the load's work
WEIGHT_MARGIN = 1e-8  # share of the total weight by which they are moved besides, for its error in the weights' work
ALIKE = 0.995  # two rays with a larger cosine are too close for one batch


def find_set(
    assembly: Assembly, solve: Callable[[Float], LoadLimit], columns: Float, gap: float, where: str
) -> LoadSet:
    """The x (d,) in the box |x_k| <= 1 for which ``columns`` @ x (6J,) is carried, to within ``gap`` if it can."""
    search = _Search(where, assembly, solve, columns)
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
    assembly: Assembly
    solve: Callable[[Float], LoadLimit]
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
        for direction in (*np.eye(dimension), *-np.eye(dimension)):
            self._ask(direction)
            self._check_inside(direction)
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
            for direction in chosen:
                self._ask(direction)

    def _ask(self, direction: Float) -> None:
        self.solves += 1
        limit = self.solve(self.columns @ direction)
        if limit.status is Status.UNDECIDED:
            self.failed.append(direction / np.linalg.norm(direction))
            return
        reach = 1 / float(np.abs(direction).max())
        self.points.append(min(limit.lower, reach) * direction)
        if limit.proof is not None:
            normal = self.columns.T @ limit.proof
            self.cuts.append(normal / (limit.upper + self._slack(normal, limit.proof)))

    def _slack(self, normal: Float, twists: Float) -> float:
        """How far a cut may be wrong where the solver's twists leave the dual cone: by loads and by weights."""
        speeds = float(np.abs(twists / self.assembly.equation_scale).sum())
        return CUT_MARGIN * float(np.abs(normal).sum()) + WEIGHT_MARGIN * self.assembly.weight * speeds

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
    """Rows of a hull, drawn in by as much as its facets miss the points that they go through."""
    rows = hull.equations[:, :-1] / -hull.equations[:, -1:]
    missed = float(np.abs(np.einsum("fkd,fd->fk", hull.points[hull.simplices], rows) - 1).max())
    return _rows(hull) * (1 + missed)


def _rows(hull: ConvexHull) -> Float:
    """Rows a of a·x <= 1 of a hull around 0, each once."""
    rows = np.asarray(hull.equations[:, :-1] / -hull.equations[:, -1:])
    return np.asarray(rows[np.unique(np.round(rows, 9), axis=0, return_index=True)[1]])


def _shown(direction: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in direction) + ")"
