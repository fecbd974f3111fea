"""Near points of two bodies: where they touch, overlap or come near, with signed distance and normal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.contacts.detect import NOMINAL_BREADTH
from holdfast.contacts.features import Features, touching_features
from holdfast.contacts.round_contacts import feet
from holdfast.contacts.tolerances import Angles
from holdfast.settling.facing_triangles import ROW, facing_corners
from holdfast.settling.moved_surfaces import Posed
from holdfast.settling.near_faces import FacePairs
from holdfast.settling.shared import Shared, shared_solids, ways_out

FACING = 15.0  # [deg] faces that enclose a smaller angle meet as faces, others by their edges and vertices
SHARP = 3.0  # [deg] an edge or a vertex touches if nothing beside it falls towards the other body by more
STRICT = 1e-6  # of the smaller body: how far from a sharp edge a vertex touches a face
ALIKE = float(np.cos(np.radians(30)))  # cosine of the angle between normals of one and the same contact
SAME = 1e-5  # of the smaller body: points nearer to each other than this are one
TURNED = 0.3  # of the smaller body: how far apart points with perpendicular normals count at least
LEAN = 0.05  # [rad] points on a body's ends are worth keeping if a smaller rotation lets them touch
MOST = 5  # near points of two bodies that are chosen: the corners of a face and one more
MANY = 256  # near points: of more than this, first the deepest in each cell of space is taken
CELL = 0.005  # of the smaller body: the side of a cell
BESIDE = 1.5  # depths of an overlap: how far from it others may be that explain it
FOLDED = 1.05  # depths of an overlap: how wide a gap the other way may be that explains it, beside a folded triangle
THIN = 0.5  # of the thickness of the thinner body: how deep an overlap may be, and its way out still be known


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

    ``faces`` are those of these two bodies, which it keeps up to date. Overlaps of more than ``least`` [m] are
    compared with what the bodies share, if both are closed. Where they are known to be ``overlapping``, overlaps are
    looked for as deep as gaps are wide.
    """
    a, b, skin_a, skin_b = one.body, other.body, one.skin, other.skin
    size = min(a.size, b.size)
    depth = margin if overlapping else min(margin, THIN * min(a.shape.surface.thickness, b.shape.surface.thickness))
    found = [np.empty((0, ROW))]
    exact = feet(a, b, gap=margin, depth=depth, breadth=NOMINAL_BREADTH * size, angles=Angles(FACING, FACING))
    for foot in exact:
        for end, height in zip(foot.ends, foot.heights, strict=True):
            found.append(np.concatenate([end, foot.normal, [height]])[None])
    pairs = faces.within(one, other, margin)
    if len(pairs):
        limit, sharp = float(np.cos(np.radians(FACING))), Angles(SHARP, SHARP)
        mesh = [facing_corners(skin_a, skin_b, pairs, margin=margin, depth=depth, cos_angle=limit)]
        features = touching_features(
            skin_a, skin_b, pairs, gap=margin, depth=depth, angles=sharp, size=size, strict=STRICT * size
        )
        mesh += [_rows(found_here) for found_here in features]
        rows = np.concatenate(mesh)
        for foot in exact:
            rows = rows[np.linalg.norm(rows[:, None, :3] - foot.ends, axis=2).min(1) > foot.reach]
        found.append(rows)
    rows = _thinned(np.concatenate(found), size)
    if overlapping or (rows[:, 6] < -least).any():
        shared = shared_solids(one, other)
        rows = _leading_out(rows, shared, least) if shared is not None else _inside(rows, one, other, least)
    return _kept(rows, size)


def _inside(rows: Float, one: Posed, other: Posed, least: float) -> Float:
    """Return the rows without overlaps of more than ``least`` that are outside of a body whose surface has an inside.

    Bodies with many such overlaps are deep in each other, and their folds matter little: there all of them are kept.
    """
    for body in (one, other):
        deep = np.flatnonzero(rows[:, 6] < -least)
        if len(deep) <= MANY:
            rows = np.delete(rows, deep[~body.encloses(rows[deep, :3])], axis=0)
    return rows


def _leading_out(rows: Float, shared: tuple[Shared, ...], least: float) -> Float:
    """Return the rows without overlaps of more than ``least`` that do not lead out of what two bodies share.

    A solid that none leads out of gets one: in its middle, as deep as it extends along the way in which it shrinks.
    """
    deep = rows[:, 6] < -least
    fits = ways_out(shared, *_overlaps(rows))
    kept = [rows[~deep | fits]]
    for solid in shared:
        if solid.way is not None and not ways_out((solid,), *_overlaps(rows[deep])).any():
            extent = float(solid.extent(solid.way[None])[0])
            middle = (solid.points.min(0) + solid.points.max(0)) / 2
            if extent > least:
                kept.append(np.concatenate([middle, solid.way, [-extent]])[None])
    return np.concatenate(kept)


