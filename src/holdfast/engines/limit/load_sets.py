"""The set of loads that an assembly carries, between two polyhedra that grow towards each other.

Along a ray from 0 one solve gives a point that is carried, which the inner polytope takes as a corner, and a mechanism.
A mechanism limits every load: it is a half-space, one row of the outer polyhedron.

Where only points inside are wanted (``find_hull``), they are known points whose combinations come close to the set
where it matters. The hull of points that are carried is itself carried. Its gauge at a load (geometry/hull.py) is
a small linear program, whose multiplier is the facet of the hull that the ray of the load goes through. The corner of
the true set farthest beyond that facet is a cone program away (``farthest``): if it is not beyond it at all, the facet
lies on the border of the true set, for all loads whose rays go through it; if it is, it becomes a known point. This is
column generation, after Dantzig and Wolfe (Operations Research 8, 1960), and few points are needed because they are
corners. How far the true set reaches beyond a facet also bounds it from outside, everywhere: no load that is carried
goes farther in that direction. Between these cutting planes and the hull lies the gap of every ray, without a solve,
and solves go where the gap is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, SolverError, message
from holdfast.base.progress import report
from holdfast.conic.solve import ConeProgram, Prepared
from holdfast.engines.contract import LoadHull, LoadSet
from holdfast.engines.limit.balance import DOWN, UP, gamma
from holdfast.engines.limit.proof import TOLERANCE, LoadLimit, LoadProofs
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import hull_gauge, largest_row, qhull

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull


@dataclass(frozen=True, eq=False)
class ExtremeLoad:
    """A load ``x`` (d,) of the family, and contact ``forces`` (3I,) [N] that about balance it and the wrench."""

    x: Float
    forces: Float


SMALLEST = 1e-6  # share of the box: a set that reaches less far along an axis counts as flat
ENOUGH = 0.999  # share of a corner, up to which it has to be proved to be carried


@dataclass(frozen=True, eq=False)
class Ray:
    """What one solve says of the ray through ``direction`` (d,).

    All its points up to ``reach`` times the direction are carried; ``reach`` is 0 where the solver found no answer, and
    then ``decided`` is False. ``row`` (d,) is a half-space row·x <= 1 that holds for every x that is carried, or None.
    """

    direction: Float
    reach: float
    decided: bool
    row: Float | None


@dataclass(frozen=True, eq=False)
class LoadFamily:
    """The loads ``columns`` (6J, d) @ x on an assembly whose bounds are ``proofs``; ``where`` names the query."""

    where: str
    proofs: LoadProofs
    columns: Float

    @property
    def dimension(self) -> int:
        """The number d of coordinates."""
        return int(self.columns.shape[1])

    def along(self, directions: Sequence[Float]) -> list[Ray]:
        """Solve along these directions (d,), each with a solve of its own."""
        if not directions:
            return []
        limits = self.proofs.limits(np.column_stack([self.columns @ direction for direction in directions]))
        return [self._ray(direction, limit) for direction, limit in zip(directions, limits, strict=True)]

    def through(self, corners: Sequence[ExtremeLoad]) -> list[Ray]:
        """Return how far the rays through these corners are known to be carried, by the forces that they came with.

        That is about 1. Where the forces prove less, or nothing can be proved, a solve along the ray says more.
        """
        if not corners:
            return []
        x = np.column_stack([corner.x for corner in corners])
        proved = self.proofs.carried(np.column_stack([corner.forces for corner in corners]), self.columns @ x)
        rays = [
            Ray(corner.x, self._certain(float(lower), corner.x), decided=bool(lower > ENOUGH), row=None)
            for corner, lower in zip(corners, proved, strict=True)
        ]
        others = iter(self.along([ray.direction for ray in rays if not ray.decided]))
        return [ray if ray.decided else next(others) for ray in rays]

    def axes(self) -> list[Ray]:
        """Solve along the d positive axes and then the negative ones.

        Raises SolverError if one of them has no answer, and HoldfastError if 0 is not inside the set.
        """
        found = self.along([*np.eye(self.dimension), *-np.eye(self.dimension)])
        for ray in found:
            if not ray.decided:
                problem = f"the solver found no answer along {_in_words(ray.direction)}"
                raise SolverError(message(self.where, problem, "ask for load_factor along single loads"))
            if ray.reach < SMALLEST:
                share = f"less than {SMALLEST:g} of the bound along {_in_words(ray.direction)} moves it"
                remedy = "the set is flat or ends at 0; ask for load_factor along single loads, or give a smaller bound"
                raise HoldfastError(message(self.where, f"0 is not inside the set: {share}", remedy))
        return found

    def farthest(self, direction: Float) -> ExtremeLoad | None:
        """Return the x (d,) that is carried and goes farthest along ``direction`` (d,), or None if the solver fails.

        It is an extreme point of the set of loads that are carried: max y·x  s.t.  G f + wrench + ``columns`` x = 0, f
        in the friction cones, |x_k| <= 1.
        """
        size, count = len(direction), self._box_program.A.shape[1]
        q = np.zeros(count)
        q[count - size :] = -direction / np.abs(direction).max()
        self._prepared.aim(q)
        found = self._prepared.solve()
        x, forces = found.x[count - size :], self.proofs.program.scales.force * found.x[: count - size]
        return ExtremeLoad(x, forces) if np.isfinite(found.x).all() and x.any() else None

    @cached_property
    def _prepared(self) -> Prepared:
        return Prepared(self._box_program, tolerance=TOLERANCE)

    @cached_property
    def _box_program(self) -> ConeProgram:
        """The program of single loads, with d columns in the place of one, and the box."""
        single, motion = self.proofs.program.cone_program, self.proofs.program.scales.motion
        size, forces = self.dimension, single.A.shape[1] - 1
        loads = sparse.csc_matrix(motion[:, None] * self.columns)
        below = sparse.csc_matrix((single.A.shape[0] - len(motion), size))
        walls = sparse.vstack([sparse.eye(size), -sparse.eye(size)])
        inside = sparse.hstack([sparse.csc_matrix((2 * size, forces)), walls])
        A = sparse.vstack([sparse.hstack([single.A[:, :forces], sparse.vstack([loads, below])]), inside])
        b = np.concatenate([single.b, np.ones(2 * size)])
        none = sparse.csc_matrix((forces + size, forces + size))
        return ConeProgram(
            none, np.zeros(forces + size), sparse.csc_matrix(A), b, (*single.cones, ("nonnegative", 2 * size))
        )

    def _ray(self, direction: Float, limit: LoadLimit) -> Ray:
        """Return what the answer for the load along a direction says of its ray."""
        if limit.status is Status.UNDECIDED:
            return Ray(direction, 0.0, decided=False, row=None)
        row = None
        if limit.proof is not None:
            unknown = gamma(len(limit.proof)) * float((np.abs(self.columns.T) @ np.abs(limit.proof)).sum())
            row = self.columns.T @ limit.proof / (limit.upper + unknown)
        return Ray(direction, self._certain(limit.lower, direction), decided=True, row=row)

    def _certain(self, lower: float, direction: Float) -> float:
        """The reach along a direction, less what rounding of the load and of the point may take from ``lower``."""
        if not lower > 0:
            return 0.0
        unknown = gamma(len(direction)) * (np.abs(self.columns) @ np.abs(direction))
        paid = np.where(unknown > 0, unknown, 0.0) @ np.where(unknown > 0, self.proofs.slope, 0.0)
        total = 1 / lower + float(paid)
        return 1 / total * DOWN if total > 0 else np.inf


def _in_words(direction: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in direction) + ")"


BUDGET = {3: 240, 6: 240}  # solves by dimension; in six dimensions the facets of a hull cost more than the solves
BATCH = {3: 6, 6: 40}  # solves by dimension before both polyhedra are computed again
ALIKE = 0.995  # two rays with a larger cosine are too close for one batch


def find_set(family: LoadFamily, accuracy: float, solves: int | None = None) -> LoadSet:
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

    family: LoadFamily
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
        box = np.vstack([np.eye(dimension), -np.eye(dimension)])
        self._learn(self.family.axes())
        while True:
            rows = np.vstack([box, np.array(self.planes).reshape(-1, dimension)])
            vertices = _rows(hull_of(rows, where))  # a row of the polar set's hull is a vertex of the set
            hull = hull_of(np.array(self.points), where)
            self.inner = drawn_in(hull)
            self.vertices = np.array(self.points)[hull.vertices]
            gauge = largest_row(self.inner, vertices)  # outer over inner reach at the vertices of outer set and box
            accuracy, self.worst = max(1 - 1 / float(gauge.max()), 0.0), vertices[int(gauge.argmax())]
            report(where, min(self.solves, most), most)
            enough = 1 / (1 - wanted) if wanted < 1 else np.inf
            chosen: list[Float] = []  # largest gauge first, no two alike, none that failed before
            taken = list(self.failed)
            for k in np.argsort(-gauge, kind="stable"):
                if len(chosen) >= min(BATCH[dimension], most - self.solves) or gauge[k] <= enough:
                    break
                way = vertices[k] / np.linalg.norm(vertices[k])
                if not taken or float((np.array(taken) @ way).max()) < ALIKE:
                    taken.append(way)
                    chosen.append(vertices[k])
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


def hull_of(points: Float, where: str) -> ConvexHull:
    """Return the convex hull of points (n, d), or raise SolverError.

    Planes that nearly coincide defeat exact arithmetic in many dimensions: there the points are joggled.
    """
    from scipy.spatial import QhullError  # not for those who ask for no set (geometry/hull.py)

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


DRAWN = 100  # loads of each kind whose gaps are looked at in a round
FACETS = 20  # facets that are pushed out before gaps are looked at again
MOST, WIDER = 0.9, 3.0  # share of the loads whose gaps are to be at most so many times the wanted one
LARGEST = 2.0  # a known point goes no farther than this many boxes
TILT = 0.01  # of a facet, so that the farthest load is a corner and not the middle of a face that is parallel to it
DIGITS = 6  # number of digits to which two facets must agree to be the same
FINER = 0.25  # a ray whose gap is this share of the wanted one is left as it is


def find_hull(family: LoadFamily, near: Float, accuracy: float, solves: int) -> LoadHull:
    """Find points that the ``family`` carries, until half of the loads drawn are within ``accuracy`` of the set.

    Half of the loads that are drawn point anywhere, and half are among ``near`` (n, d). ``solves`` bounds the solves.
    """
    search = _Growth(family, near, np.random.default_rng(0))
    gaps = search.run(accuracy, solves)
    reached, most = np.quantile(gaps, (0.5, MOST)).tolist()
    return LoadHull(np.array(search.known), np.array(search.price), reached, most, search.solves)


@dataclass(eq=False)
class _Growth:
    """The known points, each with its price: an upper bound of the gauge of the true set there.

    Points are scaled to lie on the border as far as it is known, at the price 1. Where a ray does not end within
    LARGEST boxes, its point is its direction, and the price what is known of it. ``planes`` are rows a with a·x <= 1
    for every x that is carried, as far as the solver is right: gaps are measured by them, and no point depends on them.
    """

    family: LoadFamily
    near: Float
    rng: np.random.Generator
    known: list[Float] = field(default_factory=list)
    price: list[float] = field(default_factory=list)
    planes: list[Float] = field(default_factory=list)
    solves: int = 0

    def run(self, wanted: float, most: int) -> Float:
        """Add corners until half of the gaps are as wanted; returns the gaps (n,) of the loads that were drawn last."""
        axes = self.family.axes()
        unit = np.minimum([ray.reach for ray in axes], 1.0).reshape(2, -1).min(0)  # pressed down, it may take any load
        self.solves = len(axes)
        self._learn(axes)
        while True:
            loads = self._drawn_loads(unit)
            used, facets = hull_gauge(np.array(self.known), np.array(self.price), loads)
            least = (loads @ np.array(self.planes).reshape(-1, loads.shape[1]).T).max(1, initial=0.0)
            share = np.divide(least, used, out=np.ones(len(used)), where=used > 0)  # a ray without an end has no gap
            gaps: Float = np.clip(1 - share, 0.0, 1.0)
            report(self.family.where, min(self.solves, most), most)
            wide = np.flatnonzero(gaps > FINER * wanted)
            close = np.median(gaps) <= wanted and np.quantile(gaps, MOST) <= WIDER * wanted
            if close or self.solves >= most or not len(wide):
                report(self.family.where, most, most)
                return gaps
            if not self._pushed_out(facets[self.rng.permutation(wide)], min(FACETS, most - self.solves)):
                report(self.family.where, most, most)
                return gaps

    def _drawn_loads(self, unit: Float) -> Float:
        """Loads (n, d): some anywhere, with coordinates in ``unit`` (d,), and some among those asked for."""
        anywhere = self.rng.normal(size=(DRAWN, len(unit))) * unit
        if not len(self.near):
            return anywhere
        return np.vstack([anywhere, self.near[self.rng.integers(len(self.near), size=DRAWN)]])

    def _pushed_out(self, facets: Float, most: int) -> bool:
        """Find the corners beyond ``most`` of these facets (n, d) at the most; tell whether any was looked at."""
        corners, seen = [], set[bytes]()
        for facet in facets:
            key = np.round(facet / max(float(np.abs(facet).max()), 1e-300), DIGITS).tobytes()
            if len(seen) >= most or key in seen or not facet.any():
                continue
            seen.add(key)
            self.solves += 1
            aim = facet * (1 + TILT * self.rng.normal(size=len(facet)))
            corner = self.family.farthest(aim)
            if corner is None:
                continue
            reach = float(aim @ corner.x)
            if reach > 0:
                self.planes.append(aim / reach)
            if float(facet @ corner.x) > 1:
                corners.append(corner)
        self._learn(self.family.through(corners))
        return bool(seen)

    def _learn(self, rays: list[Ray]) -> None:
        for ray in rays:
            if ray.row is not None:
                self.planes.append(ray.row)
            if not ray.reach > 0:
                continue
            size = float(np.abs(ray.direction).max())
            reach = min(ray.reach, LARGEST / size)
            self.known.append(reach * ray.direction)
            self.price.append(reach / ray.reach * UP)
