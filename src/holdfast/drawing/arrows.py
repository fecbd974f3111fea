"""Arrows as rods with cones, for files and pages in 3D."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import unit
from holdfast.drawing.camera import heat_points
from holdfast.drawing.picture import Arrow, Picture

PUSH_RADIUS: Final = 0.0035  # radius of the arrows of pushes, as a share of the size of the picture
FORCE_RADIUS: Final = 0.0022  # radius of the arrows of contact forces, likewise
_SIDES: Final = 12  # number of sides of the rods and cones of an arrow


def arrow_mesh(arrows: tuple[Arrow, ...], radius: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (V, 3) [m] and triangles (T, 3) of arrows as rods of this ``radius`` [m] with cones.

    All arrows have the same number of vertices.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    ring = np.arange(_SIDES)
    following = (ring + 1) % _SIDES
    vertices, triangles = [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
    count = 0
    for arrow in arrows:
        length = float(np.linalg.norm(arrow.head - arrow.tail))
        if length == 0.0:
            continue
        along = (arrow.head - arrow.tail) / length
        across = unit(np.cross(along, np.eye(3)[np.argmin(np.abs(along))]))
        circle = np.outer(np.cos(turn), across) + np.outer(np.sin(turn), np.cross(along, across))
        cap = min(5.0 * radius, 0.6 * length)
        neck = arrow.head - cap * along
        rod = radius * min(1.0, cap / (5.0 * radius) + 0.2)
        rings = [arrow.tail + rod * circle, neck + rod * circle, neck + 0.45 * cap * circle]
        vertices.append(np.concatenate([*rings, arrow.head[None], arrow.tail[None]]))
        for low in (0, _SIDES):
            a, b = ring + low, following + low
            triangles += [np.stack(part, axis=1) + count for part in ([a, b, b + _SIDES], [a, b + _SIDES, a + _SIDES])]
        tip = np.full(_SIDES, 3 * _SIDES)
        triangles.append(np.stack([ring + 2 * _SIDES, following + 2 * _SIDES, tip], axis=1) + count)
        triangles.append(np.stack([following, ring, tip + 1], axis=1) + count)
        count += 3 * _SIDES + 2
    return np.concatenate(vertices), np.concatenate(triangles)


def size_of(picture: Picture) -> float:
    """Return the diagonal [m] of the box around what the picture shows."""
    return float(np.linalg.norm(np.ptp(heat_points(picture), axis=0))) or 1.0
