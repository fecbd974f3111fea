"""Whether solids overlap, how deep, and how far apart they are: independent of the search for contact patches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np
from scipy.spatial import cKDTree

from holdfast.base.archive import archived
from holdfast.base.arrays import Float
from holdfast.base.values import Value
from holdfast.contacts.detect import Tolerances, neighbours
from holdfast.contacts.skin import near_boxes
from holdfast.geometry.distance import distance_to_surface, nearest_of, winding_number
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

MOST_DISTANCES = 3_000_000  # corner-to-triangle distances worth taking: about a second
MOST_ANGLES = 5_000_000  # solid angles worth summing: about a quarter of one


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Overlap(Value):
    """Two bodies that share volume; ``depth`` [m] is how deep one is in the other.

    ``tolerance`` [m] is the gap of the pair: up to twice that the overlap is a "warning", beyond it an "error" of the
    poses or the meshes. ``estimated``: a surface does not close, and the depth is that of the deepest vertex.
    """

    bodies: tuple[str, str]
    depth: float
    tolerance: float
    estimated: bool = False

    @property
    def severity(self) -> Literal["warning", "error"]:
        """How far beyond the tolerance."""
        return "warning" if self.depth <= 2 * self.tolerance else "error"


def solid_of(body: Body) -> manifold3d.Manifold | None:
    """The body as a closed solid in the world; None where its surface does not close."""
    surface = body.reduced_world
    vertices, faces = np.array(surface.vertices, order="C"), surface.faces.astype(np.uint64, order="C")
    solid = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces))
    return None if solid.status() != manifold3d.Error.NoError or solid.is_empty() else solid


def find_overlaps(scene: Scene, tolerances: Tolerances) -> tuple[Overlap, ...]:
    """Pairs, not both fixed, that share more than their gap tolerance in depth: independent of the contact search."""
    solids: dict[str, manifold3d.Manifold | None] = {}
    found = []
    for a, b in neighbours(scene, 0.0):
        tolerance = tolerances.between(a, b).gap
        if min(np.minimum(a.box[1], b.box[1]) - np.maximum(a.box[0], b.box[0])) < tolerance:
            continue
        for body in (a, b):
            if body.name not in solids:
                solids[body.name] = solid_of(body)
        solid_a, solid_b = solids[a.name], solids[b.name]
        estimated = solid_a is None or solid_b is None
        if solid_a is None or solid_b is None:
            depth = max(_deepest(a, b), _deepest(b, a))
        else:
            parts = (solid_a ^ solid_b).decompose()
            depth = max((_depth(part, a.reduced_world, b.reduced_world, tolerance) for part in parts), default=0.0)
        if depth > tolerance:
            found.append(Overlap((a.name, b.name), depth, tolerance, estimated))
    return tuple(found)


def _deepest(a: Body, b: Body) -> float:
    """How deep the deepest corner of a lies inside b [m], by winding number: for surfaces that do not close."""
    corners = a.surface_world.vertices
    near = corners[((corners >= b.box[0]) & (corners <= b.box[1])).all(1)]
    surface = b.surface_world
    near = near[:: max(1, len(near) * len(surface.faces) // MOST_ANGLES)]
    if not len(near) or not surface.oriented:
        return 0.0
    inside = near[winding_number(near, surface) > 0.5]
    return float(distance_to_surface(inside, surface).max()) if len(inside) else 0.0


def distance(a: Body, b: Body, search: float) -> float | None:
    """Smallest distance of two bodies [m], 0 where they meet; None beyond ``search``.

    Exact for closed surfaces. Where one is open, the least distance of the corners of either to the other: never too
    small.
    """
    corners = cKDTree(b.surface_world.vertices).query(a.surface_world.vertices)[0]
    reach = min(search, 1.001 * float(np.min(corners)) + 1e-9 * min(a.size, b.size))  # the solids are no further apart
    solid_a, solid_b = solid_of(a), solid_of(b)
    if solid_a is not None and solid_b is not None:
        gap = float(solid_a.min_gap(solid_b, reach))
    else:
        gap = min(_corner_distance(a, b, reach), _corner_distance(b, a, reach))
    return gap if gap < search else None


def _corner_distance(a: Body, b: Body, search: float) -> float:
    """Least distance of the corners of a to b [m], infinite beyond ``search``."""
    surface, corners = b.surface_world, a.surface_world.vertices
    triangles = surface.vertices[surface.faces]
    low, high = triangles.min(1), triangles.max(1)
    near = corners[((corners >= low.min(0) - search) & (corners <= high.max(0) + search)).all(1)]
    around = np.flatnonzero(((high >= corners.min(0) - search) & (low <= corners.max(0) + search)).all(1))
    if not len(near) or not len(around):
        return np.inf
    around = around[np.argsort(low[around, 0], kind="stable")]
    pairs = near_boxes(near, near, low[around], high[around], 0, search)
    return float(np.sqrt(nearest_of(near, triangles[around], pairs))) if len(pairs) else np.inf


def _depth(part: manifold3d.Manifold, a: Surface, b: Surface, enough: float) -> float:
    """How deep two solids are in each other where they share a part [m], exactly only where that is ``enough``.

    The deepest corner of the part under either surface, but no more than the part's width and no less than twice its
    volume over its area: the first is exact for slabs and shells, the last holds where a rod runs through a plate.
    """
    mesh = part.to_mesh64()
    shared = Surface(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64))
    directions: Float = np.unique(np.round(shared.normals, 6), axis=0)
    width = float(np.ptp(shared.vertices @ directions.T, axis=0).min())
    if width <= enough:
        return width
    mean = 2 * float(part.volume()) / max(float(part.surface_area()), 1e-300)
    low, high = shared.vertices.min(0), shared.vertices.max(0)
    deepest = 0.0
    for surface in (a, b):
        corners = surface.vertices[surface.faces]
        close = ((corners.max(1) >= low - width) & (corners.min(1) <= high + width)).all(1)
        if close.any():
            nearby = Surface(surface.vertices, surface.faces[close])
            vertices = shared.vertices[:: max(1, len(shared.vertices) * int(close.sum()) // MOST_DISTANCES)]
            deepest = max(deepest, float(distance_to_surface(vertices, nearby).max()))
    return max(min(width, deepest), mean)
