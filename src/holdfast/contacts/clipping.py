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
def _dot(a: Float, b: Float) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def keep_half_plane(corners: Float, kept: Float, count: int, a: float, b: float, c: float) -> int:
    """Keep the part of a polygon where a x + b y + c >= 0 (Sutherland-Hodgman); ``kept`` is room to work in."""
    n = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        di = a * corners[i, 0] + b * corners[i, 1] + c
        dj = a * corners[j, 0] + b * corners[j, 1] + c
        if di >= 0.0:
            kept[n, 0] = corners[i, 0]
            kept[n, 1] = corners[i, 1]
            n += 1
        if (di > 0.0 and dj < 0.0) or (di < 0.0 and dj > 0.0):
            t = di / (di - dj)
            kept[n, 0] = corners[i, 0] + t * (corners[j, 0] - corners[i, 0])
            kept[n, 1] = corners[i, 1] + t * (corners[j, 1] - corners[i, 1])
            n += 1
    for i in range(n):
        corners[i, 0] = kept[i, 0]
        corners[i, 1] = kept[i, 1]
    return n


@compiled
def _clip_pair(
    tri_a: Float, normal_a: Float, tri_b: Float, normal_b: Float, gap: float, room: Float, out: Float, normal: Float
) -> int:
    """Clip one pair in the plane halfway between them: corners to ``out`` (c, 3), direction to ``normal`` (3,).

    ``room`` (4, MAX_CORNERS, 3) is memory to work in. Returns the number of corners, 0 where they do not meet.
    """
    corners, kept, flat_b, axes = room[0], room[1], room[2], room[3]
    t1, t2 = axes[0], axes[1]
    length = 0.0
    for k in range(3):
        normal[k] = normal_a[k] - normal_b[k]
        length += normal[k] * normal[k]
    seed = 0 if abs(normal[0]) < 0.9 * np.sqrt(length) else 1
    for k in range(3):
        normal[k] /= np.sqrt(length)
    for k in range(3):
        t1[k] = (1.0 if k == seed else 0.0) - normal[seed] * normal[k]
    length = np.sqrt(_dot(t1, t1))
    for k in range(3):
        t1[k] /= length
    t2[0] = normal[1] * t1[2] - normal[2] * t1[1]
    t2[1] = normal[2] * t1[0] - normal[0] * t1[2]
    t2[2] = normal[0] * t1[1] - normal[1] * t1[0]
    for i in range(3):
        for m in range(2):
            corners[i, m] = 0.0
            flat_b[i, m] = 0.0
            for k in range(3):
                corners[i, m] += (tri_a[i, k] - tri_a[0, k]) * axes[m, k]
                flat_b[i, m] += (tri_b[i, k] - tri_a[0, k]) * axes[m, k]
    count = 3
    # b is seen from below along the normal, so its corners run clockwise there
    for i in range(3):
        j = (i + 2) % 3
        ex = flat_b[j, 0] - flat_b[i, 0]
        ey = flat_b[j, 1] - flat_b[i, 1]
        count = keep_half_plane(corners, kept, count, -ey, ex, ey * flat_b[i, 0] - ex * flat_b[i, 1])
        if count < 3:
            return 0
    # heights of the two planes along the normal, linear in the coordinates: a: ax x + ay y, b: bx x + by y + level
    slope_a, slope_b = _dot(normal_a, normal), _dot(normal_b, normal)
    ax, ay = -_dot(normal_a, t1) / slope_a, -_dot(normal_a, t2) / slope_a
    bx, by = -_dot(normal_b, t1) / slope_b, -_dot(normal_b, t2) / slope_b
    level = 0.0
    for k in range(3):
        level += (tri_b[0, k] - tri_a[0, k]) * normal_b[k] / slope_b
    for sign in (-1.0, 1.0):
        count = keep_half_plane(corners, kept, count, sign * (bx - ax), sign * (by - ay), sign * level + gap)
        if count < 3:
            return 0
    for i in range(count):
        x, y = corners[i, 0], corners[i, 1]
        middle = ((ax + bx) * x + (ay + by) * y + level) / 2
        for k in range(3):
            out[i, k] = tri_a[0, k] + x * t1[k] + y * t2[k] + middle * normal[k]
    return count


@compiled
def _box(triangle: Float, low: Float, high: Float, margin: float) -> None:
    for k in range(3):
        low[k] = min(triangle[0, k], triangle[1, k], triangle[2, k]) - margin
        high[k] = max(triangle[0, k], triangle[1, k], triangle[2, k]) + margin


@compiled
def _clip_all(
    tris_a: Float, normals_a: Float, tris_b: Float, normals_b: Float, axis: int, gap: float, cos_angle: float
) -> tuple[Float, Int, Float]:
    """All pairs whose boxes meet, with b sorted along ``axis`` so that a window of it is enough for each a."""
    capacity = 64
    out = np.zeros((capacity, MAX_CORNERS, 3))
    counts = np.zeros(capacity, dtype=np.int64)
    normals = np.zeros((capacity, 3))
    found = 0
    nb = len(tris_b)
    low_b = np.empty((nb, 3))
    high_b = np.empty((nb, 3))
    widest = 0.0
    for j in range(nb):
        _box(tris_b[j], low_b[j], high_b[j], gap)
        widest = max(widest, high_b[j, axis] - low_b[j, axis])
    starts = low_b[:, axis].copy()
    room = np.zeros((4, MAX_CORNERS, 3))
    low = np.empty(3)
    high = np.empty(3)
    for i in range(len(tris_a)):
        _box(tris_a[i], low, high, 0.0)
        for j in range(np.searchsorted(starts, low[axis] - widest), nb):
            if starts[j] > high[axis]:
                break
            apart = False
            for k in range(3):
                apart = apart or low_b[j, k] > high[k] or high_b[j, k] < low[k]
            if apart or _dot(normals_a[i], normals_b[j]) > -cos_angle:
                continue
            if found == capacity:
                out = np.concatenate((out, np.zeros((capacity, MAX_CORNERS, 3))))
                counts = np.concatenate((counts, np.zeros(capacity, dtype=np.int64)))
                normals = np.concatenate((normals, np.zeros((capacity, 3))))
                capacity *= 2
            counts[found] = _clip_pair(
                tris_a[i], normals_a[i], tris_b[j], normals_b[j], gap, room, out[found], normals[found]
            )
            if counts[found] >= 3:
                found += 1
    return out[:found], counts[:found], normals[:found]
