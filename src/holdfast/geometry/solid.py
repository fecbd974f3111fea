"""Closed surfaces as solids (manifold3d), and closed parts of a mesh that share edges or overlap, made one solid.

Unions know the origin of each triangle.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from holdfast.base.arrays import Bool, Float, Int, unit
from holdfast.base.ranges import COORDINATES
from holdfast.base.values import Value, seal
from holdfast.geometry.triangles import Edges

if TYPE_CHECKING:
    import manifold3d

SAME_ANGLE = 1e-6  # [rad] faces around an edge that are closer than this lie on each other
NEEDLE = 1e-9  # height over length of a triangle; for a thinner one the direction across its edge is undefined


def closed_solid(vertices: Float, faces: Int) -> manifold3d.Manifold | None:
    """Return the solid with the surface ``vertices`` (V, 3) [m] and ``faces`` (F, 3); None if that is not closed.

    Faces are wound outward. Every call of manifold3d with a mesh is here: an open mesh may end the process in there.
    """
    import manifold3d

    if not _closed(faces):
        return None
    mesh = manifold3d.Mesh64(np.array(vertices, order="C"), np.array(faces, dtype=np.uint64, order="C"))
    solid = manifold3d.Manifold(mesh)
    return None if solid.status() != manifold3d.Error.NoError or solid.is_empty() else solid


def _closed(faces: Int) -> bool:
    """Tell whether the three sides of each face are edges, each with one other face that runs along it backwards.

    Vertices at the same place are different ones here, as they are in manifold3d.
    """
    if not len(faces):
        return False
    begin, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(faces.max()) + 1
    ways = np.sort(begin * count + end)
    return bool((begin != end).all() and (ways[1:] != ways[:-1]).all() and (ways == np.sort(end * count + begin)).all())


def hull_solid(points: Float) -> manifold3d.Manifold:
    """Return the convex hull of points (n, 3) [m] as a solid."""
    import manifold3d

    return manifold3d.Manifold.hull_points(np.array(points, order="C"))


@dataclass(frozen=True, eq=False, repr=False)
class United(Value):
    """The union of several solids, with the surface ``vertices`` (V, 3) [m] and ``faces`` (F, 3).

    ``part`` (F,) is the number of the solid on whose surface each triangle lies, and ``shared`` [m³] is the volume of
    all solids together less that of the union.
    """

    vertices: Float
    faces: Int
    part: Int
    shared: float

    def __post_init__(self) -> None:
        seal(self)


def united(solids: Sequence[tuple[Float, Int]]) -> United | None:
    """Return the union of closed surfaces, each given by its vertices (V, 3) [m] and faces (F, 3) wound outward.

    They may overlap, touch or lie apart. Of equal surfaces only the first is used, because coincident ones are the
    slowest. Returns None if one of them is not closed.
    """
    import manifold3d

    keys = [(vertices.tobytes(), faces.tobytes()) for vertices, faces in solids]
    first = {key: k for k, key in reversed([*enumerate(keys)])}
    kept = sorted(first.values())
    closed = [closed_solid(*solids[k]) for k in kept]
    made = [solid.as_original() for solid in closed if solid is not None]
    if len(made) < len(kept):
        return None
    whole = manifold3d.Manifold.batch_boolean(made, manifold3d.OpType.Add)
    if whole.status() != manifold3d.Error.NoError or whole.is_empty():
        return None
    mesh = whole.to_mesh64()
    number = {solid.original_id(): k for k, solid in zip(kept, made, strict=True)}
    often = Counter(keys)
    ends = np.asarray(mesh.run_index, dtype=np.int64) // 3
    part = np.repeat([number[int(key)] for key in mesh.run_original_id], np.diff(ends))
    shared = sum(often[keys[k]] * solid.volume() for k, solid in zip(kept, made, strict=True)) - whole.volume()
    return United(
        np.array(mesh.vert_properties[:, :3]),
        np.array(mesh.tri_verts, dtype=np.int64),
        np.asarray(part, dtype=np.int64),
        max(float(shared), 0.0),
    )


def parts_as_given(faces: Int, merged: Int) -> tuple[Int, Int] | None:
    """Weld vertices only within parts, that is, among faces that the vertex numbers of ``faces`` (F, 3) connect.

    ``merged`` (F, 3) are the same faces after all vertices at the same place were merged. Returns, for each new vertex,
    the number (n,) of its merged vertex, and the faces (m, 3) over the new vertices. Returns None if an edge then has
    other than two faces.
    """
    _, label = _connected(int(faces.max()) + 1, faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())
    keys, numbers = np.unique(label[faces[:, :1]] * (int(merged.max()) + 1) + merged, return_inverse=True)
    numbers = numbers.reshape(faces.shape)
    numbers = numbers[_distinct(np.sort(numbers, axis=1))]
    closed = len(numbers) > 0 and bool((Edges.of(numbers, len(keys)).shared == 2).all())
    return (keys % (int(merged.max()) + 1), numbers) if closed else None


def parts_by_winding(points: Float, faces: Int) -> tuple[Int, Int] | None:
    """Split the vertices of a mesh where more than two faces meet at an edge, so that each edge has two faces.

    Around an edge, the two faces that bound the same wedge of solid stay together; the winding of a face tells which of
    its sides is solid. No two of the ``points`` (V, 3) are at the same place. Returns, for each new vertex, the number
    (n,) of its point, and the faces (m, 3) over the new vertices. Returns None if the winding is not consistent or if
    solids overlap at an edge.
    """
    first = faces.argmin(1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    faces = faces[_distinct(faces)]  # of coincident faces, two with opposite winding remain
    corners = points[faces] - points.mean(0)
    if np.linalg.det(corners).sum() < 0:
        faces = faces[:, ::-1]
    edges = Edges.of(faces, len(points))
    # (3F,) whether each side runs along its edge, and not against it
    forward = faces.ravel() == edges.ends[edges.of_face.ravel(), 0]
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
    count, number = _connected(3 * len(faces), starts, ends)  # corners that belong to the same vertex
    origin = np.empty(count, dtype=np.int64)
    origin[number] = faces.ravel()
    return origin, number.reshape(-1, 3)


def _following(sides: Int) -> Int:
    """Return the next side, or corner, of the same face."""
    following: Int = sides - sides % 3 + (sides + 1) % 3
    return following


def _wedges(ends: Float, thirds: Float, leaves: Bool) -> Int | None:
    """Pair the n faces around an edge with ``ends`` (2, 3), so that there is solid between the faces of each pair.

    ``thirds`` (n, 3) are the corners opposite the edge. Going counter-clockwise around the edge, one leaves solid at a
    face for which ``leaves`` (n,) is true, and enters solid at the others. Returns rows (n / 2, 2) of numbers of faces,
    or None if the faces cannot be paired.
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
    # of coincident faces, those at which one leaves solid come first
    order = order[np.lexsort((~leaves[order], group))]
    order = np.roll(order, -int(np.argmin(leaves[order])))
    if leaves[order[::2]].any() or not leaves[order[1::2]].all():
        return None
    return np.asarray(order.reshape(-1, 2), dtype=np.int64)


