"""Distance of points from a triangle surface, and whether they are inside it (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled
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
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for j in range(len(triangles)):
            a0, a1, a2 = triangles[j, 0, 0] - x, triangles[j, 0, 1] - y, triangles[j, 0, 2] - z
            b0, b1, b2 = triangles[j, 1, 0] - x, triangles[j, 1, 1] - y, triangles[j, 1, 2] - z
            c0, c1, c2 = triangles[j, 2, 0] - x, triangles[j, 2, 1] - y, triangles[j, 2, 2] - z
            la = np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
            lb = np.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
            lc = np.sqrt(c0 * c0 + c1 * c1 + c2 * c2)
            triple = a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)
            ab, bc, ca = a0 * b0 + a1 * b1 + a2 * b2, b0 * c0 + b1 * c1 + b2 * c2, c0 * a0 + c1 * a1 + c2 * a2
            total[i] += 2 * np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb)
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
