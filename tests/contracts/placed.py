"""Poses of bodies in tests."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: Float | None = None) -> Float:
    """Return the pose (4, 4) at this place [m], turned by the rotation matrix ``turn`` (3, 3) if given."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    if turn is not None:
        pose[:3, :3] = turn
    return pose


def lying(roll: float, tilt: float = 0.0, yaw: float = 0.0) -> Float:
    """Return a rotation that lays the z axis along -y after a turn by ``roll``, then ``tilt`` and ``yaw`` [deg]."""
    return np.asarray(Rotation.from_euler("zxz", (roll, 90 + tilt, yaw), degrees=True).as_matrix())
