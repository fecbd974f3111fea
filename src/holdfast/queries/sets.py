"""What a body may be loaded with, and how its support may accelerate: convex sets between two polyhedra."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from holdfast.assembly.assembly import FIXED, Assembly, body_forces
from holdfast.base.arrays import Bool, Float, Objects, checked, checked_number, frozen, objects
from holdfast.base.errors import HoldfastError, SceneError, SolverError, message
from holdfast.base.progress import report
from holdfast.engines.answers import Claim
from holdfast.engines.limit.engine import Limit, LimitState
from holdfast.engines.verdict import Status
from holdfast.queries.request import EngineChoice, Load, body_number, engine_of, total_wrench
from holdfast.queries.set_files import read_set, save_set

FORCE_BOUND = 20.0  # total weights, and torques of that times the assembly's size
ACCELERATION_BOUND = 5.0  # g
BUDGET = {3: 240, 6: 240}  # solves; in 6-D the facets of a hull, not the solves, are what costs
BATCH = {3: 6, 6: 40}  # solves between two looks at both polyhedra
SMALLEST = 1e-6  # of the box: a set that reaches less far along an axis is taken as flat
CUT_MARGIN = 1e-7  # of the box, and
WEIGHT_MARGIN = 1e-8  # of the total weight: how far outwards cuts are moved
ROUNDING = 1e-9  # a point on a facet counts as inside
ALIKE = 0.995  # cosine above which two directions of one batch ask the same


@dataclass(frozen=True, eq=False)
class ConvexSet:
    """A convex set between two polyhedra: every point of ``inner`` belongs to it, every one outside ``outer`` does not.

    ``inner`` and ``outer`` are (A (m, d), b (m,)) with A x <= b, scaled to b = 1 (0 is inside both). ``inner`` ends at
    the box |x_k| <= ``bound[k]`` (d,); ``outer`` does not and holds everywhere, so a set without end has an ``outer``
    without end. ``vertices`` (k, d) are those of ``inner``. ``gap``: along every ray from 0 the inner reach is at least
    (1 - gap) times that of outer and box; ``gap_wanted`` was asked for, ``solves`` is what it took.

    Coordinates in ``units`` (d,), ``frame`` in words. Both polyhedra are as exact as the solver (1e-7 of the box).
    """

    engine: str
    claim: Claim
    inner: tuple[Float, Float]
    outer: tuple[Float, Float]
    vertices: Float
    bound: Float
    gap: float
    gap_wanted: float
    solves: int
    units: tuple[str, ...]
    frame: str
    notes: tuple[str, ...]

    def contains(self, x: Any) -> bool | Objects | None:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """True: certainly in the set; False: certainly not; None: between the bounds, or beyond the box.

        ``x`` is (d,), or (n, d) for an object array (n,) of answers.
        """
        points, single = self._points(x, "contains: x")
        inside, possible = _satisfied(self.inner, points), _satisfied(self.outer, points)
        answers = [True if yes else None if maybe else False for yes, maybe in zip(inside, possible, strict=True)]
        return answers[0] if single else objects(answers)

    def usage(self, x: Any) -> float | Float:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """The share of the reach of ``inner`` from 0 that ``x`` uses: max(A x / b), at most 1 certainly in the set.

        ``x`` is (d,), or (n, d) for an array (n,).
        """
        points, single = self._points(x, "usage: x")
        A, b = self.inner
        used = np.maximum(_largest(A / b[:, None], points), 0.0)
        return float(used[0]) if single else used

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the set as JSON (.json) or for NumPy (.npz), with both polyhedra as half-spaces."""
        save_set(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ConvexSet:
        """Read a set back that ``save`` wrote, bit for bit the same."""
        return cls(**read_set(path))

    def _points(self, x: Any, where: str) -> tuple[Float, bool]:  # noqa: ANN401
        dimension = len(self.bound)
        single = np.asarray(x, dtype=object).ndim == 1
        points = checked(x, (dimension,) if single else (None, dimension), where).reshape(-1, dimension)
        return points, single


def admissible_wrenches(
    assembly: Assembly,
    body: str,
    *,
    engine: EngineChoice = "limit",
    gap: float = 0.05,
    bound: Any = None,  # noqa: ANN401 - two numbers, checked
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """The wrenches that ``body`` can take besides weight and ``standing`` loads before anything in the assembly moves.

    Points are (force [N], torque [N m] about the body's centre of mass), world axes, d = 6. ``bound`` (force [N],
    torque [N m]) ends the inner polytope; by default 20 total weights, and that times the assembly's size.

    In six dimensions the number of solves is limited: ``gap`` is a wish, and the ``gap`` of the result what came of it.
    Raises HoldfastError if the assembly does not stand, or if 0 is not inside the set.
    """
    where = f"admissible wrenches of {body!r}"
    number = body_number(assembly, body)
    if number == FIXED:
        raise SceneError(message(where, "the body is fixed: it takes every wrench", "name a movable body"))
    if bound is None:
        limits = FORCE_BOUND * assembly.weight * np.array([1.0, assembly.size])
    else:
        limits = checked(bound, (2,), f"{where}: bound")
    columns = np.zeros((6 * len(assembly.movable), 6))
    columns[6 * number : 6 * number + 6] = np.eye(6)
    units = ("N",) * 3 + ("N m",) * 3
    frame = f"world axes; torque about the centre of mass of {body!r}"
    return _convex_set(where, assembly, engine, standing, columns, np.repeat(limits, 3), gap, units, frame)


def sustainable_accelerations(
    assembly: Assembly,
    *,
    engine: EngineChoice = "limit",
    gap: float = 0.02,
    bound: float | None = None,
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """The accelerations of the support that all bodies follow without moving on it, under ``standing`` loads.

    Points are (3,) [m/s²], world: with the support accelerating by a, a body of mass m feels -m a at its centre of
    mass. ``bound`` [m/s²] of each component ends the inner polytope; 5 g by default. Raises HoldfastError if the
    assembly does not stand, or if 0 is not inside the set.
    """
    where = "sustainable accelerations"
    default = ACCELERATION_BOUND * float(np.linalg.norm(assembly.scene.gravity))
    limit = default if bound is None else checked_number(bound, f"{where}: bound", above=0)
    columns = np.column_stack([body_forces(-assembly.mass[:, None] * axis) for axis in np.eye(3)])
    return _convex_set(
        where, assembly, engine, standing, columns, np.full(3, limit), gap, ("m/s²",) * 3, "world axes, of the support"
    )


def _satisfied(half_spaces: tuple[Float, Float], points: Float) -> Bool:
    A, b = half_spaces
    return np.asarray(_largest(A / b[:, None], points) <= 1 + ROUNDING)


def _largest(A: Float, points: Float) -> Float:
    """(n,) max over the rows of A of A x, in pieces that fit into memory; -inf without rows."""
    step = max(1, 4_000_000 // max(len(A), 1))
    pieces = [(points[k : k + step] @ A.T).max(axis=1, initial=-np.inf) for k in range(0, len(points), step)]
    return np.concatenate(pieces) if pieces else np.empty(0)


def _convex_set(
    where: str,
    assembly: Assembly,
    engine: EngineChoice,
    standing: Iterable[Load],
    columns: Float,
    bound: Float,
    gap: float,
    units: tuple[str, ...],
    frame: str,
) -> ConvexSet:
    wanted = checked_number(gap, f"{where}: gap", above=0)
    if not (bound > 0).all():
        raise SceneError(message(f"{where}: bound", f"is {bound.tolist()}", "needs positive numbers"))
    if not assembly.movable:
        raise SceneError(message(where, "there is no movable body", "free one"))
    method = engine_of(engine)
    if not isinstance(method, Limit):
        problem = f"engine {method.name!r} proves nothing about loads that it was not asked"
        raise HoldfastError(message(where, problem, "use engine='limit'"))
    state = method.prepare(assembly, total_wrench(assembly, standing))
    verdict = state.verdict()
    if not verdict.equilibrium_exists:
        raise HoldfastError(message(where, f"the assembly is {verdict.status}", verdict.reason))
    search = _Search(where, state, columns * bound)
    reached = search.run(wanted)
    inner, cuts, vertices = search.polyhedra()
    notes = state.notes if verdict.status is Status.STABLE else (*state.notes, verdict.reason)
    return ConvexSet(
        method.name,
        method.claim,
        (_frozen(inner / bound), _frozen(np.ones(len(inner)))),
        (_frozen(cuts / bound), _frozen(np.ones(len(cuts)))),
        _frozen(vertices * bound),
        _frozen(bound),
        reached,
        wanted,
        search.solves,
        units,
        frame,
        notes,
    )


def _frozen(array: Float) -> Float:
    return np.asarray(frozen(np.array(array, dtype=np.float64)))


@dataclass(eq=False)
class _Search:
    """Points and cuts in units of the box [-1, 1]^d, one of each from every solve along a ray from 0.

    A cut is kept as its row a of a·x <= 1. The ray gap is largest at a vertex of the outer polytope, because the
    inner gauge is convex: asking along that vertex either confirms it or cuts it off.
    """

    where: str
    state: LimitState
    columns: Float
    points: list[Float] = field(default_factory=list)
    cuts: list[Float] = field(default_factory=list)
    failed: list[Float] = field(default_factory=list)
    solves: int = 0
    inner: Float = field(default_factory=lambda: np.empty(0))
    vertices: Float = field(default_factory=lambda: np.empty(0))

    def run(self, wanted: float) -> float:
        """Ask until the ray gap is at most ``wanted`` or the budget is used; returns the gap reached."""
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

    def polyhedra(self) -> tuple[Float, Float, Float]:
        """Rows of the inner polytope and of the outer polyhedron without the box, and the vertices of the inner one."""
        cuts = np.array(self.cuts).reshape(-1, self.columns.shape[1])
        return self.inner, np.unique(cuts, axis=0), self.vertices

    def _ask(self, direction: Float) -> None:
        self.solves += 1
        solved = self.state.solve(self.columns @ direction)
        if solved.status is Status.UNDECIDED:
            self.failed.append(direction / np.linalg.norm(direction))
            return
        reach = 1 / float(np.abs(direction).max())
        self.points.append(min(solved.lower, reach) * direction)
        if solved.twists is not None:
            normal = self.columns.T @ solved.twists
            self.cuts.append(normal / (solved.upper + self._slack(normal, solved.twists)))

    def _slack(self, normal: Float, twists: Float) -> float:
        """How far a cut may be wrong where the solver's twists leave the dual cone: by loads and by weights."""
        assembly = self.state.assembly
        speeds = float(np.abs(twists / assembly.equation_scale).sum())
        return CUT_MARGIN * float(np.abs(normal).sum()) + WEIGHT_MARGIN * assembly.weight * speeds

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
        return vertices, _largest(self.inner, vertices)

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
