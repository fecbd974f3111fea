"""Whether solids overlap, how deep, and how far apart they are: independent of the search for contact patches."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np

from holdfast.arrays import Float
from holdfast.contacts.detect import neighbours
from holdfast.scene.body import Body
from holdfast.scene.distance import distance_to_surface
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Surface

MOST_DISTANCES = 30_000_000  # corner-to-triangle distances worth taking: about a second


@dataclass(frozen=True)
class Overlap:
    """Two bodies that share volume; ``depth`` [m] is its thickness across the thinnest direction."""

    bodies: tuple[str, str]
    depth: float


def solid_of(body: Body) -> manifold3d.Manifold | None:
    """The body as a closed solid in the world; None where its surface does not close."""
    surface = body.surface_world
    vertices, faces = np.array(surface.vertices, order="C"), surface.faces.astype(np.uint64, order="C")
    solid = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces))
    return None if solid.status() != manifold3d.Error.NoError or solid.is_empty() else solid


def find_overlaps(scene: Scene, tolerance: float) -> tuple[Overlap, ...]:
    """Pairs, not both fixed, whose solids share more than ``tolerance`` [m] in depth."""
    solids: dict[str, manifold3d.Manifold | None] = {}
    found = []
    for a, b in neighbours(scene, -2 * tolerance):
        for body in (a, b):
            if body.name not in solids:
                solids[body.name] = solid_of(body)
        solid_a, solid_b = solids[a.name], solids[b.name]
        if solid_a is None or solid_b is None:
            continue
        shared = solid_a ^ solid_b
        depth = max((_thickness(part) for part in shared.decompose()), default=0.0)
        if depth > tolerance:
            found.append(Overlap((a.name, b.name), depth))
    return tuple(found)


def distance(a: Body, b: Body, search: float) -> float | None:
    """Smallest distance of two bodies [m], 0 where they meet; None beyond ``search``.

    Exact for closed surfaces. Where one is open, the least distance of the corners of either to the other: never too
    small.
    """
    solid_a, solid_b = solid_of(a), solid_of(b)
    if solid_a is not None and solid_b is not None:
        gap = float(solid_a.min_gap(solid_b, search))
    else:
        gap = min(_corner_distance(a, b, search), _corner_distance(b, a, search))
    return gap if gap < search else None


def _corner_distance(a: Body, b: Body, search: float) -> float:
    surface = b.surface_world
    low, high = surface.vertices.min(0) - search, surface.vertices.max(0) + search
    corners = a.surface_world.vertices
    near = corners[((corners >= low) & (corners <= high)).all(1)]
    if not len(near):
        return np.inf
    stride = max(1, len(near) * len(surface.faces) // MOST_DISTANCES)
    return float(distance_to_surface(near[::stride], surface).min())


def _thickness(part: manifold3d.Manifold) -> float:
    mesh = part.to_mesh64()
    surface = Surface(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64))
    directions: Float = np.unique(np.round(surface.normals, 6), axis=0)
    return float(np.ptp(surface.vertices @ directions.T, axis=0).min())
