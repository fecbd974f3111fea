"""Joints of robots as holds: their bearings bear whatever is needed, and along its axis a motor gives what it can.

Given positions of joints are checked against the limits in the file.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from holdfast.base.arrays import Float, checked_mapping, checked_number, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import FORCE, LENGTH
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Inertial
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import BodyPiece, rigid_body
from holdfast.scene.hold import Hold, Range
from holdfast.scene.shapes import Sphere

SLACK = 0.01  # share of the range, because files round limits (1.57 for a right angle) and simulators let joints yield
Torques: TypeAlias = bool | Mapping[str, float]


def check_within(where: str, position: float, low: float, high: float, *, turning: bool) -> None:
    """Raise SceneError if the position [rad or m] of a joint lies outside ``low`` to ``high``, with both units named.

    Such a position was probably meant in degrees or millimetres. Equal limits do not count: some files leave them out.
    """
    slack = SLACK * (high - low)
    if not high > low or low - slack <= position <= high + slack:
        return
    if turning:
        symbol, remedy = "rad", f"positions are radians: {position:g} degrees are {np.radians(position):.4g} rad"
    else:
        symbol, remedy = "m", f"positions are metres: {position:g} mm are {1e-3 * position:.4g} m"
    raise SceneError(
        message(where, f"{position:g} {symbol} is outside its limits {low:g} to {high:g} {symbol}", remedy)
    )


class Motors:
    """What the motors of joints give, in the place of the file where ``hold_torques`` says so."""

    def __init__(self, hold_torques: Torques, *, welded: bool) -> None:
        self.used = hold_torques is not False
        self.balls: list[str] = []  # links without a shape
        self._given: dict[str, float] = {}
        if self.used and welded:
            problem = "is given with rigid=True or fixed=True"
            raise SceneError(message("hold_torques", problem, "leave those out: rigid bodies have no joints that move"))
        if isinstance(hold_torques, bool):
            return
        for name, most in checked_mapping(hold_torques, "hold_torques", '{"elbow": 40.0}').items():
            where = f"hold_torques: {quoted(name)}"
            self._given[name] = most if most == math.inf else checked_number(most, where, minimum=0, within=FORCE)

    def check_names(self, known: Collection[str]) -> None:
        """Raise SceneError for a joint that is unknown."""
        for name in self._given:
            if name not in known:
                raise SceneError(message(f"hold_torques: {quoted(name)}", "is no joint", nearest_of(name, known)))

    def of(self, name: str, from_file: Range | None) -> Range:
        """Return the range of a joint [N m, or N if it slides]: as given, or ``from_file``, None if it has none."""
        if name in self._given:
            return -self._given[name], self._given[name]
        if from_file is None:
            remedy = f"give hold_torques={{{name!r}: N m, or N if it slides}}, with inf if it is locked"
            raise SceneError(message(f"joint {quoted(name)}", "the file has no limit of its force or torque", remedy))
        return from_file

    def ball(self, name: str, pose: Float, inertial: Inertial) -> Body:
        """Return a link without a shape, which is to touch nothing: a ball of the size that its inertia says."""
        self.balls.append(name)
        radius, at = math.sqrt(2.5 * float(np.trace(inertial.inertia)) / 3 / inertial.mass), np.eye(4)
        at[:3, 3] = inertial.com
        return rigid_body(name, [BodyPiece(Sphere(max(radius, LENGTH.least)), at)], pose=pose, inertial=inertial)


def joint_hold(body: str, on: str | None, point: Float, axis: Float, bounds: Range, *, slides: bool) -> Hold:
    """Return the hold of a link by its joint at ``point`` (3,) with the unit vector ``axis`` (3,), world frame.

    ``bounds`` are those of its motor about the axis [N m], or along it [N] if it ``slides``.
    """
    frame, free = np.eye(4), (-math.inf, math.inf)
    way = unit(axis)
    frame[:3, :3], frame[:3, 3] = np.column_stack([*tangents(way), way]), point
    along_axis = (free, free, bounds)
    return Hold(body, frame, along_axis if slides else math.inf, math.inf if slides else along_axis, on)


def never_touching(arms: Iterable[Sequence[str]], balls: Collection[str], every: Sequence[str]) -> tuple[Excluded, ...]:
    """Return the pairs of bodies that never touch: links of one arm, and ``balls`` with ``every`` body.

    Shapes of links overlap at their joints, and a contact that is none would carry what a motor has to.
    """
    pairs = [pair for names in arms for pair in itertools.combinations(names, 2)]
    pairs += [(ball, name) for ball in balls for name in every if name != ball]
    return tuple({(min(pair), max(pair)): None for pair in pairs})
