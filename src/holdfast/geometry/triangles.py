"""Triangles: areas, normals, edges and neighbours; how rough their surface is; and the first one that a ray meets.

The roughness is the scatter of vertices about smooth surfaces fitted to their neighbourhoods.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.public import Record
from holdfast.base.values import Value, seal
from holdfast.geometry.polygon import turned
from holdfast.native import core

EDGE_ON = 1e-12  # relative volume below which a triangle is seen edge-on and counts as missed
FLAT: Final = core.FLAT  # [rad] a smaller angle between two faces is rounding, not an edge
# [rad] an edge with a smaller angle is smooth: its faces represent a curved surface
SMOOTH: Final = core.SMOOTH
LEAST_VERTICES = 100  # a mesh with fewer vertices is a drawing, not a scan
SAMPLES = 250  # largest number of vertices at which the scatter is measured
LEAST_SAMPLES = 20  # with fewer even neighbourhoods, the scatter is not known
EXACT = 5e-5  # relative to the size of the surface; less scatter is rounding, or due to the facets of a smooth shape


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
    met = np.abs(volume) > EDGE_ON * size
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
