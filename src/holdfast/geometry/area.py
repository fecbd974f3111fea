"""Areas and normals of triangles and of flat outlines, from the vectors that stand for them."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.geometry.polygon import turned

NO_AREA = 1e-300  # [m²] a triangle with less has no direction: its normal is 0


def area_vectors(vertices: Float, faces: Int) -> Float:
    """(F, 3) of triangles ``faces`` (F, 3) over ``vertices`` (V, 3): as long as their area [m²], along their normals.

    Normals go by the right-hand rule around the corners.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def areas_of(vertices: Float, faces: Int) -> Float:
    """(F,) areas of triangles [m²]."""
    return np.asarray(np.linalg.norm(area_vectors(vertices, faces), axis=1))


def normals_of(vertices: Float, faces: Int) -> Float:
    """(F, 3) unit normals of triangles; 0 where a triangle has no area."""
    vectors = area_vectors(vertices, faces)
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), NO_AREA))


def outline_vector(ring: Float) -> Float:
    """(3,) area vector of a flat outline (k, 3), counter-clockwise seen from its tip [m²] (Newell)."""
    x, y, z = ring.T
    u, v, w = turned(ring, 1).T  # np.cross takes four times as long, and all pieces ask
    return np.array([(y * w - z * v).sum(), (z * u - x * w).sum(), (x * v - y * u).sum()]) / 2
