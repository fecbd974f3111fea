"""Contacts that are known in closed form, without any search of triangles, edges and corners.

Most bodies of pallets, shelves and walls are boxes, tins and balls. Three kinds of pairs are known:

- Two cuboids, all pairs of a scene at once. They are apart if they are more than the gap apart along the normal of a
  face, or if their edges are parallel and they overlap along one axis at most, as boxes that meet at an edge do: they
  could only touch at a sharp rim, which is not a contact. Or they are flush: a face of each lies in one plane, up to
  rounding, the plane separates them, and the contact is the intersection of the two rectangles. All other faces are
  perpendicular to the plane or beyond the gap, so that the patch accounts for all edges and corners.
- A cylinder that stands with a flat end on a cuboid or on another cylinder, in the same plane.
- A ball, a capsule or an ellipsoid on a face of a cuboid, far from its edges: a point or a line.

The search through triangles (``detect.find_patches``), to which all other pairs are left, finds the same contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Float, frozen, unit
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents
from holdfast.base.values import made, sealed
from holdfast.contacts.clipping import BROAD
from holdfast.contacts.interface import Patch
from holdfast.contacts.patches import HAIRLINE, NEGLIGIBLE_WIDTH, NOMINAL_BREADTH
from holdfast.contacts.round_contacts import feet
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry import polygon as flat
from holdfast.geometry.surface import EXACT, Cuboid
from holdfast.native import core
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.round_shapes import Round, round_of
from holdfast.scene.shapes import Cylinder

WIDE = 1e-6  # least gap, relative to the size of the smaller body, at which rounding cannot decide what touches
STEEP = 0.01  # least sine of the angle at which a triangle with one corner in the plane rises
LEVEL = 0.1 * COORDINATES  # [rad] largest angle between faces in one plane: corners are as level as flush ones


class Cuboids(NamedTuple):
    """Two cuboids whose bounding boxes are near each other; all lengths are in metres.

    Surfaces touch up to ``gap`` apart. ``size`` is that of the smaller body, and contacts narrower than ``negligible``
    are rounding.
    """

    a: Cuboid
    b: Cuboid
    gap: float
    size: float
    negligible: float


def patches_of(pairs: Sequence[Cuboids]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair, with normals into the second body; None if triangles have to be searched."""
    if not pairs:
        return []
    known = {id(body): body for near in pairs for body in (near.a, near.b)}
    number_of = {key: k for k, key in enumerate(known)}
    bodies = np.array([body.rows for body in known.values()])
    ends = np.array([(number_of[id(near.a)], number_of[id(near.b)]) for near in pairs])
    limits = np.array([near[2:] for near in pairs])
    counts, corners, planes, tangents = core.cuboid_contacts(bodies, ends, limits, COORDINATES, WIDE)
    several = counts.tolist()
    found: list[tuple[Patch, ...] | None] = [() if count < 0 else None for count in several]
    for count in {count for count in several if count > 2}:
        chosen = [k for k, each in enumerate(several) if each == count]
        at = slice(None) if len(chosen) == len(several) else chosen
        polygons, frames, normals = corners[at, :count], tangents[at], planes[at, :3]
        separations = planes[at, 3:].tolist()
        rings = (polygons - polygons[:, :1]) @ frames.transpose(0, 2, 1)
        moments, widths = core.measures_of(rings)
        sealed((polygons, frames, normals, rings, moments))
        for k, (number, width) in enumerate(zip(chosen, widths.tolist(), strict=True)):
            if width > pairs[number].negligible:
                low, high = separations[k]
                patch = made(
                    Patch,
                    polygon=polygons[k],
                    normal=normals[k],
                    holes=(),
                    separation=(low, high),
                    breadth=0.0,
                    inset=np.inf,
                    spots=None,
                    frame=frames[k],
                    rings=(rings[k],),
                    moments=moments[k],
                    width=width,
                )
                found[number] = (patch,)
    return found


