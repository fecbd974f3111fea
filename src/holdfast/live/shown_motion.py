"""The display of a mechanism: small finite motions of the bodies, and the contacts that open and slide."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float
from holdfast.engines.mechanism import STILL, Mechanism
from holdfast.engines.mechanism import parting as parting_of

SWING: Final = 0.08  # largest displacement that is shown, as a share of the assembly's size


def moved_by(mechanism: Mechanism, amount: float) -> dict[str, Float]:
    """Return the transforms (4, 4), world frame, of the moving bodies by name after a motion of size ``amount`` [m].

    A body turns by ``amount`` times its angular velocity about its centre of mass, which moves by ``amount`` times its
    velocity. Velocities are scaled so that |velocity| + size |angular velocity| = 1 for the fastest body.
    """
    number = {name: k for k, name in enumerate(mechanism.kinematics.names)}
    places = {}
    for name in mechanism.moving if mechanism.mode != "crush" else ():
        k = number[name]
        com, twist = mechanism.kinematics.com[k], mechanism.own[k]
        place = np.eye(4)
        place[:3, :3] = Rotation.from_rotvec(amount * twist[3:]).as_matrix()
        place[:3, 3] = com + amount * twist[:3] - place[:3, :3] @ com
        places[name] = place
    return places


class Parting(NamedTuple):
    """The contact nodes (n, 3) [m] that open in a mechanism, and those that slide."""

    opening: Float
    sliding: Float


def parting(mechanism: Mechanism) -> Parting:
    """Return which contact nodes open and which slide as the bodies begin to move."""
    nodes = mechanism.kinematics.nodes
    speeds = parting_of(nodes, mechanism.velocities(), dual=mechanism.dual)
    slides = speeds.sliding > max(float(speeds.least), STILL)
    return Parting(nodes.points[speeds.opening > STILL], nodes.points[slides])
