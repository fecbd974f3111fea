"""Flat faces of many triangles as polygons with holes, their triangulation, and which faces stand for a curve."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.public import Record
from holdfast.geometry.triangles import FLAT, SMOOTH, Topology, outline_vector

LEAST = 5  # least number of triangles of a facet; fewer are treated one by one
COPLANAR = 1e-5  # [rad] largest angle between neighbouring triangles of one facet, which contacts see as one polygon
FLATNESS = 1e-7  # largest deviation of vertices from the plane of their facet, relative to the size of the surface
ALIKE = 0.25  # least ratio of the widths of two faces of a curve; narrower faces are the rounded edge of a flat face


class Facets(Record):
    """The large flat faces of a surface.

    ``label`` (F,) is the number of the facet to which each triangle belongs, or -1. ``rings`` holds a tuple for each
    facet: the vertex numbers of its outline, counter-clockwise seen from outside, then those of its holes, clockwise.
    """

    label: Int
    rings: tuple[tuple[Int, ...], ...]

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float, topology: Topology) -> Facets:
        """Return the facets of a surface: groups of LEAST or more coplanar triangles bounded by simple rings."""
        region = topology.regions(COPLANAR)
        label = np.full(len(faces), -1, dtype=np.int64)
        large = np.flatnonzero(np.bincount(region) >= LEAST)
        if not len(large):
            return cls(label, ())  # so it is with a scan
        inner = np.abs(topology.bend) <= COPLANAR
        found: list[tuple[Int, ...]] = []
        extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
        for number in large:
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
    """Return the closed rings of vertex numbers that directed edges form; None if a vertex belongs to two of them."""
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
    """Return the faces (F, 3) with every convex facet without holes triangulated by repeated halving of its ring.

    The triangles of a fan are slivers with overlapping bounding boxes: a point is in the boxes of most of them. After
    halving, it is in the boxes of only a few triangles of each size.
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


def curved_faces(vertices: Float, faces: Int, areas: Float, topology: Topology) -> Bool:
    """Mark the faces (F,) that meet neighbours of similar width at a small angle, as in a tessellated curve.

    The width of a flat face is its area over the diagonal of its bounding box. The surface is given by vertices (V, 3)
    [m], faces (F, 3), their areas (F,) [m²] and its topology.
    """
    smooth = (np.abs(topology.bend) > FLAT) & (np.abs(topology.bend) < SMOOTH)
    if not smooth.any():
        return np.zeros(len(faces), dtype=bool)
    region = topology.regions(COPLANAR)
    order = np.argsort(region, kind="stable")
    starts = np.flatnonzero(np.diff(region[order], prepend=-1))
    corners = vertices[faces[order]]
    low, high = np.minimum.reduceat(corners.min(1), starts), np.maximum.reduceat(corners.max(1), starts)
    width = np.add.reduceat(areas[order], starts) / np.maximum(np.linalg.norm(high - low, axis=1), 1e-300)
    one, other = region[topology.sides[smooth]].T
    curved = np.zeros(len(starts), dtype=bool)
    curved[one[width[other] >= ALIKE * width[one]]] = True
    curved[other[width[one] >= ALIKE * width[other]]] = True
    return np.asarray(curved[region])
