"""Intersection of a ray with triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int

_FLAT = 1e-12  # relative volume below which a triangle is seen edge-on and counts as missed


class Hit(NamedTuple):
    """The triangle that a ray meets first, by number, and the distance along the ray, in lengths of its direction."""

    triangle: int
    distance: float


@np.errstate(over="ignore", invalid="ignore")  # rays beyond what numbers can hold meet nothing
def first_hit(vertices: Float, triangles: Int, origin: Float, direction: Float) -> Hit | None:
    """Return where a ray from ``origin`` (3,) along ``direction`` (3,) first meets ``triangles`` (T, 3), or None.

    Triangles are met from both sides, their edges included (Möller and Trumbore 1997, with a margin of 1e-9 for
    rounding).
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    ab, ac, off = b - a, c - a, origin - a
    across = np.cross(direction, ac)
    volume = np.einsum("ij,ij->i", ab, across)
    size = np.linalg.norm(ab, axis=1) * np.linalg.norm(ac, axis=1) * float(np.linalg.norm(direction))
    met = np.abs(volume) > _FLAT * size
    scale = np.where(met, volume, 1.0)
    normal = np.cross(off, ab)
    u = np.einsum("ij,ij->i", off, across) / scale
    v = (normal @ direction) / scale
    distance = np.einsum("ij,ij->i", ac, normal) / scale
    met &= (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (distance > 0)
    if not met.any():
        return None
    best = int(np.argmin(np.where(met, distance, np.inf)))
    return Hit(best, float(distance[best]))
