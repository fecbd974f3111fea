"""How far a body can move along a straight line before it touches another one, exactly for triangle meshes.

Let d be the direction of the motion. Front faces of the moving body (n · d > 0) can only run into back faces
(n · d < 0) of the body that stands still. Seen along d, a front triangle and a back triangle share a convex polygon, on
which their distance along d is linear. It is least at a corner of the polygon: a vertex of one triangle over the other,
or a crossing of two edges. Faces parallel to d, such as the side walls of a drawer, cannot stop the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Float, frozen, unit
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents
from holdfast.base.values import Value
from holdfast.geometry.surface import Surface
from holdfast.native import core

HAIRLINE = 1e-3  # relative to the tolerance: gaps up to this width between triangles are closed
CORNER = 16  # number of segments of a quarter circle where an outline is widened or narrowed


class Faces(NamedTuple):
    """Triangles (F, 3, 3) [m] and their boxes ``low``, ``high`` (F, 3) in a frame whose third axis is d."""

    triangles: Float
    low: Float
    high: Float


@dataclass(frozen=True, eq=False, repr=False)
class Swept(Value):
    """A surface with its front and back faces as seen along the unit vector ``direction`` (3,)."""

    surface: Surface
    direction: Float

    @cached_property
    def corners(self) -> Float:
        """The vertices (V, 3) [m] in a frame whose third axis is the direction."""
        axes = np.column_stack([*tangents(self.direction), self.direction])
        return frozen(np.ascontiguousarray(self.surface.vertices @ axes))

    @cached_property
    def low(self) -> Float:
        """The lowest coordinates (3,) [m] in this frame."""
        return frozen(self.corners.min(0))

    @cached_property
    def high(self) -> Float:
        """The highest coordinates (3,) [m] in this frame."""
        return frozen(self.corners.max(0))

    @cached_property
    def front(self) -> Faces:
        """The faces whose normals point forward."""
        return self._facing(1.0)

    @cached_property
    def back(self) -> Faces:
        """The faces whose normals point backward."""
        return self._facing(-1.0)

    def _facing(self, sense: float) -> Faces:
        """Return the faces whose normals point along ``sense`` · d, or all faces if the inside is not known."""
        t = self.corners[self.surface.faces]
        u, w = t[:, 1, :2] - t[:, 0, :2], t[:, 2, :2] - t[:, 0, :2]
        area = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
        seen = sense * area if self.surface.oriented else np.abs(area)
        longest = np.maximum((u**2).sum(1), np.maximum((w**2).sum(1), ((w - u) ** 2).sum(1)))
        size = float(np.max(self.high - self.low))
        chosen = np.ascontiguousarray(t[seen > COORDINATES * size * np.sqrt(longest)])
        low, high = np.ascontiguousarray(chosen.min(1)), np.ascontiguousarray(chosen.max(1))
        return Faces(frozen(chosen), frozen(low), frozen(high))


def first_hit(moving: Surface, still: Surface, direction: Float, tolerance: float = 0.0) -> float:
    """Return how far [m] ``moving`` travels along ``direction`` (3,) until it hits ``still``; inf if it never does.

    ``tolerance`` [m] is the overlap, sideways or ahead, that does not count as a hit, so that a wall along which the
    body slides does not stop it. Contacts that the motion opens never count. The result is 0 if the obstacle is no
    farther ahead than the tolerance. With a tolerance of 0 the distance is exact.
    """
    d = unit(np.asarray(direction, dtype=np.float64))
    return hit_distance(Swept(moving, d), Swept(still, d), tolerance)


def hit_distance(moving: Swept, still: Swept, tolerance: float = 0.0) -> float:
    """Return ``first_hit`` of two surfaces that were prepared for one direction; for many pairs this saves work."""
    size = float(np.max(moving.high - moving.low))
    narrow = max(tolerance, COORDINATES * size)
    across = np.minimum(moving.high, still.high)[:2] - np.maximum(moving.low, still.low)[:2]
    if (across <= narrow).any() or still.high[2] < moving.low[2] - tolerance:
        return np.inf
    # a back face further behind was passed already; if an inside is not known, a contact at 0 may just as well open
    known = moving.surface.oriented and still.surface.oriented
    least = -max(tolerance, narrow) if known else max(tolerance, narrow)
    pieces, corners, ahead = core.shared_parts(moving.front, still.back, least)
    if not len(ahead):
        return np.inf
    order = np.argsort(ahead, kind="stable")
    outlines = [shapely.Polygon(piece[:count]) for piece, count in zip(pieces[order], corners[order], strict=True)]
    ahead = ahead[order]

    def wide(count: int) -> bool:
        # widening and narrowing closes the gaps between triangles
        whole = shapely.buffer(_union(outlines[:count], HAIRLINE * narrow), HAIRLINE * narrow, quad_segs=CORNER)
        return not shapely.is_empty(shapely.buffer(whole, -(0.5 + HAIRLINE) * narrow, quad_segs=CORNER))

    if not wide(len(ahead)):
        return np.inf
    # invariant: the first ``low`` pieces are too narrow to stop it, the first ``high`` are not
    low, high, probe = 0, len(ahead), 1
    while high - low > 1:
        low, high = (low, probe) if wide(probe) else (probe, high)
        probe = min(2 * probe, (low + high) // 2)  # the first pieces are usually wide enough
    distance = float(ahead[high - 1])
    return distance if distance > narrow else 0.0


def _union(outlines: Sequence[shapely.Geometry], fine: float) -> shapely.Geometry:
    """Return the union of polygons; if nearly coincident edges make that fail, on a grid of ``fine`` [m]."""
    try:
        return shapely.union_all(outlines)
    except shapely.GEOSException:
        rounded = shapely.set_precision(outlines, fine, mode="pointwise")
        return shapely.union_all(shapely.make_valid(rounded), grid_size=fine)