class _Prism(NamedTuple):
    """The flat faces of a right prism that other faces may lie on, with outward ``normals`` (n, 3).

    They are ``levels`` (n,) [m] from the origin, and the prism is ``heights`` (n,) [m] thick behind them. ``widths``
    (n,) [m] are the longest sides of triangles across that.
    """

    body: Body
    normals: Float
    levels: Float
    heights: Float
    widths: Float

    @classmethod
    def of(cls, body: Body) -> _Prism | None:
        """Return a cylinder with its ends, or a cuboid with its faces; None for another body."""
        shape, cuboid = body.shape, body.cuboid
        if isinstance(shape, Cylinder) and round_of(shape) is not None:
            turn, middle = body.pose[:3, :3], body.pose[:3, 3]
            if np.abs(turn @ turn.T - np.eye(3)).max() > EXACT:
                return None
            axis = turn[:, 2]
            normals = np.array([-axis, axis])
            chord = 2 * shape.radius * float(np.sin(np.pi / shape.segments))
            return cls(body, normals, normals @ middle + shape.height / 2, np.full(2, shape.height), np.full(2, chord))
        if cuboid is None:
            return None
        normals, half = np.vstack([-cuboid.axes, cuboid.axes]), np.tile(cuboid.half, 2)
        sides = 2 * np.tile([cuboid.half[[1, 2]].max(), cuboid.half[[0, 2]].max(), cuboid.half[[0, 1]].max()], 2)
        return cls(body, normals, normals @ cuboid.centre + half, 2 * half, sides)

    def ring(self, face: int) -> Float:
        """Return the corners (k, 3) [m] of one of its faces, counter-clockwise seen from outside."""
        cuboid = self.body.cuboid
        if cuboid is None:
            surface, normal = self.body.reduced_world, self.normals[face]
            rings = [surface.vertices[ring] for (ring,) in self.body.shape.surface.reduced.facets.rings]
            return max(rings, key=lambda ring: float(ring[0] @ normal))
        one, other = (cuboid.half[k % 3] * cuboid.axes[k % 3] for k in (face + 1, face + 2))
        if float(np.cross(one, other) @ self.normals[face]) < 0:
            one, other = other, one
        middle = cuboid.centre + cuboid.half[face % 3] * self.normals[face]
        return np.array([middle - one - other, middle + one - other, middle + one + other, middle - one + other])


def on_end(a: Body, b: Body, tolerances: Tolerances, negligible: float) -> Patch | None:
    """Return the face at which two bodies stand on each other, one of them on the flat end of a cylinder.

    The normal points into ``b``. None if the bodies are others, or if their faces are not in one plane, far from all
    others: what else touches then has to be searched.
    """
    one, two = _Prism.of(a), _Prism.of(b)
    if one is None or two is None or (a.cuboid is not None and b.cuboid is not None):
        return None
    size, gap = min(a.size, b.size), tolerances.gap
    tiny = COORDINATES * size
    apart = one.levels[:, None] + two.levels
    tilt = np.abs(one.normals[:, None] + two.normals).max(2)
    meet = np.argwhere((np.abs(apart) <= tiny) & (tilt <= LEVEL))
    if len(meet) != 1 or gap < WIDE * size:
        return None
    i, j = meet[0].tolist()
    for prism, face in ((one, i), (two, j)):
        high = prism.heights[face]
        if high <= gap + tiny or high < STEEP * np.hypot(high, prism.widths[face]):
            return None
    normal = unit(one.normals[i] - two.normals[j])
    frame, (ring, other) = np.array(tangents(normal)), (one.ring(i), two.ring(j))
    origin = ring[0] - apart[i, j] / 2 * normal
    seen, other_seen = (shapely.Polygon((each - origin) @ frame.T) for each in (ring, other))
    shared = shapely.intersection(seen, other_seen)
    if not isinstance(shared, shapely.Polygon) or shared.is_empty:
        return None
    outline = flat.oriented(flat.without_collinear(shapely.get_coordinates(shared)[:-1], HAIRLINE * negligible))
    separation = (float(-apart[i, j]), float(-apart[i, j]))
    patch = Patch(frozen(origin + outline @ frame), frozen(normal), (), separation)
    return patch if patch.width > max(negligible, BROAD * gap) else None


