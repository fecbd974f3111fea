"""Triangles: areas and normals, also those of flat outlines, and the first one that a ray meets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.geometry.polygon import turned
from holdfast.native import core

_FLAT = 1e-12  # relative volume below which a triangle is seen edge-on and counts as missed


def area_vectors(vertices: Float, faces: Int) -> Float:
    """Return the area vectors (F, 3) [m²] of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) [m].

    Each is as long as the area of its triangle and points along the normal, by the right-hand rule.
    """
    return core.area_vectors(np.ascontiguousarray(vertices), np.ascontiguousarray(faces))


def areas_of(vertices: Float, faces: Int) -> Float:
    """Return the areas (F,) [m²] of triangles."""
    return core.areas_of(np.ascontiguousarray(vertices), np.ascontiguousarray(faces))


def normals_of(vertices: Float, faces: Int) -> Float:
    """Return the unit normals (F, 3) of triangles; 0 for a triangle without area."""
    return core.normals_of(np.ascontiguousarray(vertices), np.ascontiguousarray(faces))


def outline_vector(ring: Float) -> Float:
    """Return the area vector (3,) [m²] of a flat outline (k, 3), counter-clockwise seen from its tip (Newell)."""
    x, y, z = ring.T
    u, v, w = turned(ring, 1).T  # np.cross takes four times as long, and this is called for every piece
    return np.array([(y * w - z * v).sum(), (z * u - x * w).sum(), (x * v - y * u).sum()]) / 2


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