def _overlaps(rows: Float) -> tuple[Float, Float, Float]:
    """Return points (n, 3), normals (n, 3) and depths (n,) of rows."""
    return rows[:, :3], rows[:, 3:6], -rows[:, 6]


def _rows(features: Features) -> Float:
    """Return the ends of lines, or points, as rows (n, ROW)."""
    ends, heights = features.ends.reshape(-1, 3), features.heights.reshape(-1)
    return np.column_stack([ends, np.repeat(features.normals, 2, axis=0), heights])


def _thinned(rows: Float, size: float) -> Float:
    """Return the near points, the deepest first, of too many only the deepest in every cell of space."""
    rows = rows[np.lexsort((*rows[:, :3].T, rows[:, 6]))]
    if len(rows) > MANY:
        rows = rows[np.sort(np.unique(_cells(rows, CELL * size), return_index=True)[1])]
    return rows


def _kept(rows: Float, size: float) -> Near:
    """Return the near points without those that say nothing new, the deepest first."""
    rows = rows[np.lexsort((*rows[:, :3].T, rows[:, 6]))]
    rows = np.ascontiguousarray(rows)
    good = np.empty(len(rows), dtype=np.bool_)
    _explained(rows, ALIKE, good)
    rows = np.ascontiguousarray(rows[good])
    kept, chosen = np.empty(MOST, dtype=np.int64), np.zeros(len(rows), dtype=bool)
    chosen[kept[: _spread(rows, size, kept)]] = True
    return Near(rows[:, :3], rows[:, 3:6], rows[:, 6], chosen)


def _cells(rows: Float, side: float) -> Int:
    """Return one number (n,) for each cell of space, of this ``side`` [m], and of directions that rows are in."""
    cells = np.column_stack([np.floor(rows[:, :3] / side), np.round(2 * rows[:, 3:6])]).astype(np.int64)
    cells -= cells.min(0)
    return np.asarray(np.ravel_multi_index(tuple(cells.T), tuple(cells.max(0) + 1)))


@compiled
@lean
def _explained(rows: Float, alike: float, good: Bool) -> None:
    """Tell which near points (n,), the deepest first, are no side effect of a smaller overlap or gap beside them.

    Where a corner is inside another body, every face of that body near it could push it out: the nearest one does. A
    wall has another side, from which it would be left the wrong way: the side that is nearer to touching counts. Scans
    have folded triangles, that face inwards on the outside: there an overlap is as deep as the gap that it belongs to.
    """
    for i in range(len(rows)):
        good[i] = True
        depth = -rows[i, 6]
        if depth <= 0:
            continue
        for j in range(i + 1, len(rows)):
            if rows[j, 6] > FOLDED * depth:
                break
            cosine, apart2 = 0.0, 0.0
            for k in range(3):
                cosine += rows[i, 3 + k] * rows[j, 3 + k]
                apart2 += (rows[i, k] - rows[j, k]) ** 2
            beside = cosine < -alike if rows[j, 6] >= 0 else -rows[j, 6] < 0.999 * depth
            if beside and cosine < alike and apart2 <= (BESIDE * depth) ** 2:
                good[i] = False
                break


@compiled
def _spread(rows: Float, size: float, kept: Int) -> int:
    """Write to ``kept`` the numbers of near points that lie far from each other and touch, the deepest first.

    Each next one is that with the largest distance from those before, less what its gap is worth. Points with other
    normals count as farther away. Returns how many there are: no two are closer than SAME.
    """
    apart = np.full(len(rows), np.inf)
    count, chosen = 0, 0
    while count < len(kept) and len(rows) > 0:
        kept[count] = chosen
        count += 1
        best, following = -np.inf, -1
        for i in range(len(rows)):
            place2, turn2 = 0.0, 0.0
            for k in range(3):
                place2 += (rows[i, k] - rows[chosen, k]) ** 2
                turn2 += (rows[i, 3 + k] - rows[chosen, 3 + k]) ** 2
            apart[i] = min(apart[i], np.sqrt(place2 + turn2 * (TURNED * size) ** 2))
            worth = apart[i] - max(rows[i, 6], 0.0) / LEAN
            if apart[i] > SAME * size and worth > best:
                best, following = worth, i
        if following < 0:
            break
        chosen = following
    return count
