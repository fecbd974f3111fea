"""Poses of bodies in tests."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: Float | None = None) -> Float:
    """Return the pose (4, 4) at this place [m], turned by the rotation matrix ``turn`` (3, 3) if given."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    if turn is not None:
        pose[:3, :3] = turn
    return pose
