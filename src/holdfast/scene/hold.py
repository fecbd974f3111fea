"""Hands, grippers, suction cups: what holds a body beside its contacts, as a convex set of forces and moments."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import (
    Float,
    checked_directions,
    checked_items,
    checked_name,
    checked_number,
    checked_rows,
    checked_whole,
    frozen,
)
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.public import Record, column
from holdfast.base.ranges import FORCE, FRICTION, LENGTH, PLACE
from holdfast.base.rigid import checked_pose, transform
from holdfast.base.text import listed, quoted
from holdfast.base.values import altered, seal
from holdfast.scene.body import Body

RING, MOST_SIDES = 16, 1000  # points of the seal of a suction cup
MOST_POINTS = 10_000  # of one grip

Range: TypeAlias = tuple[float, float]
Bounds: TypeAlias = float | tuple[Range, Range, Range]  # the radius of a ball, or a range for each axis
AnyBounds: TypeAlias = "float | ArrayLike | Iterable[float | tuple[float, float]]"


class Hold(Record):
    """A hand or gripper that holds the body named ``body`` with any force and moment within bounds.

    The force acts at the origin of ``frame`` (4, 4), frame to world, and the moment about it; both are those of the
    hold on the body, along the axes of the frame. ``forces`` [N] and ``moments`` [N m] bound them: a number is the
    largest length in any direction (a ball), three entries bound the three axes (a box). An entry is a number, for that
    much either way, or a pair (low, high). ``inf`` is for as much as is needed, 0 (the default) for none. A suction
    cup on a face whose outward normal is the z axis of the frame pulls 40 N and pushes any: ``forces=(9, 9, (-inf,
    40))``.

    The hold gives whatever is needed within the bounds, at will. ``on`` names the body that holds: it gets the opposite
    force and moment, as the hand of a robot does, or the link of an arm that a joint carries. None is for a hand that
    is fixed in the world. Two bodies whose hold bears any force along some axis (``inf``) are a joint, and do not touch
    each other. If the body is moved, the hold moves with it. Raises SceneError if all bounds are 0, if low > high, or
    for numbers out of range.
    """

    body: str
    frame: Float = column("4 4")
    forces: Bounds
    moments: Bounds
    on: str | None

    def __init__(
        self,
        body: str,
        frame: ArrayLike,
        forces: AnyBounds = 0.0,
        moments: AnyBounds = 0.0,
        on: str | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "body", checked_name(body, "hold: body"))
        where = f"hold of {quoted(self.body)}"
        set_(self, "frame", checked_pose(frame, f"{where}: frame"))
        set_(self, "forces", _bounds(forces, f"{where}: forces"))
        set_(self, "moments", _bounds(moments, f"{where}: moments"))
        set_(self, "on", None if on is None else checked_name(on, f"{where}: on"))
        if all(bounds in (0.0, ((0.0, 0.0),) * 3) for bounds in (self.forces, self.moments)):
            raise SceneError(message(where, "holds nothing: all bounds are 0", "give forces=, moments= or both"))
        seal(self)


class Grip(Record):
    """Fingers or pads that press on the body named ``body`` at ``points`` (n, 3) [m], along ``normals`` (n, 3).

    Points and normals are in the world frame; normals point into the body and need no unit length. At each point is a
    contact with the friction coefficient ``mu``, whose normal force is at will between 0 and ``force`` [N], one number
    or one a point; ``inf`` is for as much as is needed. Two opposite fingers carry a weight up to 2 ``mu`` ``force``.
    Several points stand for a pad that resists torsion; a point alone does not.

    ``pull`` [N] is a force that draws the body against the points all the time, shared equally among them: vacuum or a
    magnet. Fingers are fixed in the world, and move with the body if it is moved. Raises SceneError for numbers out of
    range.
    """

    body: str
    points: Float = column("n 3")
    normals: Float = column("n 3")
    mu: float
    force: tuple[float, ...]
    pull: float

    def __init__(
        self,
        body: str,
        points: ArrayLike,
        normals: ArrayLike,
        mu: float,
        force: float | Iterable[float] = math.inf,
        pull: float = 0.0,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "body", checked_name(body, "grip: body"))
        where = f"grip of {quoted(self.body)}"
        places = checked_rows(points, 3, f"{where}: points", within=PLACE)[0]
        ways = checked_directions(normals, f"{where}: normals")
        if len(places) > MOST_POINTS:
            raise SceneError(message(where, f"has {len(places):,} points", f"the limit is {MOST_POINTS:,}"))
        if not len(places) or len(places) != len(ways):
            problem = f"{len(places)} points and {len(ways)} normals"
            raise SceneError(message(where, problem, "needs as many of each, one or more"))
        set_(self, "points", frozen(places.copy()))
        set_(self, "normals", frozen(ways.copy()))
        set_(self, "mu", checked_number(mu, f"{where}: mu", minimum=0, within=FRICTION))
        given = [force] * len(places) if np.ndim(force) == 0 else checked_items(force, f"{where}: force", "numbers")  # type: ignore[arg-type]
        if len(given) != len(places):
            raise SceneError(message(f"{where}: force", f"has {len(given)} numbers", f"needs one, or {len(places)}"))
        set_(self, "force", tuple(_size(each, f"{where}: force") for each in given))
        set_(self, "pull", checked_number(pull, f"{where}: pull", minimum=0, within=FORCE))
        if not any(self.force):
            raise SceneError(message(where, "holds nothing: force is 0", "needs a force > 0"))
        seal(self)

    @classmethod
    def suction(cls, body: str, frame: ArrayLike, force: float, radius: float, mu: float, sides: int = RING) -> Grip:
        """Return a suction cup at the origin of ``frame`` (4, 4), whose z axis is the outward normal of the face.

        Vacuum draws the body to the cup with ``force`` [N], and the cup presses on the body along its seal, a ring of
        ``radius`` [m], for which a polygon of so many ``sides`` inside it stands, so answers are cautious. It comes
        off at the pull ``force`` in the middle, and peels off at force · radius / (radius + a) for a pull at the
        distance a.
        """
        axes = checked_pose(frame, f"suction cup on {quoted(body)}: frame")
        count = checked_whole(sides, f"suction cup on {quoted(body)}: sides", 3, MOST_SIDES)
        reach = checked_number(radius, f"suction cup on {quoted(body)}: radius", above=0, within=LENGTH)
        angle = 2 * np.pi * np.arange(count) / count
        ring = reach * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
        return cls(body, transform(axes, ring), np.tile(-axes[:3, 2], (count, 1)), mu, pull=force)


AnyHold: TypeAlias = Hold | Grip


def checked_holds(holds: Iterable[Any], bodies: Collection[Body]) -> tuple[AnyHold, ...]:
    """Return the holds of a scene as a tuple; raise SceneError for anything else, and for a body that is not movable.

    ``bodies`` are those of the scene.
    """
    found = tuple(checked_items(holds, "scene: holds", "Hold or Grip objects"))
    fixed = {body.name: body.fixed for body in bodies}
    for hold in found:
        if not isinstance(hold, Hold | Grip):
            problem = f"holds has a {type(hold).__name__}"
            raise SceneError(message("scene", problem, "needs holdfast.Hold or holdfast.Grip objects"))
        if hold.body not in fixed:
            problem = f"holds names {quoted(hold.body)}, which is no body"
            raise SceneError(message("scene", problem, nearest_of(hold.body, sorted(fixed))))
        other = holder(hold)
        if other == hold.body:
            raise SceneError(message("scene", f"holds lets {quoted(other)} hold itself", "needs another body in on="))
        if other is not None and other not in fixed:
            problem = f"holds has {quoted(other)} hold {quoted(hold.body)}, which is no body"
            raise SceneError(message("scene", problem, nearest_of(other, sorted(fixed))))
        if fixed[hold.body]:
            raise SceneError(message("scene", f"holds names {quoted(hold.body)}, which is fixed", "hold what can move"))
    return found


def holder(hold: AnyHold) -> str | None:
    """Return the name of the body that holds, or None if that is fixed in the world."""
    return hold.on if isinstance(hold, Hold) else None


def holds_among(holds: Iterable[AnyHold], names: Collection[str], still: Collection[str] = ()) -> tuple[AnyHold, ...]:
    """Return the holds of the bodies with these names by each other, by the world, and by the bodies ``still``."""
    kept = {None, *names, *still}
    return tuple(hold for hold in holds if hold.body in names and holder(hold) in kept)


def moved_hold(hold: AnyHold, motion: Float) -> AnyHold:
    """Return a hold whose body was displaced by ``motion`` (4, 4), world to world."""
    if isinstance(hold, Hold):
        return altered(hold, frame=frozen(motion @ hold.frame))
    turned = hold.normals @ motion[:3, :3].T
    return altered(hold, points=frozen(transform(motion, hold.points)), normals=frozen(turned))


def renamed_hold(hold: AnyHold, names: Mapping[str, str]) -> AnyHold:
    """Return a hold whose bodies have other names, where ``names`` has them."""
    ends = {"body": hold.body, "on": holder(hold)} if isinstance(hold, Hold) else {"body": hold.body}
    return altered(hold, **{end: names.get(name or "", name) for end, name in ends.items()})


def hold_ends(holds: Iterable[AnyHold], index: Mapping[str, int], world: int) -> list[tuple[int, int]]:
    """Return for each hold the number of the body held and that of the body that holds it, or ``world``."""
    return [(index[hold.body], index.get(holder(hold) or "", world)) for hold in holds]


def jointed(holds: Iterable[AnyHold]) -> list[tuple[str, str]]:
    """Return the pairs of bodies that bearings join: holds of one by the other that bear any force along some axis.

    Shapes overlap at joints, and a contact there would carry what the motor of the joint has to.
    """
    joints = [hold for hold in holds if isinstance(hold, Hold) and np.isinf(np.array(hold.forces)).any()]
    return [(min(hold.body, hold.on), max(hold.body, hold.on)) for hold in joints if hold.on is not None]


def held_names(holds: Iterable[AnyHold]) -> set[str]:
    """Return the names of the bodies on which holds act: those held, and those that hold them."""
    return {name for hold in holds for name in (hold.body, holder(hold)) if name is not None}


def refuse_holds(holds: Collection[AnyHold], where: str, remedy: str) -> None:
    """Raise SceneError for a question that does not take holds, if there are any."""
    if holds:
        names = listed(list(dict.fromkeys(hold.body for hold in holds)))
        raise SceneError(message(where, f"does not take holds, and the scene holds {names}", remedy))


def _size(value: Any, where: str) -> float:  # noqa: ANN401 - anything a caller may pass
    """Return a force or moment >= 0, or inf."""
    return math.inf if _endless(value, math.inf) else checked_number(value, where, minimum=0, within=FORCE)


def _endless(value: Any, end: float) -> bool:  # noqa: ANN401
    return isinstance(value, float | np.floating) and float(value) == end


def _bounds(given: Any, where: str) -> Bounds:  # noqa: ANN401
    """Return the radius of a ball, or the ranges (low, high) of three axes."""
    if np.ndim(given) == 0 if not isinstance(given, tuple | list) else False:
        return _size(given, where)
    axes = checked_items(given, where, "three numbers or pairs (low, high)")
    if len(axes) != 3:
        raise SceneError(message(where, f"has {len(axes)} entries", "needs one number, or an entry for each of 3 axes"))
    first, second, third = (_range(each, where) for each in axes)
    return first, second, third


def _range(given: Any, where: str) -> Range:  # noqa: ANN401
    if np.ndim(given) == 0:
        size = _size(given, where)
        return (-size, size) if size else (0.0, 0.0)
    pair = checked_items(given, where, "two numbers, low and high")
    if len(pair) != 2:
        raise SceneError(message(where, f"has an entry of {len(pair)} numbers", "needs a number or (low, high)"))
    low, high = (
        end if _endless(value, end) else checked_number(value, where, within=FORCE)
        for value, end in zip(pair, (-math.inf, math.inf), strict=True)
    )
    if low > high:
        raise SceneError(message(where, f"has the range ({low:g}, {high:g})", "needs low <= high"))
    return low, high
