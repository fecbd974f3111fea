"""Where balls, capsules and the sides of cylinders come nearest to each other, and to edges, in closed form.

Each is a ball, or a disc, swept along a piece of an axis: the nearest points of two axes are those of the surfaces, but
for the radii. That of an edge is zero.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from holdfast.base.arrays import Float, unit

PARALLEL = 0.1  # sine of the angle between two axes up to which bodies may touch along a line
TINY = 1e-9  # of the radii: distances of axes below it have no direction, shorter lines are points


class Swept(NamedTuple):
    """A ball of ``radius`` [m] swept from ``centre`` - ``half`` to ``centre`` + ``half`` (3,) [m].

    ``flat``: whether the ends are flat, as those of a cylinder, and only the side counts.
    """

    centre: Float
    half: Float
    radius: float
    flat: bool

    @property
    def along(self) -> Float:
        """(3,) the unit direction of the axis; zero for a ball."""
        length = float(np.linalg.norm(self.half))
        return self.half / length if length else self.half

    @property
    def extent(self) -> Float:
        """(3,) [m] half the size of the box around it, along the axes of the world."""
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
        """Return where on the axis it comes nearest to a point (3,): from -1 to 1, as a multiple of ``half``."""
        length2 = float(self.half @ self.half)
        return float(np.clip((point - self.centre) @ self.half / length2, -1, 1)) if length2 else 0.0

    def at(self, share: float) -> Float:
        """Return the point (3,) of the axis at a share from -1 to 1."""
        return np.asarray(self.centre + share * self.half)


class Meeting(NamedTuple):
    """Where two swept bodies come nearest: at a point, or along a line where both ends are near enough.

    ``ends`` (2, 1 or 2, 3) [m] are points on the surface of the first and of the second, ``normal`` (3,) points into
    the second, ``heights`` (1 or 2,) [m] are the distances, negative where they overlap, and ``bend`` [1/m] is the
    least curvature of the gap between them, across the line or in any direction from the point.
    """

    ends: Float
    normal: Float
    heights: Float
    bend: float


def meeting(one: Swept, two: Swept, *, gap: float, depth: float, cos_twist: float, cos_side: float) -> Meeting | None:
    """Return where two swept bodies touch, up to ``gap`` apart and ``depth`` into each other [m], None if nowhere.

    They touch along a line if both ends of what of them lies side by side are near enough, and the normals there
    enclose no more than the angle of ``cos_twist``, and else where they are nearest. The normal has to stand on the
    sides of those with flat ends, to within the angle of ``cos_side``. What overlaps by a rim need not do so by a side.
    """
    nearest = _nearest(one, two)
    for pairs in (_side_by_side(one, two), [nearest]):
        ways = [two.at(other) - one.at(share) for share, other in pairs]
        apart = np.linalg.norm(ways, axis=-1)
        heights = apart - one.radius - two.radius
        if not ways or (apart <= TINY * (one.radius + two.radius)).any():
            continue
        normals = np.array(ways) / apart[:, None]
        if ((heights < -depth) | (heights > gap)).any() or float(normals[0] @ normals[-1]) < cos_twist:
            continue
        normal = unit(normals.sum(0))
        rim = len(pairs) == 1 and ((one.flat and abs(nearest[0]) == 1) or (two.flat and abs(nearest[1]) == 1))
        if not (rim and heights[0] < -TINY * (one.radius + two.radius)) and all(
            not it.flat or float(it.along @ normal) ** 2 <= 1 - cos_side**2 for it in (one, two)
        ):
            of_one = [one.at(share) + one.radius * way for (share, _), way in zip(pairs, normals, strict=True)]
            of_two = [two.at(other) - two.radius * way for (_, other), way in zip(pairs, normals, strict=True)]
            bends = gap_bends(one, two, normal)
            return Meeting(np.array([of_one, of_two]), normal, heights, float(bends[len(pairs) - 1]))
    return None


def _nearest(one: Swept, two: Swept) -> tuple[float, float]:
    """Return where the axes come nearest to each other, as shares of each."""
    a, b = one.half, two.half
    aa, bb, ab = float(a @ a), float(b @ b), float(a @ b)
    apart = two.centre - one.centre
    across = aa * bb - ab * ab
    share = float(np.clip((float(apart @ a) * bb - float(apart @ b) * ab) / across, -1, 1)) if across > 0 else 0.0
    other = two.share(one.at(share))
    share = one.share(two.at(other))
    return share, two.share(one.at(share))


def _side_by_side(one: Swept, two: Swept) -> list[tuple[float, float]]:
    """Return the shares of both axes where what of them lies side by side begins and ends, none if nothing does."""
    length2 = float(one.half @ one.half)
    if not length2 or not two.half.any() or np.linalg.norm(np.cross(one.along, two.along)) > PARALLEL:
        return []
    shadow = sorted(float((two.at(end) - one.centre) @ one.half) / length2 for end in (-1, 1))
    start, stop = max(-1.0, shadow[0]), min(1.0, shadow[1])
    if (stop - start) * np.sqrt(length2) <= TINY * (one.radius + two.radius):
        return []
    return [(share, two.share(one.at(share))) for share in (start, stop)]


class Curved(Protocol):
    """A smooth body, as ``Swept`` is one."""

    @property
    def thickness(self) -> float:
        """How far it reaches from its axis or its centre [m]; 0 for an edge."""

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """


def gap_bends(one: Curved, two: Curved, normal: Float) -> Float:
    """Return the least and the greatest curvature (2,) [1/m] of the gap between two surfaces along a normal (3,)."""
    least = TINY * (one.thickness + two.thickness)  # an edge has no radius, and 1/0 would drown the other's
    return np.asarray(np.linalg.eigvalsh(one.curvature(normal, least) + two.curvature(normal, least))[1:])
