"""The connectivity of a triangle surface: its edges, their angles, and the neighbours of faces and vertices."""

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
