"""The set of loads that an assembly carries, between two polyhedra that grow towards each other.

Along a ray from 0 one solve gives a point that is carried, which the inner polytope takes as a corner, and a mechanism.
A mechanism limits every load: it is a half-space, one row of the outer polyhedron.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import SolverError, message
from holdfast.base.progress import report
from holdfast.engines.contract import LoadSet
from holdfast.engines.limit.family import Family, Ray
from holdfast.engines.limit.rounding import gamma
from holdfast.geometry.half_spaces import largest_row
from holdfast.geometry.spatial import qhull

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

BUDGET = {3: 240, 6: 240}  # solves by dimension; in six dimensions the facets of a hull cost more than the solves
BATCH = {3: 6, 6: 40}  # solves by dimension before both polyhedra are computed again
ALIKE = 0.995  # two rays with a larger cosine are too close for one batch


def find_set(family: Family, accuracy: float, solves: int | None = None) -> LoadSet:
    """The x (d,) in the box |x_k| <= 1 for which the load of the ``family`` is carried, within ``accuracy`` if it can.

    ``solves`` bounds the solves; None stands for BUDGET.
    """
    search = _Search(family)
    reached = search.run(accuracy, BUDGET[family.dimension] if solves is None else solves)
    planes = np.array(search.planes).reshape(-1, family.dimension)
    return LoadSet(search.inner, np.unique(planes, axis=0), search.vertices, reached, search.worst, search.solves)


@dataclass(eq=False)
class _Search:
    """Corners and cutting planes in units of the box [-1, 1]^d.

    A cutting plane is kept as its row a of a·x <= 1. The gap along rays is largest at a vertex of the outer polytope,
    because the inner gauge is convex: a solve along that vertex either confirms it or cuts it off.
    """

    family: Family
    points: list[Float] = field(default_factory=list)
    planes: list[Float] = field(default_factory=list)
    failed: list[Float] = field(default_factory=list)
    solves: int = 0
    inner: Float = field(default_factory=lambda: np.empty(0))
    vertices: Float = field(default_factory=lambda: np.empty(0))
    worst: Float = field(default_factory=lambda: np.empty(0))

    def run(self, wanted: float, most: int) -> float:
        """Ask until the gap is at most ``wanted`` or ``most`` solves are used up; returns the gap that is left."""
        dimension, where = self.family.dimension, self.family.where
        self._learn(self.family.axes())
        while True:
            vertices, gauge = self._corners()
            accuracy, self.worst = max(1 - 1 / float(gauge.max()), 0.0), vertices[int(gauge.argmax())]
            report(where, min(self.solves, most), most)
            enough = 1 / (1 - wanted) if wanted < 1 else np.inf
            chosen = self._worst(vertices, gauge, enough, min(BATCH[dimension], most - self.solves))
            if accuracy <= wanted or not chosen:
                report(where, most, most)
                return accuracy
            self._learn(self.family.along(chosen))

    def _learn(self, rays: list[Ray]) -> None:
        self.solves += len(rays)
        for ray in rays:
            if not ray.decided:
                self.failed.append(ray.direction / np.linalg.norm(ray.direction))
                continue
            self.points.append(min(ray.reach, 1 / float(np.abs(ray.direction).max())) * ray.direction)
            if ray.row is not None:
                self.planes.append(ray.row)

    def _corners(self) -> tuple[Float, Float]:
        """Vertices (k, d) of outer polyhedron and box, and the inner gauge (k,) there: outer over inner reach."""
        dimension = self.family.dimension
        box = np.vstack([np.eye(dimension), -np.eye(dimension)])
        rows = np.vstack([box, np.array(self.planes).reshape(-1, dimension)])
        vertices = _rows(hull_of(rows, self.family.where))  # a row of the polar set's hull is a vertex of the set
        hull = hull_of(np.array(self.points), self.family.where)
        self.inner = drawn_in(hull)
        self.vertices = np.array(self.points)[hull.vertices]
        return vertices, largest_row(self.inner, vertices)

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


def hull_of(points: Float, where: str) -> ConvexHull:
    """Return the convex hull of points (n, d), or raise SolverError.

    Planes that nearly coincide defeat exact arithmetic in many dimensions: there the points are joggled.
    """
    from scipy.spatial import QhullError  # not for those who ask for no set (geometry/spatial.py)

    last: QhullError | None = None
    for options in ("Qt", "QJ") if points.shape[1] <= 3 else ("QJ",):
        try:
            return qhull(points, options)
        except QhullError as error:
            last = error
    problem = f"no convex hull of the points found ({str(last).splitlines()[0]})"
    raise SolverError(message(where, problem, "give a bound closer to the set's size")) from last


def drawn_in(hull: ConvexHull) -> Float:
    """Return the rows of a hull, drawn in by as much as its facets miss the points that they go through.

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
