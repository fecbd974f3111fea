"""What moves in a picture: the states of an answer as steps of a slider, and the small motions of a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.placement.result import Placement, Placements
from holdfast.applications.resting_poses import RestingPoses
from holdfast.applications.settled import Settled
from holdfast.base.arrays import Float
from holdfast.base.public import number
from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.engines.mechanism import STILL, Mechanism
from holdfast.engines.mechanism import parting as parting_of

BETWEEN: Final = 10  # number of steps from the given poses to those at rest
RAISED: Final = 0.15  # displacement of the body that is taken out next, as a share of the assembly's size
SWING: Final = 0.08  # largest displacement of a mechanism that is shown, likewise


@dataclass(frozen=True)
class ShownStep:
    """What a picture shows at one step of its slider: a text, the bodies hidden, and those drawn elsewhere.

    ``moved`` maps the name of a body to the transform (4, 4), world frame, from its pose in the assembly to where it is
    drawn.
    """

    text: str
    hidden: frozenset[str] = frozenset()
    moved: Mapping[str, Float] = field(default_factory=dict)


def settling(result: Settled) -> tuple[ShownStep, ...]:
    """Return states between the given poses and those at rest, both included."""
    steps = []
    for k in range(BETWEEN + 1):
        back = 1.0 - k / BETWEEN
        moved = {}
        for name in result.names:
            given, rest = result.given.body(name).pose, result.scene.body(name).pose
            turn = Rotation.from_matrix(given[:3, :3] @ rest[:3, :3].T).as_rotvec()
            moved[name] = _turned(back * turn, rest[:3, 3], rest[:3, 3] + back * (given[:3, 3] - rest[:3, 3]))
        ends = {0: "as given", BETWEEN: f"at rest: {result.status}, {result.reason}"}
        steps.append(ShownStep(ends.get(k, f"{k / BETWEEN:.0%} of the way"), moved=moved))
    return tuple(steps)


def taking_apart(result: Disassembly) -> tuple[ShownStep, ...]:
    """Return the states before every removal, with the next body drawn apart, and the final state."""
    steps = []
    away = np.eye(4)
    away[:3, 3] = RAISED * result.assembly.size * result.lift
    for k, step in enumerate(result.steps):
        text = f"{k + 1}: take out {one_line(step.body, LONGEST_NAME)}; {one_line(step.reason)}"
        steps.append(ShownStep(text, frozenset(result.order[:k]), {step.body: away}))
    left = "nothing is left" if not result.remaining else f"{len(result.remaining)} bodies stay"
    return (*steps, ShownStep(left, frozenset(result.order)))


def places(result: Placement) -> tuple[ShownStep, ...]:
    """Return the stable poses that were found for the body, the best first; none without a place."""
    if result.body is None:
        return ()
    home = np.linalg.inv(result.body.pose)
    return tuple(
        ShownStep(
            f"place {k + 1} of {len(result.candidates)}: "
            + ("stands" if one.robustness is None else f"least push {number(one.robustness, 'N')}"),
            moved={result.name: one.pose @ home},
        )
        for k, one in enumerate(result.candidates)
    )


def placing(result: Placements) -> tuple[ShownStep, ...]:
    """Return the states after the objects were put down one by one."""
    return tuple(
        ShownStep(
            f"{k + 1}: put down {one_line(step.body, LONGEST_NAME)}: "
            + ("least push undecided" if step.least is None else f"least push {number(step.least, 'N')}"),
            frozenset(result.order[k + 1 :]),
        )
        for k, step in enumerate(result.steps)
    )


def resting(result: RestingPoses) -> tuple[ShownStep, ...]:
    """Return the poses in which a body rests, the most probable first."""
    home = np.linalg.inv(result.body.pose)
    return tuple(
        ShownStep(f"pose {k} of {len(result)}: {pose.probability:.1%}", moved={result.body.name: pose.pose @ home})
        for k, pose in enumerate(result, 1)
    )


def moved_by(mechanism: Mechanism, amount: float) -> dict[str, Float]:
    """Return the transforms (4, 4), world frame, of the moving bodies by name after a motion of size ``amount`` [m].

    A body turns by ``amount`` times its angular velocity about its centre of mass, which moves by ``amount`` times its
    velocity. Velocities are scaled so that |velocity| + size |angular velocity| = 1 for the fastest body.
    """
    number_of = {name: k for k, name in enumerate(mechanism.kinematics.names)}
    places = {}
    for name in mechanism.moving if mechanism.mode != "crush" else ():
        com, twist = mechanism.kinematics.com[number_of[name]], mechanism.own[number_of[name]]
        places[name] = _turned(amount * twist[3:], com, com + amount * twist[:3])
    return places


class PartingNodes(NamedTuple):
    """The contact nodes (n, 3) [m] that open in a mechanism, and those that slide."""

    opening: Float
    sliding: Float


def parting(mechanism: Mechanism) -> PartingNodes:
    """Return which contact nodes open and which slide as the bodies begin to move."""
    nodes = mechanism.kinematics.nodes
    speeds = parting_of(nodes, mechanism.velocities(), dual=mechanism.dual)
    slides = speeds.sliding > max(float(speeds.least), STILL)
    return PartingNodes(nodes.points[speeds.opening > STILL], nodes.points[slides])


def _turned(turn: Float, start: Float, end: Float) -> Float:
    """Return the transform (4, 4) that turns by a rotation vector (3,) [rad] and takes one point (3,) to another."""
    place = np.eye(4)
    place[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    place[:3, 3] = end - place[:3, :3] @ start
    return place
