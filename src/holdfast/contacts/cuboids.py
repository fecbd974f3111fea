"""Cuboids that lie flat on each other, or certainly do not touch: all pairs of a scene at once (compiled).

Most bodies of pallets, shelves and walls are boxes, and most pairs of near boxes are one of these two. Their contact
is then known in closed form, without a look at triangles, edges and corners:

- ``APART``: along the normal of one face they are more than the gap apart; or their edges are parallel and they
  overlap along one axis at most, like boxes that meet at an edge or at a corner. A face, an edge or a corner would then
  have to touch at a sharp rim, where nothing touches.
- ``FLUSH``: the plane of a face of each separates them, to within rounding. The contact is what the two rectangles
  share. All other faces stand upright on the plane or lie beyond the gap, which is where patches answer for all edges
  and corners (flush.py).

All others are left to the search through triangles (``detect.find_patches``), which finds the same for these two.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, dot3
from holdfast.contacts.clipping import plane_between
from holdfast.contacts.flush import ROUNDING, UPRIGHT, WIDE
from holdfast.contacts.interface import Patch
from holdfast.geometry.cuboid import Cuboid
from holdfast.geometry.polygon import keep_half_plane

OTHER, APART, FLUSH = 0, 1, 2
MOST = 8  # corners that two rectangles can share
SAME = 1e-3  # of the negligible width: nearer corners are one


class Near(NamedTuple):
    """Two cuboids whose boxes come near each other; all lengths in metres.

    Surfaces touch up to ``gap`` apart; ``size`` is that of the smaller body, and narrower contacts than ``negligible``
    are rounding.
    """

    a: Cuboid
    b: Cuboid
    gap: float
    size: float
    negligible: float


def patches_of(pairs: Sequence[Near]) -> list[tuple[Patch, ...] | None]:
    """Return the contacts of each pair, with normals into the second; None where triangles have to be looked at."""
    if not pairs:
        return []
    numbers: dict[int, int] = {}
    distinct = [body for near in pairs for body in (near.a, near.b) if numbers.setdefault(id(body), len(numbers)) >= 0]
    known = list({id(body): body for body in distinct}.values())
    kinds = np.zeros((2, len(pairs)), dtype=np.int64)
    corners, planes = np.empty((len(pairs), MOST, 3)), np.empty((len(pairs), 5))
    _meet_all(
        np.array([np.vstack([body.centre, body.axes, body.half]) for body in known]),
        np.array([(numbers[id(near.a)], numbers[id(near.b)]) for near in pairs]),
        np.array([near[2:] for near in pairs]),
        kinds,
        corners,
        planes,
    )
    found: list[tuple[Patch, ...] | None] = []
    for k, (kind, count) in enumerate(kinds.T.tolist()):
        if kind == FLUSH:
            low, high = planes[k, 3:].tolist()
            found.append((Patch(corners[k, :count].copy(), planes[k, :3].copy(), (), (low, high)),))
        else:
            found.append(() if kind == APART else None)
    return found


@compiled
def _meet_all(bodies: Float, pairs: Int, limits: Float, kinds: Int, corners: Float, planes: Float) -> None:
    """Tell how ``pairs`` (m, 2) of ``bodies`` (n, 5, 3) meet; rows of a body are centre, three axes and half lengths.

    ``limits`` (m, 3) are gap, size and negligible width. ``kinds`` (2, m) takes OTHER, APART or FLUSH and the number of
    corners, which ``corners`` (m, MOST, 3) takes; ``planes`` (m, 5) takes normal, least and largest separation.
    """
    room, axes = np.zeros((2, 2 * MOST, 2)), np.zeros((3, 3))
    for pair in range(len(pairs)):
        a, b = bodies[pairs[pair, 0]], bodies[pairs[pair, 1]]
        gap, size, negligible = limits[pair, 0], limits[pair, 1], limits[pair, 2]
        kind, k, m = _kind(a, b, gap, size, negligible)
        if kind == FLUSH:
            count = _shared(a, b, k, m, SAME * negligible, axes, room, corners[pair], planes[pair])
            wide = count > 2 and _width(room[0], count) > negligible
            kind = FLUSH if wide else OTHER
            kinds[1, pair] = count
        kinds[0, pair] = kind


@compiled
def _kind(a: Float, b: Float, gap: float, size: float, negligible: float) -> tuple[int, int, int]:
    """How two bodies meet; where they may be flush, along which axis of a and of b."""
    tiny = ROUNDING * size
    beside, flush, along = 0, -1, -1
    off, longest = 0.0, 0.0  # the largest cosine between axes that are not parallel; the longest half length
    for k in range(3):
        nearest, leaning = 0, 0.0  # the axis of b that is nearest to this one of a, and the cosine with the others
        apart, reach_a, back, reach_b = 0.0, a[4, k], 0.0, b[4, k]
        for m in range(3):
            slope = abs(dot3(a[1 + k], b[1 + m]))
            leaning = max(leaning, min(slope, abs(dot3(a[1 + k], b[1 + nearest])))) if m > 0 else 0.0
            if slope > abs(dot3(a[1 + k], b[1 + nearest])):
                nearest = m
            reach_a += slope * b[4, m]  # of both bodies along an axis of a
            reach_b += abs(dot3(b[1 + k], a[1 + m])) * a[4, m]  # and along one of b
            apart += (b[0, m] - a[0, m]) * a[1 + k, m]
            back += (b[0, m] - a[0, m]) * b[1 + k, m]
        overlap = reach_a - abs(apart)
        if overlap < -gap - tiny or reach_b - abs(back) < -gap - tiny:
            return APART, 0, 0
        if overlap <= negligible / 4:
            beside += 1
        if leaning <= UPRIGHT and abs(overlap) <= tiny and min(a[4, k], b[4, nearest]) * 2 > gap + tiny:
            flush, along = k, nearest
        off, longest = max(off, leaning), max(longest, a[4, k], b[4, k])
    if beside > 1 and off <= UPRIGHT and off * longest < negligible / 16:
        return APART, 0, 0
    if beside == 1 and flush >= 0 and gap >= WIDE * size:
        return FLUSH, flush, along
    return OTHER, 0, 0


@compiled
def _shared(
    a: Float, b: Float, k: int, m: int, same: float, axes: Float, room: Float, corners: Float, plane: Float
) -> int:
    """What the face of a along its k-th axis and that of b along its m-th share; returns the number of corners.

    They are written to ``room[0]`` in the plane's frame, relative to the centre of a, and to ``corners`` in the world,
    where they begin at the first one along the plane's first tangent.
    """
    flat, kept = room[0], room[1]
    normal_a, normal_b, arm = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        arm[i] = b[0, i] - a[0, i]
    side = 1.0 if dot3(a[1 + k], arm) > 0 else -1.0
    other = -1.0 if dot3(b[1 + m], arm) > 0 else 1.0
    for i in range(3):
        normal_a[i], normal_b[i] = side * a[1 + k, i], other * b[1 + m, i]
    plane_between(normal_a, normal_b, axes)
    one, two = (k + 1) % 3, (k + 2) % 3
    for corner in range(4):  # counter-clockwise seen from outside where the side is +1
        x = a[4, one] if corner == 0 or corner == 3 else -a[4, one]
        y = side * (a[4, two] if corner < 2 else -a[4, two])
        for t in range(2):
            flat[corner, t] = x * dot3(a[1 + one], axes[1 + t]) + y * dot3(a[1 + two], axes[1 + t])
    count = 4
    for edge in range(1, 3):
        axis = (m + edge) % 3
        u, v = dot3(b[1 + axis], axes[1]), dot3(b[1 + axis], axes[2])
        at, half = dot3(b[1 + axis], arm), b[4, axis]
        count = keep_half_plane(flat, kept, count, u, v, half - at)
        count = keep_half_plane(flat, kept, count, -u, -v, half + at)
    count = _tidied(flat, kept, count, same)
    _lifted(a, b, k, m, side, axes, flat, count, corners, plane)
    return count


@compiled
def _tidied(flat: Float, kept: Float, count: int, same: float) -> int:
    """Drop corners within ``same`` of the next one, or of the line through their neighbours, and begin at the first."""
    for pass_ in range(2):
        n = 0
        for i in range(count):
            before, after = (i if pass_ == 0 or i > 0 else count) - 1, i + 1 if i + 1 < count else 0
            if pass_ == 0:
                keep = np.hypot(flat[after, 0] - flat[i, 0], flat[after, 1] - flat[i, 1]) > same
            else:
                cx, cy = flat[after, 0] - flat[before, 0], flat[after, 1] - flat[before, 1]
                turn = cx * (flat[i, 1] - flat[before, 1]) - cy * (flat[i, 0] - flat[before, 0])
                keep = abs(turn) > same * np.hypot(cx, cy)
            if keep:
                kept[n, 0], kept[n, 1] = flat[i, 0], flat[i, 1]
                n += 1
        count = n
        for i in range(count):
            flat[i, 0], flat[i, 1] = kept[i, 0], kept[i, 1]
    first = 0
    for i in range(1, count):
        ahead = flat[first, 0] - flat[i, 0]
        if ahead > same or (ahead >= -same and flat[i, 1] < flat[first, 1]):
            first = i
    for i in range(count):
        j = (first + i) % count
        kept[i, 0], kept[i, 1] = flat[j, 0], flat[j, 1]
    for i in range(count):
        flat[i, 0], flat[i, 1] = kept[i, 0], kept[i, 1]
    return count


@compiled
def _lifted(
    a: Float,
    b: Float,
    k: int,
    m: int,
    side: float,
    axes: Float,
    flat: Float,
    count: int,
    corners: Float,
    plane: Float,
) -> None:
    """Write the corners halfway between the two faces, the normal and the separation of the faces."""
    level_a = side * a[4, k] * dot3(a[1 + k], axes[0])
    level_b = -b[4, m] * abs(dot3(b[1 + m], axes[0]))
    for i in range(3):
        level_b += (b[0, i] - a[0, i]) * axes[0, i]
        plane[i] = axes[0, i]
    plane[3] = plane[4] = level_b - level_a
    for i in range(count):
        for j in range(3):
            height = (level_a + level_b) / 2 * axes[0, j]
            corners[i, j] = a[0, j] + flat[i, 0] * axes[1, j] + flat[i, 1] * axes[2, j] + height


@compiled
def _width(ring: Float, count: int) -> float:
    """Twice the area over the perimeter of a convex polygon of the first corners of ``ring`` (n, 2)."""
    twice, around = 0.0, 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        twice += ring[i, 0] * ring[j, 1] - ring[j, 0] * ring[i, 1]
        around += np.hypot(ring[j, 0] - ring[i, 0], ring[j, 1] - ring[i, 1])
    return twice / around
