"""How the triangles of a surface hang together: its edges, which of them stick out, and who is whose neighbour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.values import Value, seal

FLAT = 1e-3  # [rad] a smaller dihedral is rounding, not an edge
SMOOTH = 0.6  # [rad] faces that meet at less stand for a curved surface


@dataclass(frozen=True, eq=False, repr=False)
class Edges(Value):
    """The E edges of F triangles, whichever way round each triangle names its corners.

    ``ends`` (E, 2) vertices, the lower number first, in order; ``of_face`` (F, 3) the edge from a face's k-th to its
    next vertex; ``shared`` (E,) the number of faces beside each. ``sides`` (3F,) numbers 3 · face + k for the side of a
    face that begins at its k-th vertex: those along one edge stand together, in the order of the faces, and those of
    edge e begin at ``first[e]``, (E,).
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
        """Of triangles ``faces`` (F, 3) over ``count`` vertices."""
        following = np.roll(faces, -1, axis=1)
        low, high = np.minimum(faces, following).ravel(), np.maximum(faces, following).ravel()
        keys, number, shared = np.unique(low * count + high, return_inverse=True, return_counts=True)
        sides = np.argsort(number, kind="stable")
        first = np.concatenate([[0], np.cumsum(shared)[:-1]]).astype(np.int64)
        return cls(np.column_stack([keys // count, keys % count]), number.reshape(-1, 3), shared, sides, first)

    def side_of(self, number: int) -> Int:
        """(E,) the ``number``-th side of every edge, -1 where it has no more than that."""
        there = self.shared > number
        sides = np.full(len(self.ends), -1, dtype=np.int64)
        sides[there] = self.sides[self.first[there] + number]
        return sides


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Topology(Value):
    """Edges and vertices of a triangle surface.

    ``edges`` (E, 2) vertices; ``sides`` (E, 2) the faces beside each, -1 where there is none; ``bend`` (E,) angle
    between its two faces' normals [rad], positive where the edge sticks out, infinite at the rim of an open sheet;
    ``of_face`` (F, 3) the edge from a face's k-th to its next vertex; ``starts`` (V + 1,) and ``neighbours`` list the
    vertices joined to each vertex; ``closed`` tells whether every edge has exactly two faces.
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
        """Of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) with unit ``normals`` (F, 3)."""
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
        """(F,) the number of the region each face is in: joined across edges that bend by ``angle`` [rad] or less."""
        one, other = self.sides[self.joins(angle)].T
        count = len(self.of_face)
        graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)

    def joins(self, angle: float) -> Bool:
        """(E,) whether an edge bends by no more than ``angle`` [rad]: a rim does not."""
        return np.asarray(np.abs(self.bend) <= angle)
