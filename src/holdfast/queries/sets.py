"""Compute all wrenches that a body withstands, and all accelerations of its support, as convex sets.

Each set is enclosed between an inner and an outer polyhedron.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly, body_forces
from holdfast.base.archive import archived, to_dict
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
from holdfast.base.kinds import shaped
from holdfast.base.public import PublicValue, Summary, number
from holdfast.base.ranges import ACCELERATION, FORCE, MANY, SCALE
from holdfast.base.rounding import COORDINATES
from holdfast.engines.answers import Claim
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.capabilities import SETS, LoadSet
from holdfast.engines.contract import State
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.geometry.half_spaces import largest_row
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    EngineChoice,
    Load,
    body_number,
    checked_assembly,
    engine_of,
    total_wrench,
)
from holdfast.scene.scene import Scene

FORCE_BOUND = 20.0  # default bound of forces, in total weights; times the assembly's size, the default bound of torques
ACCELERATION_BOUND = 5.0  # default bound of each component of an acceleration, in g


@archived
@shaped(units="d", box="d", vertices="v d")
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ConvexSet(PublicValue):
    """A convex set between two polyhedra: it contains every point of ``inner`` and no point outside ``outer``.

    ``inner`` and ``outer`` are pairs of arrays A (m, d) and b (m,) for the half-spaces A x <= b, scaled to b = 1; the
    origin is inside both. ``inner`` is limited to the box ``|x_k| <= box[k]``, with ``box`` (d,). ``outer`` is not
    limited to it; if the set is unbounded, ``outer`` is unbounded too. ``vertices`` (k, d) are those of ``inner``.

    Along every ray from the origin, ``inner`` extends at least (1 - ``accuracy``) times as far as ``outer`` within the
    box. ``accuracy_wanted`` is the accuracy that was requested, and ``solves`` the number of solves that it took.

    The coordinates have the units in ``units`` (d,), and ``frame`` describes their axes in words. The solver limits the
    precision of both polyhedra to 1e-7 of the box.

    ``save`` writes a file that other programs can read as well. In .npz, ``inner.0`` and ``inner.1`` are A and b. In
    .json, ``inner`` lists them as ``$tuple``, each with its numbers row by row and its shape.
    """

    engine: str
    claim: Claim
    inner: tuple[Float, Float]
    outer: tuple[Float, Float]
    vertices: Float
    box: Float
    accuracy: float
    accuracy_wanted: float
    solves: int
    units: tuple[str, ...]
    frame: str
    notes: tuple[str, ...]

    def contains(self, coordinates: Any) -> bool | Objects | None:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """Return whether ``coordinates`` are certainly in the set (True), certainly outside (False), or neither (None).

        None means that they lie between the two polyhedra or beyond the box. They are (d,), or (n, d) for an object
        array (n,) of answers.
        """
        points, single = checked_rows(coordinates, len(self.box), "contains: coordinates")
        inside, possible = _satisfied(self.inner, points), _satisfied(self.outer, points)
        answers = [True if yes else None if maybe else False for yes, maybe in zip(inside, possible, strict=True)]
        return answers[0] if single else objects(answers)

    def usage(self, coordinates: Any) -> float | Float:  # noqa: ANN401 - (d,) or (n, d) numbers, checked
        """Return max(A x / b) over the facets of ``inner``, at least 0, for ``coordinates`` x (d,) or (n, d).

        This is the distance of x from the origin as a share of the distance to the boundary of ``inner``. If it is at
        most 1, x is certainly in the set. The result is a number, or an array (n,).
        """
        points, single = checked_rows(coordinates, len(self.box), "usage: coordinates")
        A, b = self.inner
        used = np.maximum(largest_row(A / b[:, None], points), 0.0)
        return float(used[0]) if single else used

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the values that were read from a file cannot be those of a set."""
        dimension = len(checked(self.box, (None,), "box"))
        checked(self.vertices, (None, dimension), "vertices")
        for name in ("accuracy", "accuracy_wanted"):
            checked_number(getattr(self, name), name, minimum=0)
        for name in ("inner", "outer"):
            A, b = getattr(self, name)
            checked(A, (len(checked(b, (None,), f"{name}: b")), dimension), f"{name}: A")
            if not (b > 0).all():
                problem = f"has {b.min():g}"
                raise HoldfastError(message(f"{name}: b", problem, "needs positive numbers: 0 is in the set"))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, with both polyhedra as A and b of A x <= b."""
        known = ("accuracy", "accuracy_wanted", "solves")
        names = ("engine", "claim", "vertices", "box", *known, "units", "frame", "notes")
        half_spaces = {name: to_dict(dict(zip("Ab", getattr(self, name), strict=True))) for name in ("inner", "outer")}
        return half_spaces | {name: to_dict(getattr(self, name)) for name in names}

    def summary(self) -> Summary:
        """Summarise the extent of the set and how close the two polyhedra are."""
        headline = f"{len(self.box)} dimensions, {len(self.inner[1])} facets inside, accuracy {self.accuracy:.2%}"
        largest = np.abs(self.vertices).max(axis=0, initial=0.0)
        rows = [[f"{k + 1}", number(far, unit)] for k, (far, unit) in enumerate(zip(largest, self.units, strict=True))]
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("frame", self.frame)]
        return Summary(headline, facts, ("coordinate", "largest value"), rows, self.notes)


def admissible_wrenches(
    assembly: Assembly | Scene,
    body: str,
    *,
    engine: EngineChoice = CERTAIN_ENGINE,
    accuracy: float = 0.05,
    box: ArrayLike | None = None,
    solves: int | None = None,
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """Compute the set of wrenches on ``body`` under which nothing in the assembly moves.

    They act in addition to the weight and the ``standing`` loads. The points of the set have d = 6 coordinates: a force
    [N] and a torque [N m] about the body's centre of mass, along the world axes. ``box`` (2,) holds the largest force
    [N] and torque [N m] components of the inner polyhedron. The defaults are 20 times the total weight, and that times
    the assembly's size.

    ``accuracy`` is only a target, because ``solves`` limits the number of solves, to 240 by default. The ``accuracy``
    of the result is the one that was reached, and its ``notes`` say along which ray. Time grows faster than the number
    of solves: 600 take about ten times as long as 240. ``constraint`` is closer to the set for most wrenches.

    Raises SceneError if the body is fixed or unknown. Raises HoldfastError if the assembly does not stand, or if the
    origin is not inside the set.
    """
    assembly = checked_assembly(assembly)
    where = f"admissible wrenches of {body!r}"
    columns = wrench_columns(assembly, body, where)
    limits = wrench_box(assembly, box, where)
    units = ("N",) * 3 + ("N m",) * 3
    frame = f"world axes; torque about the centre of mass of {body!r}"
    return _convex_set(where, assembly, engine, standing, columns, limits, accuracy, solves, units, frame)


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
    engine: EngineChoice = CERTAIN_ENGINE,
    accuracy: float = 0.02,
    box: ArrayLike | None = None,
    solves: int | None = None,
    standing: Iterable[Load] = (),
) -> ConvexSet:
    """Compute the accelerations of the support that all bodies can follow without moving relative to it.

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
    return _convex_set(
        where,
        assembly,
        engine,
        standing,
        columns,
        np.full(3, limit),
        accuracy,
        solves,
        ("m/s²",) * 3,
        "world axes, of the support",
    )


