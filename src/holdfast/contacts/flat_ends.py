"""Cylinders that stand with a flat end on a cuboid or on another cylinder, in the same plane, without any triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Float, frozen, unit
from holdfast.base.rigid import tangents
from holdfast.base.rounding import COORDINATES
from holdfast.contacts.cuboids import WIDE
from holdfast.contacts.facing_polygons import BROAD
from holdfast.contacts.interface import Patch
from holdfast.contacts.patches import HAIRLINE
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry import polygon as flat
from holdfast.geometry.cuboid import EXACT
from holdfast.scene.body import Body
from holdfast.scene.round_shapes import round_of
from holdfast.scene.shapes import Cylinder

STEEP = 0.01  # least sine of the angle at which a triangle with one corner in the plane rises
LEVEL = 0.1 * COORDINATES  # [rad] largest angle between faces in one plane: corners are as level as flush ones


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
