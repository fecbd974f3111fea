"""Opposing triangles of two surfaces, clipped against each other within a gap and an angle (compiled)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.arrays import Float, Int
from holdfast.compiled import compiled

MAX_CORNERS = 12  # triangle against triangle gives at most 6, each bound of the gap adds one


@dataclass(frozen=True)
class Pieces:
    """Convex pieces: ``corners`` (m, MAX_CORNERS, 3), of which ``counts`` (m,) are used, and ``normals`` (m, 3)."""

    corners: Float
    counts: Int
    normals: Float

    def polygon(self, index: int) -> Float:
        """The corners (k, 3) of one piece."""
        return np.asarray(self.corners[index, : self.counts[index]])


def clip_surfaces(
    triangles_a: Float, normals_a: Float, triangles_b: Float, normals_b: Float, *, gap: float, cos_angle: float
) -> Pieces:
    """Where two surfaces face each other: triangles (n, 3, 3) with unit normals (n, 3), gap [m], cosine of the angle.

    Pieces lie halfway between the two surfaces; their normals point from a into b.
    """
    low = np.maximum(triangles_a.min((0, 1)), triangles_b.min((0, 1))) - gap
    high = np.minimum(triangles_a.max((0, 1)), triangles_b.max((0, 1))) + gap
    near_a = _within(triangles_a, low, high)
    near_b = _within(triangles_b, low, high)
    if not near_a.any() or not near_b.any():
        empty = np.empty((0, 3))
        return Pieces(np.empty((0, MAX_CORNERS, 3)), np.empty(0, dtype=np.int64), empty)
    tris_a, tris_b = triangles_a[near_a], triangles_b[near_b]
    axis = int(np.argmax(high - low))
    order = np.argsort(tris_b[:, :, axis].min(1))
    tris_b = np.ascontiguousarray(tris_b[order])
    corners, counts, normals = _clip_all(
        np.ascontiguousarray(tris_a), normals_a[near_a], tris_b, normals_b[near_b][order], axis, gap, cos_angle
    )
    return Pieces(corners, counts, normals)


def _within(triangles: Float, low: Float, high: Float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    result: np.ndarray[tuple[int], np.dtype[np.bool_]]
    result = ((triangles.max(1) >= low) & (triangles.min(1) <= high)).all(1)
    return result


@compiled
def _half_plane(corners: Float, heights: Float, count: int, a: float, b: float, c: float) -> int:
    """Keep the part of a polygon where a x + b y + c >= 0 (Sutherland-Hodgman), heights interpolated along."""
    kept = np.empty_like(corners)
    kept_heights = np.empty_like(heights)
    n = 0
    for i in range(count):
        j = (i + 1) % count
        di = a * corners[i, 0] + b * corners[i, 1] + c
        dj = a * corners[j, 0] + b * corners[j, 1] + c
        if di >= 0:
            kept[n] = corners[i]
            kept_heights[n] = heights[i]
            n += 1
        if (di > 0 and dj < 0) or (di < 0 and dj > 0):
            t = di / (di - dj)
            kept[n] = corners[i] + t * (corners[j] - corners[i])
            kept_heights[n] = heights[i] + t * (heights[j] - heights[i])
            n += 1
    corners[:n] = kept[:n]
    heights[:n] = kept_heights[:n]
    return n


@compiled
def _clip_pair(
    tri_a: Float, normal_a: Float, tri_b: Float, normal_b: Float, gap: float, corners: Float, heights: Float
) -> tuple[int, Float, Float, Float]:
    """Clip one pair in the plane halfway between them; returns corner count, normal and tangents.

    ``corners`` (c, 2) are coordinates along t1, t2 from the first corner of a, ``heights`` (c, 2) the two planes'
    heights along the normal.
    """
    normal = normal_a - normal_b
    normal = normal / np.sqrt((normal * normal).sum())
    t1 = np.zeros(3)
    k = 0 if abs(normal[0]) < 0.9 else 1
    t1[k] = 1.0
    t1 = t1 - normal[k] * normal
    t1 = t1 / np.sqrt((t1 * t1).sum())
    t2 = np.cross(normal, t1)
    origin = tri_a[0]
    slope_a = normal_a / (normal_a * normal).sum()
    slope_b = normal_b / (normal_b * normal).sum()
    offset_b = ((tri_b[0] - origin) * slope_b).sum()
    flat_b = np.empty((3, 2))
    for i in range(3):
        d = tri_a[i] - origin
        corners[i, 0] = (d * t1).sum()
        corners[i, 1] = (d * t2).sum()
        e = tri_b[i] - origin
        flat_b[i, 0] = (e * t1).sum()
        flat_b[i, 1] = (e * t2).sum()
    count = 3
    # b is seen from below along the normal, so its corners run clockwise there
    for i in range(3):
        j = (i + 2) % 3
        ex = flat_b[j, 0] - flat_b[i, 0]
        ey = flat_b[j, 1] - flat_b[i, 1]
        count = _half_plane(corners, heights, count, -ey, ex, ey * flat_b[i, 0] - ex * flat_b[i, 1])
        if count < 3:
            return 0, normal, t1, t2
    # gap(x, y) = height of b's plane - height of a's plane, both linear
    ax, ay = -(slope_a * t1).sum(), -(slope_a * t2).sum()
    bx, by = -(slope_b * t1).sum(), -(slope_b * t2).sum()
    gx, gy = bx - ax, by - ay
    for sign in (-1.0, 1.0):
        count = _half_plane(corners, heights, count, sign * gx, sign * gy, sign * offset_b + gap)
        if count < 3:
            return 0, normal, t1, t2
    for i in range(count):
        heights[i, 0] = ax * corners[i, 0] + ay * corners[i, 1]
        heights[i, 1] = bx * corners[i, 0] + by * corners[i, 1] + offset_b
    return count, normal, t1, t2


@compiled
def _clip_all(
    tris_a: Float, normals_a: Float, tris_b: Float, normals_b: Float, axis: int, gap: float, cos_angle: float
) -> tuple[Float, Int, Float]:
    """All pairs whose boxes meet, with b sorted along ``axis`` so that a window of it is enough for each a."""
    capacity = 64
    out = np.zeros((capacity, MAX_CORNERS, 3))
    counts = np.empty(capacity, dtype=np.int64)
    normals = np.empty((capacity, 3))
    found = 0
    nb = len(tris_b)
    low_b = np.empty((nb, 3))
    high_b = np.empty((nb, 3))
    for j in range(nb):
        for k in range(3):
            low_b[j, k] = min(tris_b[j, 0, k], tris_b[j, 1, k], tris_b[j, 2, k]) - gap
            high_b[j, k] = max(tris_b[j, 0, k], tris_b[j, 1, k], tris_b[j, 2, k]) + gap
    widest = (high_b[:, axis] - low_b[:, axis]).max()
    starts = low_b[:, axis].copy()
    corners = np.empty((MAX_CORNERS, 2))
    heights = np.zeros((MAX_CORNERS, 2))
    low = np.empty(3)
    high = np.empty(3)
    for i in range(len(tris_a)):
        for k in range(3):
            low[k] = min(tris_a[i, 0, k], tris_a[i, 1, k], tris_a[i, 2, k])
            high[k] = max(tris_a[i, 0, k], tris_a[i, 1, k], tris_a[i, 2, k])
        first = np.searchsorted(starts, low[axis] - widest)
        for j in range(first, nb):
            if starts[j] > high[axis]:
                break
            if (
                low_b[j, 0] > high[0]
                or low_b[j, 1] > high[1]
                or low_b[j, 2] > high[2]
                or high_b[j, 0] < low[0]
                or high_b[j, 1] < low[1]
                or high_b[j, 2] < low[2]
            ):
                continue
            if (normals_a[i] * normals_b[j]).sum() > -cos_angle:
                continue
            count, normal, t1, t2 = _clip_pair(tris_a[i], normals_a[i], tris_b[j], normals_b[j], gap, corners, heights)
            if count < 3:
                continue
            if found == capacity:
                capacity *= 2
                grown = np.zeros((capacity, MAX_CORNERS, 3))
                grown[:found] = out
                out = grown
                grown_counts = np.empty(capacity, dtype=np.int64)
                grown_counts[:found] = counts
                counts = grown_counts
                grown_normals = np.empty((capacity, 3))
                grown_normals[:found] = normals
                normals = grown_normals
            for c in range(count):
                middle = (heights[c, 0] + heights[c, 1]) / 2
                out[found, c] = tris_a[i, 0] + corners[c, 0] * t1 + corners[c, 1] * t2 + middle * normal
            counts[found] = count
            normals[found] = normal
            found += 1
    return out[:found], counts[:found], normals[:found]
