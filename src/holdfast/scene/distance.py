"""Distance from points to a triangle surface (compiled)."""

from __future__ import annotations

import numpy as np

from holdfast.arrays import Float
from holdfast.compiled import compiled
from holdfast.scene.shapes import Surface


def distance_to_surface(points: Float, surface: Surface) -> Float:
    """(n,) distance of points (n, 3) to the nearest triangle [m]."""
    return np.asarray(np.sqrt(_squared(np.ascontiguousarray(points), surface.vertices[surface.faces])))


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
