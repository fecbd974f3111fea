"""The normals of what touches a plane face of one body, which is known better than those of a scan on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.base.arrays import Float
from holdfast.contacts.clipping import Piece
from holdfast.contacts.features import Features
from holdfast.contacts.patches import SAME_WAY
from holdfast.contacts.tolerances import SIGMAS, Tolerances
from holdfast.geometry.distance import distance_to_surface
from holdfast.geometry.facets import COPLANAR
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.shapes import Mesh


def pieces_on_planes(a: Body, b: Body, pieces: list[Piece], tolerances: Tolerances) -> list[Piece]:
    """Return the pieces where two bodies touch; beside a scan, those on a plane face of the other have its normal."""
    if not pieces or _scanned(a) == _scanned(b):
        return pieces
    rings = [piece.rings[0] for piece in pieces]
    normals = _on_planes(a, b, np.array([piece.normal for piece in pieces]), rings, tolerances)
    return [replace(piece, normal=normal) for piece, normal in zip(pieces, normals, strict=True)]


def features_on_planes(
    a: Body, b: Body, lines: Features, points: Features, tolerances: Tolerances
) -> tuple[Features, Features]:
    """Return touching edges and corners; beside a scan, those on a plane face of the other body have its normal."""
    count = len(lines.normals)
    if not count + len(points.normals) or _scanned(a) == _scanned(b):
        return lines, points
    both, ends = np.concatenate([lines.normals, points.normals]), np.concatenate([lines.ends, points.ends])
    normals = _on_planes(a, b, both, ends, tolerances)
    return replace(lines, normals=normals[:count]), replace(points, normals=normals[count:])


def _scanned(body: Body) -> bool:
    """Tell whether the surface of a body is measured: a rough mesh, or planes fitted to one with noise."""
    shapes = [part.shape for part in body.shape.parts] if isinstance(body.shape, Compound) else [body.shape]
    fitted = any(isinstance(shape, Mesh) and shape.noise > 0 for shape in shapes)
    return fitted or body.shape.surface.roughness.slope > 0


def _on_planes(a: Body, b: Body, normals: Float, rings: Sequence[Float] | Float, tolerances: Tolerances) -> Float:
    """Return normals (n, 3), from a to b: that of a plane face of the exact body for each of the ``rings`` on it."""
    # A corner, an edge or a face that touches a plane presses along the normal of the plane. The normals of a scan
    # scatter by degrees about it, and contacts tilted against each other wedge: they seem to hold more than μ N.
    body, other, outward = (a, b, 1.0) if _scanned(b) else (b, a, -1.0)
    scatter = SIGMAS * float(np.sqrt(2)) * other.shape.surface.roughness.slope  # √2 slope: of a facet about each axis
    best = np.full(len(normals), max(SAME_WAY, np.cos(max(scatter, np.radians(tolerances.angle)))))
    local, world = body.shape.surface.reduced, body.reduced_world
    gap, corners = tolerances.gap, np.vstack(list(rings))
    starts = np.cumsum([0, *(len(ring) for ring in rings[:-1])])
    triangles = world.vertices[world.faces]
    near = (triangles.max(1) >= corners.min(0) - gap) & (triangles.min(1) <= corners.max(0) + gap)
    faces, region, found = np.flatnonzero(near.all(1) & ~local.curved), local.topology.regions(COPLANAR), normals.copy()
    for number, first in zip(*np.unique(region[faces], return_index=True), strict=True):
        way = outward * world.normals[faces[first]]
        along = normals @ way
        if (along > best).any():
            away = distance_to_surface(corners, replace(world, faces=world.faces[region == number]))
            mine = (along > best) & (np.maximum.reduceat(away, starts) <= gap)
            found[mine], best[mine] = way, along[mine]
    return found
