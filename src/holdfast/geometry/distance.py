"""Distances of points from a triangle surface, and winding numbers, which tell whether they are inside (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, dot3, lean
from holdfast.geometry.surface import Surface

TINY = 1e-100  # a running product is rescaled when its size leaves the range from TINY to 1 / TINY

# Points are copied below, because Numba would compile the loops a second time for read-only arrays.


def distance_to_surface(points: Float, surface: Surface) -> Float:
    """Return the distances (n,) [m] of points (n, 3) from the nearest triangle."""
    return np.asarray(np.sqrt(_squared(np.array(points, order="C"), surface.vertices[surface.faces])))


def winding_number(points: Float, surface: Surface) -> Float:
    """Return how often (n,) the surface winds around points (n, 3): 1 inside and 0 outside, nearly so with small holes.

    It is the sum of the triangles' solid angles over 4π (van Oosterom and Strackee 1983; Jacobson et al. 2013).
    """
    return np.asarray(_winding(np.array(points, order="C"), np.array(surface.vertices), np.array(surface.faces)))


@compiled
def _winding(points: Float, vertices: Float, faces: Int) -> Float:
    """Return the winding numbers (n,) of ``points`` (n, 3).

    Half of each solid angle is the argument of a complex number, so half of their sum is the argument of the product.
    It is enough to count how often the product crosses the negative real axis, with one arctangent for each point.
    """
    total = np.zeros(len(points))
    arms, lengths = np.empty((len(vertices), 3)), np.empty(len(vertices))
    for i in range(len(points)):
        for k in range(len(vertices)):
            x, y, z = vertices[k, 0] - points[i, 0], vertices[k, 1] - points[i, 1], vertices[k, 2] - points[i, 2]
            arms[k, 0], arms[k, 1], arms[k, 2] = x, y, z
            lengths[k] = np.sqrt(x * x + y * y + z * z)
        real, imaginary, turns = 1.0, 0.0, 0
        for j in range(len(faces)):
            a, b, c = arms[faces[j, 0]], arms[faces[j, 1]], arms[faces[j, 2]]
            la, lb, lc = lengths[faces[j, 0]], lengths[faces[j, 1]], lengths[faces[j, 2]]
            sine = (
                a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
            )
            cosine = la * lb * lc + dot3(a, b) * lc + dot3(b, c) * la + dot3(c, a) * lb
            if sine == 0.0 and cosine == 0.0:  # at a corner of the triangle
                continue
            product = real * sine + imaginary * cosine
            if imaginary >= 0.0 and sine >= 0.0 and product < 0.0:
                turns += 1
            elif imaginary < 0.0 and sine < 0.0 and product >= 0.0:
                turns -= 1
            real = real * cosine - imaginary * sine
            imaginary = product
            size = max(abs(real), abs(imaginary))
            if not TINY < size < 1 / TINY:
                real, imaginary = real / size, imaginary / size
        total[i] = (2 * np.pi * turns + np.arctan2(imaginary, real)) / (2 * np.pi)
    return total


@compiled
@lean
def nearest_of(points: Float, triangles: Float, pairs: Int) -> float:
    """Return the least squared distance among ``pairs`` (m, 2) of points (n, 3) and triangles (k, 3, 3)."""
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
@lean
def _apart(point: Float, triangle: Float) -> float:
    """Return the squared distance of a point from a triangle.

    It is the distance from the plane inside the prism of the triangle, and from the nearest edge outside.
    """
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