def joined(vertices: Float, faces: Int) -> tuple[Float, Int, int, float] | None:
    """Join the closed parts of a mesh that share faces or overlap to one solid; None if there are no such parts.

    Returns the vertices (V, 3) [m] and faces (F, 3) of the solid, the number of parts that meet others, and the volume
    [m³] of all parts together less that of the solid.

    Every edge must have two faces, parts must be wound outward and cavities inward. Parts that meet only at edges or
    vertices are not joined.
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
    made = []
    for shell, out in zip(shells, outer, strict=True):
        used, numbers = np.unique(shell if out else shell[:, ::-1], return_inverse=True)
        solid = closed_solid(vertices[used], numbers.reshape(-1, 3))
        if solid is None:
            return None
        made.append(solid)
    solids = [made[k] for k in np.flatnonzero(outer)]
    for k in np.flatnonzero(~outer):
        around = np.flatnonzero(((low < boxes[k, 0]) & (boxes[k, 1] < high)).all(1))
        if not len(around):
            return None
        holder = around[np.argmin((high[around] - low[around]).prod(1))]
        hollow = solids[holder] - made[k]
        if hollow.volume() > solids[holder].volume() - (1 - COORDINATES) * made[k].volume():  # it is not inside
            return None
        solids[holder] = hollow
    whole = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if whole.status() != manifold3d.Error.NoError:
        return None
    if whole.surface_area() >= (1 - COORDINATES) * sum(solid.surface_area() for solid in solids):
        return None
    mesh = whole.to_mesh64()
    volume = sum(solid.volume() for solid in solids)
    shared = max(volume - whole.volume(), 0.0)
    return (
        np.array(mesh.vert_properties[:, :3]),
        np.array(mesh.tri_verts, dtype=np.int64),
        int(meets.any(1).sum()),
        shared if shared > COORDINATES * volume else 0.0,
    )


def _connected(count: int, one: Int, other: Int) -> tuple[int, Int]:
    """Return the number of components of ``count`` items with links ``one`` - ``other`` (n,), and that of each item."""
    from scipy.sparse import coo_matrix  # only here, as it takes long to import
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
    groups, label = connected_components(graph, directed=False)
    return int(groups), label.astype(np.int64)


def _distinct(faces: Int) -> Bool:
    """Tell which faces (F,) have three different vertices and do not repeat an earlier face."""
    proper = (faces != np.roll(faces, -1, axis=1)).all(1)
    unique = np.zeros(len(faces), dtype=bool)
    unique[np.unique(faces, axis=0, return_index=True)[1]] = True
    return np.asarray(proper & unique)
