"""Closed surfaces as solids (manifold3d): unions with the origin of each triangle, intersections, simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from holdfast.base.arrays import Float, Int

if TYPE_CHECKING:
    import manifold3d


from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from holdfast.base.values import Value, seal


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
