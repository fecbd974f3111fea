"""Spots: the places at which a merged patch touches, each with a normal and a share of the contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int, kept, unit
from holdfast.base.kinds import shaped
from holdfast.base.rigid import Frame, snapped
from holdfast.base.values import Value

TURNED = 0.5  # normals that differ by 2 are apart by this share of the extent: both sides of a lip keep spots
TOGETHER = 4_000_000  # distances that are held at a time


@archived
@shaped(points="m 3", normals="m 3", shares="m")
@dataclass(frozen=True, eq=False, repr=False)
class Spots(Value):
    """The m places at which a patch that stands for many smaller ones touches, in the order of farthest points.

    - ``points`` (m, 3) [m] and unit ``normals`` (m, 3), which point into the second body. Every point is one where the
      surfaces come near each other, moved onto the plane of the patch unless ``bent``.
    - ``shares`` (m,) [m²]: the part of the contact that each spot stands for; lines and points count as ``breadth``
      wide. Their moments are those of the contact: area and first moments, and of one plane the second moments.
    - ``bent``: whether the normals differ. If not, they are that of the patch, in whose plane all points lie.
    - ``area`` [m²]: of the faces alone.
    - ``residual`` [m]: how far the contact that they stand for lies from the plane or, if ``bent``, from them.
    - ``spread`` [deg]: how far the normals of that contact are turned from those of the spots.
    """

    points: Float
    normals: Float
    shares: Float
    bent: bool
    area: float
    residual: float
    spread: float

    def __post_init__(self) -> None:
        for name in ("points", "normals", "shares"):
            object.__setattr__(self, name, kept(getattr(self, name)))

    def flipped(self) -> Spots:
        """Return the same spots seen from the other body."""
        return replace(self, normals=-self.normals)

    def canonical(self, frame: Frame, bits: int) -> Spots:
        """Return the same spots with coordinates rounded in ``frame`` to this many binary digits."""
        seen = frame.seen(self.points)
        normals = unit(snapped(self.normals @ frame.axes.T, 1.0, bits) @ frame.axes)
        return replace(self, points=frame.world(snapped(seen, float(np.abs(seen).max()), bits)), normals=normals)


def in_order(points: Float, normals: Float, count: int) -> Int:
    """Return the numbers of at most ``count`` of the points (n, 3): each is the farthest from those before it.

    The first is the farthest from the mean. Points at one place with different ``normals`` (n, 3) are apart.
    """
    places = _places(points, normals)
    away = ((places - places.mean(0)) ** 2).sum(1)
    chosen = [int(np.argmax(away))]
    apart = ((places - places[chosen[0]]) ** 2).sum(1)
    while len(chosen) < count:
        farthest = int(np.argmax(apart))
        if apart[farthest] <= 0:
            break
        chosen.append(farthest)
        apart = np.minimum(apart, ((places - places[farthest]) ** 2).sum(1))
    return np.array(chosen, dtype=np.int64)


def nearest_spot(points: Float, normals: Float, spots: Int) -> Int:
    """Return which of ``spots``, numbers of points, is nearest to each of the points (n, 3) with ``normals`` (n, 3)."""
    places = _places(points, normals)
    size = max(1, TOGETHER // len(spots))
    parts = [places[first : first + size] for first in range(0, len(places), size)]
    return np.concatenate([((part[:, None] - places[spots]) ** 2).sum(-1).argmin(1) for part in parts])


def _places(points: Float, normals: Float) -> Float:
    """Return points (n, 6) whose distances are those of places and normals together."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    return np.hstack([points, normals * (TURNED / 2 * extent)])
