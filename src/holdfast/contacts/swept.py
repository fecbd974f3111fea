"""Nearest points of balls, capsules and sides of cylinders to each other and to edges, in closed form.

Each of these is a ball or a disc swept along a segment of its axis; for an edge the radius is zero. The nearest points
of two surfaces follow from those of the axes by the radii.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from holdfast.base.arrays import Float, unit
from holdfast.base.ranges import COORDINATES

PARALLEL = 0.1  # sine of the largest angle between two axes at which bodies may touch along a line


class Swept(NamedTuple):
    """A ball of ``radius`` [m] swept from ``centre`` - ``half`` to ``centre`` + ``half`` (3,) [m].

    ``flat`` is True if the ends are flat, as those of a cylinder; then only the side counts.
    """

    centre: Float
    half: Float
    radius: float
    flat: bool

    @property
    def along(self) -> Float:
        """The unit direction (3,) of the axis; zero for a ball."""
        length = float(np.linalg.norm(self.half))
        return self.half / length if length else self.half

    @property
    def extent(self) -> Float:
        """Half the size (3,) [m] of the bounding box, along the axes of the world."""
        return np.asarray(np.abs(self.half) + self.radius)

    @property
    def thickness(self) -> float:
        """The radius [m]."""
        return self.radius

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """
        flat = np.eye(3) - np.outer(normal, normal)
        along = flat @ self.along
        return np.asarray((flat - np.outer(along, along)) / max(self.radius, least))

    def flattest(self, normal: Float) -> float:
        """Return the curvature [1/m] across its axis."""
        return 1 / self.radius

    def share(self, point: Float) -> float:
        """Return the point of the axis nearest to a point (3,), as a multiple of ``half`` from -1 to 1."""
        length2 = float(self.half @ self.half)
        return float(np.clip((point - self.centre) @ self.half / length2, -1, 1)) if length2 else 0.0

    def at(self, share: float) -> Float:
        """Return the point (3,) of the axis at a share from -1 to 1."""
        return np.asarray(self.centre + share * self.half)


class Meeting(NamedTuple):
    """The contact of two round bodies, at a point or along a line.

    ``ends`` (2, 1 or 2, 3) [m] are points on the surface of the first and of the second, ``normal`` (3,) points into
    the second, ``heights`` (1 or 2,) [m] are the distances, negative where they overlap. ``bend`` [1/m] is the
    curvature of the gap between the bodies across the line or, at a point, the least curvature in any direction.
    """

    ends: Float
    normal: Float
    heights: Float
    bend: float


def meeting(one: Swept, two: Swept, *, gap: float, depth: float, cos_twist: float, cos_side: float) -> Meeting | None:
    """Return where two swept bodies touch, up to ``gap`` apart and ``depth`` into each other [m]; None if they do not.

    They touch along a line if they are near enough at both ends of the part in which they lie side by side, and if the
    cosine of the angle between the normals there is at least ``cos_twist``. Otherwise they may touch where they are
    nearest. The normal must be perpendicular to the side of a body with flat ends, within an angle whose cosine is
    ``cos_side``. An overlap at a rim does not count, as the sides need not overlap there.
    """
    nearest = _nearest(one, two)
    for pairs in (_side_by_side(one, two), [nearest]):
        ways = [two.at(other) - one.at(share) for share, other in pairs]
        apart = np.linalg.norm(ways, axis=-1)
        heights = apart - one.radius - two.radius
        if not ways or (apart <= COORDINATES * (one.radius + two.radius)).any():
            continue
        normals = np.array(ways) / apart[:, None]
        if ((heights < -depth) | (heights > gap)).any() or float(normals[0] @ normals[-1]) < cos_twist:
            continue
        normal = unit(normals.sum(0))
        rim = len(pairs) == 1 and ((one.flat and abs(nearest[0]) == 1) or (two.flat and abs(nearest[1]) == 1))
        if not (rim and heights[0] < -COORDINATES * (one.radius + two.radius)) and all(
            not it.flat or float(it.along @ normal) ** 2 <= 1 - cos_side**2 for it in (one, two)
        ):
            of_one = [one.at(share) + one.radius * way for (share, _), way in zip(pairs, normals, strict=True)]
            of_two = [two.at(other) - two.radius * way for (_, other), way in zip(pairs, normals, strict=True)]
            bends = gap_bends(one, two, normal)
            return Meeting(np.array([of_one, of_two]), normal, heights, float(bends[len(pairs) - 1]))
    return None


def _nearest(one: Swept, two: Swept) -> tuple[float, float]:
    """Return the nearest points of the two axes, each as a multiple of ``half`` from -1 to 1."""
    a, b = one.half, two.half
    aa, bb, ab = float(a @ a), float(b @ b), float(a @ b)
    apart = two.centre - one.centre
    across = aa * bb - ab * ab
    share = float(np.clip((float(apart @ a) * bb - float(apart @ b) * ab) / across, -1, 1)) if across > 0 else 0.0
    other = two.share(one.at(share))
    share = one.share(two.at(other))
    return share, two.share(one.at(share))


def _side_by_side(one: Swept, two: Swept) -> list[tuple[float, float]]:
    """Return the ends, as shares of both axes, of the part in which two nearly parallel axes lie side by side.

    The list is empty if there is none.
    """
    length2 = float(one.half @ one.half)
    if not length2 or not two.half.any() or np.linalg.norm(np.cross(one.along, two.along)) > PARALLEL:
        return []
    shadow = sorted(float((two.at(end) - one.centre) @ one.half) / length2 for end in (-1, 1))
    start, stop = max(-1.0, shadow[0]), min(1.0, shadow[1])
    if (stop - start) * np.sqrt(length2) <= COORDINATES * (one.radius + two.radius):
        return []
    return [(share, two.share(one.at(share))) for share in (start, stop)]


class Curved(Protocol):
    """A smooth body, such as ``Swept``."""

    @property
    def thickness(self) -> float:
        """The largest distance [m] of its surface from its axis or its centre; 0 for an edge."""

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """


def gap_bends(one: Curved, two: Curved, normal: Float) -> Float:
    """Return the least and the greatest curvature (2,) [1/m] of the gap between two surfaces along a normal (3,)."""
    # an edge has no radius, and its infinite curvature would hide the other
    least = COORDINATES * (one.thickness + two.thickness)
    return np.asarray(np.linalg.eigvalsh(one.curvature(normal, least) + two.curvature(normal, least))[1:])
