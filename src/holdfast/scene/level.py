"""Horizontal directions in a scene, the gravity in the frame of a tilted carrier, and angles that look like radians."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_whole, frozen
from holdfast.base.ranges import ANGLE
from holdfast.base.rigid import tangents

MOST_DIRECTIONS = 1_000_000  # more answers would not fit into memory
# Parts of a turn in radians, such as 1.5708, are multiples of pi / 12; they are often given with three digits, as 1.57
PART, DIGITS_OFF = np.pi / 12, 6e-4
ANGLE_ZERO = 1e-6  # [deg] of rounding in poses


def directions_around(up: Float, count: int) -> Float:
    """Return ``count`` unit vectors (count, 3), evenly spaced around the circle perpendicular to ``up`` (3,)."""
    checked_whole(count, "horizontal_directions: count", 1, MOST_DIRECTIONS)
    ahead, left = tangents(up)
    angle = 2 * np.pi * np.arange(count)[:, None] / count
    return np.asarray(frozen(np.cos(angle) * ahead + np.sin(angle) * left))


def tilted_gravity(gravity: Float, tilt_degrees: ArrayLike) -> tuple[Float, str]:
    """Return the gravity (3,) [m/s²] in the axes of a tilted carrier, and a description of the tilt, "" if it is zero.

    ``tilt_degrees`` is as in ``Scene.tilted``.
    """
    given = checked(tilt_degrees, (3,), "tilt_degrees", within=ANGLE)
    from scipy.spatial.transform import Rotation  # only here, as it takes a tenth of a second

    turn = Rotation.from_rotvec(np.radians(given)).as_matrix()
    vector = np.degrees(Rotation.from_matrix(turn).as_rotvec())
    angle = float(np.linalg.norm(vector))
    axis = ", ".join(f"{v + 0.0:.3g}" for v in np.round(vector / angle, 9)) if angle else "any axis"
    note = f"the carrier is tilted by {angle:.4g}° about ({axis})" if angle else ""
    if like_radians(given):
        note += f": are these degrees? {angle:.5g} rad are {np.degrees(angle):.3g}°"
    return turn.T @ gravity, note


def like_radians(degrees: Float) -> bool:
    """Tell whether angles (n,) [deg] look as if they were in radians.

    None is larger than a turn in radians, and half of those that are not zero are its usual parts, 30, 45, 60, 90 ...
    """
    angles = np.abs(degrees[np.abs(degrees) > ANGLE_ZERO])
    number = np.round(angles / PART)
    part = (np.abs(angles - number * PART) <= DIGITS_OFF * angles) & ((number % 2 == 0) | (number % 3 == 0))
    return bool(len(angles) and angles.max() <= 24.1 * PART and 2 * part.sum() >= len(angles))
