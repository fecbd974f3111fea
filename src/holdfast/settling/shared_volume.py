"""The common volume of two closed bodies: its solids, and the direction of motion in which each shrinks."""

from __future__ import annotations

from typing import Final, NamedTuple

import manifold3d
import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.native import core
from holdfast.settling.moved_surfaces import Posed

CLEAR = 0.3  # least sum of area vectors, relative to the area of the second body inside the first, that has a direction
SHEET = 0.05  # thickness, relative to the square root of the area, below which a common solid is a sheet
PARTED = 0.05  # bodies have come apart if their common volume after a motion, relative to before, is at most this
FARTHEST = (1.0, 2.0, 4.0, 8.0)  # [thicknesses of the sheet] motions to either side that are tried
AGAINST = -0.5  # a normal whose cosine to the direction of a solid is smaller points against it
AROUND = 0.1  # [depths of a near point] how far from a common solid the point may lie
# largest ratio of two depths of one overlap, or of its depth to the extent of the solid along it
SAME_DEPTH: Final = core.SAME_DEPTH


class Shared(NamedTuple):
    """A connected solid of the common volume of two bodies, with corners ``points`` (n, 3) [m].

    It shrinks fastest if the second body moves along the unit vector ``way`` (3,): the derivative of the common volume
    is the integral of n·v over the part of that body's surface inside the other one. If the area vectors there nearly
    cancel and the solid is a sheet, as for a thin floor just inside another one, ``way`` points to the side on which
    the bodies come apart. It is None if neither gives a direction, as for a peg in a tight hole or a rod through a
    plate.
    """

    points: Float
    way: Float | None

    def extent(self, directions: Float) -> Float:
        """Return the extent (m,) [m] of the solid along each of ``directions`` (m, 3)."""
        return np.asarray(np.ptp(self.points @ directions.T, axis=0))


def shared_solids(a: Posed, b: Posed) -> tuple[Shared, ...] | None:
    """Return the solids of the common volume of two bodies, or None if a surface is not closed."""
    if a.solid is None or b.solid is None:
        return None
    return tuple(_shared(part, a.solid, b.solid, b.number) for part in (a.solid ^ b.solid).decompose())


def _shared(part: manifold3d.Manifold, a: manifold3d.Manifold, b: manifold3d.Manifold, second: int) -> Shared:
    mesh = part.to_mesh64()
    points, triangles = np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64)
    ends: Int = np.asarray(mesh.run_index, dtype=np.int64) // 3
    own = triangles[np.repeat(np.asarray(mesh.run_original_id, dtype=np.int64), ends[1:] - ends[:-1]) == second]
    area = np.cross(points[own[:, 1]] - points[own[:, 0]], points[own[:, 2]] - points[own[:, 0]])
    total, sizes = -area.sum(0), np.linalg.norm(area, axis=1)
    length = float(np.linalg.norm(total))
    if length > CLEAR * float(sizes.sum()):
        return Shared(points, total / length)
    return Shared(points, _side(part, a, b, area[sizes > 0], sizes[sizes > 0]))


def _side(
    part: manifold3d.Manifold, a: manifold3d.Manifold, b: manifold3d.Manifold, area: Float, sizes: Float
) -> Float | None:
    """Return the unit normal (3,) of a common sheet ``part``, pointing to the side on which b leaves a, or None.

    ``area`` (n, 3) are twice the area vectors of the triangles of b inside a, and ``sizes`` (n,) their lengths.
    """
    thickness = 2 * part.volume() / part.surface_area()
    if not len(area) or thickness > SHEET * part.surface_area() ** 0.5:
        return None
    axes = np.linalg.eigh((area / sizes[:, None]).T @ area).eigenvectors
    across = axes[:, 2] * thickness
    for far in FARTHEST:
        one, other = (
            float((a ^ b.translate(way)).volume()) <= PARTED * part.volume() for way in (far * across, -far * across)
        )
        if one or other:
            return None if one and other else np.asarray(axes[:, 2] if one else -axes[:, 2])
    return None


def ways_out(shared: tuple[Shared, ...], points: Float, normals: Float, depths: Float) -> Bool:
    """Tell which near points (n,) of overlapping bodies lead out of one of the common solids.

    Such a point is at the solid. If the direction in which the solid shrinks is known, the normal does not point
    against it, and the depth, one of ``depths`` (n,) [m], is at most the extent of the solid along the normal. All
    other near points belong to the far sides of walls or to folds.
    """
    fits = np.zeros(len(points), dtype=bool)
    for solid in shared:
        low, high = solid.points.min(0), solid.points.max(0)
        around = AROUND * depths[:, None]
        here = ((points >= low - around) & (points <= high + around)).all(1)
        if solid.way is not None:
            here &= (depths <= SAME_DEPTH * solid.extent(normals)) & (normals @ solid.way > AGAINST)
        fits |= here
    return fits
