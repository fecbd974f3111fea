"""Distance of points from a triangle surface, and whether they are inside it (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.arrays import Float
from holdfast.compiled import compiled
from holdfast.scene.surface import Surface


def distance_to_surface(points: Float, surface: Surface) -> Float:
    """(n,) distance of points (n, 3) to the nearest triangle [m]."""
    return np.asarray(np.sqrt(_squared(np.ascontiguousarray(points), surface.vertices[surface.faces])))


def winding_number(points: Float, surface: Surface) -> Float:
    """(n,) how often the surface winds around points (n, 3): about 1 inside, 0 outside, also if it has small holes.

    The sum of the triangles' solid angles over 4π (van Oosterom and Strackee 1983; Jacobson et al. 2013).
    """
    return np.asarray(_winding(np.ascontiguousarray(points), surface.vertices[surface.faces]))


@compiled
def _winding(points: Float, triangles: Float) -> Float:
    total = np.zeros(len(points))
    for i in range(len(points)):
        p = points[i]
        for j in range(len(triangles)):
            a, b, c = triangles[j, 0] - p, triangles[j, 1] - p, triangles[j, 2] - p
            la, lb, lc = np.sqrt(_dot(a, a)), np.sqrt(_dot(b, b)), np.sqrt(_dot(c, c))
            triple = (
                a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
            )
            total[i] += 2 * np.arctan2(triple, la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb)
    return total / (4 * np.pi)


@compiled
def _dot(a: Float, b: Float) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def _squared(points: Float, triangles: Float) -> Float:
    """Squared distance to the nearest triangle: inside its prism to its plane, outside to its edges."""
    best = np.full(len(points), np.inf)
    for j in range(len(triangles)):
        a, b, c = triangles[j, 0], triangles[j, 1], triangles[j, 2]
        ab, ac = b - a, c - a
        normal = np.array([ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]])
        area2 = _dot(normal, normal)
        for i in range(len(points)):
            inside = area2 > 0
            for k in range(3):
                p = triangles[j, k]
                edge = triangles[j, (k + 1) % 3] - p
                arm = points[i] - p
                length2 = _dot(edge, edge)
                t = min(max(_dot(arm, edge) / length2, 0.0), 1.0) if length2 > 0 else 0.0
                off = arm - t * edge
                best[i] = min(best[i], _dot(off, off))
                side = (
                    (edge[1] * arm[2] - edge[2] * arm[1]) * normal[0]
                    + (edge[2] * arm[0] - edge[0] * arm[2]) * normal[1]
                    + (edge[0] * arm[1] - edge[1] * arm[0]) * normal[2]
                )
                inside = inside and side >= 0
            if inside:
                height = _dot(points[i] - a, normal)
                best[i] = min(best[i], height * height / area2)
    return best
