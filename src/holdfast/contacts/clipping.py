"""Clipping of opposing triangles of two surfaces against each other, within a gap and an angle (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, dot3, lean
from holdfast.contacts.facing_polygons import Piece
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Angles
from holdfast.geometry.polygon import keep_half_plane

MAX_CORNERS = 12  # two triangles share at most 6 corners, and each limit of the gap adds one
PIECES = 256  # largest number of pieces that one call of compiled code can write
AT_ONCE = 50_000  # number of pairs that are passed to one call of compiled code


def clip_faces(a: SearchMesh, b: SearchMesh, pairs: Int, *, gap: float, depth: float, angles: Angles) -> list[Piece]:
    """Return where faces of ``pairs`` (m, 2) face each other, up to ``gap`` apart or ``depth`` into each other [m]."""
    limits, pieces = np.array([gap, depth, *angles.cosine(np.array([False, True]))]), []
    corners, counts = np.zeros((PIECES, MAX_CORNERS, 3)), np.zeros(PIECES, dtype=np.int64)
    normals, heights, curved = np.zeros((PIECES, 3)), np.zeros((PIECES, 2)), np.zeros(PIECES, dtype=np.bool_)
    room = np.zeros((4, MAX_CORNERS, 3))
    start = 0
    while start < len(pairs):
        part = pairs[start : start + AT_ONCE]
        found, done = _clip_all(a, b, part, limits, room, corners, counts, normals, heights, curved)
        for k in range(found):
            outline, apart = corners[k, : counts[k]].copy(), (float(heights[k, 0]), float(heights[k, 1]))
            pieces.append(Piece((outline,), normals[k].copy(), apart, bool(curved[k])))
        start += done
    return pieces


@compiled
@lean
def plane_between(normal_a: Float, normal_b: Float, axes: Float) -> None:
    """Write to the rows of ``axes`` (3, 3) the mean normal of two faces, pointing from a to b, and two tangents."""
    normal, t1, t2 = axes[0], axes[1], axes[2]
    length = 0.0
    for k in range(3):
        normal[k] = normal_a[k] - normal_b[k]
        length += normal[k] * normal[k]
    seed = 0 if abs(normal[0]) < 0.9 * np.sqrt(length) else 1
    for k in range(3):
        normal[k] /= np.sqrt(length)
    for k in range(3):
        t1[k] = (1.0 if k == seed else 0.0) - normal[seed] * normal[k]
    length = np.sqrt(dot3(t1, t1))
    for k in range(3):
        t1[k] /= length
    t2[0] = normal[1] * t1[2] - normal[2] * t1[1]
    t2[1] = normal[2] * t1[0] - normal[0] * t1[2]
    t2[2] = normal[0] * t1[1] - normal[1] * t1[0]


@compiled
@lean
def _clip_pair(
    tri_a: Float,
    normal_a: Float,
    tri_b: Float,
    normal_b: Float,
    gap: float,
    depth: float,
    room: Float,
    out: Float,
    normal: Float,
    heights: Float,
) -> int:
    """Clip one pair of triangles, seen along their mean normal; return the number of corners, 0 if they do not meet.

    The corners, halfway between the triangles, are written to ``out`` (c, 3), the mean normal to ``normal`` (3,), and
    the least and the largest separation to ``heights`` (2,). ``room`` (4, MAX_CORNERS, 3) is scratch memory.
    """
    corners, kept, flat_b, axes = room[0], room[1], room[2], room[3]
    plane_between(normal_a, normal_b, axes)
    t1, t2 = axes[1], axes[2]
    for k in range(3):
        normal[k] = axes[0, k]
    for i in range(3):
        for m in range(2):
            corners[i, m] = 0.0
            flat_b[i, m] = 0.0
            for k in range(3):
                corners[i, m] += (tri_a[i, k] - tri_a[0, k]) * axes[m + 1, k]
                flat_b[i, m] += (tri_b[i, k] - tri_a[0, k]) * axes[m + 1, k]
    count = 3
    # b is seen from below along the normal, so its corners are in clockwise order
    for i in range(3):
        j = (i + 2) % 3
        ex = flat_b[j, 0] - flat_b[i, 0]
        ey = flat_b[j, 1] - flat_b[i, 1]
        count = keep_half_plane(corners, kept, count, -ey, ex, ey * flat_b[i, 0] - ex * flat_b[i, 1])
        if count < 3:
            return 0
    # heights of the two planes along the normal: ax x + ay y for a, and bx x + by y + level for b
    slope_a, slope_b = dot3(normal_a, normal), dot3(normal_b, normal)
    ax, ay = -dot3(normal_a, t1) / slope_a, -dot3(normal_a, t2) / slope_a
    bx, by = -dot3(normal_b, t1) / slope_b, -dot3(normal_b, t2) / slope_b
    level = 0.0
    for k in range(3):
        level += (tri_b[0, k] - tri_a[0, k]) * normal_b[k] / slope_b
    for sign, bound in ((-1.0, gap), (1.0, depth)):
        count = keep_half_plane(corners, kept, count, sign * (bx - ax), sign * (by - ay), sign * level + bound)
        if count < 3:
            return 0
    for i in range(count):
        x, y = corners[i, 0], corners[i, 1]
        middle = ((ax + bx) * x + (ay + by) * y + level) / 2
        apart = (bx - ax) * x + (by - ay) * y + level
        heights[0] = apart if i == 0 else min(heights[0], apart)
        heights[1] = apart if i == 0 else max(heights[1], apart)
        for k in range(3):
            out[i, k] = tri_a[0, k] + x * t1[k] + y * t2[k] + middle * normal[k]
    return count


@compiled
@lean
def _clip_all(
    a: SearchMesh,
    b: SearchMesh,
    pairs: Int,
    limits: Float,
    room: Float,
    out: Float,
    counts: Int,
    normals: Float,
    heights: Float,
    curved: Bool,
) -> tuple[int, int]:
    """Clip as many pairs as there is room for; return the number of pieces, and of pairs that were clipped.

    ``limits`` (4,) are gap, depth and the cosines of the angle for two flat faces and for pairs with a curved face.
    ``room`` is as in ``_clip_pair``.
    """
    gap, depth = limits[0], limits[1]
    found = 0
    for pair in range(len(pairs)):
        i, j = pairs[pair, 0], pairs[pair, 1]
        bent = a.curved[i] or b.curved[j]
        if dot3(a.normals[i], b.normals[j]) > -limits[3 if bent else 2]:
            continue
        if found == len(out):
            return found, pair
        curved[found] = bent
        counts[found] = _clip_pair(
            a.triangles[i],
            a.normals[i],
            b.triangles[j],
            b.normals[j],
            gap,
            depth,
            room,
            out[found],
            normals[found],
            heights[found],
        )
        if counts[found] >= 3:
            found += 1
    return found, len(pairs)
