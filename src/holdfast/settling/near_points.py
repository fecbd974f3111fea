"""The near points of two bodies: where they touch, overlap or are near, with signed distances and normals.

Pairs of nearby faces are kept from step to step until the bodies have moved too far. Overlaps are checked against the
common volume of two closed bodies: its solids, and the direction of motion in which each shrinks.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import manifold3d
import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.contacts.patches import NEGLIGIBLE_WIDTH, NOMINAL_BREADTH
from holdfast.contacts.round_contacts import feet
from holdfast.contacts.search_mesh import Features, near_faces, touching_features
from holdfast.contacts.tolerances import THINNEST, Angles
from holdfast.native import core
from holdfast.settling.moved_surfaces import Posed

FACING = 15.0  # [deg] faces at a smaller angle meet as faces, others with their edges and vertices
SHARP = 3.0  # [deg] an edge or a vertex touches if the surface beside it does not slope towards the other body by more
ALIKE = float(np.cos(np.radians(30)))  # cosine of the largest angle between normals of the same contact
SAME = 10 * NEGLIGIBLE_WIDTH  # relative to the smaller body: closer points are the same
MANY = 256  # if there are more near points, only the deepest in each cell of space is used
CELL = 0.005  # side of a cell, relative to the smaller body
ROW: Final = core.NEAR_ROW  # numbers of a near point: point (3), normal (3), distance
GREATEST = 50.0  # [margins] pairs that were searched up to a larger distance are too many to be reused
CLEAR = 0.3  # least sum of area vectors, relative to the area of the second body inside the first, that has a direction
SHEET = 0.05  # thickness, relative to the square root of the area, below which a common solid is a sheet
PARTED = 0.05  # bodies have come apart if their common volume after a motion, relative to before, is at most this
FARTHEST = (1.0, 2.0, 4.0, 8.0)  # [thicknesses of the sheet] motions to either side that are tried
AGAINST = -0.5  # a normal whose cosine to the direction of a solid is smaller points against it
AROUND = 0.1  # [depths of a near point] how far from a common solid the point may lie
# largest ratio of two depths of one overlap, or of its depth to the extent of the solid along it
SAME_DEPTH: Final = core.SAME_DEPTH


class NearPoints(NamedTuple):
    """The points at which two bodies touch, overlap or are near each other.

    ``points`` (n, 3) [m] lie halfway between the surfaces, ``normals`` (n, 3) point into the second body, and ``gaps``
    (n,) [m] are the distances along them, negative where the bodies overlap. ``chosen`` (n,) are a few of them that lie
    far apart and nearly touch.
    """

    points: Float
    normals: Float
    gaps: Float
    chosen: Bool


def near_points(
    one: Posed, other: Posed, faces: FacePairs, *, margin: float, least: float = 0.0, overlapping: bool = False
) -> NearPoints:
    """Find the near points of two bodies that are up to ``margin`` apart or into each other [m].

    ``faces`` is the cache of nearby faces of these two bodies. Overlaps of more than ``least`` [m] are checked against
    the common volume of the bodies, if both are closed. If the bodies are known to be ``overlapping``, overlaps are
    searched to the full depth of ``margin``.
    """
    a, b, mesh_a, mesh_b = one.body, other.body, one.mesh, other.mesh
    size = min(a.size, b.size)
    depth = margin if overlapping else min(margin, THINNEST * min(a.shape.surface.thickness, b.shape.surface.thickness))
    found = [np.empty((0, ROW))]
    exact = feet(a, b, gap=margin, depth=depth, breadth=NOMINAL_BREADTH * size, angles=Angles(FACING, FACING))
    for foot in exact:
        for end, height in zip(foot.ends, foot.heights, strict=True):
            found.append(np.concatenate([end, foot.normal, [height]])[None])
    pairs = faces.within(one, other, margin)
    if len(pairs):
        limit, sharp = float(np.cos(np.radians(FACING))), Angles(SHARP, SHARP)
        faces_a, faces_b = ((mesh.triangles, mesh.normals) for mesh in (mesh_a, mesh_b))
        by_mesh = [core.facing_corners(*faces_a, *faces_b, pairs, margin, depth, limit)]
        features = touching_features(
            mesh_a, mesh_b, pairs, gap=margin, depth=depth, angles=sharp, size=size, strict=NEGLIGIBLE_WIDTH * size
        )
        by_mesh += [_rows(found_here) for found_here in features]
        rows = np.concatenate(by_mesh)
        for foot in exact:
            rows = rows[np.linalg.norm(rows[:, None, :3] - foot.ends, axis=2).min(1) > foot.mesh_radius]
        found.append(rows)
    rows = _thinned(np.concatenate(found), size)
    if overlapping or (rows[:, 6] < -least).any():
        shared = shared_solids(one, other)
        rows = _leading_out(rows, shared, least) if shared is not None else _inside(rows, one, other, least)
    return _without_explained(rows, size)


def _inside(rows: Float, one: Posed, other: Posed, least: float) -> Float:
    """Drop overlaps of more than ``least`` [m] at points that are outside one of the bodies.

    If there are many such overlaps, the bodies are deep in each other, folds of their surfaces matter little, and all
    overlaps remain.
    """
    for body in (one, other):
        deep = np.flatnonzero(rows[:, 6] < -least)
        if len(deep) <= MANY:
            rows = np.delete(rows, deep[~body.encloses(rows[deep, :3])], axis=0)
    return rows


def _leading_out(rows: Float, shared: tuple[Shared, ...], least: float) -> Float:
    """Drop overlaps of more than ``least`` [m] that do not lead out of the common volume of two bodies.

    If no overlap leads out of one of its solids, one is added: in the middle of the solid, along the direction in which
    the solid shrinks, and as deep as the solid extends in that direction.
    """
    deep = rows[:, 6] < -least
    fits = ways_out(shared, *_overlaps(rows))
    found = [rows[~deep | fits]]
    for solid in shared:
        if solid.way is not None and not ways_out((solid,), *_overlaps(rows[deep])).any():
            extent = float(solid.extent(solid.way[None])[0])
            middle = (solid.points.min(0) + solid.points.max(0)) / 2
            if extent > least:
                found.append(np.concatenate([middle, solid.way, [-extent]])[None])
    return np.concatenate(found)


def _overlaps(rows: Float) -> tuple[Float, Float, Float]:
    """Return the points (n, 3), normals (n, 3) and depths (n,) of rows (n, ROW)."""
    return rows[:, :3], rows[:, 3:6], -rows[:, 6]


def _rows(features: Features) -> Float:
    """Return the ends of lines, or points, as rows (n, ROW)."""
    ends, heights = features.ends.reshape(-1, 3), features.heights.reshape(-1)
    return np.column_stack([ends, np.repeat(features.normals, 2, axis=0), heights])


def _thinned(rows: Float, size: float) -> Float:
    """Return the near points, the deepest first; if there are too many, only the deepest in each cell of space."""
    rows = rows[np.lexsort((*rows[:, :3].T, rows[:, 6]))]
    if len(rows) > MANY:
        rows = rows[np.sort(np.unique(_cells(rows, CELL * size), return_index=True)[1])]
    return rows


def _without_explained(rows: Float, size: float) -> NearPoints:
    """Return the near points, the deepest first, without those that others explain."""
    rows = rows[np.lexsort((*rows[:, :3].T, rows[:, 6]))]
    rows = np.ascontiguousarray(rows)
    good = np.empty(len(rows), dtype=np.bool_)
    core.mark_unexplained(rows, ALIKE, good)
    rows = np.ascontiguousarray(rows[good])
    chosen = np.zeros(len(rows), dtype=bool)
    chosen[core.spread_points(rows, size, SAME * size)] = True
    return NearPoints(rows[:, :3], rows[:, 3:6], rows[:, 6], chosen)


def _cells(rows: Float, side: float) -> Int:
    """Return the number (n,) of the cell of each row; cells are cubes of this ``side`` [m], divided by direction."""
    cells = np.column_stack([np.floor(rows[:, :3] / side), np.round(2 * rows[:, 3:6])]).astype(np.int64)
    cells -= cells.min(0)
    return np.asarray(np.ravel_multi_index(tuple(cells.T), tuple(cells.max(0) + 1)))


class FacePairs:
    """A cache of pairs of faces of two bodies that may be near each other.

    It holds the pairs whose boxes came within twice the requested distance, that distance, and the relative
    pose. Until the bodies have moved by the difference, no other pair can be within the requested distance.
    """

    def __init__(self) -> None:
        self._pairs, self._searched = np.empty((0, 2), dtype=np.int64), -1.0
        self._place = np.eye(4)

    def within(self, a: Posed, b: Posed, margin: float) -> Int:
        """Return the pairs (m, 2) of faces whose boxes come within ``margin`` [m] and that do not face away."""
        place = np.linalg.inv(a.body.pose) @ b.body.pose
        needed = margin + _way(self._place, place, b)
        if not needed <= self._searched <= GREATEST * margin:
            self._searched, self._place = 2 * margin, place
            self._pairs = near_faces(a.mesh, b.mesh, self._searched)
        of_a, of_b = ((mesh.low, mesh.high, mesh.normals) for mesh in (a.mesh, b.mesh))
        return core.facing_near(self._pairs, *of_a, *of_b, margin)


def _way(before: Float, after: Float, body: Posed) -> float:
    """Return an upper bound [m] of the motion of any point of a body from pose ``before`` (4, 4) to ``after``."""
    change = after - before
    at_centre = change[:3, :3] @ body.start.com_body + change[:3, 3]
    return float(np.linalg.norm(at_centre) + body.radius * np.linalg.norm(change[:3, :3], 2))


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
    """Tell which contacts (n,) of overlapping bodies, at ``points``, lead out of a solid that bodies have in common.

    Such a point lies in the bounding box of the solid. If the direction in which the solid shrinks is known, the normal
    does not point against it, and the depth, one of ``depths`` (n,) [m], is at most the extent of the solid along the
    normal. All other contacts belong to the far sides of walls or to folds.
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
