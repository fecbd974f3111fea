"""The connectivity of a triangle surface: edges, their angles, neighbours of faces and vertices; and its roughness.

The roughness is the scatter of vertices about smooth surfaces fitted to their neighbourhoods.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.public import Record
from holdfast.base.values import Value, seal
from holdfast.native import core

FLAT: Final = core.FLAT  # [rad] a smaller angle between two faces is rounding, not an edge
# [rad] an edge with a smaller angle is smooth: its faces represent a curved surface
SMOOTH: Final = core.SMOOTH
LEAST_VERTICES = 100  # a mesh with fewer vertices is a drawing, not a scan
SAMPLES = 250  # largest number of vertices at which the scatter is measured
LEAST_SAMPLES = 20  # with fewer even neighbourhoods, the scatter is not known
EXACT = 5e-5  # relative to the size of the surface; less scatter is rounding, or due to the facets of a smooth shape


@dataclass(frozen=True, eq=False, repr=False)
class Edges(Value):
    """The E edges of F triangles, whatever their winding.

    ``ends`` (E, 2) are the two vertices of each edge, the lower number first, in lexicographic order. ``of_face``
    (F, 3) is the edge from the k-th vertex of a face to the next one. ``shared`` (E,) is the number of faces at each
    edge. ``sides`` (3F,) lists all sides of faces, ordered by edge and then by face; 3 · face + k is the side that
    begins at the k-th vertex of a face. The sides at edge e begin at ``first[e]``; ``first`` is (E,).
    """

    ends: Int
    of_face: Int
    shared: Int
    sides: Int
    first: Int

    def __post_init__(self) -> None:
        seal(self)

    @classmethod
    def of(cls, faces: Int, count: int) -> Edges:
        """Return the edges of triangles ``faces`` (F, 3) over ``count`` vertices."""
        return cls(*core.edges_of(np.ascontiguousarray(faces), count))


class Topology(Record):
    """Edges and vertices of a triangle surface.

    ``edges`` (E, 2) are the vertices of each edge, and ``sides`` (E, 2) its two faces, -1 if there is none. ``bend``
    (E,) [rad] is the angle between the normals of the two faces, positive at a convex edge, and infinite at the rim of
    an open surface. ``of_face`` (F, 3) is the edge from the k-th vertex of a face to the next one. The vertices that
    are joined to vertex v are ``neighbours[starts[v]:starts[v + 1]]``; ``starts`` is (V + 1,). ``closed`` is True if
    every edge has exactly two faces.
    """

    edges: Int
    sides: Int
    bend: Float
    of_face: Int
    starts: Int
    neighbours: Int
    closed: bool

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float) -> Topology:
        """Return the topology of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) with unit ``normals`` (F, 3)."""
        return cls(*core.topology_of(vertices, faces, normals))

    def regions(self, angle: float) -> Int:
        """Return the region (F,) of each face; faces are connected across edges of up to ``angle`` [rad]."""
        return core.regions_of(self.sides, self.bend, angle, len(self.of_face))

    def joins(self, angle: float) -> Bool:
        """Tell at which edges (E,) two faces meet at ``angle`` [rad] or less; never at a rim."""
        return np.asarray(np.abs(self.bend) <= angle)


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
