"""Triangle surfaces as values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.arrays import Float, Int, frozen
from holdfast.scene.topology import Topology

STRAIGHT = 1e-8  # of its size: how far a surface may bend and still count as flat when triangles are left out


@dataclass(frozen=True)
class Surface:
    """Triangles with outward normals: vertices (V, 3) [m], faces (F, 3).

    ``sagitta`` [m]: how far the triangles lie inside the curved surface they stand for; ``oriented``: whether it is
    known which side is the inside.
    """

    vertices: Float
    faces: Int
    sagitta: float = 0.0
    oriented: bool = True

    @cached_property
    def normals(self) -> Float:
        """(F, 3) unit outward normals."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        cross = np.cross(b - a, c - a)
        return np.asarray(cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300))

    @property
    def thickness(self) -> float:
        """Smallest side of the bounding box in the body frame [m]."""
        return float(np.ptp(self.vertices, axis=0).min())

    @cached_property
    def topology(self) -> Topology:
        """Its edges and neighbours."""
        return Topology.of(self.vertices, self.faces, self.normals)

    @cached_property
    def reduced(self) -> Surface:
        """The same surface with as few triangles as its flat faces need; itself where it does not close.

        Only vertices inside flat faces and along straight edges go; the others stay where they are.
        """
        import manifold3d

        size = float(np.linalg.norm(np.ptp(self.vertices, axis=0)))
        mesh = manifold3d.Mesh64(np.array(self.vertices, order="C"), self.faces.astype(np.uint64, order="C"))
        solid = manifold3d.Manifold(mesh)
        if solid.status() != manifold3d.Error.NoError or solid.is_empty():
            return self
        fewer = solid.simplify(STRAIGHT * size)
        if fewer.num_tri() >= len(self.faces) or not fewer.num_tri():
            return self
        found = fewer.to_mesh64()
        vertices = np.array(found.vert_properties[:, :3])
        return Surface(frozen(vertices), frozen(np.array(found.tri_verts, dtype=np.int64)), self.sagitta, self.oriented)
