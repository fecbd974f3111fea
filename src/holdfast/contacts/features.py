"""Contacts of vertices and edges: where a corner or an edge of one surface is nearest to the other (compiled).

A feature touches only where it is a local minimum of the distance along the contact normal: everything it is joined to
goes away from the other body, up to the angle tolerance. The normal is that of the face touched, or the cross product
of two edges. Where faces meet at a smooth angle, as on a tessellated curve, the contact may sit between them and takes
the mean of their normals; on a sharp edge or corner it would have no normal of its own, and none is invented.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compilable, compiled, dot3, lean
from holdfast.base.values import Value, seal
from holdfast.contacts.around import (
    Within,
    edge_rises,
    height_over,
    inset_of,
    lies_over,
    normal_at,
    slack_at,
    vertex_rises,
)
from holdfast.contacts.skin import Skin
from holdfast.contacts.tolerances import Angles
from holdfast.geometry.topology import FLAT, SMOOTH

NEAR_PARALLEL = 0.02  # sine below which two edges have no cross product to speak of
WIDEST = 1.001 * float(np.tan(SMOOTH / 2))  # how far beyond a face's edge a point touches, over its height, at most
ROUNDING = 1e-9  # of the size of the smaller body
ROW = 13  # numbers that stand for a feature: two ends (3 each), normal (3), two heights, inset, blended
ROOM = 512  # rows that one call of compiled code may find
AT_ONCE = 20_000  # pairs of faces that one call of compiled code is given


@dataclass(frozen=True, eq=False, repr=False)
class Features(Value):
    """Contacts along lines and at points, halfway between the bodies.

    ``ends`` (m, 2, 3) of a line, equal at a point; ``normals`` (m, 3) into b; ``heights`` (m, 2) separations at the
    ends [m]; ``inset`` (m,) how far inside the nearest sharp edge of what is touched they lie [m]; ``blended`` (m,)
    whether the normal is a mean of several faces'.
    """

    ends: Float
    normals: Float
    heights: Float
    inset: Float
    blended: Bool

    def __post_init__(self) -> None:
        seal(self)


def touching_features(
    a: Skin, b: Skin, pairs: Int, *, gap: float, depth: float, angles: Angles, size: float, strict: float
) -> tuple[Features, Features]:
    """Lines and points where edges and vertices touch, among ``pairs`` (m, 2) of faces whose boxes meet.

    ``size`` [m] is that of the smaller body; a sharp edge is stayed away from by ``strict`` [m].
    """
    sin_angle, sin_curved = np.sin(np.radians(angles)).tolist()
    within = Within(gap, depth, sin_angle, sin_curved, ROUNDING * size, strict)
    room, counts, scratch = np.empty((2, ROOM, ROW)), np.zeros(2, dtype=np.int64), np.empty((2, 3))
    lines: list[Float] = []
    points: list[Float] = []

    def search(look: Callable[[Int], int]) -> None:
        start = 0
        while start < len(pairs):
            counts[:] = 0
            start += look(pairs[start : start + AT_ONCE])
            lines.append(room[0, : counts[0]].copy())
            points.append(room[1, : counts[1]].copy())

    search(lambda part: _features_on_faces(a, b, part, False, within, room, counts, scratch))
    search(lambda part: _features_on_faces(b, a, part, True, within, room, counts, scratch))
    search(lambda part: _edges_on_edges(a, b, part, within, room[1], counts, scratch))
    return _features(lines), _features(points)


def _features(parts: list[Float]) -> Features:
    rows = np.concatenate([np.empty((0, ROW)), *parts])
    return Features(rows[:, :6].reshape(-1, 2, 3), rows[:, 6:9], rows[:, 9:11], rows[:, 11], rows[:, 12] > 0)


@compiled
@lean
def _comes_over(one: Skin, other: Skin, i: int, j: int, within: Within) -> bool:
    """Whether face i of ``one`` may have a corner or an edge that touches face j of ``other``: False is certain."""
    m, c = other.normals[j], other.triangles[j, 0]
    low, high = np.inf, -np.inf
    for n in range(3):
        p = one.triangles[i, n]
        h = (p[0] - c[0]) * m[0] + (p[1] - c[1]) * m[1] + (p[2] - c[2]) * m[2]
        low, high = min(low, h), max(high, h)
    if low > within.gap or high < -within.depth:
        return False
    reach = within.tiny + WIDEST * max(abs(low), abs(high))
    for k in range(3):
        out, c = other.outward[j, k], other.triangles[j, k]
        least = np.inf
        for n in range(3):
            p = one.triangles[i, n]
            least = min(least, out[0] * (p[0] - c[0]) + out[1] * (p[1] - c[1]) + out[2] * (p[2] - c[2]))
        if least > reach:
            return False
    return True


@compiled
@lean
def _features_on_faces(
    one: Skin, other: Skin, pairs: Int, flipped: bool, within: Within, room: Float, counts: Int, scratch: Float
) -> int:
    """Vertices and edges of ``one`` on faces of ``other``; ``flipped`` where ``one`` is the second body.

    Rows are written to ``room`` (2, n, ROW), of lines and of points, of which ``counts`` (2,) are in use. Returns how
    many pairs were looked at before one of them was full. ``scratch`` (2, 3) is memory.
    """
    lines, points = room[0], room[1]
    normal, middle = scratch[0], scratch[1]
    sign = 1.0 if flipped else -1.0
    for pair in range(len(pairs)):
        if max(counts[0], counts[1]) + 3 > len(points):
            return pair
        i, j = (pairs[pair, 1], pairs[pair, 0]) if flipped else (pairs[pair, 0], pairs[pair, 1])
        if not _comes_over(one, other, i, j, within):
            continue
        for k in range(3):
            if one.owns_vertex[i, k] and _vertex_on_face(
                one, other, i, k, j, within, sign, normal, middle, points[counts[1]]
            ):
                counts[1] += 1
            edge = one.of_face[i, k]
            sticks_out = one.owns_edge[i, k] and FLAT < one.bend[edge] < np.inf
            if sticks_out and _edge_on_face(one, other, edge, j, within, sign, normal, middle, lines[counts[0]]):
                counts[0] += 1
    return len(pairs)


@compilable
@lean
def _vertex_on_face(
    one: Skin, other: Skin, i: int, k: int, j: int, within: Within, sign: float, normal: Float, v: Float, row: Float
) -> bool:
    """Whether the k-th vertex of face i of ``one`` touches face j of ``other``; then ``row`` (ROW,) tells where."""
    for m in range(3):  # a copy: functions are compiled once more for arrays that are read-only
        v[m] = one.triangles[i, k, m]
    h = height_over(other, j, v)
    if not (-within.depth <= h <= within.gap and lies_over(other, j, v, h, within.tiny, within.strict)):
        return False
    blended = normal_at(other, j, v, h, within.tiny, normal)
    if not vertex_rises(one, one.faces[i, k], normal, within):
        return False
    for m in range(3):
        row[m] = row[3 + m] = v[m] - h / 2 * normal[m]
        row[6 + m] = sign * normal[m]
    row[9] = row[10] = h
    row[11] = inset_of(other, j, v)
    row[12] = blended
    return True


@compilable
@lean
def _edge_on_face(
    one: Skin, other: Skin, edge: int, j: int, within: Within, sign: float, normal: Float, middle: Float, row: Float
) -> bool:
    """Whether a part of an edge of ``one`` runs along face j of ``other``; then ``row`` (ROW,) tells which part."""
    p, q = one.vertices[one.edges[edge, 0]], one.vertices[one.edges[edge, 1]]
    hp, hq = height_over(other, j, p), height_over(other, j, q)
    length = np.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2)
    if abs(hq - hp) > (within.sin_angle + np.sin(SMOOTH / 2)) * length:
        return False
    low, high = _part_over(other, j, p, q, hp, hq, within)
    if (high - low) * length <= within.strict:
        return False
    t = (low + high) / 2
    for m in range(3):
        middle[m] = p[m] + t * (q[m] - p[m])
    blended = normal_at(other, j, middle, hp + t * (hq - hp), within.tiny, normal)
    slope = 0.0
    for m in range(3):
        slope += (q[m] - p[m]) / length * normal[m]
    round_ = other.curved[j] or (one.curved[one.sides[edge, 0]] and one.curved[one.sides[edge, 1]])
    if abs(slope) > (within.sin_curved if round_ else within.sin_angle) or not edge_rises(one, edge, normal, within):
        return False
    inset = inset_of(other, j, middle)
    if inset <= within.strict:  # it runs along a sharp edge
        return False
    for e in range(2):
        t = high if e else low
        h = hp + t * (hq - hp)
        for m in range(3):
            row[3 * e + m] = p[m] + t * (q[m] - p[m]) - h / 2 * normal[m]
        row[9 + e] = h
    for m in range(3):
        row[6 + m] = sign * normal[m]
    row[11] = inset
    row[12] = blended
    return True


@compilable
@lean
def _part_over(other: Skin, j: int, p: Float, q: Float, hp: float, hq: float, within: Within) -> tuple[float, float]:
    """From where to where, as shares of its length, a segment from p to q lies over face j; 1 to 0 where nowhere.

    ``hp`` and ``hq`` [m] are the heights of its ends. It is cut by -depth <= h <= gap and by the three sides of the
    face; each of these keeps the part where f(t) = f0 + t (f1 - f0) >= 0.
    """
    low, high = 0.0, 1.0
    for bound in range(5):
        if bound < 2:
            f0 = within.depth + hp if bound == 0 else within.gap - hp
            f1 = within.depth + hq if bound == 0 else within.gap - hq
        else:
            out = other.outward[j, bound - 2]
            c = other.triangles[j, bound - 2]
            nearest = min(abs(hp), abs(hq)) if hp * hq > 0 else 0.0
            slack = slack_at(other.bend[other.of_face[j, bound - 2]], nearest, within.tiny, -within.tiny)
            f0 = slack - (out[0] * (p[0] - c[0]) + out[1] * (p[1] - c[1]) + out[2] * (p[2] - c[2]))
            f1 = slack - (out[0] * (q[0] - c[0]) + out[1] * (q[1] - c[1]) + out[2] * (q[2] - c[2]))
        if f0 < 0 and f1 < 0:
            low, high = 1.0, 0.0
        elif f0 < 0:
            low = max(low, f0 / (f0 - f1))
        elif f1 < 0:
            high = min(high, f0 / (f0 - f1))
    return low, high


@compiled
@lean
def _edges_on_edges(a: Skin, b: Skin, pairs: Int, within: Within, points: Float, counts: Int, scratch: Float) -> int:
    """Crossings of edges that stick out, inside both, with the cross product as normal, added to ``points``.

    Returns how many pairs were looked at before ``points`` was full. ``scratch`` (2, 3) is memory.
    """
    strict = within.strict
    n, back = scratch[0], scratch[1]
    for pair in range(len(pairs)):
        if counts[1] + 9 > len(points):
            return pair
        i, j = pairs[pair, 0], pairs[pair, 1]
        for k in range(3):
            ea = a.of_face[i, k]
            if not (a.owns_edge[i, k] and FLAT < a.bend[ea] < np.inf):
                continue
            p, q = a.vertices[a.edges[ea, 0]], a.vertices[a.edges[ea, 1]]
            for n_b in range(3):
                eb = b.of_face[j, n_b]
                if not (b.owns_edge[j, n_b] and FLAT < b.bend[eb] < np.inf):
                    continue
                r, s = b.vertices[b.edges[eb, 0]], b.vertices[b.edges[eb, 1]]
                ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
                wx, wy, wz = s[0] - r[0], s[1] - r[1], s[2] - r[2]
                n[0] = uy * wz - uz * wy
                n[1] = uz * wx - ux * wz
                n[2] = ux * wy - uy * wx
                uu, ww = ux * ux + uy * uy + uz * uz, wx * wx + wy * wy + wz * wz
                cross = np.sqrt(dot3(n, n))
                if cross <= NEAR_PARALLEL * np.sqrt(uu * ww):
                    continue
                dx, dy, dz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
                h = (dx * n[0] + dy * n[1] + dz * n[2]) / cross
                if abs(h) > within.gap:  # depth is never more
                    continue
                ud, wd, uw = ux * dx + uy * dy + uz * dz, wx * dx + wy * dy + wz * dz, ux * wx + uy * wy + uz * wz
                determinant = uu * ww - uw * uw
                t = (ud * ww - wd * uw) / determinant
                o = (ud * uw - wd * uu) / determinant
                within_a, within_b = strict / np.sqrt(uu), strict / np.sqrt(ww)
                if not (within_a < t < 1 - within_a and within_b < o < 1 - within_b):
                    continue
                for m in range(3):
                    n[m] /= cross
                for sign in (1.0, -1.0):
                    if not -within.depth <= sign * h <= within.gap:
                        continue
                    for m in range(3):
                        back[m] = -sign * n[m]
                    if not edge_rises(a, ea, back, within):
                        continue
                    for m in range(3):
                        back[m] = sign * n[m]
                    if not edge_rises(b, eb, back, within):
                        continue
                    row = points[counts[1]]
                    for m in range(3):
                        row[m] = row[3 + m] = (p[m] + t * (q[m] - p[m]) + r[m] + o * (s[m] - r[m])) / 2
                        row[6 + m] = back[m]
                    row[9] = row[10] = sign * h
                    row[12] = 0.0
                    row[11] = min(min(t, 1 - t) * np.sqrt(uu), min(o, 1 - o) * np.sqrt(ww))
                    counts[1] += 1
                    break
    return len(pairs)
