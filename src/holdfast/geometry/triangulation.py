"""An incremental Delaunay triangulation (Bowyer and Watson) within a given convex hull."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.geometry.hull import twice_area

FLAT = 1e-10  # twice the area below which a triangle counts as degenerate, for points in a unit square
ROUND = 1e-9  # a point is inside a circumcircle if the in-circle determinant exceeds this


def fan(corners: Int) -> Int:
    """Return the triangles (k - 2, 3) of a convex polygon with ``corners`` (k,), as a fan about the first corner."""
    return np.column_stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]])


@compiled
@lean
def _least_share(points: Float, triangle: Int, k: int) -> float:
    """Return the smallest barycentric coordinate of point k."""
    a, b, c = triangle
    whole = twice_area(points, a, b, c)
    return float(min(twice_area(points, k, b, c), twice_area(points, a, k, c), twice_area(points, a, b, k)) / whole)


@compiled
@lean
def _within_circle(points: Float, triangle: Int, k: int) -> bool:
    total = 0.0
    x, y = points[k]
    for i in range(3):
        a, b, c = triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]
        bx, by, cx, cy = points[b, 0] - x, points[b, 1] - y, points[c, 0] - x, points[c, 1] - y
        total += ((points[a, 0] - x) ** 2 + (points[a, 1] - y) ** 2) * (bx * cy - by * cx)
    return total > ROUND


@compiled
def inserted(points: Float, triangles: Int, k: int) -> Int:
    """Insert point k and return the triangles (t, 3), counter-clockwise; unchanged if the point is already a corner."""
    count = len(triangles)
    holds = np.zeros(count, dtype=np.bool_)
    bad = np.zeros(count, dtype=np.bool_)
    best, nearest = -np.inf, 0
    for t in range(count):
        share = _least_share(points, triangles[t], k)
        if share > best:
            best, nearest = share, t
        holds[t] = share > -1e-9
        bad[t] = holds[t] or _within_circle(points, triangles[t], k)
        for i in range(3):
            a = triangles[t, i]
            if max(abs(points[a, 0] - points[k, 0]), abs(points[a, 1] - points[k, 1])) < 1e-9:
                return triangles
    holds[nearest] = True
    for attempt in range(2):
        if attempt == 1:
            bad = holds
        kept = 0
        for t in range(count):
            kept += not bad[t]
        # each removed triangle is replaced by at most three
        fresh = np.empty((3 * count - 2 * kept, 3), dtype=np.int64)
        made, before, after, valid = 0, 0.0, 0.0, True
        for t in range(count):
            if not bad[t]:
                for i in range(3):
                    fresh[made, i] = triangles[t, i]
                made += 1
        for t in range(count):
            if not bad[t]:
                continue
            before += twice_area(points, triangles[t, 0], triangles[t, 1], triangles[t, 2])
            for i in range(3):
                a, b = triangles[t, i], triangles[t, (i + 1) % 3]
                shared = False
                for u in range(count):
                    for j in range(3):
                        if bad[u] and triangles[u, j] == b and triangles[u, (j + 1) % 3] == a:
                            shared = True
                if shared:
                    continue
                area = twice_area(points, a, b, k)
                if area > FLAT:
                    fresh[made, 0], fresh[made, 1], fresh[made, 2] = a, b, k
                    made += 1
                    after += area
                elif area < -FLAT:
                    valid = False
        if valid and made > kept and abs(after - before) <= 1e-6 * before:
            return fresh[:made]
    return triangles


@compiled
def located(points: Float, triangles: Int, asked: Int) -> tuple[Int, Float]:
    """Return the triangle (a,) of each of the points ``asked`` (a,), and barycentric coordinates (a, 3), all >= 0."""
    where = np.zeros(len(asked), dtype=np.int64)
    shares = np.zeros((len(asked), 3))
    for n in range(len(asked)):
        best, k = -np.inf, asked[n]
        for t in range(len(triangles)):
            share = _least_share(points, triangles[t], k)
            if share > best:
                best = share
                where[n] = t
                if share >= 0:
                    break
        a, b, c = triangles[where[n]]
        shares[n, 0] = max(twice_area(points, k, b, c), 0.0)
        shares[n, 1] = max(twice_area(points, a, k, c), 0.0)
        shares[n, 2] = max(twice_area(points, a, b, k), 0.0)
        total = shares[n, 0] + shares[n, 1] + shares[n, 2]
        for i in range(3):
            shares[n, i] /= total
    return where, shares
