"""Flat faces of many triangles, as polygons: their outlines and holes, and a triangulation that searches fast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int
from holdfast.base.values import Value, seal
from holdfast.geometry.area import outline_vector
from holdfast.geometry.topology import Topology

LEAST = 5  # triangles: fewer are as well left as they are
COPLANAR = 1e-5  # [rad] between neighbouring triangles of one facet: its outline stands for them in contact
FLATNESS = 1e-7  # of the surface's size: vertices of a facet may leave its plane by no more


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Facets(Value):
    """The large flat faces of a surface.

    ``label`` (F,) number of the facet each triangle belongs to, -1 for those of none; ``rings`` one tuple a facet:
    vertex numbers of the outline, counter-clockwise seen from outside, then of the holes, clockwise.
    """

    label: Int
    rings: tuple[tuple[Int, ...], ...]

    def __post_init__(self) -> None:
        seal(self)

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float, topology: Topology) -> Facets:
        """Groups of LEAST or more coplanar triangles whose rim is made of simple rings."""
        region = topology.regions(COPLANAR)
        inner = topology.joins(COPLANAR)
        label = np.full(len(faces), -1, dtype=np.int64)
        found: list[tuple[Int, ...]] = []
        extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
        for number in np.flatnonzero(np.bincount(region) >= LEAST):
            members = np.flatnonzero(region == number)
            normal = normals[members].mean(0)
            normal /= max(float(np.linalg.norm(normal)), 1e-300)
            heights = vertices[faces[members]] @ normal
            if np.ptp(heights) > FLATNESS * extent:
                continue
            rim = ~inner[topology.of_face[members]]
            starts, ends = faces[members][rim], np.roll(faces[members], -1, axis=1)[rim]
            rings = _rings(starts, ends)
            if rings is None:
                continue
            areas = [float(outline_vector(vertices[ring]) @ normal) for ring in rings]
            if sum(area > 0 for area in areas) != 1:
                continue
            order = np.argsort(areas)[::-1]
            label[members] = len(found)
            found.append(tuple(rings[k] for k in order))
        return cls(label, tuple(found))


def _rings(starts: Int, ends: Int) -> list[Int] | None:
    """Closed rings of vertex numbers from their directed edges; None where a vertex is passed more than once."""
    follow = dict(zip(starts.tolist(), ends.tolist(), strict=True))
    if len(follow) != len(starts):
        return None
    rings = []
    while follow:
        first = next(iter(follow))
        ring, at = [first], follow.pop(first)
        while at != first:
            ring.append(at)
            if at not in follow:
                return None
            at = follow.pop(at)
        rings.append(np.array(ring, dtype=np.int64))
    return rings


def balanced(vertices: Float, faces: Int, facets: Facets) -> Int:
    """The faces (F, 3), with every convex facet without holes triangulated anew by halving its ring.

    Triangles of a fan are slivers whose bounding boxes overlap, so that a point lies in the boxes of most of them; of
    these it lies in the boxes of a few of each size.
    """
    kept = [faces[facets.label < 0]]
    for number, (outline, *holes) in enumerate(facets.rings):
        mine = faces[facets.label == number]
        kept.append(mine if holes or not _convex(vertices[outline]) else _halved(outline))
    return np.vstack(kept)


def _convex(ring: Float) -> bool:
    edges = np.roll(ring, -1, axis=0) - ring
    turns = np.cross(edges, np.roll(edges, -1, axis=0))
    return bool((turns @ turns.sum(0) > 0).all())


def _halved(ring: Int) -> Int:
    triangles, parts = [], [(0, len(ring) - 1)]
    while parts:
        low, high = parts.pop()
        if high - low < 2:
            continue
        middle = (low + high) // 2
        triangles.append((ring[low], ring[middle], ring[high]))
        parts += [(low, middle), (middle, high)]
    return np.array(triangles, dtype=np.int64)
