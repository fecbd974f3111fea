"""Closed surfaces as solids (manifold3d), for unions, intersections and simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from holdfast.base.arrays import Float, Int

if TYPE_CHECKING:
    import manifold3d


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
