"""The way out of an overlap: how far one of two solids must be moved to leave the other."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from holdfast.base.arrays import Float
from holdfast.geometry.distance import distance_to_surface
from holdfast.geometry.surface import Surface

if TYPE_CHECKING:
    import manifold3d

MOST_DISTANCES = 3_000_000  # largest number of distances from corners to triangles; they take about 1 s
MOST_WAYS = 60  # directions that are tried as ways out of a solid that is not convex; each takes about a millisecond
NEARLY = 1e-3  # relative error of a way out that is found by trying
ROUNDING = 1e-9  # relative error of volumes and of supports
SHRUNK = 100 * ROUNDING  # share by which the second of two solids is shrunk


def way_out(a: manifold3d.Manifold, b: manifold3d.Manifold, of_a: Surface, of_b: Surface, *, enough: float) -> float:
    """Return the longest of the ways out of the parts that two solids share [m]; 0 if none is longer than ``enough``.

    ``of_a`` and ``of_b`` are their surfaces.
    """
    found = 0.0
    for part in (a ^ _shrunk(b)).decompose():
        shared = _surface(part)
        width = float(np.ptp(shared.vertices @ np.unique(np.round(shared.normals, 6), axis=0).T, axis=0).min())
        if width > enough or _least(part, of_a, of_b) > enough:
            found = max(found, _way_out(shared, a, b))
    return found if found > enough else 0.0


def _shrunk(solid: manifold3d.Manifold) -> manifold3d.Manifold:
    """Return a solid that is a little smaller: faces that lie on each other would share parts without a volume."""
    low, high = np.array(solid.bounding_box()).reshape(2, 3)
    middle = (low + high) / 2
    return solid.translate(-middle).scale(np.full(3, 1 - SHRUNK)).translate(middle)


def _convex(solid: manifold3d.Manifold) -> bool:
    return float(solid.hull().volume()) <= (1 + ROUNDING) * float(solid.volume())


def _surface(solid: manifold3d.Manifold) -> Surface:
    mesh = solid.to_mesh64()
    return Surface(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64))


def _least(part: manifold3d.Manifold, a: Surface, b: Surface) -> float:
    """Return a lower bound of the way out of the ``part`` that two solids share [m]: how deep its points are in either.

    The points are its corners and, as a rod through a plate has all of these on both surfaces, the middle of a convex
    part.
    """
    points = _surface(part).vertices
    low, high = points.min(0), points.max(0)
    far, deepest = float(np.linalg.norm(high - low)), 0.0
    points = np.vstack([points, points.mean(0)]) if _convex(part) else points
    for surface in (a, b):
        corners = surface.vertices[surface.faces]
        close = ((corners.max(1) >= low - far) & (corners.min(1) <= high + far)).all(1)
        nearby = Surface(surface.vertices, surface.faces[close] if close.any() else surface.faces)
        some = points[:: -max(1, len(points) * len(nearby.faces) // MOST_DISTANCES)]
        deepest = max(deepest, float(distance_to_surface(some, nearby).max()))
    return deepest


def _way_out(part: Surface, a: manifold3d.Manifold, b: manifold3d.Manifold) -> float:
    """Return how far one of two solids must be moved to leave the other where they share a ``part`` [m].

    It is that of their hulls, exact for convex solids, or else a shorter one along a normal of the part, which then
    counts alone.
    """
    found = _apart(_surface(a.hull()), _surface(b.hull()))
    if _convex(a) and _convex(b):
        return found
    normals = np.unique(np.round(part.normals, 6), axis=0)
    ways = np.vstack([normals, -normals])
    lengths = np.ptp(part.vertices @ ways.T, axis=0)
    for k in np.argsort(lengths, kind="stable")[:MOST_WAYS].tolist():
        found = min(found, _length(ways[k], float(lengths[k]), part, a, b, found))
    return found


def _length(
    way: Float, length: float, part: Surface, a: manifold3d.Manifold, b: manifold3d.Manifold, most: float
) -> float:
    """Return how far b must go along ``way`` (3,) to leave a where they share a ``part`` [m], inf from ``most`` on.

    It goes by ``length`` [m] at first, and then on by the extent of what is still shared near the part.
    """
    low, high = part.vertices.min(0), part.vertices.max(0)
    while length < most:
        left = [_surface(solid).vertices for solid in (a ^ _shrunk(b.translate(length * way))).decompose()]
        near = [own for own in left if (own.max(0) >= low - length).all() and (own.min(0) <= high + length).all()]
        further = max((float(np.ptp(own @ way)) for own in near), default=0.0)
        if further <= NEARLY * length:
            return length
        length += further
    return np.inf


def _apart(one: Surface, other: Surface) -> float:
    """Return the least translation [m] that separates two convex solids which overlap.

    It is the distance of 0 from the boundary of the hull of all differences of their points. A polytope inside that
    hull is extended where it is nearest to 0 until its nearest face is one of the hull (van den Bergen 2001).
    """

    def farthest(ways: Float) -> Float:
        ends = (one.vertices @ ways.T).argmax(0), (other.vertices @ ways.T).argmin(0)
        return np.asarray(one.vertices[ends[0]] - other.vertices[ends[1]])

    axes: Float = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    known = farthest(np.vstack([axes, one.normals[:MOST_WAYS], -other.normals[:MOST_WAYS]]))
    while True:
        faces = ConvexHull(known, qhull_options="QJ Pp").equations
        faces = faces[np.argsort(-faces[:, 3])[:MOST_WAYS]]
        beyond = farthest(faces[:, :3])
        depth = max(float(-faces[0, 3]), 0.0)
        if float(beyond[0] @ faces[0, :3]) - depth <= NEARLY**2 * depth + ROUNDING * float(np.abs(known).max()):
            return depth
        known = np.vstack([known, beyond])
