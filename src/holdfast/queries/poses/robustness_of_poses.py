"""Compute for many poses of some bodies how hard one can push before something moves, one push for each pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, Objects, checked_pushes, objects
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.progress import answers_in_parallel, free_threads
from holdfast.base.public import MOST_ROWS, PublicValue, Summary, column, number
from holdfast.base.text import listed, quoted
from holdfast.engines.answers import Answers, Bound, Claim, joined_notes, weakest_bound
from holdfast.engines.bearing import limited
from holdfast.engines.verdict import Status
from holdfast.geometry.distance import distance_to_surface
from holdfast.queries.poses.neighbourhoods import STAGE, GivenPoses, Neighbourhood, Neighbourhoods, given_poses
from holdfast.queries.poses.plain_cases import PlainCases
from holdfast.queries.push import load_factors, robustness
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of, push_columns, quiet
from holdfast.queries.result import ROW_HEADS, cells, places_of
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

NAME = "robustness_of_poses"


class RobustnessOfPoses(PublicValue):
    """The largest push on ``body`` before anything moves, with some ``bodies`` at each of n poses.

    ``poses`` (n, k, 4, 4) are those of the k moved bodies; the push of each pose acts at ``points`` (n, 3) [m] along
    the unit ``directions`` (n, 3), world frame. ``force`` (n,) [N] is the answer, and ``status`` (n,) says what it
    means, as in ``Robustness``: FINITE, INFINITE, UNSTABLE or UNDECIDED. ``lower`` and ``upper`` (n,) [N] bound the
    true answer; ``lower_bound`` and ``upper_bound`` say how all of these bounds are known at least. ``moving`` (n,)
    holds the names of the bodies that begin to move, and ``mode`` (n,) is "slip", "topple", "mixed", "roll" or
    "crush", and "none" where nothing gives way or the body falls without the push.
    """

    engine: str
    claim: Claim
    bodies: tuple[str, ...]
    poses: Float = column("n k 4 4")
    body: str
    points: Float = column("n 3")
    directions: Float = column("n 3")
    force: Float = column("n")
    lower: Float = column("n")
    upper: Float = column("n")
    status: Objects = column("n", of=Status)
    moving: Objects = column("n")
    mode: Objects = column("n")
    lower_bound: Bound
    upper_bound: Bound
    notes: tuple[str, ...]

    plain = (
        "engine claim bodies body force status lower upper moving mode points directions poses lower_bound "
        "upper_bound notes"
    )

    def __len__(self) -> int:
        return len(self.force)

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the rows that were read from a file cannot be answers."""
        if not ((self.lower <= self.force) & (self.force <= self.upper)).all():
            raise HoldfastError(message(NAME, "a force lies outside its bounds", "needs lower <= force <= upper"))

    def summary(self) -> Summary:
        """Summarise the answer by its weakest pushes."""
        known = np.array([status is not Status.UNDECIDED for status in self.status])
        rows = np.flatnonzero(known)[np.argsort(self.force[known], kind="stable")]
        least = number(float(self.force[rows[0]]), "N") if len(rows) else "not known"
        headline = f"{len(self):,} poses of {listed(self.bodies)}, a push on {self.body} at each: the least {least}"
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("not known", f"{int((~known).sum()):,}")]
        places = places_of(self.points)
        table = [cells(f"pose {k}, {places[k]}", self, k, "N") for k in rows[:MOST_ROWS].tolist()]
        return Summary(headline, facts, ROW_HEADS, table, self.notes)


@dataclass(frozen=True)
class Row:
    """The answer for one pose, in short."""

    force: float
    lower: float
    upper: float
    status: Status
    moving: tuple[str, ...] = ()
    mode: str = "none"
    lower_bound: Bound = Bound.PROVED
    upper_bound: Bound = Bound.PROVED
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, found: Answers, row: int = 0) -> Row:
        """Return one row of a table of answers; a body that may not stand, uncrushed, gives way in no known way."""
        status = found.status[row]
        moving = () if status is Status.UNDECIDED else found.moving[row]
        falls = status in (Status.UNDECIDED, Status.UNSTABLE) and found.mode[row] != "crush"
        mode = "none" if falls else found.mode[row]
        force, lower, upper = (float(column[row]) for column in (found.force, found.lower, found.upper))
        return cls(force, lower, upper, status, moving, mode, found.lower_bound, found.upper_bound, found.notes)

    @classmethod
    def not_standing(cls, status: Status, moving: tuple[str, ...]) -> Row:
        """Return the row of a body that does not stand, or of which that is not known."""
        if status is Status.UNSTABLE:
            return cls(0.0, 0.0, 0.0, Status.UNSTABLE, moving)
        return cls(0.0, 0.0, np.inf, Status.UNDECIDED)


