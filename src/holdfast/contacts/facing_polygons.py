"""Large flat faces opposite each other: polygon against polygon, exact however many triangles they are made of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from holdfast.base.arrays import Float, Int, unit
from holdfast.base.rigid import tangents
from holdfast.base.values import Value, seal
from holdfast.contacts.skin import Skin
from holdfast.contacts.tolerances import Angles
from holdfast.geometry import polygon as flat
from holdfast.geometry.area import outline_vector
from holdfast.geometry.surface import Surface

ALONG = float(np.cos(np.radians(3)))  # normals of faces that lie along each other, far closer than kin (patches.py)
BROAD = 2.0  # of the gap: pieces of faces that are narrower may lose their edges' contacts to rounding


@dataclass(frozen=True, eq=False, repr=False)
class Piece(Value):
    """A polygon halfway between two surfaces: ``rings`` (k, 3), the outline and holes; ``normal`` (3,) from a into b.

    ``heights``: least and largest separation of the surfaces there [m]; ``curved``: whether one of the two stands for a
    curved surface.
    """

    rings: tuple[Float, ...]
    normal: Float
    heights: tuple[float, float]
    curved: bool = False

    def __post_init__(self) -> None:
        seal(self)


def facing_pairs(a: Skin, b: Skin, pairs: Int, *, cos_angle: float) -> tuple[set[tuple[int, int]], Int]:
    """Split ``pairs`` (m, 2) of triangles: faces of which one is large and that are opposed, and what is left (n, 2).

    A large face meets a triangle of a small one as a whole. Large faces have their numbers, triangles -1 downwards.
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
    a: Skin,
    b: Skin,
    local_a: Surface,
    local_b: Surface,
    faces: Iterable[tuple[int, int]],
    *,
    gap: float,
    depth: float,
    angles: Angles,
) -> tuple[dict[tuple[int, int], list[Piece]], list[tuple[int, int]]]:
    """Where pairs of ``faces``, numbered as by ``facing_pairs``, lie opposite each other, and the pairs left to search.

    Of two large faces that lie along each other, the polygon answers for all edges and corners between them. All other
    pairs of large faces are left: their triangles have to be looked at.
    """
    pieces, left = {}, []
    for key_a, key_b in sorted(faces):
        rings_a, normal_a = _outline(a, local_a, key_a)
        rings_b, normal_b = _outline(b, local_b, key_b)
        along = -float(normal_a @ normal_b)
        curved = _is_curved(a, key_a) or _is_curved(b, key_b)
        opposed = along >= float(angles.cosine(np.array(curved)))
        found = _shared(rings_a, normal_a, rings_b, normal_b, gap, depth, curved) if opposed else []
        pieces[key_a, key_b] = found
        if min(key_a, key_b) >= 0 and (along < ALONG or not _broad(found, gap)):
            left.append((key_a, key_b))
    return pieces, left


def _broad(pieces: Sequence[Piece], gap: float) -> bool:
    """Tell whether there are pieces, all of them far wider than rounding errors of their corners, and than the gap."""
    for piece in pieces:
        ring = piece.rings[0]
        around = float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())
        if 2 * float(np.linalg.norm(outline_vector(ring - ring[0]))) <= BROAD * gap * around:
            return False
    return len(pieces) > 0


def _outline(skin: Skin, local: Surface, key: int) -> tuple[list[Float], Float]:
    """Rings in the world and the outward normal of a large face, or of a triangle, numbered -1 downwards."""
    if key < 0:
        return [skin.triangles[-1 - key]], skin.normals[-1 - key]
    rings = [skin.vertices[ring] for ring in local.facets.rings[key]]
    return rings, unit(outline_vector(rings[0] - rings[0][0]))


def _is_curved(skin: Skin, key: int) -> bool:
    """Whether a large face, or a triangle, numbered -1 downwards, stands for a curved surface."""
    return bool(skin.curved[-1 - key if key < 0 else int(np.argmax(skin.facet == key))])


def _shared(
    rings_a: list[Float], normal_a: Float, rings_b: list[Float], normal_b: Float, gap: float, depth: float, curved: bool
) -> list[Piece]:
    """The overlap of two polygons seen along the mean of their normals, where they are near enough to each other."""
    normal = unit(normal_a - normal_b)
    frame = np.array(tangents(normal))
    origin = rings_a[0][0]

    def plane(rings: list[Float], own: Float) -> tuple[Float, float]:
        """Height along ``normal`` as slopes (2,) and level: h = slopes · x + level."""
        slopes = -(frame @ own) / (normal @ own)
        return slopes, float((rings[0][0] - origin) @ own / (normal @ own))

    (slope_a, level_a), (slope_b, level_b) = plane(rings_a, normal_a), plane(rings_b, normal_b)
    seen_a, seen_b = (flat.shapely_polygon([(r - origin) @ frame.T for r in rings]) for rings in (rings_a, rings_b))
    shared: shapely.Geometry = shapely.intersection(seen_a, seen_b)
    slope, level = slope_b - slope_a, level_b - level_a
    for sign, bound in ((-1.0, gap), (1.0, depth)):
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
    """The part of a shape where slope · x + level >= 0."""
    points = shapely.get_coordinates(shape)
    if not len(points) or (points @ slope + level).min() >= 0:
        return shape
    steep = float(np.linalg.norm(slope))
    if (points @ slope + level).max() < 0 or steep == 0:
        return shapely.Polygon()
    along = slope / steep
    across = np.array([-along[1], along[0]])
    reach = 2 * float(np.ptp(points, axis=0).max()) + float(np.abs(points).max())
    foot = -level / steep * along
    corners = [foot - reach * across, foot + reach * across]
    corners += [corners[1] + 2 * reach * along, corners[0] + 2 * reach * along]
    return shapely.intersection(shape, shapely.Polygon(corners))
