"""Poses of bodies in tests, a floor without end, and prisms."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float

FLOOR = hf.Body("floor", hf.HalfSpace(), fixed=True)


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


def prism(outline: Float, low: float, high: float) -> hf.Mesh:
    """Return a prism along z, from one height to another [m], over a convex outline (n, 2), counter-clockwise."""
    n = len(outline)
    i = np.arange(n)
    j = (i + 1) % n
    fan = np.column_stack([np.zeros(n - 2, dtype=int), i[1:-1], i[2:]])
    sides = [np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])]
    ends = [np.column_stack([outline, np.full(n, z)]) for z in (low, high)]
    return hf.Mesh(np.vstack(ends), np.vstack([*sides, fan[:, ::-1], fan + n]))
