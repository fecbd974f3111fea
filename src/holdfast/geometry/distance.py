"""Distance of points from a triangle surface, and whether they are inside it (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, dot3
from holdfast.geometry.surface import Surface

# Points are copied below: read-only ones, such as those of a surface, would have the loops compiled a second time.


def distance_to_surface(points: Float, surface: Surface) -> Float:
    """(n,) distance of points (n, 3) to the nearest triangle [m]."""
    return np.asarray(np.sqrt(_squared(np.array(points, order="C"), surface.vertices[surface.faces])))


def winding_number(points: Float, surface: Surface) -> Float:
    """(n,) how often the surface winds around points (n, 3): about 1 inside, 0 outside, also if it has small holes.

    The sum of the triangles' solid angles over 4π (van Oosterom and Strackee 1983; Jacobson et al. 2013).
    """
    return np.asarray(_winding(np.array(points, order="C"), surface.vertices[surface.faces]))


@compiled
def _winding(points: Float, triangles: Float) -> Float:
    total = np.zeros(len(points))
    for i in range(len(points)):
        p = points[i]
        for j in range(len(triangles)):
            a, b, c = triangles[j, 0] - p, triangles[j, 1] - p, triangles[j, 2] - p
            la, lb, lc = np.sqrt(dot3(a, a)), np.sqrt(dot3(b, b)), np.sqrt(dot3(c, c))
            triple = (
                a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
            )
            total[i] += 2 * np.arctan2(triple, la * lb * lc + dot3(a, b) * lc + dot3(b, c) * la + dot3(c, a) * lb)
    return total / (4 * np.pi)


@compiled
def nearest_of(points: Float, triangles: Float, pairs: Int) -> float:
    """The least squared distance among ``pairs`` (m, 2) of points (n, 3) and triangles (k, 3, 3)."""
    best = np.inf
    for k in range(len(pairs)):
        best = min(best, _apart(points[pairs[k, 0]], triangles[pairs[k, 1]]))
    return best


@compiled
def _squared(points: Float, triangles: Float) -> Float:
    best = np.full(len(points), np.inf)
    for j in range(len(triangles)):
        for i in range(len(points)):
            best[i] = min(best[i], _apart(points[i], triangles[j]))
    return best


@compiled
def _apart(point: Float, triangle: Float) -> float:
    """Squared distance of a point from a triangle: inside its prism to its plane, outside to its edges."""
    ux, uy, uz = triangle[1, 0] - triangle[0, 0], triangle[1, 1] - triangle[0, 1], triangle[1, 2] - triangle[0, 2]
    wx, wy, wz = triangle[2, 0] - triangle[0, 0], triangle[2, 1] - triangle[0, 1], triangle[2, 2] - triangle[0, 2]
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    area2 = nx * nx + ny * ny + nz * nz
    inside = area2 > 0
    best = np.inf
    for k in range(3):
        m = k + 1 if k < 2 else 0
        ex, ey, ez = (
            triangle[m, 0] - triangle[k, 0],
            triangle[m, 1] - triangle[k, 1],
            triangle[m, 2] - triangle[k, 2],
        )
        ax, ay, az = point[0] - triangle[k, 0], point[1] - triangle[k, 1], point[2] - triangle[k, 2]
        length2 = ex * ex + ey * ey + ez * ez
        t = min(max((ax * ex + ay * ey + az * ez) / length2, 0.0), 1.0) if length2 > 0 else 0.0
        dx, dy, dz = ax - t * ex, ay - t * ey, az - t * ez
        best = min(best, dx * dx + dy * dy + dz * dz)
        inside = inside and (ey * az - ez * ay) * nx + (ez * ax - ex * az) * ny + (ex * ay - ey * ax) * nz >= 0
    if inside:
        height = (point[0] - triangle[0, 0]) * nx + (point[1] - triangle[0, 1]) * ny + (point[2] - triangle[0, 2]) * nz
        best = min(best, height * height / area2)
    return best
