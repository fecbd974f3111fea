"""The roughness of a surface: the scatter of its vertices about smooth surfaces fitted to their neighbourhoods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.geometry.topology import Topology
from holdfast.native import core

LEAST_VERTICES = 100  # a mesh with fewer vertices is a drawing, not a scan
SAMPLES = 250  # largest number of vertices at which the scatter is measured
LEAST_SAMPLES = 20  # with fewer even neighbourhoods, the scatter is not known
EXACT = 5e-5  # relative to the size of the surface; less scatter is rounding, or due to the facets of a smooth shape


@dataclass(frozen=True)
class Roughness:
    """The scatter of a scanned surface.

    ``height`` [m] is the standard deviation of its vertices about the smooth surface, and ``slope`` [-] is that of its
    facets, that is the height over the median length of an edge. Both are 0 for a surface without scatter, such as a
    CAD model.
    """

    height: float
    slope: float


NONE = Roughness(0.0, 0.0)


def roughness_of(vertices: Float, faces: Int, areas: Float, normals: Float, topology: Topology) -> Roughness:
    """Measure the roughness of a triangle surface: vertices (V, 3) [m], faces (F, 3), areas (F,), unit normals (F, 3).

    A quadric is fitted to the two rings of neighbours of a vertex, and the residual is the scatter. It is exactly 0 on
    a plane, and on a smooth surface it vanishes with the third power of the edge length. The median over many vertices
    is taken, leaving out vertices near sharp edges and small features. Surfaces with fewer vertices than LEAST_VERTICES
    are drawings, and not asked about.
    """
    around = topology.starts, topology.neighbours
    height = core.median_scatter(vertices, faces, areas, normals, *around, SAMPLES, LEAST_SAMPLES)
    if not height > EXACT * float(np.linalg.norm(np.ptp(vertices, axis=0))):
        return NONE
    return Roughness(height, height / core.median_length(vertices, topology.edges))
