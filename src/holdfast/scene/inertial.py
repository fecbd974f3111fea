"""Mass, centre of mass and inertia of a rigid body: in another frame, about another point, and summed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.rigid import transform


class Inertial(NamedTuple):
    """A mass [kg], its centre (3,) [m] and its inertia (3, 3) [kg m²] about it, along the axes of some frame."""

    mass: float
    com: Float
    inertia: Float

    def seen(self, pose: Float) -> Inertial:
        """Return the same in another frame; ``pose`` (4, 4) maps this frame to it."""
        R = pose[:3, :3]
        return Inertial(self.mass, transform(pose, self.com[None])[0], R @ self.inertia @ R.T)

    def about(self, point: Float) -> Float:
        """Return the inertia (3, 3) [kg m²] about another ``point`` (3,) [m] (parallel axis theorem)."""
        arm = self.com - point
        return np.asarray(self.inertia + self.mass * (np.eye(3) * (arm @ arm) - np.outer(arm, arm)))


def together(inertials: Iterable[Inertial]) -> Inertial:
    """Return the sum of several inertials in the same frame, at least one of which has a mass."""
    each = list(inertials)
    if len(each) == 1:
        return each[0]
    mass = sum(one.mass for one in each)
    com = np.asarray(sum((one.mass * one.com for one in each), np.zeros(3)) / mass)
    return Inertial(float(mass), com, np.asarray(sum((one.about(com) for one in each), np.zeros((3, 3)))))
