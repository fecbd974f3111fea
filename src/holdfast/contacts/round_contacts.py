"""Exact contact of balls, cylinders, capsules and ellipsoids: with flat faces, sharp edges and corners, and each other.

On a tessellated surface such a contact would be at the nearest vertex, up to half an edge from its true place, or it
would be as wide as a facet. A round part of a compound touches like a whole body, except where it is hidden inside
other parts. The flat ends of cylinders are ordinary faces: a round body may rest on them, and they meet faces as
polygons.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Bool, Float
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents
from holdfast.contacts.compound_parts import exposed, nearest_part
from holdfast.contacts.interface import Patch
from holdfast.contacts.round_bodies import Meeting, PlacedEllipsoid, PlacedRod, RoundLimits, meet
from holdfast.contacts.sharp_contacts import on_edges
from holdfast.contacts.tolerances import Angles
from holdfast.geometry.facets import COPLANAR
from holdfast.geometry.triangles import FLAT, SMOOTH
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.round_shapes import Round, round_of

ONE_CONTACT = float(np.cos(np.radians(20)))  # cosine of the largest angle between normals of the same contact
SAME = 1 - 1e-9  # cosine between the axis of a cylinder and the normal of its own end, up to rounding


class Smooth(NamedTuple):
    """A round body, or round part ``number`` of a body, with its ``shape`` and its ``pose`` (4, 4) in the world."""

    body: Body
    number: int
    shape: Round
    pose: Float

    @property
    def placed(self) -> PlacedRod | PlacedEllipsoid:
        """The shape in the world: a ball or disc swept along its axis, or an ellipsoid."""
        shape = self.shape
        if not shape.is_swept:
            return PlacedEllipsoid.of(self.pose, shape.radii)
        half = shape.half * self.pose[:3, 2]
        return PlacedRod(self.pose[:3, 3], half, float(shape.radii[0]), shape.has_flat_ends)

    @property
    def outer_radius(self) -> float:
        """An upper bound of the distance [m] from its centre to its surface."""
        return self.shape.half + float(self.shape.radii.max())


@dataclass(frozen=True, eq=False)
class Foot:
    """An exact contact of a round body or part with a face, an edge, a corner or another round part.

    ``ends`` (1 or 2, 3) [m] is a point or a line halfway between the surfaces, ``normal`` (3,) points into the second
    body, and ``heights`` (1 or 2,) [m] are the distances there, negative where the bodies overlap. Patches of the
    tessellated surfaces within ``mesh_radius`` [m] represent the same contact.
    """

    of: Smooth
    ends: Float
    normal: Float
    heights: Float
    mesh_radius: float

    def patch(self, breadth: float) -> Patch:
        """Return the contact as a patch with this ``breadth`` [m]."""
        low, high = float(self.heights.min()), float(self.heights.max())
        return Patch(self.ends, self.normal, (), (low, high), breadth)

    def is_near(self, points: Float, normal: Float, distance: float) -> Bool:
        """Tell which points (n, 3) of a surface with this ``normal`` (3,) lie within ``distance`` [m]."""
        start, along = self.ends[0], self.ends[-1] - self.ends[0]
        arm = points - start
        t = np.clip(arm @ along / max(float(along @ along), 1e-300), 0, 1)
        near = np.linalg.norm(arm - t[:, None] * along, axis=1) <= distance
        return np.asarray(near & (float(self.normal @ normal) >= ONE_CONTACT))


def feet(a: Body, b: Body, *, gap: float, depth: float, breadth: float, angles: Angles) -> list[Foot]:
    """Find the exact contacts of round bodies and parts with the other body, at heights from -depth to gap [m].

    They are contacts with flat faces, sharp edges and corners, and other round parts. Faces of a tessellated curved
    surface do not count, nor does a flat end of a cylinder that is parallel to the face, within the angle tolerance. If
    two parts of one body touch at the same place, within ``breadth`` [m], the first one counts.
    """
    found: list[Foot] = []
    seen = gap + a.shape.surface.sagitta + b.shape.surface.sagitta
    cos_side, cos_twist = np.cos(np.radians(angles)).tolist()
    limits = RoundLimits(gap, depth, cos_side, cos_twist, seen)
    round_a, round_b = (list(_smooth_parts(body)) for body in (a, b))
    for rounds, other, sign in ((round_a, b, -1.0), (round_b, a, 1.0)):
        whole = round_of(other.shape)
        if whole is None or whole.has_flat_ends:
            for smooth in rounds:
                found += _feet(smooth, other, sign, limits)
                found += _on_edges(smooth, other, sign, limits)
    for one, two in product(round_a, round_b):
        found += _between_rounds(one, two, limits)
    several: list[Foot] = []
    for foot in sorted(found, key=lambda foot: -len(foot.ends)):  # lines first, so that their ends are no points
        if not any(each.is_near(foot.ends, foot.normal, breadth).all() for each in several):
            several.append(foot)
    return several


def meet_smoothly(a: Body, b: Body) -> bool:
    """Tell whether both bodies are balls, capsules or ellipsoids, so that ``feet`` finds all their contacts."""
    shapes = [round_of(body.shape) for body in (a, b)]
    return all(shape is not None and not shape.has_flat_ends for shape in shapes)


def not_at(feet: Sequence[Foot], patches: Sequence[Patch]) -> list[Patch]:
    """Return the patches that do not represent one of the contacts ``feet``, by place and part."""

    def is_of(foot: Foot, patch: Patch) -> bool:
        if not foot.is_near(patch.polygon, patch.normal, foot.mesh_radius).any():
            return False
        return bool((nearest_part(foot.of.body, patch.polygon) == foot.of.number).all())

    return [patch for patch in patches if not any(is_of(foot, patch) for foot in feet)]


def _smooth_parts(body: Body) -> Iterator[Smooth]:
    """Yield the round parts of a compound that are not hidden inside others, or the whole body if it is round."""
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


def _is_flat(body: Body, point: Float, normal: Float) -> bool:
    """Tell whether the face of a body at a ``point`` (3,), with this ``normal`` (3,), is flat.

    Faces of round parts represent curved surfaces, except for the ends of cylinders.
    """
    shape, turn = body.shape, body.pose[:3, :3]
    if isinstance(shape, Compound):
        if not any(round_of(part.shape) is not None for part in shape.parts):
            return True
        part = shape.parts[int(nearest_part(body, point[None])[0])]
        shape, turn = part.shape, turn @ part.pose[:3, :3]
    whole = round_of(shape)
    return whole is None or bool(whole.is_end(normal @ turn, SAME))


def _feet(of: Smooth, other: Body, sign: float, limits: RoundLimits) -> Iterator[Foot]:
    """Yield the contacts of a round part with flat faces, except inside other parts of its own body."""
    R, shape, gap, depth = of.pose[:3, :3], of.shape, limits.gap, limits.depth
    along = shape.half * R[:, 2]
    centres = of.pose[:3, 3] + (np.array([-along, along]) if shape.half else np.zeros((1, 3)))
    surface, topology = other.reduced_world, other.shape.surface.reduced.topology
    normals, corners = surface.normals, surface.vertices[surface.faces]
    own = normals @ R
    lengths = np.maximum(np.linalg.norm(own * shape.radii, axis=1), 1e-300)[:, None]
    lowest = -(own * shape.radii**2 / lengths) @ R.T
    points = centres[:, None] + lowest  # (centres, F, 3)
    heights = ((points - corners[:, 0]) * normals).sum(-1)
    near = ((heights >= -depth) & (heights <= gap)).any(0) & ~shape.is_end(own, limits.cos_side)
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
        rim = np.unique(topology.of_face[members])
        bend = np.abs(topology.bend[rim])
        curved = surface.vertices[topology.edges[rim[(bend > FLAT) & (bend < SMOOTH)]]]  # where a curved surface begins
        for start, stop in exposed(of.body, of.number, at[within]):
            low, height_there = (_between(v[within], start, stop) for v in (at, height))
            ends = low - np.outer(height_there, normal)
            share = _on_face(ends, corners[members], normal)
            if len(share):
                ends, there = (_between(v, float(share[0]), float(share[-1])) for v in (ends, height_there))
                if _clear(ends, curved, shape.spread(gap, own[face])) and _is_flat(other, ends[0], normal):
                    middle = ends + np.outer(there / 2, normal)
                    yield Foot(of, middle, sign * normal, there, shape.spread(limits.seen, own[face]))


def _between_rounds(one: Smooth, two: Smooth, limits: RoundLimits) -> Iterator[Foot]:
    """Yield the contact of two round parts, without what lies inside other parts of their bodies."""
    found = meet(one.placed, two.placed, limits)
    if found is not None:
        yield from _shown([one, two], found, found.normal, one.outer_radius + two.outer_radius, limits.seen)


def _on_edges(of: Smooth, other: Body, sign: float, limits: RoundLimits) -> Iterator[Foot]:
    """Yield the contacts of a round part with sharp edges and corners, except inside other parts of its own body."""
    local = other.shape.surface.reduced
    if local.roughness.slope or not len(local.sharp_edges):
        return
    for found in on_edges(of.placed, other.reduced_world, local.sharp_edges, limits):
        yield from _shown([of], found, -sign * found.normal, 2 * of.outer_radius, limits.seen)


def _shown(of: Sequence[Smooth], found: Meeting, normal: Float, whole: float, seen: float) -> Iterator[Foot]:
    """Yield what of a contact of round parts ``of`` does not lie inside other parts of their bodies.

    ``whole`` [m] is an upper bound of ``mesh_radius``, and ``seen`` [m] is the gap of the tessellated surfaces.
    """
    mesh_radius = min(whole, max(2 * seen, float(np.sqrt(8 * seen / max(found.bend, 1e-300)))))
    for spans in product(*(exposed(each.body, each.number, end) for each, end in zip(of, found.ends, strict=False))):
        start, stop = max(span[0] for span in spans), min(span[1] for span in spans)
        if start <= stop:
            middle = _between(found.ends.mean(0), start, stop)
            yield Foot(of[0], middle, normal, _between(found.heights, start, stop), mesh_radius)


def _between(values: Float, start: float, stop: float) -> Float:
    """Interpolate between the first and the last row of ``values`` at two shares; return one row if they are equal."""
    shares = np.unique([start, stop])
    return np.asarray(values[0] + np.multiply.outer(shares, values[-1] - values[0]))


def _on_face(ends: Float, triangles: Float, normal: Float) -> Float:
    """Return where a point or a line with ``ends`` (1 or 2, 3) enters and leaves a face, as shares of the line.

    The shares are (2,), equal for a point, or (0,) if the line does not meet the face. The face is given as triangles
    (n, 3, 3); its holes are ignored.
    """
    frame = np.array(tangents(normal))
    origin = triangles[0, 0]
    flat = (triangles - origin) @ frame.T
    face = shapely.union_all(shapely.polygons(flat)).buffer(
        COORDINATES * float(np.ptp(flat.reshape(-1, 2), axis=0).max())
    )
    seen = (ends - origin) @ frame.T
    along = seen[-1] - seen[0]
    left = (shapely.LineString(seen) if len(seen) > 1 else shapely.Point(seen[0])).intersection(face)
    share = (shapely.get_coordinates(left) - seen[0]) @ along / max(float(along @ along), 1e-300)
    return np.unique([share.min(), share.max()]) if len(share) else share


def _clear(ends: Float, edges: Float, spread: float) -> bool:
    """Tell whether a contact at ``ends`` (1 or 2, 3) is farther than ``spread`` [m] from all ``edges`` (n, 2, 3)."""
    if not len(edges):
        return True
    lines = shapely.linestrings(edges)
    here = shapely.linestrings(ends[None]) if len(ends) > 1 else shapely.points(ends)
    flat_apart = np.asarray(shapely.distance(lines, here))  # in x and y only: a lower bound of the distance
    return bool(flat_apart.min() > spread)
