"""Contacts of vertices and edges: where a corner or an edge of one surface is nearest to the other.

A feature (an edge or a vertex) touches only where it is a local minimum of the distance along the contact normal: the
surface around it leads away from the other body, up to the angle tolerance. The normal is that of the touched face, or
the cross product of two edges. If faces meet at a smooth edge, as on a tessellated curve, the contact may be between
them and takes the mean of their normals. On a sharp edge or corner the normal is undefined, so there is no contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.ranges import COORDINATES
from holdfast.base.values import Value, seal
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Angles
from holdfast.native import core

# sine of the angle below which the cross product of two edges is not reliable
NEAR_PARALLEL: Final = core.NEAR_PARALLEL


class FeatureLimits(NamedTuple):
    """Tolerances of the search for touching edges and vertices; lengths are in metres.

    Surfaces touch up to ``gap`` apart and ``depth`` into each other. ``sin_angle`` is the sine of the angle by which
    the surface beside a feature may slope towards the other body; beside a curved face ``sin_curved`` holds instead.
    Lengths up to ``tiny`` are rounding. Contacts within ``strict`` of a sharp edge do not count.
    """

    gap: float
    depth: float
    sin_angle: float
    sin_curved: float
    tiny: float
    strict: float


@dataclass(frozen=True, eq=False, repr=False)
class Features(Value):
    """Contacts along lines and at points, halfway between the bodies.

    ``ends`` (m, 2, 3) [m] are the two ends of each line, which are equal for a point. ``normals`` (m, 3) point into b.
    ``heights`` (m, 2) [m] are the separations at the ends. ``inset`` (m,) [m] is the distance from the nearest sharp
    edge of the touched face. ``blended`` (m,) is True if the normal is the mean of several faces.
    """

    ends: Float
    normals: Float
    heights: Float
    inset: Float
    blended: Bool

    def __post_init__(self) -> None:
        seal(self)


def touching_features(
    a: SearchMesh, b: SearchMesh, pairs: Int, *, gap: float, depth: float, angles: Angles, size: float, strict: float
) -> tuple[Features, Features]:
    """Find the lines and the points where edges and vertices touch, among ``pairs`` (m, 2) of faces whose boxes meet.

    ``size`` [m] is that of the smaller body. Contacts within ``strict`` [m] of a sharp edge do not count.
    """
    sin_angle, sin_curved = np.sin(np.radians(angles)).tolist()
    limits = FeatureLimits(gap, depth, sin_angle, sin_curved, COORDINATES * size, strict)
    lines, points = core.touching_features(a, b, pairs, limits)
    return _features(lines), _features(points)


def _features(rows: Float) -> Features:
    return Features(rows[:, :6].reshape(-1, 2, 3), rows[:, 6:9], rows[:, 9:11], rows[:, 11], rows[:, 12] > 0)
