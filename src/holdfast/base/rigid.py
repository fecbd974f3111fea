"""Poses, twists and wrenches.

A pose is a 4x4 transform from the body frame to the world frame. A wrench is (force, torque) [N, N m] and a twist is
(velocity, angular velocity) [m/s, rad/s]. Both are about a stated reference point and along the world axes, so that
power = wrench · twist.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked, frozen
from holdfast.base.errors import GeometryError, message
from holdfast.base.ranges import ANGLE, PLACE
from holdfast.native import core

FAR = 1e6  # [-] entries of a rotation are clipped to this before they are squared; it is far from rigid
UNIT_LENGTH = 1e-3  # [-] largest deviation of a quaternion's length from 1; files print three digits and more
RIGID_TOLERANCE = 1e-5  # [-] largest entry of |RᵀR - 1|; scanned poses are printed with about six digits
_LAST_ROW = frozen(np.array([0.0, 0.0, 0.0, 1.0]))
_LAST_ROW_TOLERANCE = frozen(np.array([1e-12, 1e-12, 1e-12, RIGID_TOLERANCE]))


class Frame(NamedTuple):
    """A frame of reference: its ``origin`` (3,) [m] in the world, and the rows of ``axes`` (3, 3), unit vectors."""

    origin: Float
    axes: Float

    def seen(self, points: Float) -> Float:
        """Return points (..., 3) [m] of the world in this frame."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def world(self, points: Float) -> Float:
        """Return points (..., 3) [m] of this frame in the world."""
        return np.asarray(self.origin + points @ self.axes)


# (4, 4), rotates the y axis, which is up in graphics files, to the z axis
Y_TO_Z = frozen(np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]))
WORLD = Frame(frozen(np.zeros(3)), frozen(np.eye(3)))


def snapped(values: Float, size: Float | float, bits: int) -> Float:
    """Round values to ``bits`` binary digits relative to ``size``, which is one number or one for each value.

    This removes earlier rounding errors, and differences that come from the axes and units of the world.
    """
    _, power = np.frexp(np.maximum(core.BESIDE * np.asarray(size), core.NOTHING))
    step = np.ldexp(1.0, power - (bits + 1))
    return np.asarray(np.round(values / step) * step + 0.0)


def checked_pose(value: Any, where: str) -> Float:  # noqa: ANN401 - anything a caller may pass
    """Return ``value`` as a read-only rigid transform (4, 4).

    Raises GeometryError for another shape, scale, shear, a reflection or NaN; ``where`` names the argument.
    """
    pose = checked(value, (4, 4), where, error=GeometryError)
    if (np.abs(pose[3] - _LAST_ROW) > _LAST_ROW_TOLERANCE).any():
        raise GeometryError(message(where, f"last row is {pose[3].tolist()}", "needs (0, 0, 0, 1)"))
    if (np.abs(pose[:3, 3]) > PLACE.largest).any():
        raise GeometryError(message(where, f"is at {pose[:3, 3].tolist()}", f"needs coordinates {PLACE.most()}"))
    rotation = pose[:3, :3].clip(-FAR, FAR)
    defect = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if defect > RIGID_TOLERANCE:
        problem = f"is not rigid: |RᵀR - 1| = {defect:.2g}"
        raise GeometryError(message(where, problem, "needs a rotation and a translation, scale belongs in the shape"))
    if np.linalg.det(rotation) < 0:
        raise GeometryError(message(where, "is a reflection: det R = -1", "needs a proper rotation"))
    return pose


def pose(
    x: float = 0.0, y: float = 0.0, z: float = 0.0, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0
) -> Float:
    """Return the pose (4, 4) at (x, y, z) [m], turned by ``roll``, ``pitch`` and ``yaw`` [deg].

    The body turns about the fixed axes x, y and z of the world, in this order: R = Rz(yaw) Ry(pitch) Rx(roll), as in
    URDF and SDF. Multiples of 90 degrees give exact zeros and ones. Raises GeometryError for anything but finite
    numbers in range.
    """
    return pose_at((x, y, z), (roll, pitch, yaw), "pose")


def pose_at(position: Any, rpy_degrees: Any, where: str) -> Float:  # noqa: ANN401 - three numbers each, checked
    """Return the read-only pose (4, 4) with a position (3,) [m] and roll, pitch, yaw (3,) [deg], see ``pose``."""
    place = checked(position, (3,), f"{where}: position", within=PLACE, error=GeometryError)
    angles = checked(rpy_degrees, (3,), f"{where}: rpy_degrees", within=ANGLE, error=GeometryError)
    sines, cosines = zip(*(_sine_and_cosine(float(angle)) for angle in angles), strict=True)
    found = rpy_pose((0.0, 0.0, 0.0), sines, cosines)
    found += 0.0  # no negative zeros
    found[:3, 3] = place
    return np.asarray(frozen(found))