def robustness_of_poses(
    assembly: Assembly | Scene,
    bodies: str | Sequence[str],
    poses: ArrayLike | Mapping[str, ArrayLike],
    points: ArrayLike,
    directions: ArrayLike,
    *,
    body: str | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
    bounds: bool = False,
) -> RobustnessOfPoses:
    """Compute for each of n poses the largest force [N] of a push before anything moves.

    ``bodies`` and ``poses`` are those of ``stability_of_poses``. ``points`` [m] and ``directions`` are (n, 3), one push
    for each pose, or (3,) for all, in the world frame, as in ``robustness``: row k is the answer of
    ``robustness(assembly.moved(...), body, points[k], directions[k])`` at pose k. To push a body where it is marked,
    map the mark with its poses: ``poses[:, :3, :3] @ mark + poses[:, :3, 3]``. ``body`` is the one that is pushed, by
    default the only one that is moved.

    ``bounds`` is as in ``robustness``. Raises SceneError if a point is further from the surface of the body than the
    contact tolerance, and the errors of ``stability_of_poses``.
    """
    assembly = checked_assembly(assembly)
    refuse_holds(
        assembly.scene.holds, NAME, "ask one pose at a time: hf.robustness(assembly.moved(...), ..., engine=hf.Limit())"
    )
    method = engine_of(engine)
    given = given_poses(assembly, bodies, poses, NAME)
    if body is None and len(given.names) > 1:
        raise SceneError(message(NAME, f"moves {quoted(given.names, 80)}", "say which is pushed, body="))
    name = given.names[0] if body is None else assembly.scene.body(body).name
    p, e = _pushes(assembly, given, name, points, directions)
    if limited(assembly.bodies):  # who is crushed is asked of the whole scene

        def asked_alone(row: int) -> Row:
            at = assembly.moved(given.row(row))
            return Row.of(robustness(at, name, p[row], e[row], engine=method, bounds=bounds).answers)

        with quiet():
            found = answers_in_parallel(STAGE, asked_alone, min(free_threads(), len(given)), len(given), len(given))
    else:
        found = _rows(Neighbourhoods(assembly, given, method), name, p, e, bounds)
    return RobustnessOfPoses(
        engine=method.name,
        claim=method.claim,
        bodies=given.names,
        poses=given.poses,
        body=name,
        points=p,
        directions=e,
        force=np.array([row.force for row in found]),
        lower=np.array([row.lower for row in found]),
        upper=np.array([row.upper for row in found]),
        status=objects([row.status for row in found]),
        moving=objects([row.moving for row in found]),
        mode=objects([row.mode for row in found]),
        lower_bound=weakest_bound([row.lower_bound for row in found]),
        upper_bound=weakest_bound([row.upper_bound for row in found]),
        notes=joined_notes([assembly.scene.notes, *(row.notes for row in found)]),
    )


def _pushes(
    assembly: Assembly,
    given: GivenPoses,
    name: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401
) -> tuple[Float, Float]:
    """Check one push on a body for each pose, and return the points (n, 3) and unit directions (n, 3)."""
    where = f"{NAME} of {quoted(name)}"
    p, e = checked_pushes(points, directions, where)
    if len(p) not in (1, len(given)):
        problem = f"{len(p)} pushes at {len(given)} poses"
        raise SceneError(message(where, problem, "needs one for each pose, or one for all"))
    p, e = np.broadcast_to(p, (len(given), 3)).copy(), np.broadcast_to(e, (len(given), 3)).copy()
    body = assembly.scene.body(name)
    at = given.of(name) if name in given.names else np.broadcast_to(body.pose, (len(given), 4, 4))
    own = np.asarray(np.linalg.solve(at[:, :3, :3], (p - at[:, :3, 3])[..., None])[..., 0], dtype=np.float64)
    away = distance_to_surface(own, body.shape.surface)
    tolerance = assembly.tolerances.of(body) + body.shape.surface.sagitta
    worst = int(np.argmax(away))
    if away[worst] > tolerance:
        problem = f"at pose {worst} its point is {1e3 * away[worst]:.3g} mm from the surface"
        remedy = f"needs points on the body at that pose (tolerance {tolerance * 1e3:.3g} mm), in world coordinates"
        raise SceneError(message(where, problem, remedy))
    return p, e


def _rows(around: Neighbourhoods, name: str, points: Float, directions: Float, bounds: bool) -> list[Row]:
    """Return the answers for one push on a body at each pose, in threads; all at once where no pose concerns it."""

    def pushed(there: Assembly, rows: list[int]) -> Answers:
        W = push_columns(there, there.index[name], points[rows], directions[rows])
        return load_factors(around.engine, there, W, np.zeros(6 * len(there.movable)), bounds=bounds)

    plain = {moved: PlainCases(around, moved) for moved in around.given.names}
    found: dict[int, Row] = {}
    left: list[tuple[int, Neighbourhood]] = []
    untouched: list[int] = []
    for pieces, rows in around.patterns:
        own = [piece for piece in pieces if name in (*piece.moved, *piece.others)]
        if not own or around.assembly.index[name] == FIXED:
            untouched += rows.tolist()
            continue
        for at, groups in plain[own[0].moved[0]].at_once(own[0], rows):
            (group,) = (each for each in groups if name in each.names)
            if group.status is not Status.STABLE:
                found |= dict.fromkeys(at.tolist(), Row.not_standing(group.status, group.moving))
        left += [(row, own[0]) for row in rows.tolist() if row not in found]
    left.sort(key=lambda entry: entry[0])
    each = around.in_threads(left, lambda there, row: Row.of(pushed(there, [row])))
    found |= {row: answer for (row, _), answer in zip(left, each, strict=True)}
    if untouched:
        with quiet():
            table = pushed(around.rest or around.assembly, untouched)
        found |= {row: Row.of(table, k) for k, row in enumerate(untouched)}
    return [found[row] for row in range(len(around.given))]
