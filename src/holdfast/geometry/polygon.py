"""Flat polygons with holes: exact moments, unions, and points inside."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from holdfast.base.arrays import Bool, Float
from holdfast.geometry.hull import search_tree
from holdfast.native import core

SCATTERED = 32  # if a union has more parts, pieces are widened before they are joined
# of more pieces, the union is made of widened ones only: that of 60,000 needles takes 2 s and not 13
MANY = 32 * SCATTERED
FEW = 16  # of more than MANY pieces, so many in a row are joined first
MITRE = 100  # most by which a corner moves out, relative to its sides, where a polygon is widened


def turned(ring: Float, first: int) -> Float:
    """Return the rows of a ring (k, ...) rotated so that row ``first`` comes first; five times as fast as np.roll."""
    return np.concatenate((ring[first:], ring[:first]))


def signed_area(ring: Float) -> float:
    """Return the area of a ring (k, 2), positive if it is counter-clockwise."""
    x, y = ring.T
    return float(np.dot(x, turned(y, 1)) - np.dot(turned(x, 1), y)) / 2


def oriented(ring: Float, *, clockwise: bool = False) -> Float:
    """Return the ring (k, 2) in counter-clockwise order, or in clockwise order if ``clockwise``."""
    return np.asarray(ring[::-1] if (signed_area(ring) < 0) != clockwise else ring)


def polynomial_moments(rings: Sequence[Float]) -> Float:
    """Return the integrals (6,) of 1, x, y, x², xy, y² over a polygon.

    Its outline is counter-clockwise, and its holes are clockwise.
    """
    total = np.zeros(6)
    for ring in rings:
        core.add_moments(np.ascontiguousarray(ring), total)
    return total


def distance_moment(rings: Sequence[Float], centre: Float) -> float:
    """Return the integral of the distance to ``centre`` (2,) over a polygon.

    It is the lever arm, times the area, of uniform friction against twisting about the centre. Each edge spans a
    triangle with the centre. With h the distance of the edge from the centre and s the coordinate along it, the
    triangle contributes the difference of [h s sqrt(h² + s²) + h³ asinh(s/h)] / 6 between the ends of the edge, signed
    by its orientation.
    """
    total = 0.0
    for ring in rings:
        p = ring - centre
        q = turned(p, 1)
        edge = q - p
        length = np.linalg.norm(edge, axis=1)
        keep = length > 0
        p, q, edge = p[keep], q[keep], edge[keep] / length[keep, None]
        h = p[:, 0] * edge[:, 1] - p[:, 1] * edge[:, 0]
        safe = np.where(h == 0, 1.0, h)
        for end, sign in ((q, 1.0), (p, -1.0)):
            s = (end * edge).sum(1)
            part = h * s * np.hypot(h, s) + np.where(h == 0, 0.0, h**3 * np.arcsinh(s / np.abs(safe)))
            total += sign * float(part.sum()) / 6
    return total


def without_collinear(ring: Float, tolerance: float) -> Float:
    """Return the ring (k, 2) without vertices that are within ``tolerance`` of the line through their neighbours."""
    before, after = turned(ring, -1), turned(ring, 1)
    chord, back = after - before, ring - before
    area = np.abs(chord[:, 0] * back[:, 1] - chord[:, 1] * back[:, 0])
    if ((area > tolerance * np.hypot(*chord.T)) & (np.hypot(*back.T) > tolerance)).all():
        return np.array(ring)
    points: list[tuple[float, float]] = [(x, y) for x, y in ring.tolist()]
    i = 0
    while i < len(points) and len(points) > 3:
        (ax, ay), (bx, by), (cx, cy) = points[i - 1], points[i], points[(i + 1) % len(points)]
        length = math.hypot(cx - ax, cy - ay)
        height = abs((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)) / length if length > 0 else 0.0
        if height > tolerance and math.hypot(bx - ax, by - ay) > tolerance:
            i += 1
            continue
        del points[i]
        i = 0 if i == len(points) else max(i - 1, 0)  # only the previous vertex has a new neighbour
    return np.array(points)


def shapely_polygon(rings: Sequence[Float]) -> shapely.Polygon:
    """Return the polygon with the first ring as outline and the others as holes."""
    return shapely.Polygon(rings[0], list(rings[1:]))


def inside(polygon: shapely.Polygon, points: Float) -> Bool:
    """Tell which points (n, 2) lie in the polygon or on its boundary."""
    return np.asarray(shapely.intersects_xy(polygon, points[:, 0], points[:, 1]))


def union(pieces: Sequence[Sequence[Float]], tolerance: float, smallest_hole: float) -> list[list[Float]]:
    """Return the union of polygons as a list of polygons [outline counter-clockwise, holes clockwise ...].

    ``pieces`` are polygons [outline, holes ...] of rings (k, 2). Pieces that were clipped one by one do not quite meet
    along shared edges, because of rounding, and some are so thin that their corners are out of order. They are joined
    on a grid finer than ``tolerance``. The union is widened by ``tolerance``, which closes hairline gaps, and narrowed
    again with mitred corners, and every vertex is moved back to the corner of a piece from which it came. If there are
    many pieces, or the union still has many parts, the pieces are widened before they are joined, because widening a
    union of 720 needles takes half a minute. Groups of pieces that are apart are joined one by one. Holes narrower than
    ``smallest_hole`` are filled: small pieces are missing there.
    """
    if len(pieces) == 1 and len(pieces[0]) == 1:
        ring = pieces[0][0]
        return [[oriented(without_collinear(ring, tolerance))]] if signed_area(ring) else []
    if len(pieces) == 1:
        return rings_of(shapely_polygon(pieces[0]), tolerance, smallest_hole)
    few = len(pieces) <= MANY
    if few:
        ends, corners = np.cumsum([len(rings[0]) for rings in pieces]), np.vstack([rings[0] for rings in pieces])
        group = core.groups_apart(corners, ends, 2 * MITRE * tolerance)
        apart = [np.flatnonzero(group == number) for number in range(int(group.max()) + 1)]
        if len(apart) > 1:
            parts = (union([pieces[k] for k in members.tolist()], tolerance, smallest_hole) for members in apart)
            return [part for found in parts for part in found]
        if all(len(rings) == 1 for rings in pieces):
            around, ends, known = core.outlines_of(corners, ends, 2 * tolerance)
            if known:
                return _nested(np.split(around, ends[:-1]), tolerance, smallest_hole)
    else:
        rows = (pieces[k : k + FEW] for k in range(0, len(pieces), FEW))  # neighbours, which are often one polygon
        pieces = [part for row in rows for part in union(row, tolerance, smallest_hole)]
    whole = polygons(pieces)
    # a piece whose corners are out of order is its hull; what was joined before may touch itself, as needles at a point
    mended = shapely.convex_hull(whole) if few else shapely.make_valid(whole)
    solid = np.where(shapely.is_valid(whole), whole, mended)
    merged = shapely.union_all(solid, grid_size=tolerance / 8) if few else None
    if merged is None or shapely.get_num_geometries(merged) > SCATTERED:
        wide = shapely.buffer(solid, tolerance, join_style="mitre", mitre_limit=MITRE)
        merged = shapely.union_all(wide, grid_size=None if merged is None else tolerance / 8)
    else:
        merged = merged.buffer(tolerance, join_style="mitre", mitre_limit=MITRE)
    merged = merged.buffer(-tolerance, join_style="mitre", mitre_limit=MITRE)
    corners = np.vstack([ring for rings in pieces for ring in rings])
    nearest = search_tree(corners)
    result = []
    for rings in rings_of(merged, tolerance, smallest_hole):
        found = [(np.asarray(d), k) for d, k in (nearest.query(ring) for ring in rings)]
        restored = zip(rings, found, strict=True)
        rings = [np.where(d[:, None] <= 4 * tolerance, corners[k], ring) for ring, (d, k) in restored]
        if (
            shapely_polygon(rings).area > 2 * tolerance * np.ptp(rings[0], axis=0).max()
        ):  # otherwise a sliver between pieces
            result.append(rings)
    return result


def _nested(rings: Sequence[Float], tolerance: float, smallest_hole: float) -> list[list[Float]]:
    """Return polygons [outline, holes ...] of outlines and holes; without slivers and narrow holes, as ``union``."""
    rings = [without_collinear(ring, tolerance) for ring in rings]
    areas = [signed_area(ring) for ring in rings]
    outlines = [k for k, area in enumerate(areas) if area > 2 * tolerance * np.ptp(rings[k], axis=0).max()]
    result = [[rings[k]] for k in outlines]
    for hole, area in zip(rings, areas, strict=True):
        if -2 * area > smallest_hole * float(np.linalg.norm(turned(hole, 1) - hole, axis=1).sum()):
            middle = (hole[:1] + hole[1:2]) / 2
            of = [k for k, outline in enumerate(outlines) if inside(shapely.Polygon(rings[outline]), middle).all()]
            if of:  # otherwise a hole in a sliver
                result[min(of, key=lambda k: areas[outlines[k]])].append(hole)
    return result


def polygons(pieces: Sequence[Sequence[Float]]) -> NDArray[np.object_]:
    """Return the polygons (n,) of pieces [outline, holes ...], made in two calls, as one call for each is slow."""
    if not pieces:
        return np.empty(0, dtype=object)
    rings = [ring for piece in pieces for ring in piece]
    owner = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    closed: Any = shapely.linearrings(np.vstack(rings), indices=owner)  # shapely's stubs do not mention rings here
    return np.asarray(shapely.polygons(closed, indices=np.repeat(np.arange(len(pieces)), [len(p) for p in pieces])))


def rings_of(geometry: shapely.Geometry, tolerance: float, smallest_hole: float) -> list[list[Float]]:
    """Return the polygons of a geometry as [outline counter-clockwise, holes clockwise ...].

    Holes narrower than ``smallest_hole`` are left out.
    """
    result = []
    for part in getattr(geometry, "geoms", [geometry]):
        if not isinstance(part, shapely.Polygon) or part.is_empty or not part.area > 0:
            continue
        rings = [oriented(without_collinear(np.array(part.exterior.coords)[:-1], tolerance))]
        rings += [
            oriented(without_collinear(np.array(hole.coords)[:-1], tolerance), clockwise=True)
            for hole in part.interiors
            if 2 * shapely.Polygon(hole).area > smallest_hole * hole.length
        ]
        result.append(rings)
    return result
