"""Finds the triangles of a tessellation that represent a curved surface.

The distinction matters because a curved surface that is turned a little touches elsewhere, but on no larger area.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.geometry.facets import COPLANAR
from holdfast.geometry.topology import FLAT, SMOOTH, Topology

ALIKE = 0.25  # least ratio of the widths of two faces of a curve; narrower faces are the rounded edge of a flat face


def curved_faces(vertices: Float, faces: Int, areas: Float, topology: Topology) -> Bool:
    """Mark the faces (F,) that meet neighbours of similar width at a small angle, as in a tessellated curve.

    The width of a flat face is its area over the diagonal of its bounding box. The surface is given by vertices (V, 3)
    [m], faces (F, 3), their areas (F,) [m²] and its topology.
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