def _satisfied(half_spaces: tuple[Float, Float], points: Float) -> Bool:
    A, b = half_spaces
    return np.asarray(largest_row(A / b[:, None], points) <= 1 + COORDINATES)


def _convex_set(
    where: str,
    assembly: Assembly,
    engine: EngineChoice,
    standing: Iterable[Load],
    columns: Float,
    box: Float,
    accuracy: float,
    solves: int | None,
    units: tuple[str, ...],
    frame: str,
) -> ConvexSet:
    wanted = checked_number(accuracy, f"{where}: accuracy", above=0, below=1, within=SCALE)
    most = None if solves is None else checked_whole(solves, f"{where}: solves", 0, MANY)
    if not assembly.movable:
        raise SceneError(message(where, "there is no movable body", "free one"))
    method = engine_of(engine)
    loaded = np.flatnonzero(columns.reshape(-1, 6, columns.shape[1]).any((1, 2))).tolist()
    state, rows = prepared(method, assembly, total_wrench(assembly, standing)).together(loaded, where)
    found = SETS.of(state, engine=method.name, where=where).load_set(columns[rows] * box, wanted, most, where)
    notes = notes_of(state, assembly)
    if found.accuracy > wanted:
        notes += (_why_wide(found, box, units),)
    return ConvexSet(
        engine=method.name,
        claim=method.claim,
        inner=(frozen(found.inner / box), frozen(np.ones(len(found.inner)))),
        outer=(frozen(found.outer / box), frozen(np.ones(len(found.outer)))),
        vertices=frozen(found.vertices * box),
        box=frozen(box),
        accuracy=found.accuracy,
        accuracy_wanted=wanted,
        solves=found.solves,
        units=units,
        frame=frame,
        notes=notes,
    )


def _why_wide(found: LoadSet, box: Float, units: tuple[str, ...]) -> str:
    """Return a note on the ray along which the polyhedra are furthest apart, and on why they are not closer."""
    worst = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(found.worst * box, units, strict=True))
    return (
        f"the inner set is {found.accuracy:.0%} too short along the ray to ({worst}), after {found.solves} solves: "
        "near friction cones that a ray meets at a small angle, a polytope needs thousands of corners; a smaller box "
        "and more solves help, and constraint() is close to the set along most rays"
    )
