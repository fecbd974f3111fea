"""What two closed bodies share: the solids in which they overlap, and the way along which these shrink."""

from __future__ import annotations

from typing import NamedTuple

import manifold3d
import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.settling.moved_surfaces import Posed

CLEAR = 0.3  # of the area of the second body in a shared solid: less of it facing one way in sum says nothing
SHEET = 0.05  # of the root of the area of a shared solid: a sheet is thinner than that
PARTED = 0.05  # of the volume of a sheet: bodies that share no more after a motion to one side have come apart there
FARTHEST = (1.0, 2.0, 4.0, 8.0)  # thicknesses of a sheet: motions to either side by which bodies may come apart
AGAINST = -0.5  # cosine of the angle to the way of a shared solid from which on a normal goes against it
AROUND = 0.1  # of the depth of a near point: how far from a shared solid it may lie
DEEPER = 1.05  # of how far a shared solid extends along a normal: what lies deeper is not the way out of it


class Shared(NamedTuple):
    """A connected solid that two bodies share, with corners ``points`` (n, 3) [m].

    Moving the second body along the unit vector ``way`` (3,) makes it smaller fastest: the derivative of a shared
    volume is the integral of n·v over that part of the surface of the body that is inside the other one. Where the sum
    of the normals there is nearly zero, and they are those of a sheet, it is the side to which the bodies come apart: a
    thin floor that is just inside another one. It is None if neither tells, as for a peg in a tight hole or a rod
    through a plate.
    """

    points: Float
    way: Float | None

    def extent(self, directions: Float) -> Float:
        """Return how far the solid extends along each of ``directions`` (m, 3) [m]."""
        return np.asarray(np.ptp(self.points @ directions.T, axis=0))


def shared_solids(a: Posed, b: Posed) -> tuple[Shared, ...] | None:
    """Return the solids that two bodies share, or None if a surface is not closed."""
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
    """Return the unit normal (3,) of a sheet that solids share, towards the side on which b leaves a, or None.

    ``area`` (n, 3) are the normals of the triangles of b inside a, as long as their ``sizes`` (n,).
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
    """Tell which near points (n,) of overlapping bodies, ``depths`` (n,) [m] in each other, are ways out of a solid.

    Such a point lies at the solid. If the way in which this shrinks is known, it is no deeper than the solid extends
    along the normal, which does not go against that way. All others belong to other sides of walls, or to folds.
    """
    fits = np.zeros(len(points), dtype=bool)
    for solid in shared:
        low, high = solid.points.min(0), solid.points.max(0)
        around = AROUND * depths[:, None]
        here = ((points >= low - around) & (points <= high + around)).all(1)
        if solid.way is not None:
            here &= (depths <= DEEPER * solid.extent(normals)) & (normals @ solid.way > AGAINST)
        fits |= here
    return fits
