"""Near points of two bodies: where they touch, overlap or are near, with signed distances and normals.

Pairs of nearby faces are kept from step to step until the bodies have moved too far.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.contacts.features import Features, touching_features
from holdfast.contacts.patches import NEGLIGIBLE_WIDTH, NOMINAL_BREADTH
from holdfast.contacts.round_contacts import feet
from holdfast.contacts.search_mesh import near_faces
from holdfast.contacts.tolerances import THINNEST, Angles
from holdfast.native import core
from holdfast.settling.moved_surfaces import Posed
from holdfast.settling.shared_volume import Shared, shared_solids, ways_out

FACING = 15.0  # [deg] faces at a smaller angle meet as faces, others with their edges and vertices
SHARP = 3.0  # [deg] an edge or a vertex touches if the surface beside it does not slope towards the other body by more
ALIKE = float(np.cos(np.radians(30)))  # cosine of the largest angle between normals of the same contact
SAME = 10 * NEGLIGIBLE_WIDTH  # relative to the smaller body: closer points are the same
MANY = 256  # if there are more near points, only the deepest in each cell of space is used
CELL = 0.005  # side of a cell, relative to the smaller body
ROW: Final = core.NEAR_ROW  # numbers of a near point: point (3), normal (3), distance
GREATEST = 50.0  # [margins] pairs that were searched up to a larger distance are too many to be reused


class Near(NamedTuple):
    """Near points of two bodies.

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
) -> Near:
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


def _without_explained(rows: Float, size: float) -> Near:
    """Return the near points, the deepest first, without those that others explain."""
    rows = rows[np.lexsort((*rows[:, :3].T, rows[:, 6]))]
    rows = np.ascontiguousarray(rows)
    good = np.empty(len(rows), dtype=np.bool_)
    core.mark_unexplained(rows, ALIKE, good)
    rows = np.ascontiguousarray(rows[good])
    chosen = np.zeros(len(rows), dtype=bool)
    chosen[core.spread_points(rows, size, SAME * size)] = True
    return Near(rows[:, :3], rows[:, 3:6], rows[:, 6], chosen)


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
