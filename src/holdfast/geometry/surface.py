"""Triangle surfaces as values, and the cuboids among them, however their faces are divided into triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakValueDictionary

import numpy as np

from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.base.public import Record, column
from holdfast.base.values import Value, made, seal
from holdfast.geometry.facets import Facets, balanced, curved_faces
from holdfast.geometry.solid import closed_solid
from holdfast.geometry.triangles import (
    LEAST_VERTICES,
    NONE,
    SMOOTH,
    Roughness,
    Topology,
    areas_of,
    normals_of,
    roughness_of,
)
from holdfast.native import core

EXACT = 1e-12  # largest deviation of corners, relative to the diagonal, and largest cosine of an angle that is right
IDENTITY = frozen(np.eye(3))
STRAIGHT = 1e-8  # largest change of a surface when triangles are removed from it, relative to its size
SHEET = 1e-6  # a surface is flat if it is no thicker, relative to its size: files round to 6e-8 of it
# of cuboids: their corners in half lengths, their triangles, which of these are curved, and the axes that ``Cuboid.of``
# finds
CORNERS = frozen(np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]))
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACES = frozen(np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))], dtype=np.int64))
FLAT = frozen(np.zeros(len(FACES), dtype=bool))
OUTWARD = frozen(np.diag([-1.0, -1.0, 1.0]))
HUB = 64  # a vertex with more faces is the hub of a fan, which is triangulated differently before it is reduced


@dataclass(frozen=True, eq=False, repr=False)
class Cuboid(Value):
    """A solid box: all points centre + x · axes with |x_k| <= half_k.

    ``centre`` (3,) [m]; the rows of ``axes`` (3, 3) are unit vectors at right angles; ``half`` (3,) [m] are half the
    edge lengths along them.
    """

    centre: Float
    axes: Float
    half: Float

    def __post_init__(self) -> None:
        seal(self)

    @cached_property
    def rows(self) -> Float:
        """The centre, the axes and the half lengths as rows (5, 3)."""
        return frozen(np.vstack([self.centre, self.axes, self.half]))

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float) -> Cuboid | None:
        """Return the cuboid that triangles bound, or None if it is none.

        The triangles ``faces`` (F, 3) over ``vertices`` (V, 3) form a closed surface with outward ``normals`` (F, 3).
        """
        if len(vertices) != 8 or len(faces) != 12:
            return None
        first = normals[0]
        second = normals[np.argmin(np.abs(normals @ first))]
        axes = np.array([first, second, np.cross(first, second)])
        slopes = normals @ axes.T
        facing = np.abs(slopes) > 0.5
        if (facing.sum(1) != 1).any() or np.abs(slopes[~facing]).max() > EXACT:
            return None
        centre = (vertices.min(0) + vertices.max(0)) / 2
        seen = (vertices - centre) @ axes.T
        half = np.ptp(seen, axis=0) / 2
        tiny = EXACT * float(np.linalg.norm(half))
        corners = {tuple(corner) for corner in (seen > 0).tolist()}
        if len(corners) != 8 or np.abs(np.abs(seen) - half).max() > tiny:
            return None
        outward = (slopes[:, None] * seen[faces] * facing[:, None]).sum(2)  # (F, 3 corners)
        return cls(centre, axes, half) if (outward > 0).all() else None

    def placed(self, pose: Float) -> Cuboid | None:
        """Return the cuboid moved by ``pose`` (4, 4), or None if that is no exact rotation.

        A pose that is given with six digits is not exact: it would shear the cuboid.
        """
        return self.placed_together([self], pose[None, :3, :3], pose[None, None, :3, 3])[0]

    @staticmethod
    def placed_together(cuboids: Sequence[Cuboid], turns: Float, places: Float) -> list[Cuboid | None]:
        """Return each of n cuboids as ``placed``, by rotations ``turns`` (n, 3, 3) and ``places`` (n, 1, 3) [m]."""
        back = turns.transpose(0, 2, 1)
        rigid = (np.abs(turns @ back - IDENTITY).max((1, 2)) <= EXACT).tolist()
        local = np.array([cuboid.rows for cuboid in cuboids])
        rows = np.concatenate([local[:, :1] @ back + places, local[:, 1:4] @ back, local[:, 4:]], axis=1)
        return [
            made(Cuboid, centre=own[0], axes=own[1:4], half=own[4], rows=own) if exact else None
            for exact, own in zip(rigid, frozen(rows), strict=True)
        ]


class Surface(Record):
    """A surface of triangles with outward normals: ``vertices`` (V, 3) [m] and ``faces`` (F, 3).

    ``sagitta`` [m] is the largest distance by which the triangles lie inside the curved surface that they represent.
    ``oriented`` is True if it is known which side is the inside.
    """

    vertices: Float = column("V 3")
    faces: Int = column("F 3")
    sagitta: float = 0.0
    oriented: bool = True

    @classmethod
    def of_box(cls, size: Float, centre: Float) -> Surface:
        """Return the surface of a cuboid along the axes with these edge lengths (3,) and centre (3,) [m].

        It has eight vertices and twelve triangles. What would be found in them is known, unless the cuboid is so thin
        that its faces might count as one.
        """
        half = size / 2
        surface = cls(CORNERS * half + centre, FACES)
        diagonal, least = float(np.linalg.norm(size)), float(size.min())
        if least > SHEET * diagonal:
            cuboid = Cuboid(centre, OUTWARD, half)
            surface.__dict__.update(cuboid=cuboid, reduced=surface, closed=True, curved=FLAT, bends=False)
            surface.__dict__.update(diagonal=diagonal, thickness=least)
        return surface

    def shared(self) -> Surface:
        """Return an equal surface that is already in use, or this one, so that derived properties are computed once.

        Fifty tins with the same mesh share one surface, whatever files they come from.
        """
        key = (self.vertices.tobytes(), self.faces.tobytes(), self.sagitta, self.oriented)
        return _IN_USE.setdefault(key, self)

    @cached_property
    def normals(self) -> Float:
        """The outward unit normals (F, 3)."""
        return frozen(normals_of(self.vertices, self.faces))

    @cached_property
    def areas(self) -> Float:
        """The areas (F,) [m²] of the triangles."""
        return frozen(areas_of(self.vertices, self.faces))

    @property
    def area(self) -> float:
        """The total area [m²]."""
        return float(self.areas.sum())

    @cached_property
    def diagonal(self) -> float:
        """The diagonal [m] of the bounding box in the body frame; it does not depend on the pose."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def thickness(self) -> float:
        """The smallest side [m] of the bounding box in the body frame; 0 for a flat sheet, but for rounding."""
        least = float(np.ptp(self.vertices, axis=0).min())
        return least if least > SHEET * self.diagonal else 0.0

    @cached_property
    def topology(self) -> Topology:
        """The edges of the surface, and the neighbours of its faces and vertices."""
        return Topology.of(self.vertices, self.faces, self.normals)

    @cached_property
    def roughness(self) -> Roughness:
        """The scatter of the vertices; none if the surface is a tessellation with a known ``sagitta``."""
        if self.sagitta > 0 or len(self.vertices) < LEAST_VERTICES:
            return NONE
        return roughness_of(self.vertices, self.faces, self.areas, self.normals, self.topology)

    @cached_property
    def curved(self) -> Bool:
        """Which triangles (F,) represent a curved surface; none on a rough surface, where angles are random."""
        if self.roughness.slope:
            return np.zeros(len(self.faces), dtype=bool)
        return frozen(curved_faces(self.vertices, self.faces, self.areas, self.topology))

    @cached_property
    def bends(self) -> bool:
        """Whether some triangle represents a curved surface."""
        return bool(self.curved.any())

    @cached_property
    def closed(self) -> bool:
        """Whether the surface bounds a volume."""
        return self.reduced.topology.closed

    @cached_property
    def sharp_edges(self) -> Int:
        """The numbers (n,) of the convex sharp edges that do not bound a curved face."""
        bend, sides = self.topology.bend, self.topology.sides
        sharp = np.flatnonzero((bend >= SMOOTH) & np.isfinite(bend))
        return frozen(sharp[~self.curved[sides[sharp]].any(1)])

    @cached_property
    def reduced(self) -> Surface:
        """The same surface with as few triangles as its flat faces need, if it is closed.

        Only vertices inside flat faces and along straight edges are removed; the others stay where they are. Large
        convex faces are triangulated for fast search.
        """
        # removing the hub of a fan is slow
        start = self._balanced() if np.bincount(self.faces.ravel()).max(initial=0) > HUB else self
        known = start.topology
        shape = start.vertices, start.faces, known.edges, known.sides, known.of_face
        if not known.closed or not core.may_lose_corners(*shape, STRAIGHT * start.diagonal):  # so it is with most scans
            return start._balanced()
        solid = closed_solid(start.vertices, start.faces)
        if solid is None:
            return start._balanced()
        fewer = solid.simplify(STRAIGHT * self.diagonal)
        if not 0 < fewer.num_tri() < len(start.faces):
            return start._balanced()
        read = fewer.to_mesh64()
        vertices, faces = np.array(read.vert_properties[:, :3]), np.array(read.tri_verts, dtype=np.int64)
        return replace(self, vertices=vertices, faces=faces)._balanced()

    def _balanced(self) -> Surface:
        """Return the same surface with its large convex faces triangulated for fast search."""
        if not self.facets.rings:
            return self
        faces = balanced(self.vertices, self.faces, self.facets)
        used, numbers = np.unique(faces, return_inverse=True)
        return replace(self, vertices=self.vertices[used], faces=numbers.reshape(faces.shape))

    @cached_property
    def cuboid(self) -> Cuboid | None:
        """The cuboid with this surface, however its faces are triangulated; None if it is not a cuboid."""
        reduced = self.reduced
        if len(reduced.vertices) != 8 or not (self.oriented and reduced.topology.closed):
            return None
        return Cuboid.of(reduced.vertices, reduced.faces, reduced.normals)

    @cached_property
    def owned(self) -> tuple[Bool, Bool]:
        """Which corners and which sides (F, 3) of the triangles are theirs: of no triangle before them."""
        numbers = np.arange(len(self.faces))
        owner = np.zeros(len(self.vertices), dtype=np.int64)
        owner[self.faces[::-1].ravel()] = np.repeat(numbers[::-1], 3)
        sides = self.topology.sides[self.topology.of_face, 0]
        return frozen(owner[self.faces] == numbers[:, None]), frozen(sides == numbers[:, None])

    @cached_property
    def facets(self) -> Facets:
        """The flat faces that consist of many triangles."""
        return Facets.of(self.vertices, self.faces, self.normals, self.topology)


_IN_USE: WeakValueDictionary[tuple[bytes, bytes, float, bool], Surface] = WeakValueDictionary()
