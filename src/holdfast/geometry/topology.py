"""How the triangles of a surface hang together: its edges, which of them stick out, and who is whose neighbour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int
from holdfast.base.values import Value

FLAT = 1e-3  # [rad] a smaller dihedral is rounding, not an edge


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

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float) -> Topology:
        """Of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) with unit ``normals`` (F, 3)."""
        count = len(faces)
        half = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        low, high = half.min(1), half.max(1)
        keys, inverse, shared = np.unique(low * len(vertices) + high, return_inverse=True, return_counts=True)
        edges = np.column_stack([keys // len(vertices), keys % len(vertices)])
        order = np.argsort(inverse, kind="stable")
        first = np.concatenate([[0], np.cumsum(shared)[:-1]])
        sides = np.full((len(edges), 2), -1, dtype=np.int64)
        sides[:, 0] = order[first] // 3
        several = shared > 1
        sides[several, 1] = order[first[several] + 1] // 3
        bend = np.full(len(edges), np.inf)
        one, other = sides[several].T
        cosine = np.clip((normals[one] * normals[other]).sum(1), -1, 1)
        sine = np.linalg.norm(np.cross(normals[one], normals[other]), axis=1)
        away = vertices[faces[other]].sum(1) - 3 * vertices[faces[one, 0]]
        out = np.where((away * normals[one]).sum(1) <= 0, 1.0, -1.0)
        bend[several] = out * np.arctan2(sine, cosine)
        starts = np.concatenate([[0], np.cumsum(np.bincount(edges.ravel(), minlength=len(vertices)))])
        ends = np.concatenate([edges, edges[:, ::-1]])
        neighbours = ends[np.argsort(ends[:, 0], kind="stable"), 1]
        return cls(edges, sides, bend, inverse.reshape(count, 3), starts, neighbours, bool((shared == 2).all()))
