"""How far a body can be moved along a straight line before it meets another: exact for triangle surfaces (compiled).

Only a triangle of the moving surface that faces the way of the motion and a triangle of the other that faces against it
can meet. Seen along the motion both are triangles in a plane, the distance between them is linear over the part that
they share, and so is least at a corner of that part: corners on faces and edges on edges in one.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from holdfast.arrays import Bool, Float, Int, unit
from holdfast.compiled import compiled
from holdfast.contacts.clipping import keep_half_plane
from holdfast.contacts.skin import near_boxes
from holdfast.rigid import tangents
from holdfast.scene.body import Body
from holdfast.scene.surface import Surface

ALONG = 1e-6  # cosine below which a face runs along the motion: it slides past and meets nothing
ROUNDING = 1e-9  # of the size of the smaller surface


def first_hit(moving: Surface, still: Surface, direction: Float, *, slack: float = 0.0) -> float:
    """How far ``moving`` can go along ``direction`` (3,) before it meets ``still`` [m]; inf if it never does.

    Faces that slide along each other do not meet. ``slack`` [m]: what overlaps by less, seen along the motion, at the
    outlines of both surfaces passes; surfaces that lie into each other by no more than it count as apart, with a
    distance of 0 if they close in.
    """
    along = unit(np.asarray(direction, dtype=np.float64))
    frame = np.vstack([*tangents(along), along])
    size = min(float(np.linalg.norm(np.ptp(s.vertices, axis=0))) for s in (moving, still))
    tiny = max(slack, ROUNDING * size)
    front = moving.normals @ along > ALONG
    back = still.normals @ along < -ALONG
    a, b = _facing(moving, front, frame), _facing(still, back, frame)
    if not len(a) or not len(b):
        return np.inf
    b = b[np.argsort(b[:, :, 0].min(1), kind="stable")]
    flat = np.array([1.0, 1.0, 0.0])
    pairs = near_boxes(a.min(1) * flat, a.max(1) * flat, b.min(1) * flat, b.max(1) * flat, 0, 0.0)
    level, width, middle = _nearest(a, b, pairs, tiny)
    order = np.argsort(level, kind="stable")
    order = order[np.isfinite(level[order])]
    narrow = width[order] <= tiny
    if narrow.any():
        order = order[~(narrow & _at_outlines(middle[order], narrow, moving, front, still, back, frame, tiny))]
    return max(float(level[order[0]]), 0.0) if len(order) else np.inf


def clear_path(
    body: Body, others: Iterable[Body], direction: Float, *, distance: float = np.inf, slack: float = 0.0
) -> bool:
    """Whether ``body`` can be moved by ``distance`` [m] along ``direction`` without meeting any of ``others``."""
    surface = body.reduced_world
    return all(
        first_hit(surface, other.reduced_world, direction, slack=slack) >= distance
        for other in others
        if other.name != body.name
    )


def _facing(surface: Surface, which: Bool, frame: Float) -> Float:
    """(n, 3, 3) chosen triangles in the frame whose third axis is the motion."""
    return np.ascontiguousarray(surface.vertices[surface.faces[which]] @ frame.T)


@compiled
def _nearest(a: Float, b: Float, pairs: Int, tiny: float) -> tuple[Float, Float, Float]:
    """Of each pair of triangles: the least distance along the third axis, width and middle of the part they share.

    Infinite where they share none, or where b is behind a.
    """
    level = np.full(len(pairs), np.inf)
    width = np.zeros(len(pairs))
    middle = np.zeros((len(pairs), 2))
    corners, room = np.zeros((12, 2)), np.zeros((12, 2))
    plane = np.zeros((2, 3))
    for p in range(len(pairs)):
        s, t = a[pairs[p, 0]], b[pairs[p, 1]]
        count = 3
        for c in range(3):
            corners[c, 0], corners[c, 1] = s[c, 0], s[c, 1]
        turn = (t[1, 0] - t[0, 0]) * (t[2, 1] - t[0, 1]) - (t[1, 1] - t[0, 1]) * (t[2, 0] - t[0, 0])
        sign = 1.0 if turn > 0 else -1.0
        for c in range(3):
            d = c + 1 if c < 2 else 0
            x, y = -sign * (t[d, 1] - t[c, 1]), sign * (t[d, 0] - t[c, 0])
            count = keep_half_plane(corners, room, count, x, y, -x * t[c, 0] - y * t[c, 1])
        if count < 3:
            continue
        for side in range(2):
            q = s if side == 0 else t
            ux, uy, uz = q[1, 0] - q[0, 0], q[1, 1] - q[0, 1], q[1, 2] - q[0, 2]
            wx, wy, wz = q[2, 0] - q[0, 0], q[2, 1] - q[0, 1], q[2, 2] - q[0, 2]
            det = ux * wy - uy * wx
            plane[side, 0] = (uz * wy - uy * wz) / det
            plane[side, 1] = (ux * wz - uz * wx) / det
            plane[side, 2] = q[0, 2] - plane[side, 0] * q[0, 0] - plane[side, 1] * q[0, 1]
        low, high, area, rim = np.inf, -np.inf, 0.0, 0.0
        for c in range(count):
            d = c + 1 if c + 1 < count else 0
            x, y = corners[c, 0], corners[c, 1]
            h = (plane[1, 0] - plane[0, 0]) * x + (plane[1, 1] - plane[0, 1]) * y + plane[1, 2] - plane[0, 2]
            low, high = min(low, h), max(high, h)
            area += (x - corners[0, 0]) * (corners[d, 1] - corners[0, 1])
            area -= (y - corners[0, 1]) * (corners[d, 0] - corners[0, 0])
            rim += np.sqrt((corners[d, 0] - x) ** 2 + (corners[d, 1] - y) ** 2)
            middle[p, 0] += x / count
            middle[p, 1] += y / count
        if high < -tiny or rim == 0.0:
            continue
        level[p] = low
        width[p] = abs(area) / rim
    return level, width, middle


def _at_outlines(
    middle: Float, narrow: Bool, moving: Surface, front: Bool, still: Surface, back: Bool, frame: Float, reach: float
) -> Bool:
    """(n,) which of the narrow parts lie within ``reach`` of the outline of either surface, seen along the motion."""
    result = np.zeros(len(middle), dtype=bool)
    segments = np.vstack([_outline(moving, front, frame), _outline(still, back, frame)])
    result[narrow] = _near_segments(np.ascontiguousarray(middle[narrow]), segments, 2 * reach)
    return result


def _outline(surface: Surface, which: Bool, frame: Float) -> Float:
    """(n, 2, 2) edges between triangles that are ``which`` and others, in the plane across the motion."""
    sides = surface.topology.sides
    one, other = which[sides[:, 0]], np.where(sides[:, 1] >= 0, which[sides[:, 1]], False)
    return np.ascontiguousarray((surface.vertices @ frame[:2].T)[surface.topology.edges[one != other]])


@compiled
def _near_segments(points: Float, segments: Float, reach: float) -> Bool:
    result = np.zeros(len(points), dtype=np.bool_)
    for i in range(len(points)):
        for s in range(len(segments)):
            ux, uy = segments[s, 1, 0] - segments[s, 0, 0], segments[s, 1, 1] - segments[s, 0, 1]
            ax, ay = points[i, 0] - segments[s, 0, 0], points[i, 1] - segments[s, 0, 1]
            length2 = ux * ux + uy * uy
            t = min(max((ax * ux + ay * uy) / length2, 0.0), 1.0) if length2 > 0 else 0.0
            if (ax - t * ux) ** 2 + (ay - t * uy) ** 2 <= reach * reach:
                result[i] = True
                break
    return result
