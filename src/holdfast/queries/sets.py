"""Compute all wrenches that a body withstands, and all accelerations of its support, as convex sets.

Each set is enclosed between an inner and an outer polyhedron. What holds is asked direction by direction, and checked
in between (checked_hull.py); where an equilibrium exists is a convex set, and both polyhedra are proved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly, body_forces
from holdfast.base.archive import to_dict
from holdfast.base.arrays import (
    Bool,
    Float,
    Objects,
    checked,
    checked_number,
    checked_rows,
    checked_whole,
    frozen,
    objects,
)
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.public import PublicValue, Summary, column, number
from holdfast.base.ranges import ACCELERATION, COORDINATES, FORCE, MANY, SCALE
from holdfast.engines.answers import Claim
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.contract import SETS, Engine, LoadSet, State
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.limit.load_sets import BUDGET, drawn_in, hull_of
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import largest_row
from holdfast.queries.checked_hull import checked_hull
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    Load,
    body_number,
    checked_assembly,
    engine_for,
    engine_of,
    total_wrench,
)
from holdfast.scene.scene import Scene

FORCE_BOUND = 20.0  # default bound of forces, in total weights; times the assembly's size, the default bound of torques
OUTSIDE = 0.1  # accuracy of the outer polyhedron around what holds: what is proved to move, seldom close to it
ASKED = {3: "accelerations", 6: "wrenches"}  # what sets are of, by dimension
ACCELERATION_BOUND = 5.0  # default bound of each component of an acceleration, in g


class ConvexSet(PublicValue):
    """A set of loads between two polyhedra: nothing outside ``outer`` is in it.

    With the ``claim`` *holds*, ``inner`` is what holds by the ``lower`` of the default engine. That was asked in many
    directions and checked in as many in between, and ``inner`` was drawn in where a check failed; ``notes`` count both.
    It is no proof. With the claim *exists*, ``inner`` is proved to have an equilibrium, which need not come about.
    Nothing outside of ``outer`` has one: there something moves for certain.

    ``inner`` and ``outer`` are pairs of arrays A (m, d) and b (m,) for the half-spaces A x <= b, scaled to b = 1; the
    origin is inside both. ``inner`` is limited to the box ``|x_k| <= box[k]``, with ``box`` (d,). ``outer`` is not
    limited to it; if the set is unbounded, ``outer`` is unbounded too. ``vertices`` (k, d) are those of ``inner``.

    Where an equilibrium exists, ``inner`` extends at least (1 - ``accuracy``) times as far as ``outer`` within the box
    along every ray from the origin. Of what holds it extends (1 - ``accuracy``) times as far as ``lower`` or more in
    half of the directions. ``accuracy_wanted`` is the accuracy that was requested, and ``solves`` the number of solves.

    The coordinates have the units in ``units`` (d,), and ``frame`` describes their axes in words. The solver limits the
    precision of both polyhedra to 1e-7 of the box.

    ``save`` writes a file that other programs can read as well. In .npz, ``inner.0`` and ``inner.1`` are A and b. In
    .json, ``inner`` lists them as ``$tuple``, each with its numbers row by row and its shape.
    """

    engine: str
    claim: Claim
    inner: tuple[Float, Float]
    outer: tuple[Float, Float]
    vertices: Float = column("v d")
    box: Float = column("d")
    accuracy: float
    accuracy_wanted: float
    solves: int
    units: tuple[str, ...] = column("d")
    frame: str
    notes: tuple[str, ...]

    plain = "engine claim vertices box accuracy accuracy_wanted solves units frame notes"

    def contains(self, coordinates: Any) -> bool | Objects | None:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """Return whether ``coordinates`` are in what holds (True), certainly outside (False), or neither (None).

        None means that they lie between the two polyhedra or beyond the box. They are (d,), or (n, d) for an object
        array (n,) of answers. Raises HoldfastError for a set of what exists: ask ``exists``.
        """
        if self.claim is not Claim.HOLDS:
            remedy = "ask .exists(...), or for a set without exists=True"
            raise HoldfastError(message("contains", "inside an equilibrium exists, which need not hold", remedy))
        return self._between(coordinates, "contains")

    def exists(self, coordinates: Any) -> bool | Objects | None:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """Return whether an equilibrium certainly exists at ``coordinates`` (True), or none (False), or neither (None).

        They are as in ``contains``. Raises HoldfastError for a set of what holds: ask ``contains``.
        """
        if self.claim is Claim.HOLDS:
            raise HoldfastError(message("exists", "this is a set of what holds", "ask .contains(...)"))
        return self._between(coordinates, "exists")

    def _between(self, coordinates: Any, where: str) -> bool | Objects | None:  # noqa: ANN401
        points, single = checked_rows(coordinates, len(self.box), f"{where}: coordinates")
        inside, possible = _satisfied(self.inner, points), _satisfied(self.outer, points)
        answers = [True if yes else None if maybe else False for yes, maybe in zip(inside, possible, strict=True)]
        return answers[0] if single else objects(answers)

    def usage(self, coordinates: Any) -> float | Float:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """Return max(A x / b) over the facets of ``inner``, at least 0, for ``coordinates`` x (d,) or (n, d).

        This is the distance of x from the origin as a share of the distance to the boundary of ``inner``. If it is at
        most 1, x is inside ``inner``. The result is a number, or an array (n,).
        """
        points, single = checked_rows(coordinates, len(self.box), "usage: coordinates")
        A, b = self.inner
        used = np.maximum(largest_row(A / b[:, None], points), 0.0)
        return float(used[0]) if single else used

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the values that were read from a file cannot be those of a set."""
        dimension = len(self.box)
        for name in ("accuracy", "accuracy_wanted"):
            checked_number(getattr(self, name), name, minimum=0)
        for name in ("inner", "outer"):
            A, b = getattr(self, name)
            checked(A, (len(checked(b, (None,), f"{name}: b")), dimension), f"{name}: A")
            if not (b > 0).all():
                problem = f"has {b.min():g}"
                raise HoldfastError(message(f"{name}: b", problem, "needs positive numbers: 0 is in the set"))

    def about(self) -> dict[str, Any]:
        """Return both polyhedra as plain data, as A and b of A x <= b."""
        return {name: to_dict(dict(zip("Ab", getattr(self, name), strict=True))) for name in ("inner", "outer")}

    def summary(self) -> Summary:
        """Summarise the extent of the set and how close the two polyhedra are."""
        what = "where an equilibrium exists" if self.claim is Claim.EXISTS else "what holds"
        size = f"{len(self.box)} dimensions, {len(self.inner[1])} facets inside"
        headline = f"{what}: {size}, accuracy {self.accuracy:.2%}"
        largest = np.abs(self.vertices).max(axis=0, initial=0.0)
        rows = [[f"{k + 1}", number(far, unit)] for k, (far, unit) in enumerate(zip(largest, self.units, strict=True))]
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("frame", self.frame)]
        return Summary(headline, facts, ("coordinate", "largest value"), rows, self.notes)


