"""Triangle surfaces as values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakValueDictionary

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.base.kinds import shaped
from holdfast.base.values import Value, seal
from holdfast.geometry.area import areas_of, normals_of
from holdfast.geometry.cuboid import Cuboid
from holdfast.geometry.curved import curved_faces
from holdfast.geometry.facets import Facets, balanced
from holdfast.geometry.roughness import NONE, Roughness, roughness_of
from holdfast.geometry.solid import closed_solid
from holdfast.geometry.topology import SMOOTH, Topology

STRAIGHT = 1e-8  # of its size: how far a surface may bend and still count as flat when triangles are left out
HUB = 64  # spokes: a fan with more is cut anew before it is reduced


@archived
@shaped(vertices="V 3", faces="F 3")
@dataclass(frozen=True, eq=False, repr=False)
class Surface(Value):
    """Triangles with outward normals: vertices (V, 3) [m], faces (F, 3).

    ``sagitta`` [m]: how far the triangles lie inside the curved surface they stand for; ``oriented``: whether it is
    known which side is the inside.
    """

    vertices: Float
    faces: Int
    sagitta: float = 0.0
    oriented: bool = True

    def __post_init__(self) -> None:
        seal(self)

    def shared(self) -> Surface:
        """Itself, or the same surface that is in use already: what follows from it is worked out once for all of them.

        Fifty tins of one mesh are one surface, whatever files they come from.
        """
        key = (self.vertices.tobytes(), self.faces.tobytes(), self.sagitta, self.oriented)
        return _IN_USE.setdefault(key, self)

    @cached_property
    def normals(self) -> Float:
        """(F, 3) unit outward normals."""
        return frozen(normals_of(self.vertices, self.faces))

    @cached_property
    def areas(self) -> Float:
        """(F,) [m²]."""
        return frozen(areas_of(self.vertices, self.faces))

    @property
    def area(self) -> float:
        """Of all triangles [m²]."""
        return float(self.areas.sum())

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box in the body frame [m], which no pose changes."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def thickness(self) -> float:
        """Smallest side of the bounding box in the body frame [m]."""
        return float(np.ptp(self.vertices, axis=0).min())

    @cached_property
    def topology(self) -> Topology:
        """Its edges and neighbours."""
        return Topology.of(self.vertices, self.faces, self.normals)

    @cached_property
    def roughness(self) -> Roughness:
        """How much its vertices scatter; nothing where ``sagitta`` says how the triangles lie in a smooth surface."""
        if self.sagitta > 0:
            return NONE
        return roughness_of(self.vertices, self.faces, self.areas, self.normals, self.topology)

    @cached_property
    def curved(self) -> Bool:
        """(F,) which triangles stand for a curved surface: none of a rough one, whose bends scatter."""
        if self.roughness.slope:
            return np.zeros(len(self.faces), dtype=bool)
        return frozen(curved_faces(self.vertices, self.faces, self.areas, self.topology))

    @cached_property
    def crisp(self) -> Int:
        """(n,) its sharp edges that stick out, but for those that bound a curved surface."""
        bend, sides = self.topology.bend, self.topology.sides
        sharp = np.flatnonzero((bend >= SMOOTH) & np.isfinite(bend))
        return frozen(sharp[~self.curved[sides[sharp]].any(1)])

    @cached_property
    def reduced(self) -> Surface:
        """The same surface with as few triangles as its flat faces need; itself where it does not close.

        Only vertices inside flat faces and along straight edges go; the others stay where they are.
        """
        size = float(np.linalg.norm(np.ptp(self.vertices, axis=0)))
        # taking out the hub of a fan is slow
        start = self._balanced() if np.bincount(self.faces.ravel()).max(initial=0) > HUB else self
        solid = closed_solid(start.vertices, start.faces)
        if solid is None:
            return start._balanced()
        fewer = solid.simplify(STRAIGHT * size)
        if not 0 < fewer.num_tri() < len(start.faces):
            return start._balanced()
        read = fewer.to_mesh64()
        vertices, faces = np.array(read.vert_properties[:, :3]), np.array(read.tri_verts, dtype=np.int64)
        return replace(self, vertices=vertices, faces=faces)._balanced()

    def _balanced(self) -> Surface:
        """The same surface, its large convex faces cut so that they are searched fast."""
        if not self.facets.rings:
            return self
        faces = balanced(self.vertices, self.faces, self.facets)
        used, numbers = np.unique(faces, return_inverse=True)
        return replace(self, vertices=self.vertices[used], faces=numbers.reshape(faces.shape))

    @cached_property
    def cuboid(self) -> Cuboid | None:
        """The cuboid that it bounds, however many triangles its faces consist of; None if it bounds something else."""
        reduced = self.reduced
        if len(reduced.vertices) != 8 or not (self.oriented and reduced.topology.closed):
            return None
        return Cuboid.of(reduced.vertices, reduced.faces, reduced.normals)

    @cached_property
    def facets(self) -> Facets:
        """Its flat faces of many triangles."""
        return Facets.of(self.vertices, self.faces, self.normals, self.topology)


_IN_USE: WeakValueDictionary[tuple[bytes, bytes, float, bool], Surface] = WeakValueDictionary()
