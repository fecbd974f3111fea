"""Closed surfaces as solids (manifold3d), for unions, intersections and simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from holdfast.base.arrays import Float, Int

if TYPE_CHECKING:
    import manifold3d


def closed_solid(vertices: Float, faces: Int) -> manifold3d.Manifold | None:
    """Return the solid with the surface ``vertices`` (V, 3) [m] and ``faces`` (F, 3); None if that is not closed.

    Faces are wound outward.
    """
    import manifold3d

    mesh = manifold3d.Mesh64(np.array(vertices, order="C"), np.array(faces, dtype=np.uint64, order="C"))
    solid = manifold3d.Manifold(mesh)
    return None if solid.status() != manifold3d.Error.NoError or solid.is_empty() else solid


def hull_solid(points: Float) -> manifold3d.Manifold:
    """Return the convex hull of points (n, 3) [m] as a solid."""
    import manifold3d

    return manifold3d.Manifold.hull_points(np.array(points, order="C"))
