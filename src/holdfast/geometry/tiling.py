"""Recognition of convex polygons that a few pieces tile, such as the overlap of two faces of two triangles each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean

FEW = 16  # largest number of pieces


def tiled(pieces: Sequence[Sequence[Float]], tolerance: float) -> Float | None:
    """Return the convex polygon (k, 2), counter-clockwise, that ``pieces`` [outline (n, 2), holes ...] tile, or None.

    The pieces tile their convex hull if all of them are convex and without holes, no two overlap by more than
    ``tolerance``, and their areas add up to that of the hull, up to a strip of that width along its boundary.
    """
    if len(pieces) > FEW or any(len(rings) > 1 for rings in pieces):
        return None
    corners = np.vstack([rings[0] for rings in pieces])
    ends = np.cumsum([len(rings[0]) for rings in pieces])
    out = np.empty((2 * len(corners) + 2, 2))
    count = _tiled(corners, ends, np.lexsort(corners.T[::-1]), tolerance, out)
    return out[:count].copy() if count > 2 else None


@compiled
@lean
def _tiled(corners: Float, ends: Int, order: Int, tolerance: float, out: Float) -> int:
    """Write the hull of all corners (n, 2) into ``out``; return its corner count, or 0 if the pieces do not tile it."""
    count = _hull(corners, order, tolerance, out)
    total = 0.0
    for piece in range(len(ends)):
        first = ends[piece - 1] if piece > 0 else 0
        area = 0.0
        for i in range(first + 1, ends[piece] - 1):
            area += _turn(corners, first, i, i + 1) / 2
        if area < 0:  # make all of them counter-clockwise
            i, j = first, ends[piece] - 1
            while i < j:
                for m in range(2):
                    kept = corners[i, m]
                    corners[i, m] = corners[j, m]
                    corners[j, m] = kept
                i, j = i + 1, j - 1
        total += abs(area)
    hull, around = 0.0, 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        ex, ey = out[j, 0] - out[i, 0], out[j, 1] - out[i, 1]
        around += np.hypot(ex, ey)
        hull += (
            (out[i, 0] - out[0, 0]) * (out[j, 1] - out[0, 1]) - (out[j, 0] - out[0, 0]) * (out[i, 1] - out[0, 1])
        ) / 2
    if abs(hull - total) > tolerance * around:
        return 0
    for one in range(len(ends)):
        for other in range(one + 1):
            if one == other and not _beyond(corners, ends, one, one, tolerance, True):
                return 0
            if one != other and not (
                _beyond(corners, ends, one, other, tolerance, False)
                or _beyond(corners, ends, other, one, tolerance, False)
            ):
                return 0
    return count


@compiled
@lean
def _turn(corners: Float, a: int, b: int, c: int) -> float:
    """Return twice the signed area of the triangle of corners a, b and c."""
    return float(
        (corners[b, 0] - corners[a, 0]) * (corners[c, 1] - corners[a, 1])
        - (corners[b, 1] - corners[a, 1]) * (corners[c, 0] - corners[a, 0])
    )


@compiled
@lean
def _hull(corners: Float, order: Int, tolerance: float, out: Float) -> int:
    """Write the hull of corners (n, 2), counter-clockwise, into ``out``; return its number of corners.

    ``order`` (n,) sorts the corners along x. Corners within ``tolerance`` of a side or of another corner are left out.
    """
    size = 0
    for side in range(2):
        floor = size + 1
        for step in range(len(order)):
            p = corners[order[step] if side == 0 else order[len(order) - 1 - step]]
            while size > floor:
                ax, ay = out[size - 2, 0], out[size - 2, 1]
                cx, cy = p[0] - ax, p[1] - ay
                turn = (out[size - 1, 0] - ax) * cy - (out[size - 1, 1] - ay) * cx
                if turn > tolerance * np.hypot(cx, cy):
                    break
                size -= 1
            if size == 0 or np.hypot(out[size - 1, 0] - p[0], out[size - 1, 1] - p[1]) > tolerance:
                out[size, 0], out[size, 1] = p[0], p[1]
                size += 1
        size -= 1
    return max(size, 0)


@compiled
@lean
def _beyond(corners: Float, ends: Int, one: int, other: int, tolerance: float, every: bool) -> bool:
    """Tell whether an edge of polygon ``one`` has all corners of polygon ``other`` on its outer side.

    With ``every``, tell instead whether every edge has all corners on its inner side; for ``one`` = ``other`` that
    means that the polygon is convex.
    """
    start = ends[one - 1] if one > 0 else 0
    first = ends[other - 1] if other > 0 else 0
    for i in range(start, ends[one]):
        j = i + 1 if i + 1 < ends[one] else start
        length = np.hypot(corners[j, 0] - corners[i, 0], corners[j, 1] - corners[i, 1])
        outside = length > tolerance
        for k in range(first, ends[other]):
            left = _turn(corners, i, j, k)
            if every and left < -tolerance * length:
                return False
            outside = outside and left <= tolerance * length
        if outside and not every:
            return True
    return every
