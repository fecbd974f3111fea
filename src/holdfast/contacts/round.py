"""Exact contact of balls, capsules and ellipsoids with flat faces: where their surface comes nearest to the plane.

Found on tessellated surfaces, such a contact lies at the nearest vertex, up to half an edge from where it is. A part of
a compound that is round touches as a whole body would, but for what of it lies inside other parts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import tangents
from holdfast.contacts.interface import Patch
from holdfast.contacts.parts import exposed, nearest_part
from holdfast.contacts.skin import SMOOTH
from holdfast.geometry.facets import COPLANAR
from holdfast.geometry.topology import FLAT
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.round import Round, round_of

ALIKE = float(np.cos(np.radians(20)))  # cosine of the angle between normals of patches that may stand for one contact
ROUNDING = 1e-9  # of a face's size: how far beyond its outline a point may lie


class Smooth(NamedTuple):
    """A round body, or a round part of one: its ``number``, its ``shape``, and its ``pose`` (4, 4) in the world."""

    body: Body
    number: int
    shape: Round
    pose: Float


@dataclass(frozen=True, eq=False)
class Foot:
    """Where a round body or part comes nearest to a flat face, within the tolerance.

    ``ends`` (1 or 2, 3) [m] is a point or a line on the face, ``normal`` (3,) points into the second body, and
    ``heights`` (1 or 2,) [m] are the distances there, negative where the bodies overlap. ``reach`` [m] is how far from
    there its tessellation may seem to touch.
    """

    of: Smooth
    ends: Float
    normal: Float
    heights: Float
    reach: float

    def patch(self, breadth: float) -> Patch:
        """Return the contact, halfway between the two surfaces."""
        middle = self.ends + np.outer(self.heights / 2, self.normal)
        low, high = float(self.heights.min()), float(self.heights.max())
        return Patch(middle, self.normal, (), (low, high), breadth)

    def is_near(self, points: Float, normal: Float, reach: float) -> Bool:
        """Tell which points (n, 3) of a surface with this ``normal`` (3,) lie within ``reach`` [m]."""
        start, along = self.ends[0], self.ends[-1] - self.ends[0]
        arm = points - start
        t = np.clip(arm @ along / max(float(along @ along), 1e-300), 0, 1)
        near = np.linalg.norm(arm - t[:, None] * along, axis=1) <= reach
        return np.asarray(near & (float(self.normal @ normal) >= ALIKE))


def feet(a: Body, b: Body, *, gap: float, depth: float, breadth: float) -> list[Foot]:
    """Find where round bodies and parts lie over a flat face of the other body, at a height from -depth to gap [m].

    Faces that are part of a tessellated curved surface do not count. Where two parts of one body touch at the same
    place, to within ``breadth`` [m], the first one counts.
    """
    found: list[Foot] = []
    sagitta = a.shape.surface.sagitta + b.shape.surface.sagitta
    for one, other, sign in ((a, b, -1.0), (b, a, 1.0)):
        if round_of(other.shape) is None:
            for smooth in _smooth_parts(one):
                for foot in _feet(smooth, other, sign, gap, depth, smooth.shape.spread(gap + sagitta)):
                    if not any(each.is_near(foot.ends, foot.normal, breadth).all() for each in found):
                        found.append(foot)
    return found


def not_at(feet: Sequence[Foot], patches: Sequence[Patch]) -> list[Patch]:
    """Return the patches that do not stand for one of the contacts ``feet``: near it, and on the same round part."""
    return [patch for patch in patches if not any(_stands_for(patch, foot) for foot in feet)]


def _stands_for(patch: Patch, foot: Foot) -> bool:
    if not foot.is_near(patch.polygon, patch.normal, foot.reach).any():
        return False
    return bool((nearest_part(foot.of.body, patch.polygon) == foot.of.number).all())


def _smooth_parts(body: Body) -> Iterator[Smooth]:
    """Yield the round parts of a body that are not hidden in others, or the whole body if it is round."""
    if not isinstance(body.shape, Compound):
        whole = round_of(body.shape)
        if whole is not None:
            yield Smooth(body, 0, whole, body.pose)
        return
    shapes = [round_of(part.shape) for part in body.shape.parts]
    if any(shape is not None for shape in shapes):
        seen = set(np.unique(body.shape.part_of).tolist())
        for k, shape in enumerate(shapes):
            if shape is not None and k in seen:
                yield Smooth(body, k, shape, body.pose @ body.shape.parts[k].pose)


def _is_flat(body: Body, point: Float) -> bool:
    """Tell whether the part of a body on which a point (3,) lies is none of the round ones."""
    if not isinstance(body.shape, Compound):
        return True
    if not any(round_of(part.shape) is not None for part in body.shape.parts):
        return True
    return round_of(body.shape.parts[int(nearest_part(body, point[None])[0])].shape) is None


def _feet(of: Smooth, other: Body, sign: float, gap: float, depth: float, reach: float) -> Iterator[Foot]:
    R, shape = of.pose[:3, :3], of.shape
    along = shape.half * R[:, 2]
    centres = of.pose[:3, 3] + (np.array([-along, along]) if shape.half else np.zeros((1, 3)))
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
        curved = surface.vertices[topology.edges[_curved_rim(topology.of_face[members], topology.bend)]]
        for start, stop in exposed(of.body, of.number, at[within]):
            low, height_there = (_between(v[within], start, stop) for v in (at, height))
            ends = low - np.outer(height_there, normal)
            share = _on_face(ends, corners[members], normal)
            if len(share):
                ends, there = (_between(v, float(share[0]), float(share[-1])) for v in (ends, height_there))
                if _clear(ends, curved, gap, shape) and _is_flat(other, ends[0]):
                    yield Foot(of, ends, sign * normal, there, reach)


def _between(values: Float, start: float, stop: float) -> Float:
    """Return the values at two shares of the way from the first to the last of one or two rows; one row if equal."""
    shares = np.unique([start, stop])
    return np.asarray(values[0] + np.multiply.outer(shares, values[-1] - values[0]))


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
