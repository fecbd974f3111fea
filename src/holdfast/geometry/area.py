"""Areas and normals of triangles and of flat outlines, from their area vectors."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.geometry.polygon import turned
from holdfast.native import core


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
