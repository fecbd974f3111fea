"""Which triangles of a drawn surface stand for a curved one: turned a little, it touches elsewhere, but no wider."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.geometry.facets import COPLANAR
from holdfast.geometry.topology import FLAT, SMOOTH, Topology

ALIKE = 0.25  # of a flat face's width: where it bends smoothly into narrower ones, these are the rounding of its edge


def curved_faces(vertices: Float, faces: Int, areas: Float, topology: Topology) -> Bool:
    """Mark the faces (F,) that bend smoothly, as a tessellated curve does, into others about as wide as they are.

    The width of a flat face is its area over the diagonal of its bounding box. The surface is given as vertices (V, 3)
    [m], faces (F, 3) and their areas (F,).
    """
    smooth = (np.abs(topology.bend) > FLAT) & (np.abs(topology.bend) < SMOOTH)
    if not smooth.any():
        return np.zeros(len(faces), dtype=bool)
    region = topology.regions(COPLANAR)
    order = np.argsort(region, kind="stable")
    starts = np.flatnonzero(np.diff(region[order], prepend=-1))
    corners = vertices[faces[order]]
    low, high = np.minimum.reduceat(corners.min(1), starts), np.maximum.reduceat(corners.max(1), starts)
    width = np.add.reduceat(areas[order], starts) / np.maximum(np.linalg.norm(high - low, axis=1), 1e-300)
    one, other = region[topology.sides[smooth]].T
    curved = np.zeros(len(starts), dtype=bool)
    curved[one[width[other] >= ALIKE * width[one]]] = True
    curved[other[width[one] >= ALIKE * width[other]]] = True
    return np.asarray(curved[region])