def rpy_pose(position: Sequence[float], sines: Iterable[float], cosines: Iterable[float]) -> Float:
    """Return the pose (4, 4) at a position (3,) [m] for the sines and cosines of roll, pitch and yaw, see ``pose``."""
    (sr, sp, sy), (cr, cp, cy) = sines, cosines
    pose = np.eye(4)
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = position
    return pose


def quaternion_of(rotation: Float) -> Float:
    """Return the quaternion (w, x, y, z) of a rotation (3, 3)."""
    from scipy.spatial.transform import Rotation  # only here, as it takes a tenth of a second

    return np.asarray(Rotation.from_matrix(rotation).as_quat(scalar_first=True))


def _sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Return the sine and the cosine of an angle [deg], exactly 0, 1 or -1 at multiples of 90 degrees."""
    quarters, rest = divmod(degrees, 90.0)
    sine, cosine = math.sin(math.radians(rest)), math.cos(math.radians(rest))
    turned = ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))
    return turned[int(quarters) % 4]


def pose_from(position: Float, quaternion: Float) -> Float:
    """Return the read-only pose (4, 4) with this position (3,) [m] and quaternion (w, x, y, z), which is normalised.

    Raises GeometryError if the quaternion is zero or not finite.
    """
    largest = float(np.abs(quaternion).max())
    if not 0 < largest < np.inf:
        problem = f"is the quaternion {quaternion.tolist()}"
        raise GeometryError(message("orientation", problem, "needs finite numbers that are not all zero"))
    scaled = quaternion / largest  # so that its squares do not overflow
    w, x, y, z = scaled / np.linalg.norm(scaled)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = position
    return np.asarray(frozen(pose), dtype=np.float64)


def cross(a: Float, b: Float) -> Float:
    """Return a x b of vectors (..., 3). The digits are those of ``np.cross``, which takes about three times as long."""
    found = np.empty(np.broadcast_shapes(a.shape, b.shape), np.result_type(a, b))
    x, y, z, u, v, w = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    found[..., 0], found[..., 1], found[..., 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return found


def transform(pose: Float, points: Float) -> Float:
    """Transform ``points`` (n, 3) [m] from the body frame to the world frame."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3], dtype=np.float64)


def wrench_at(force: Float, point: Float, reference: Float) -> Float:
    """Return the wrench (..., 6) about ``reference`` of a ``force`` (..., 3) that acts at ``point`` (..., 3)."""
    return np.concatenate([force, cross(point - reference, force)], axis=-1)


def shift_twist(twist: Float, reference: Float, new_reference: Float) -> Float:
    """Return the twist (6,) of the same rigid motion about ``new_reference`` (3,) instead of ``reference`` (3,)."""
    return np.concatenate([twist[:3] + cross(twist[3:], new_reference - reference), twist[3:]])


def rotation_about(axis: Float, origin: Float, reference: Float) -> Float:
    """Return the twist (..., 6) about ``reference`` of a rotation about the line ``origin`` + t ``axis``.

    The axis (..., 3) is a unit vector and the rate is 1 rad/s.
    """
    velocity = cross(axis, reference - origin)
    return np.concatenate([velocity, np.broadcast_to(axis, velocity.shape)], axis=-1)


def tangents(normal: Float) -> tuple[Float, Float]:
    """Return two unit tangents (..., 3) with t1 x t2 = normal. They depend on the normal alone, so are reproducible."""
    if normal.ndim == 1:
        return _tangents_of_one(*normal.tolist())
    seed = np.where(np.abs(normal[..., :1]) < 0.9, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    t1 = seed - (seed * normal).sum(-1, keepdims=True) * normal
    t1 = t1 / np.linalg.norm(t1, axis=-1, keepdims=True)
    return np.asarray(t1), cross(normal, t1)


def _tangents_of_one(x: float, y: float, z: float) -> tuple[Float, Float]:
    """Return the tangents of one normal, with the same digits as for arrays of normals, in far less time."""
    sx, sy = (1.0, 0.0) if abs(x) < 0.9 else (0.0, 1.0)
    along = sx * x + sy * y + 0.0 * z
    ax, ay, az = sx - along * x, sy - along * y, 0.0 - along * z
    length = math.sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax / length, ay / length, az / length
    return np.array([ax, ay, az]), np.array([y * az - z * ay, z * ax - x * az, x * ay - y * ax])
