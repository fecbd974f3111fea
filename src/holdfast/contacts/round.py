"""Exact contact of balls, capsules and ellipsoids with flat faces: where their surface comes nearest to the plane.

Found on tessellated surfaces, such a contact lies at the nearest vertex, up to half an edge from where it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import tangents
from holdfast.contacts.interface import Patch
from holdfast.contacts.skin import SMOOTH
from holdfast.geometry.facets import COPLANAR
from holdfast.geometry.topology import FLAT
from holdfast.scene.body import Body
from holdfast.scene.round import Round, round_of

ALIKE = float(np.cos(np.radians(20)))  # cosine of the angle between normals of patches that may stand for one contact
ROUNDING = 1e-9  # of a face's size: how far beyond its outline a point may lie


@dataclass(frozen=True, eq=False)
class Foot:
    """Where a round body comes nearest to a flat face, within the tolerance.

    ``ends`` (1 or 2, 3) [m] is a point or a line on the face, ``normal`` (3,) points into the second body, and
    ``heights`` (1 or 2,) [m] are the distances there, negative where the bodies overlap.
    """

    ends: Float
    normal: Float
    heights: Float

    def patch(self, breadth: float) -> Patch:
        """Return the contact, halfway between the two surfaces."""
        middle = self.ends + np.outer(self.heights / 2, self.normal)
        low, high = float(self.heights.min()), float(self.heights.max())
        return Patch(middle, self.normal, (), (low, high), breadth)


def feet(a: Body, b: Body, *, gap: float, depth: float) -> list[Foot]:
    """Find where a round body lies over a flat face of another one, at a height from ``-depth`` to ``gap`` [m].

    Faces that are part of a tessellated curved surface do not count.
    """
    found: list[Foot] = []
    for one, other, sign in ((a, b, -1.0), (b, a, 1.0)):
        shape = round_of(one.shape)
        if shape is not None and round_of(other.shape) is None:
            found += _feet(one, shape, other, sign, gap, depth)
    return found


def not_at(feet: Sequence[Foot], patches: Sequence[Patch], reach: float) -> list[Patch]:
    """Return the patches that do not stand for one of the contacts ``feet``, which they may miss by ``reach`` [m]."""
    return [patch for patch in patches if not any(_same(foot, patch, reach) for foot in feet)]


def reach_of(a: Body, b: Body, gap: float) -> float:
    """Return how far from its foot a round body may seem to touch a plane within ``gap`` [m] and its tessellation."""
    sagitta = a.shape.surface.sagitta + b.shape.surface.sagitta
    return max(shape.spread(gap + sagitta) for shape in map(round_of, (a.shape, b.shape)) if shape is not None)


def _same(foot: Foot, patch: Patch, reach: float) -> bool:
    if foot.normal @ patch.normal < ALIKE:
        return False
    start, along = foot.ends[0], foot.ends[-1] - foot.ends[0]
    arm = patch.polygon - start
    t = np.clip(arm @ along / max(float(along @ along), 1e-300), 0, 1)
    return bool(np.linalg.norm(arm - t[:, None] * along, axis=1).min() <= reach)


def _feet(body: Body, shape: Round, other: Body, sign: float, gap: float, depth: float) -> Iterator[Foot]:
    R = body.pose[:3, :3]
    along = shape.half * R[:, 2]
    centres = body.pose[:3, 3] + (np.array([-along, along]) if shape.half else np.zeros((1, 3)))
    surface, topology = other.reduced_world, other.shape.surface.reduced.topology
    normals, corners = surface.normals, surface.vertices[surface.faces]
    lowest = -(normals @ R * shape.radii**2) @ R.T / np.linalg.norm(normals @ R * shape.radii, axis=1)[:, None]
    points = centres[:, None] + lowest  # (centres, F, 3)
    heights = ((points - corners[:, 0]) * normals).sum(-1)
    near = ((heights >= -depth) & (heights <= gap)).any(0)
    box = points.min(0) - gap, points.max(0) + gap
    near &= ((corners.min(1) <= box[1]) & (corners.max(1) >= box[0])).all(1)
    if not near.any():
        return
    region = topology.regions(COPLANAR)
    for number in np.unique(region[near]):
        members = np.flatnonzero(region == number)
        face = members[np.argmax(surface.areas[members])]
        normal, at = normals[face], points[:, face]
        height = (at - corners[face, 0]) @ normal
        within = (height >= -depth) & (height <= gap)
        if not within.any():
            continue
        ends, height = at[within] - np.outer(height[within], normal), height[within]
        share = _on_face(ends, corners[members], normal)
        ends, height = (v[0] + np.multiply.outer(share, v[-1] - v[0]) for v in (ends, height))
        curved = topology.edges[_curved_rim(topology.of_face[members], topology.bend)]
        if len(ends) and _clear(ends, surface.vertices[curved], gap, shape):
            yield Foot(ends, sign * normal, height)


def _on_face(ends: Float, triangles: Float, normal: Float) -> Float:
    """Return which part of a point or a line (1 or 2, 3) lies on a face: where it begins and ends, as shares (0 to 2,).

    The face is given as triangles (n, 3, 3); across its gaps the line goes on.
    """
    frame = np.array(tangents(normal))
    origin = triangles[0, 0]
    flat = (triangles - origin) @ frame.T
    face = shapely.union_all(shapely.polygons(flat)).buffer(ROUNDING * float(np.ptp(flat.reshape(-1, 2), axis=0).max()))
    seen = (ends - origin) @ frame.T
    along = seen[-1] - seen[0]
    left = (shapely.LineString(seen) if len(seen) > 1 else shapely.Point(seen[0])).intersection(face)
    share = (shapely.get_coordinates(left) - seen[0]) @ along / max(float(along @ along), 1e-300)
    return np.unique([share.min(), share.max()]) if len(share) else share


def _curved_rim(edges: Int, bend: Float) -> Int:
    """Return those of the edges (n, 3) of a flat region at which the surface bends as a curved one does."""
    rim = np.unique(edges)
    angle = np.abs(bend[rim])
    return np.asarray(rim[(angle > FLAT) & (angle < SMOOTH)])


def _clear(ends: Float, edges: Float, gap: float, shape: Round) -> bool:
    """Tell whether a contact at ``ends`` (1 or 2, 3) keeps clear of edges (n, 2, 3) of a curved surface."""
    if not len(edges):
        return True
    lines = shapely.linestrings(edges)
    here = shapely.linestrings(ends[None]) if len(ends) > 1 else shapely.points(ends)
    flat_apart = np.asarray(shapely.distance(lines, here))  # in the plane x, y alone: never more than the distance
    return bool(flat_apart.min() > shape.spread(gap))