def admissible_wrenches(
    assembly: Assembly | Scene,
    body: str,
    *,
    exists: bool = False,
    accuracy: float = 0.05,
    box: ArrayLike | None = None,
    solves: int | None = None,
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """Compute the set of wrenches on ``body`` under which everything in the assembly stays at rest, as far as known.

    With ``exists``, it is the set for which an equilibrium exists, which is larger; see ConvexSet.

    The wrenches act in addition to the weight and the ``standing`` loads. The points of the set have d = 6 coordinates:
    a force [N] and a torque [N m] about the body's centre of mass, along the world axes. ``box`` (2,) holds the largest
    force [N] and torque [N m] components of the inner polyhedron. The defaults are 20 times the total weight, and that
    times the assembly's size.

    ``accuracy`` is only a target, because ``solves`` limits the number of solves, to 240 by default. The ``accuracy``
    of the result is the one that was reached, and its ``notes`` say along which ray. Time grows faster than the number
    of solves: 600 take about ten times as long as 240. ``constraint`` is closer to the set for most wrenches.

    Raises SceneError if the body is fixed or unknown, or if something is held, unless with ``exists``. Raises
    HoldfastError if the assembly does not stand, or if the origin is not inside the set.
    """
    assembly = checked_assembly(assembly)
    where = f"admissible wrenches of {body!r}"
    columns = wrench_columns(assembly, body, where)
    limits = wrench_box(assembly, box, where)
    units = ("N",) * 3 + ("N m",) * 3
    frame = f"world axes; torque about the centre of mass of {body!r}"
    question = _SetQuestion(where, assembly, columns, limits, total_wrench(assembly, standing), exists)
    return question.answer(accuracy, solves, units, frame)


def wrench_box(assembly: Assembly, box: ArrayLike | None, where: str) -> Float:
    """Return the largest components (6,) [N, N m] of wrenches, from ``box`` (2,) or its default."""
    if box is None:
        limits = FORCE_BOUND * assembly.weight * np.array([1.0, assembly.size])
    else:
        limits = checked(box, (2,), f"{where}: box", within=FORCE)
    if not (limits > 0).all():
        raise SceneError(message(f"{where}: box", f"is {limits.tolist()}", "needs positive numbers"))
    return np.repeat(limits, 3)


def wrench_columns(assembly: Assembly, body: str, where: str) -> Float:
    """Return the load columns (6J, 6) of unit forces and torques on ``body``. Raises SceneError if it is fixed."""
    number = body_number(assembly, body)
    if number == FIXED:
        raise SceneError(message(where, "the body is fixed: it takes every wrench", "name a movable body"))
    columns = np.zeros((6 * len(assembly.movable), 6))
    columns[6 * number : 6 * number + 6] = np.eye(6)
    return columns


def notes_of(state: State, assembly: Assembly) -> tuple[str, ...]:
    """Return the notes of a state, the reason of its verdict unless it is STABLE, and that crushing is not asked."""
    verdict = state.verdict()
    why = () if verdict.status is Status.STABLE else (verdict.reason,)
    return (*state.notes, *why, *unchecked_limits(assembly.bodies))


def sustainable_accelerations(
    assembly: Assembly | Scene,
    *,
    exists: bool = False,
    accuracy: float = 0.02,
    box: ArrayLike | None = None,
    solves: int | None = None,
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """Compute the accelerations of the support that all bodies follow without moving relative to it, as far as known.

    With ``exists``, it is the set for which an equilibrium exists, which is larger; see ConvexSet.

    The ``standing`` loads act throughout. The points of the set are accelerations (3,) [m/s²] along the world axes: if
    the support accelerates by a, the inertial force on a body of mass m is -m a at its centre of mass. ``box`` is the
    largest component [m/s²] of the inner polyhedron, 5 g by default. ``accuracy`` is a target, see ConvexSet:
    ``solves`` limits the number of solves, to 240 by default.

    Raises HoldfastError if the assembly does not stand, or if the origin is not inside the set.
    """
    assembly = checked_assembly(assembly)
    where = "sustainable accelerations"
    default = ACCELERATION_BOUND * float(np.linalg.norm(assembly.scene.gravity))
    limit = default if box is None else checked_number(box, f"{where}: box", above=0, within=ACCELERATION)
    columns = np.column_stack([body_forces(-assembly.mass[:, None] * axis) for axis in np.eye(3)])
    found = _SetQuestion(where, assembly, columns, np.full(3, limit), total_wrench(assembly, standing), exists)
    return found.answer(accuracy, solves, ("m/s²",) * 3, "world axes, of the support")


def _satisfied(half_spaces: tuple[Float, Float], points: Float) -> Bool:
    A, b = half_spaces
    return np.asarray(largest_row(A / b[:, None], points) <= 1 + COORDINATES)


@dataclass(frozen=True, eq=False)
class _SetQuestion:
    """Which loads ``columns`` (6J, d) @ x, in the ``box`` (d,), an assembly takes beside a ``wrench`` (6J,)."""

    where: str
    assembly: Assembly
    columns: Float
    box: Float
    wrench: Float
    exists: bool

    def answer(self, accuracy: float, solves: int | None, units: tuple[str, ...], frame: str) -> ConvexSet:
        """Return the set; the arguments are those of the public functions, and of ConvexSet."""
        wanted = checked_number(accuracy, f"{self.where}: accuracy", above=0, below=1, within=SCALE)
        most = None if solves is None else checked_whole(solves, f"{self.where}: solves", 0, MANY)
        if not self.assembly.movable:
            raise SceneError(message(self.where, "there is no movable body", "free one"))
        engine = engine_for(self.assembly, self.where, exists=self.exists)
        found, notes = self._existing(wanted, most) if self.exists else self._holding(engine, wanted, most)
        if self.exists and found.accuracy > wanted:
            worst = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(found.worst * self.box, units, strict=True))
            why = (
                f"the inner set is {found.accuracy:.0%} too short along the ray to ({worst}), after {found.solves} "
                "solves: near friction cones that a ray meets at a small angle, a polytope needs thousands of corners; "
                "a smaller box and more solves help, and constraint() is close to the set along most rays"
            )
            notes = (*notes, why)
        return ConvexSet(
            engine=engine.name,
            claim=engine.claim,
            inner=(frozen(found.inner / self.box), frozen(np.ones(len(found.inner)))),
            outer=(frozen(found.outer / self.box), frozen(np.ones(len(found.outer)))),
            vertices=frozen(found.vertices * self.box),
            box=frozen(self.box),
            accuracy=found.accuracy,
            accuracy_wanted=wanted,
            solves=found.solves,
            units=units,
            frame=frame,
            notes=notes,
        )

    @property
    def _loaded(self) -> list[int]:
        """The numbers of the bodies that are loaded."""
        return [int(k) for k in np.flatnonzero(self.columns.reshape(-1, 6, len(self.box)).any((1, 2)))]

    def _existing(self, wanted: float, most: int | None) -> tuple[LoadSet, tuple[str, ...]]:
        """Return the set for which an equilibrium exists, and notes on it."""
        groups = prepared(engine_of(CERTAIN_ENGINE), self.assembly, self.wrench)
        state, rows = groups.together(self._loaded, self.where)
        sets = SETS.of(state, engine=CERTAIN_ENGINE, where=self.where)
        return sets.load_set(self.columns[rows] * self.box, wanted, most, self.where), notes_of(state, self.assembly)

    def _holding(self, engine: Engine, wanted: float, most: int | None) -> tuple[LoadSet, tuple[str, ...]]:
        """Return the set that holds by ``lower``, inside of that for which an equilibrium exists, and notes on it."""
        groups = prepared(engine, self.assembly, self.wrench)
        lower = lower_of(groups, self._loaded, self.columns * self.box, self.where)
        size = len(self.box)
        checks = checked_hull(lower, np.empty((0, size)), wanted, BUDGET[size] if most is None else most, self.where)
        hull = checks.hull
        reach = hull.known / hull.price[:, None]
        reach /= np.maximum(np.abs(reach).max(1, keepdims=True), 1.0)  # within the box
        around, (existing, _) = hull_of(reach, self.where), self._existing(OUTSIDE, most)
        found = replace(
            existing,
            inner=drawn_in(around),
            vertices=reach[around.vertices],
            accuracy=hull.accuracy,
            solves=hull.solves,
        )
        return found, (*groups.notes, *unchecked_limits(self.assembly.bodies), *checks.notes(ASKED[size]))


def lower_of(groups: Groups, loaded: list[int], columns: Float, where: str) -> Callable[[Float], Float]:
    """Return the function that gives ``lower`` (n,) of the loads ``columns`` (6J, d) @ x, for x (n, d).

    Raises HoldfastError, with ``where`` in its message, if the ``loaded`` bodies are not known to stand.
    """
    verdict = groups.verdict_on(loaded)
    if verdict.status is not Status.STABLE:
        raise HoldfastError(message(where, f"the assembly is {verdict.status}", verdict.reason))
    return lambda x: groups.load_factor(columns @ x.T).lower
