"""The connectivity of a triangle surface: its edges, their angles, and the neighbours of faces and vertices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int
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
        following = np.roll(faces, -1, axis=1)
        low, high = np.minimum(faces, following).ravel(), np.maximum(faces, following).ravel()
        keys, number, shared = np.unique(low * count + high, return_inverse=True, return_counts=True)
        sides = np.argsort(number, kind="stable")
        first = np.concatenate([[0], np.cumsum(shared)[:-1]]).astype(np.int64)
        return cls(np.column_stack([keys // count, keys % count]), number.reshape(-1, 3), shared, sides, first)

    def side_of(self, number: int) -> Int:
        """Return side number ``number`` (from 0) of every edge, (E,), or -1 if it has fewer sides."""
        there = self.shared > number
        sides = np.full(len(self.ends), -1, dtype=np.int64)
        sides[there] = self.sides[self.first[there] + number]
        return sides


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Topology(Value):
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

    def __post_init__(self) -> None:
        seal(self)

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float) -> Topology:
        """Return the topology of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) with unit ``normals`` (F, 3)."""
        edges = Edges.of(faces, len(vertices))
        sides = np.column_stack([edges.side_of(0), edges.side_of(1)]) // 3
        several = edges.shared > 1
        bend = np.full(len(edges.ends), np.inf)
        one, other = sides[several].T
        cosine = np.clip((normals[one] * normals[other]).sum(1), -1, 1)
        sine = np.linalg.norm(np.cross(normals[one], normals[other]), axis=1)
        away = vertices[faces[other]].sum(1) - 3 * vertices[faces[one, 0]]
        out = np.where((away * normals[one]).sum(1) <= 0, 1.0, -1.0)
        bend[several] = out * np.arctan2(sine, cosine)
        starts = np.concatenate([[0], np.cumsum(np.bincount(edges.ends.ravel(), minlength=len(vertices)))])
        ways = np.concatenate([edges.ends, edges.ends[:, ::-1]])
        neighbours = ways[np.argsort(ways[:, 0], kind="stable"), 1]
        return cls(edges.ends, sides, bend, edges.of_face, starts, neighbours, bool((edges.shared == 2).all()))

    def regions(self, angle: float) -> Int:
        """Return the region (F,) of each face; faces are connected across edges of up to ``angle`` [rad]."""
        one, other = self.sides[self.joins(angle)].T
        count = len(self.of_face)
        graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)

    def joins(self, angle: float) -> Bool:
        """Tell at which edges (E,) two faces meet at ``angle`` [rad] or less; never at a rim."""
        return np.asarray(np.abs(self.bend) <= angle)
