"""Spots: the points that represent a merged patch, each with a normal and a share that sums up exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.base.arrays import Float, Int, read_only, unit
from holdfast.base.public import Record, column
from holdfast.base.rigid import Frame, snapped
from holdfast.native import core

TURNED = 0.5  # distance of points with opposite normals, relative to the extent, so that both sides of a lip get spots
TOGETHER = 4_000_000  # number of distances that are in memory at a time
LEAST = 0.02  # share of the mean weight that is added to every spot or node of merged patches before a correction


class Spots(Record):
    """The m points that represent a patch merged from many smaller ones, ordered so that early ones are far apart.

    - ``points`` (m, 3) [m] and unit ``normals`` (m, 3), which point into the second body. At every point the surfaces
      are near each other. Unless the patch is ``bent``, points are projected to its plane.
    - ``shares`` (m,) [m²]: the area of the contact that each spot represents; lines and points count as ``breadth``
      wide. They preserve the area and the first moments of the contact and, in one plane, the second moments.
    - ``bent``: True if the normals differ; otherwise all are the normal of the patch, and all points are in its plane.
    - ``area`` [m²]: the area of the merged faces, without lines and points.
    - ``residual`` [m]: the largest distance of the merged patches from the plane or, if ``bent``, from the spots.
    - ``spread`` [deg]: the largest angle between the normals of the merged patches and of the spots.
    """

    points: Float = column("m 3")
    normals: Float = column("m 3")
    shares: Float = column("m")
    bent: bool
    area: float
    residual: float
    spread: float

    def __post_init__(self) -> None:
        for name in ("points", "normals", "shares"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def flipped(self) -> Spots:
        """Return the same spots seen from the other body."""
        return replace(self, normals=-self.normals)

    def canonical(self, frame: Frame, bits: int) -> Spots:
        """Return the same spots with coordinates rounded in ``frame`` to this many binary digits."""
        seen = frame.seen(self.points)
        normals = unit(snapped(self.normals @ frame.axes.T, 1.0, bits) @ frame.axes)
        return replace(self, points=frame.world(snapped(seen, float(np.abs(seen).max()), bits)), normals=normals)


def in_order(points: Float, normals: Float, count: int) -> Int:
    """Return the numbers of at most ``count`` of the points (n, 3), each the farthest from those before it.

    The first is the farthest from the mean. Points with different ``normals`` (n, 3) count as farther apart.
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
    """Return points (n, 6) whose distances combine those of the places and of the normals."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    return np.hstack([points, normals * (TURNED / 2 * extent)])


def corrected(weights: Float, basis: Float, wanted: Float, matched: Sequence[int]) -> Float:
    """Return the weights (n,) nearest to the given ones with ``basis @ weights = wanted``.

    ``basis`` (m, n) holds the values of m functions at the nodes, and ``wanted`` (m,) their integrals. Only the first
    of them are matched, as many as one of the counts ``matched``: the first count that positive weights can match. If
    there is none, the weights remain as they are.
    """
    return core.corrected(weights, np.ascontiguousarray(basis), wanted, np.array(matched))