def on_plane(a: Body, b: Body, tolerances: Tolerances, breadth: float) -> tuple[Patch, ...] | None:
    """Return the patch, ``breadth`` [m] wide, at which a round body without flat ends lies on a face of a cuboid.

    The normal points into ``b``. There is no patch if the tessellated surfaces alone are within the gap. None if the
    bodies are others, or touch in another way or not at all.
    """
    for body, other, sign in ((a, b, -1.0), (b, a, 1.0)):
        shape = round_of(body.shape)
        if shape is not None and not shape.has_flat_ends and other.cuboid is not None:
            sagittas = body.shape.surface.sagitta + other.shape.surface.sagitta
            return _lying(shape, body, other.cuboid, sign, tolerances, sagittas, breadth)
    return None


def _lying(
    shape: Round, body: Body, cuboid: Cuboid, sign: float, tolerances: Tolerances, sagittas: float, breadth: float
) -> tuple[Patch, ...] | None:
    gap, R = tolerances.gap, body.pose[:3, :3]
    centre = cuboid.axes @ (body.pose[:3, 3] - cuboid.centre)
    face = int(np.argmax(np.abs(centre) - cuboid.half))
    normal = cuboid.axes[face] * (1.0 if centre[face] > 0 else -1.0)
    own = normal @ R
    lowest = body.pose[:3, 3] - R @ (own * shape.radii**2 / np.linalg.norm(own * shape.radii))
    along = shape.half * R[:, 2]
    points = np.array([lowest - along, lowest + along]) if shape.half else lowest[None]
    heights = (points - cuboid.centre) @ normal - cuboid.half[face]
    # deeper than the gap, or with one end higher, it may touch elsewhere, too
    if sagittas > gap or (np.abs(heights) > min(gap, tolerances.depth)).any():
        return None
    # whatever of the body is within the gap is within half of this of the points
    spread = shape.spread(gap + sagittas, own)
    beside = np.abs((points - cuboid.centre) @ cuboid.axes.T) + spread > cuboid.half
    beside[:, face] = False
    if beside.any():
        return None
    if heights.min() > gap - sagittas:
        return ()
    ends = points - np.outer(heights / 2, normal)
    return (Patch(ends, sign * normal, (), (float(heights.min()), float(heights.max())), breadth),)


def cuboid_towards(body: Body, other: Body, gap: float) -> Cuboid | None:
    """Return the cuboid that a body is within ``gap`` [m] of another one: the body itself, or a part of its compound.

    It is a part if the boxes of all other parts are farther from the box of the other body, so that they cover nothing
    of it there.
    """
    if not isinstance(body.shape, Compound) or len(body.shape.parts) == 1:
        return body.cuboid
    low, high = other.box[0] - gap, other.box[1] + gap
    near = []
    for part in body.shape.parts:
        corners = body.placed(part.placed(part.shape.surface.vertices))
        if (corners.min(0) <= high).all() and (corners.max(0) >= low).all():
            near.append(part)
    local = near[0].shape.surface.cuboid if len(near) == 1 else None
    return body.cuboid if local is None else local.placed(body.pose @ near[0].pose)


def of_cuboids(pairs: Sequence[tuple[Body, Body]], tolerances: Sequence[Tolerances]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair that meets as cuboids in closed form, and None for all other pairs."""
    numbers, near = [], []
    for k, ((a, b), own) in enumerate(zip(pairs, tolerances, strict=True)):
        one, two = cuboid_towards(a, b, own.gap), cuboid_towards(b, a, own.gap)
        if one is not None and two is not None:
            size = min(a.size, b.size)
            numbers.append(k)
            near.append(Cuboids(one, two, own.gap, size, NEGLIGIBLE_WIDTH * size))
    found: list[tuple[Patch, ...] | None] = [None] * len(pairs)
    for k, patches in zip(numbers, patches_of(near), strict=True):
        found[k] = patches
    return found


def of_round(a: Body, b: Body, tolerances: Tolerances) -> tuple[Patch, ...] | None:
    """Return the patches of a round body on a plane face in closed form, and None for all other pairs."""
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    breadth = NOMINAL_BREADTH * size
    found = on_plane(a, b, tolerances, breadth)
    if found is None:
        face = on_end(a, b, tolerances, NEGLIGIBLE_WIDTH * size)
        if face is not None and not feet(a, b, gap=gap, depth=depth, breadth=breadth, angles=tolerances.angles):
            found = (face,)
    return found
