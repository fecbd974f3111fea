"""Closed parts of a mesh that touch or overlap: told apart at the edges they share, and joined to one solid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from holdfast.base.arrays import Bool, Float, Int, unit
from holdfast.base.values import Value, seal
from holdfast.geometry.topology import Edges

if TYPE_CHECKING:
    import manifold3d

SAME_ANGLE = 1e-6  # [rad] faces around an edge that are closer than this lie on each other
NEEDLE = 1e-9  # height of a triangle over its length below which its direction across an edge is not known
LEAST_SHARE = 1e-9  # of areas and volumes: smaller differences are rounding


@dataclass(frozen=True, eq=False, repr=False)
class Joined(Value):
    """One solid made of several closed parts.

    ``vertices`` (V, 3) [m] and ``faces`` (F, 3) bound it; ``parts`` of those given met others; ``shared`` [m³] is
    how much less volume it has than all parts together.
    """

    vertices: Float
    faces: Int
    parts: int
    shared: float

    def __post_init__(self) -> None:
        seal(self)


def parts_as_given(faces: Int, merged: Int) -> tuple[Int, Int] | None:
    """Weld a mesh within its parts only, which are what the vertex numbers of ``faces`` (F, 3) hold together.

    ``merged`` (F, 3) are the same faces after vertices at the same place were made one. Returns which of these each new
    vertex is (n,) and the faces (m, 3) over new vertices, or None if not every edge then has two faces.
    """
    _, label = _connected(int(faces.max()) + 1, faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())
    keys, numbers = np.unique(label[faces[:, :1]] * (int(merged.max()) + 1) + merged, return_inverse=True)
    numbers = numbers.reshape(faces.shape)
    numbers = numbers[_distinct(np.sort(numbers, axis=1))]
    closed = len(numbers) > 0 and bool((Edges.of(numbers, len(keys)).shared == 2).all())
    return (keys % (int(merged.max()) + 1), numbers) if closed else None


def parts_by_winding(points: Float, faces: Int) -> tuple[Int, Int] | None:
    """Split the vertices of a mesh where more than two faces meet at an edge, so that each edge has two faces.

    Around an edge, the two faces stay together that bound the same wedge of solid; which side of a face is solid is
    told by its winding. ``points`` (V, 3) and ``faces`` (F, 3) have no two vertices at the same place. Returns which of
    ``points`` each new vertex is (n,) and the faces (m, 3) over new vertices, or None if the faces are not wound alike
    or solids overlap at an edge.
    """
    first = faces.argmin(1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    faces = faces[_distinct(faces)]  # two faces on each other remain if they are wound in opposite senses
    corners = points[faces] - points.mean(0)
    if np.linalg.det(corners).sum() < 0:
        faces = faces[:, ::-1]
    edges = Edges.of(faces, len(points))
    forward = faces.ravel() == edges.ends[edges.of_face.ravel(), 0]  # (3F,) by side
    if (2 * np.bincount(edges.of_face.ravel(), weights=forward) != edges.shared).any():
        return None
    simple = edges.first[edges.shared == 2]
    pairs = [np.column_stack([edges.sides[simple], edges.sides[simple + 1]])]
    for edge in np.flatnonzero(edges.shared > 2):
        sides = edges.sides[edges.first[edge] : edges.first[edge] + edges.shared[edge]]
        thirds = faces.ravel()[_following(_following(sides))]
        order = _wedges(points[edges.ends[edge]], points[thirds], forward[sides])
        if order is None:
            return None
        pairs.append(sides[order])
    one, other = np.concatenate(pairs).T
    starts, ends = np.concatenate([one, _following(one)]), np.concatenate([_following(other), other])
    count, number = _connected(3 * len(faces), starts, ends)  # corners of faces that are one vertex
    origin = np.empty(count, dtype=np.int64)
    origin[number] = faces.ravel()
    return origin, number.reshape(-1, 3)


def _following(sides: Int) -> Int:
    """The next side, or corner, of the same face."""
    following: Int = sides - sides % 3 + (sides + 1) % 3
    return following


def _wedges(ends: Float, thirds: Float, leaves: Bool) -> Int | None:
    """Pair the n faces around an edge with ``ends`` (2, 3), each pair with solid between them; None if that fails.

    ``thirds`` (n, 3) are the corners opposite the edge. Counter-clockwise around the edge, a face that ``leaves`` (n,)
    has solid before it, another one has solid behind it. Returns rows (n / 2, 2) of numbers of faces.
    """
    along = unit(ends[1] - ends[0])
    arms = thirds - ends[0]
    length = np.linalg.norm(arms, axis=1)
    arms = arms - np.outer(arms @ along, along)
    if (np.linalg.norm(arms, axis=1) <= NEEDLE * length).any():
        return None
    ahead = unit(arms[0])
    angle = np.arctan2(arms @ np.cross(along, ahead), arms @ ahead) % (2 * np.pi)
    angle[angle > 2 * np.pi - SAME_ANGLE] -= 2 * np.pi
    order = np.argsort(angle, kind="stable")
    group = np.cumsum(np.diff(angle[order], prepend=angle[order[0]]) > SAME_ANGLE)
    order = order[np.lexsort((~leaves[order], group))]  # of faces on each other, those that leave a solid come first
    order = np.roll(order, -int(np.argmin(leaves[order])))
    if leaves[order[::2]].any() or not leaves[order[1::2]].all():
        return None
    return np.asarray(order.reshape(-1, 2), dtype=np.int64)


def joined(vertices: Float, faces: Int) -> Joined | None:
    """Join the closed parts of a mesh that have faces in common or overlap; None if there are no such parts.

    Every edge has two faces. Parts are wound outward, and cavities inward. Parts that meet at edges or vertices only
    are not joined.
    """
    import manifold3d

    edges = Edges.of(faces, len(vertices))
    one, other = edges.sides[edges.first] // 3, edges.sides[edges.first + 1] // 3
    count, label = _connected(len(faces), one, other)  # parts may have vertices in common
    if count < 2:
        return None
    shells = [faces[label == k] for k in range(count)]
    boxes = np.array([(vertices[shell].min((0, 1)), vertices[shell].max((0, 1))) for shell in shells])
    outer = np.array([np.linalg.det(vertices[s] - vertices[s].mean((0, 1))).sum() >= 0 for s in shells])
    low, high = boxes[outer, 0], boxes[outer, 1]
    meets = ((low[:, None] <= high) & (low <= high[:, None])).all(2)
    np.fill_diagonal(meets, val=False)
    if not meets.any():
        return None
    solids = [_solid(vertices, shells[k]) for k in np.flatnonzero(outer)]
    for k in np.flatnonzero(~outer):
        around = np.flatnonzero(((low < boxes[k, 0]) & (boxes[k, 1] < high)).all(1))
        if not len(around):
            return None
        holder = around[np.argmin((high[around] - low[around]).prod(1))]
        cavity = _solid(vertices, shells[k][:, ::-1])
        hollow = solids[holder] - cavity
        if hollow.volume() > solids[holder].volume() - (1 - LEAST_SHARE) * cavity.volume():  # it is not inside
            return None
        solids[holder] = hollow
    whole = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if whole.status() != manifold3d.Error.NoError or any(solid.is_empty() for solid in solids):
        return None
    if whole.surface_area() >= (1 - LEAST_SHARE) * sum(solid.surface_area() for solid in solids):
        return None
    mesh = whole.to_mesh64()
    volume = sum(solid.volume() for solid in solids)
    shared = max(volume - whole.volume(), 0.0)
    return Joined(
        np.array(mesh.vert_properties[:, :3]),
        np.array(mesh.tri_verts, dtype=np.int64),
        int(meets.any(1).sum()),
        shared if shared > LEAST_SHARE * volume else 0.0,
    )


def _solid(vertices: Float, faces: Int) -> manifold3d.Manifold:
    import manifold3d

    used, numbers = np.unique(faces, return_inverse=True)
    mesh = manifold3d.Mesh64(np.array(vertices[used], order="C"), numbers.reshape(-1, 3).astype(np.uint64))
    return manifold3d.Manifold(mesh)


def _connected(count: int, one: Int, other: Int) -> tuple[int, Int]:
    """Return how many groups links from ``one`` to ``other`` (n,) make of ``count`` things, and the group of each."""
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
    groups, label = connected_components(graph, directed=False)
    return int(groups), label.astype(np.int64)


def _distinct(faces: Int) -> Bool:
    """(F,) which rows of three vertex numbers name three vertices and are not those of an earlier row."""
    proper = (faces != np.roll(faces, -1, axis=1)).all(1)
    unique = np.zeros(len(faces), dtype=bool)
    unique[np.unique(faces, axis=0, return_index=True)[1]] = True
    return np.asarray(proper & unique)
