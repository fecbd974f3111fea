"""The surface of a body made ready for the search: arrays for compiled code, and pairs of faces that come near."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.base.values import sealed
from holdfast.geometry.surface import Surface
from holdfast.geometry.topology import SMOOTH, Topology
from holdfast.scene.body import Body

LARGE = 8  # times the median: larger faces are searched apart, so that they do not widen the window of the others


class Skin(NamedTuple):
    """A triangle surface in the world as plain arrays for compiled code.

    All of them are read-only: a skin with one that is not would be compiled for anew.

    ``triangles`` (F, 3, 3) with ``normals`` (F, 3) and boxes ``low``, ``high`` (F, 3); ``box`` (2, 3) is the lowest and
    the highest corner of all of them; ``faces`` (F, 3) and the fields of Topology; ``mean`` (V, 3) normals of smooth
    vertices, zero at sharp ones; ``owns_vertex`` and ``owns_edge`` (F, 3) give every vertex and edge to one face;
    ``outward`` (F, 3, 3) are the unit directions in a face's plane across its edges, away from it; ``facet`` (F,) is
    the large flat face a triangle is part of, or -1. ``curved`` (F,) marks the faces that stand for a curved surface.
    """

    vertices: Float
    triangles: Float
    normals: Float
    low: Float
    high: Float
    box: Float
    faces: Int
    edges: Int
    sides: Int
    bend: Float
    of_face: Int
    starts: Int
    neighbours: Int
    mean: Float
    owns_vertex: Bool
    owns_edge: Bool
    outward: Float
    facet: Int
    curved: Bool

    @classmethod
    def of(cls, body: Body) -> Skin:
        """Of a body in its pose, flat faces in as few triangles as they need."""
        local, surface = body.shape.surface.reduced, body.reduced_world
        topology, faces, count = local.topology, local.faces, len(local.faces)
        owner = np.zeros(len(surface.vertices), dtype=np.int64)
        owner[faces[::-1].ravel()] = np.repeat(np.arange(count)[::-1], 3)
        number = np.arange(count)[:, None]
        triangles = surface.vertices[faces]
        low, high = triangles.min(1), triangles.max(1)
        skin = cls(
            np.ascontiguousarray(surface.vertices),
            np.ascontiguousarray(triangles),
            np.ascontiguousarray(surface.normals),
            np.ascontiguousarray(low),
            np.ascontiguousarray(high),
            _box(low, high),
            np.ascontiguousarray(faces),
            topology.edges,
            topology.sides,
            topology.bend,
            topology.of_face,
            topology.starts,
            topology.neighbours,
            _smooth_normals(surface, topology),
            owner[faces] == number,
            topology.sides[topology.of_face, 0] == number,
            outward(triangles, surface.normals),
            local.facets.label,
            local.curved,
        )
        return sealed(skin)


def _box(low: Float, high: Float) -> Float:
    """The lowest and the highest corner (2, 3) of boxes (F, 3)."""
    return np.array([[column.min() for column in low.T], [column.max() for column in high.T]])


def outward(triangles: Float, normals: Float) -> Float:
    """Return the unit directions (F, 3, 3) in the plane of each face across its k-th edge, away from the face."""
    across = np.cross(np.roll(triangles, -1, axis=1) - triangles, normals[:, None])
    length = np.linalg.norm(across, axis=2, keepdims=True)
    return np.ascontiguousarray(across / np.maximum(length, 1e-300))


def _smooth_normals(surface: Surface, topology: Topology) -> Float:
    """(V, 3) mean normal of the faces around each vertex; zero where a sharp edge or a rim ends."""
    order, count = surface.faces.T.ravel(), len(surface.vertices)
    total = np.column_stack([np.bincount(order, np.tile(part, 3), count) for part in surface.normals.T])
    sharp = ~(topology.bend < SMOOTH)
    total[topology.edges[sharp].ravel()] = 0
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.ascontiguousarray(np.divide(total, length, out=np.zeros_like(total), where=length > 0.1))


def moved_skin(local: Skin, pose: Float) -> Skin:
    """Return the skin of a body in its own frame as it is in ``pose`` (4, 4)."""
    faces = local.faces
    vertices, triangles = np.empty_like(local.vertices), np.empty_like(local.triangles)
    low, high = np.empty_like(local.low), np.empty_like(local.high)
    _place(local.vertices, faces, pose[:3, :3], pose[:3, 3], vertices, triangles, low, high)
    turn = pose[:3, :3].T
    moved = local._replace(
        vertices=vertices,
        triangles=triangles,
        normals=np.ascontiguousarray(local.normals @ turn),
        low=low,
        high=high,
        box=_box(low, high),
        mean=np.ascontiguousarray(local.mean @ turn),
        outward=np.ascontiguousarray((local.outward.reshape(-1, 3) @ turn).reshape(-1, 3, 3)),
    )
    return sealed(moved)


@compiled
@lean
def _place(
    points: Float, faces: Int, turn: Float, shift: Float, vertices: Float, triangles: Float, low: Float, high: Float
) -> None:
    """Write vertices (V, 3), triangles (F, 3, 3) and their boxes (F, 3), of ``points`` (V, 3) turned and shifted."""
    for v in range(len(points)):
        for k in range(3):
            vertices[v, k] = shift[k]
            for m in range(3):
                vertices[v, k] += turn[k, m] * points[v, m]
    for f in range(len(faces)):
        for k in range(3):
            low[f, k], high[f, k] = np.inf, -np.inf
            for corner in range(3):
                x = vertices[faces[f, corner], k]
                triangles[f, corner, k] = x
                low[f, k], high[f, k] = min(low[f, k], x), max(high[f, k], x)


def near_faces(a: Skin, b: Skin, gap: float, facets: tuple[int, int] | None = None) -> Int:
    """(m, 2) faces of a and b whose boxes come within ``gap``.

    With ``facets``, the numbers of a large flat face of each body, only those that these two consist of.
    """
    if facets is None:
        return _near_faces(a, b, gap)
    return _near_faces(a, b, gap, (a.facet == facets[0], b.facet == facets[1]))


def near_but_facets(a: Skin, b: Skin, gap: float) -> Int:
    """The same as ``near_faces`` without pairs that are both part of large flat faces, which meet as a whole."""
    return _near_faces(a, b, gap, apart=(a.facet >= 0, b.facet >= 0))


def in_reach(a: Skin, b: Skin, gap: float) -> tuple[Bool, Bool]:
    """Mark the faces (F,) of a and of b that come within ``gap`` of the box that the boxes of both bodies share."""
    low, high = _common(a, b, gap)
    of_a, of_b = (np.ones(len(skin.low), dtype=bool) for skin in (a, b))
    for skin, of in ((a, of_a), (b, of_b)):
        for k in range(3):  # by columns: numpy is slow along short rows
            of &= (skin.high[:, k] >= low[k]) & (skin.low[:, k] <= high[k])
    return of_a, of_b


def _common(a: Skin, b: Skin, gap: float) -> tuple[Float, Float]:
    """The lowest and the highest corner (3,) of what the boxes of both bodies share, wider by ``gap`` on all sides."""
    return np.maximum(a.box[0], b.box[0]) - gap, np.minimum(a.box[1], b.box[1]) + gap


def _near_faces(
    a: Skin, b: Skin, gap: float, among: tuple[Bool, Bool] | None = None, apart: tuple[Bool, Bool] | None = None
) -> Int:
    """(m, 2) near faces, if given only ``among`` some of a and of b, and without those that are both in ``apart``."""
    low, high = _common(a, b, gap)
    of_a, of_b = in_reach(a, b, gap)
    if among is not None:
        of_a, of_b = of_a & among[0], of_b & among[1]
    in_a, in_b = np.flatnonzero(of_a), np.flatnonzero(of_b)
    if not len(in_a) or not len(in_b):
        return np.empty((0, 2), dtype=np.int64)
    axis = int(np.argmax(high - low))
    in_b = in_b[np.argsort(b.low[in_b, axis], kind="stable")]
    length = b.high[in_b, axis] - b.low[in_b, axis]
    large = length > LARGE * np.median(length)
    found = []
    for part in (in_b[~large], in_b[large]):
        marked = None if apart is None else (apart[0][in_a], apart[1][part])
        pairs = near_boxes(a.low[in_a], a.high[in_a], b.low[part], b.high[part], axis, gap, marked)
        found.append(np.column_stack([in_a[pairs[:, 0]], part[pairs[:, 1]]]))
    return np.concatenate(found)


def near_facets(a: Skin, b: Skin, gap: float) -> list[tuple[int, int]]:
    """The pairs of large flat faces of a and b, by their numbers, whose boxes come within ``gap``."""
    (low_a, high_a), (low_b, high_b) = _facet_boxes(a), _facet_boxes(b)
    near = (low_a[:, None] <= high_b + gap) & (low_b <= high_a[:, None] + gap)
    return [(int(i), int(j)) for i, j in np.argwhere(near.all(2))]


def _facet_boxes(skin: Skin) -> tuple[Float, Float]:
    """The lowest and the highest corners (n, 3) of the boxes of the large flat faces."""
    order = np.argsort(skin.facet, kind="stable")
    starts = np.searchsorted(skin.facet[order], np.arange(skin.facet.max(initial=-1) + 1))
    if not len(starts):
        return np.empty((0, 3)), np.empty((0, 3))
    return np.minimum.reduceat(skin.low[order], starts), np.maximum.reduceat(skin.high[order], starts)


def near_boxes(
    low_a: Float,
    high_a: Float,
    low_b: Float,
    high_b: Float,
    axis: int,
    gap: float,
    apart: tuple[Bool, Bool] | None = None,
) -> Int:
    """(m, 2) pairs of boxes within ``gap`` of each other; ``low_b`` is sorted along ``axis``.

    Boxes that are both marked in ``apart``, of a and of b, are no pair.
    """
    widest = (high_b[:, axis] - low_b[:, axis]).max(initial=0.0)
    first = np.searchsorted(low_b[:, axis], low_a[:, axis] - widest - gap)
    in_a, in_b = (np.zeros(len(low_a), bool), np.zeros(len(low_b), bool)) if apart is None else apart
    out = np.empty((max(256, 4 * len(low_a)), 2), dtype=np.int64)
    found = _near(low_a, high_a, low_b, high_b, first, axis, gap, in_a, in_b, out)
    if found > len(out):  # once more, with room for all
        out = np.empty((found, 2), dtype=np.int64)
        _near(low_a, high_a, low_b, high_b, first, axis, gap, in_a, in_b, out)
    return out[:found]


@compiled
@lean
def _near(
    low_a: Float,
    high_a: Float,
    low_b: Float,
    high_b: Float,
    first: Int,
    axis: int,
    gap: float,
    marked_a: Bool,
    marked_b: Bool,
    out: Int,
) -> int:
    """Write the pairs into ``out`` (n, 2), as many as it has room for; returns how many there are."""
    found = 0
    for i in range(len(low_a)):
        for j in range(first[i], len(low_b)):
            if low_b[j, axis] > high_a[i, axis] + gap:
                break
            apart = marked_a[i] and marked_b[j]
            for k in range(3):
                apart = apart or low_b[j, k] > high_a[i, k] + gap or high_b[j, k] < low_a[i, k] - gap
            if apart:
                continue
            if found < len(out):
                out[found, 0] = i
                out[found, 1] = j
            found += 1
    return found
