"""Faces of two surfaces that oppose each other within a gap and an angle, and the polygons that they share.

Small faces are clipped triangle by triangle; large flat ones are intersected as polygons, exact however many triangles
they consist of.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
import shapely

from holdfast.base.arrays import Float, Int, unit
from holdfast.base.rigid import tangents
from holdfast.base.values import Value
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry import polygon as flat
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import outline_vector
from holdfast.native import core

ALONG = float(np.cos(np.radians(3)))  # cosine of the largest angle between faces that count as parallel
BROAD = 2.0  # [gaps] in a narrower piece, rounding may lose the contacts of edges


def clip_faces(a: SearchMesh, b: SearchMesh, pairs: Int, tolerances: Tolerances) -> list[Piece]:
    """Return where faces of ``pairs`` (m, 2) face each other."""
    cosines = tolerances.angles.cosine(np.array([False, True])).tolist()
    corners, counts, normals, heights, bent = core.clip_faces(a, b, pairs, tolerances.gap, tolerances.depth, *cosines)
    ends = np.cumsum(counts).tolist()
    return [
        Piece((corners[end - count : end].copy(),), normal.copy(), (low, high), round_ > 0)
        for end, count, normal, (low, high), round_ in zip(
            ends, counts.tolist(), normals, heights.tolist(), bent.tolist(), strict=True
        )
    ]


@dataclass(frozen=True, eq=False, repr=False)
class Piece(Value):
    """A polygon halfway between two surfaces a and b that face each other.

    ``rings`` (k, 3) [m] are its outline and holes, and ``normal`` (3,) points into b. ``heights`` [m] are the least and
    the largest separation of the surfaces. ``curved`` is True if one of the two faces represents a curved surface.
    """

    rings: tuple[Float, ...]
    normal: Float
    heights: tuple[float, float]
    curved: bool = False

    def __post_init__(self) -> None:
        for array in (*self.rings, self.normal):  # as seal does, in a fifth of the time: there may be 200,000
            array.setflags(write=False)


def facing_pairs(a: SearchMesh, b: SearchMesh, pairs: Int, *, cos_angle: float) -> tuple[set[tuple[int, int]], Int]:
    """Split ``pairs`` (m, 2) of triangles into opposed pairs with a large face, and pairs of small faces (n, 2).

    In the first set, a large face is given by its number, and a triangle t of a small face by -1 - t.
    """
    large_a, large_b = a.facet[pairs[:, 0]], b.facet[pairs[:, 1]]
    whole = (large_a >= 0) | (large_b >= 0)
    small = pairs[~whole]
    pairs, large_a, large_b = pairs[whole], large_a[whole], large_b[whole]
    opposed = (a.normals[pairs[:, 0]] * b.normals[pairs[:, 1]]).sum(1) <= -cos_angle
    keys_a = np.where(large_a >= 0, large_a, -1 - pairs[:, 0])[opposed]
    keys_b = np.where(large_b >= 0, large_b, -1 - pairs[:, 1])[opposed]
    return set(zip(keys_a.tolist(), keys_b.tolist(), strict=True)), small


def facing_polygons(
    a: SearchMesh,
    b: SearchMesh,
    local_a: Surface,
    local_b: Surface,
    faces: Iterable[tuple[int, int]],
    tolerances: Tolerances,
) -> tuple[dict[tuple[int, int], list[Piece]], list[tuple[int, int]]]:
    """Intersect pairs of ``faces``, numbered as by ``facing_pairs``; return the pieces, and the pairs left to search.

    For two large parallel faces, the polygon accounts for all edges and corners between them. The triangles of all
    other pairs of large faces still have to be searched.
    """
    pieces, left = {}, []
    of_a, of_b = cache(partial(_polygon, a, local_a)), cache(partial(_polygon, b, local_b))
    flat_cosine, curved_cosine = tolerances.angles.cosine(np.array([False, True])).tolist()
    for key_a, key_b in sorted(faces):
        (rings_a, normal_a, curved_a), (rings_b, normal_b, curved_b) = of_a(key_a), of_b(key_b)
        along, curved = -float(normal_a @ normal_b), curved_a or curved_b
        opposed = along >= (curved_cosine if curved else flat_cosine)
        found = _shared(rings_a, normal_a, rings_b, normal_b, tolerances, curved) if opposed else []
        pieces[key_a, key_b] = found
        if min(key_a, key_b) >= 0 and (along < ALONG or not _broad(found, tolerances.gap)):
            left.append((key_a, key_b))
    return pieces, left


def _broad(pieces: Sequence[Piece], gap: float) -> bool:
    """Tell whether there are pieces and all of them are wide compared with the gap and with rounding errors."""
    for piece in pieces:
        ring = piece.rings[0]
        around = float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())
        if 2 * float(np.linalg.norm(outline_vector(ring - ring[0]))) <= BROAD * gap * around:
            return False
    return len(pieces) > 0


def _polygon(mesh: SearchMesh, local: Surface, key: int) -> tuple[list[Float], Float, bool]:
    """Return the rings in the world of a large face or, for a negative key, of a triangle; and its outward normal.

    The last value tells whether it represents a curved surface.
    """
    if key < 0:
        return [mesh.triangles[-1 - key]], mesh.normals[-1 - key], bool(mesh.curved[-1 - key])
    rings = [mesh.vertices[ring] for ring in local.facets.rings[key]]
    curved = bool(mesh.curved[np.argmax(mesh.facet == key)])
    return rings, unit(outline_vector(rings[0] - rings[0][0])), curved


def _shared(
    rings_a: list[Float], normal_a: Float, rings_b: list[Float], normal_b: Float, tolerances: Tolerances, curved: bool
) -> list[Piece]:
    """Intersect two polygons, seen along their mean normal, where their separation is within gap and depth."""
    normal = unit(normal_a - normal_b)
    frame = np.array(tangents(normal))
    origin = rings_a[0][0]

    def plane(rings: list[Float], own: Float) -> tuple[Float, float]:
        """Return slopes (2,) and level of the height along ``normal``: h = slopes · x + level."""
        slopes = -(frame @ own) / (normal @ own)
        return slopes, float((rings[0][0] - origin) @ own / (normal @ own))

    (slope_a, level_a), (slope_b, level_b) = plane(rings_a, normal_a), plane(rings_b, normal_b)
    seen_a, seen_b = (flat.shapely_polygon([(r - origin) @ frame.T for r in rings]) for rings in (rings_a, rings_b))
    try:
        shared: shapely.Geometry = shapely.intersection(seen_a, seen_b)
    except shapely.GEOSException:  # a face of a damaged mesh may cross itself
        shared = shapely.intersection(seen_a.buffer(0), seen_b.buffer(0))
    slope, level = slope_b - slope_a, level_b - level_a
    for sign, bound in ((-1.0, tolerances.gap), (1.0, tolerances.depth)):
        shared = _kept(shared, sign * slope, sign * level + bound)
    result = []
    for part in getattr(shared, "geoms", [shared]):
        if isinstance(part, shapely.Polygon) and not part.is_empty:
            rings = [np.array(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)]
            heights = rings[0] @ slope + level
            middle = [(r @ (slope_a + slope_b) + level_a + level_b) / 2 for r in rings]
            lifted = tuple(origin + r @ frame + m[:, None] * normal for r, m in zip(rings, middle, strict=True))
            result.append(Piece(lifted, normal, (float(heights.min()), float(heights.max())), curved))
    return result


def _kept(shape: shapely.Geometry, slope: Float, level: float) -> shapely.Geometry:
    """Return the part of a shape where slope · x + level >= 0."""
    points = shapely.get_coordinates(shape)
    if not len(points) or (points @ slope + level).min() >= 0:
        return shape
    steep = float(np.linalg.norm(slope))
    if (points @ slope + level).max() < 0 or steep == 0:
        return shapely.Polygon()
    along = slope / steep
    across = np.array([-along[1], along[0]])
    extent = 2 * float(np.ptp(points, axis=0).max()) + float(np.abs(points).max())
    foot = -level / steep * along
    corners = [foot - extent * across, foot + extent * across]
    corners += [corners[1] + 2 * extent * along, corners[0] + 2 * extent * along]
    return shapely.intersection(shape, shapely.Polygon(corners))
