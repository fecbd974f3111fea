"""Patches from clipped pieces and touching features: those that belong together are joined, covered ones dropped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from holdfast.base.arrays import Bool, Float, Int, frozen, unit
from holdfast.base.rigid import tangents
from holdfast.contacts.clipping import Piece
from holdfast.contacts.interface import Patch
from holdfast.contacts.search_mesh import Features
from holdfast.contacts.tolerances import Angles
from holdfast.geometry import polygon as flat
from holdfast.geometry.triangles import SMOOTH
from holdfast.native import core

NEGLIGIBLE_WIDTH = 1e-6  # width, relative to the size of the smaller body, below which a patch is a rounding error
NOMINAL_BREADTH = 1e-3  # width of a line or a point in the weights of nodes, relative to the size of the smaller body
HAIRLINE = 1e-3  # relative to the negligible width: gaps between pieces that belong together
SAME_WAY = float(np.cos(np.radians(15)))  # cosine of the largest angle between normals of the same contact
BLENDED = float(np.cos(SMOOTH))  # the same if one of the normals is a mean, which deviates more from those of faces
STRAIGHT = float(np.cos(np.radians(2)))  # cosine of the largest angle between lines that may be joined
SLACK = 2e-9  # share of a line that is a rounding error
MOST_POINTS = 16  # largest number of points with similar normals of a pair: corners of their hull, then farthest ones


def face_patches(pieces: Sequence[Piece], gap: float, angles: Angles, negligible: float) -> list[Patch]:
    """Join pieces to face patches: the largest remaining piece defines a plane, and all pieces in it are joined."""
    if not pieces:
        return []
    outlines = [piece.rings[0] for piece in pieces]
    counts = np.array([len(ring) for ring in outlines])
    corners, starts = np.vstack(outlines), np.cumsum(counts) - counts
    centres = np.add.reduceat(corners, starts) / counts[:, None]
    extent = np.maximum.reduceat(np.abs(corners - np.repeat(centres, counts, axis=0)).max(1), starts)
    normals = np.array([piece.normal for piece in pieces])
    curved = np.array([piece.curved for piece in pieces])
    left = np.flatnonzero(extent > negligible / 2)
    patches: list[Patch] = []
    while len(left):
        seed = left[np.argmax(extent[left])]
        offset = np.abs((centres[left] - centres[seed]) @ normals[seed])
        alike = normals[left] @ normals[seed] >= angles.cosine(curved[left] | curved[seed])
        in_plane = alike & (offset <= max(gap, negligible))
        patches += _plane_patches([pieces[k] for k in left[in_plane]], centres[seed], negligible)
        left = left[~in_plane]
    return sorted(patches, key=lambda patch: -patch.area)


def _plane_patches(pieces: Sequence[Piece], origin: Float, negligible: float) -> list[Patch]:
    rings = [ring for piece in pieces for ring in piece.rings]
    counts, number = np.array([len(ring) for ring in rings]), np.array([len(piece.rings) for piece in pieces])
    ends, corners = np.cumsum(counts), np.vstack(rings) - origin
    starts, outlines = ends - counts, np.cumsum(number) - number
    normal = pieces[0].normal
    if len(pieces) > 1:
        follows = np.arange(1, len(corners) + 1)
        follows[ends - 1] = starts
        areas = np.add.reduceat(np.cross(corners, corners[follows]), starts)[outlines]
        normal = unit(np.linalg.norm(areas, axis=1) @ np.array([piece.normal for piece in pieces]))
    frame = frozen(np.array(tangents(normal)))
    means = (np.add.reduceat(corners, starts) / counts[:, None])[outlines]
    level = float(np.mean(means @ normal))
    base = origin + level * normal
    seen = corners @ frame.T
    flat_rings = [seen[start:end] for start, end in zip(starts, ends, strict=True)]
    flats = [flat_rings[first : first + count] for first, count in zip(outlines, number, strict=True)]
    middles = means @ frame.T
    all_heights = np.array([piece.heights for piece in pieces])
    patches = []
    parts = flat.union(flats, HAIRLINE * negligible, negligible)
    if len(parts) > flat.MANY:  # fine cones meet in 20,000 needles
        parts = [parts[k] for k in thinned(np.array([outline.mean(0) for outline, *_ in parts]), flat.MANY)]
    for (outline, *holes), polygon in zip(parts, flat.polygons(parts), strict=True):
        mine = flat.inside(polygon, middles)
        heights = all_heights[mine] if mine.any() else all_heights
        separation = (float(heights[:, 0].min()), float(heights[:, 1].max()))
        lifted = [frozen(base + ring @ frame) for ring in (outline, *holes)]
        patch = Patch(lifted[0], frozen(np.array(normal)), tuple(lifted[1:]), separation)
        patch.__dict__["frame"] = frame  # it depends on the normal alone
        if patch.width > negligible:
            patches.append(patch)
    return patches


def line_patches(lines: Features, faces: Sequence[Patch], gap: float, negligible: float, breadth: float) -> list[Patch]:
    """Join lines along one edge to line patches, and leave out what lies on a face patch."""
    if not len(lines.ends):
        return []
    found = []
    cover = Cover(faces, gap)
    run = lines.ends[:, 1] - lines.ends[:, 0]
    length = np.linalg.norm(run, axis=1)
    left = np.flatnonzero(cover.free(lines))
    left = left[np.argsort(-length[left], kind="stable")]
    while len(left):
        seed = left[0]
        origin, along = lines.ends[seed, 0], unit(lines.ends[seed, 1] - lines.ends[seed, 0])
        arm = lines.ends[left] - origin
        at = arm @ along
        off = np.linalg.norm(arm - at[..., None] * along, axis=2).max(1)
        straight = np.abs(run[left] @ along) >= STRAIGHT * length[left]
        along_it = straight & (lines.normals[left] @ lines.normals[seed] >= SAME_WAY) & (off <= gap)
        along_it[0] = True  # the seed itself, in spite of rounding if the gap is zero
        members = left[along_it]
        spans = np.sort(at[along_it], axis=1)
        for low, high, whose in _joined(spans, negligible):
            ends = origin + np.outer([low, high], along)
            mine = members[whose]
            normal = unit((length[mine, None] * lines.normals[mine]).sum(0))
            heights, inset = lines.heights[mine], float(lines.inset[mine].min())
            # parts shorter than the breadth are left out: their ends are contacts of points
            for part in cover.left_of(ends, normal, breadth, bool(lines.blended[mine].all())):
                separation = (float(heights.min()), float(heights.max()))
                found.append(Patch(frozen(part), frozen(normal), (), separation, breadth, inset))
        left = left[~along_it]
    return found


def _joined(spans: Float, apart: float) -> list[tuple[float, float, Int]]:
    """Join intervals (n, 2) that are at most ``apart`` from each other; return the ends and members of each union."""
    order = np.argsort(spans[:, 0], kind="stable")
    result: list[tuple[float, float, Int]] = []
    members: list[int] = []
    low, high = np.inf, -np.inf
    for k in order:
        if spans[k, 0] > high + apart and members:
            result.append((low, high, np.array(members)))
            members, low, high = [], np.inf, -np.inf
        members.append(int(k))
        low, high = min(low, float(spans[k, 0])), max(high, float(spans[k, 1]))
    result.append((low, high, np.array(members)))
    return result


class Cover:
    """Patches that were found before; they cover features with similar normals that lie on them, within ``gap`` [m]."""

    def __init__(self, patches: Sequence[Patch], gap: float) -> None:
        rings = [ring for patch in patches for ring in (patch.polygon, *patch.holes)]
        self._native = patches and core.Cover(
            np.vstack(rings),
            np.cumsum([len(ring) for ring in rings]),
            np.cumsum([1 + len(patch.holes) for patch in patches]),
            np.array([patch.normal for patch in patches]),
            np.array([patch.frame for patch in patches]),
            gap,
        )

    def free(self, features: Features) -> Bool:
        """Tell which points or lines (n,) do not lie entirely on one of the patches."""
        if not self._native:
            return np.ones(len(features.ends), dtype=bool)
        alike = np.where(features.blended, BLENDED, SAME_WAY)
        return ~self._native.covered(features.ends, np.ascontiguousarray(features.normals), alike).view(bool)

    def left_of(self, ends: Float, normal: Float, negligible: float, blended: bool) -> list[Float]:
        """Return the parts (2, 3) of a line, longer than ``negligible`` [m], that lie on none of the patches."""
        run = ends[1] - ends[0]
        length = float(np.linalg.norm(run))
        alike, slack = BLENDED if blended else SAME_WAY, SLACK * length
        left = self._native.left(ends, normal, alike, slack).tolist() if self._native else [(0.0, 1.0)]
        long = [part for part in left if (part[1] - part[0]) * length > max(negligible, slack)]
        return [ends[0] + np.array(part)[:, None] * run for part in long]


def point_patches(points: Features, others: Sequence[Patch], gap: float, breadth: float) -> list[Patch]:
    """Return point patches for points that no face or line covers, one for each place and direction, nearest first."""
    if not len(points.ends):
        return []
    places = points.ends[:, 0]
    free = Cover(others, gap).free(points)
    order = np.argsort(np.abs(points.heights[:, 0]), kind="stable")
    left = order[free[order]]
    found = []
    while len(left):
        way = points.normals[left] @ points.normals[left[0]] >= SAME_WAY
        for members in _spread(places, points.normals, left[way], max(gap, breadth)):
            normal = unit(points.normals[members].mean(0))
            nearest = members[0]
            height = float(points.heights[nearest, 0])
            place, inset = frozen(places[nearest][None].copy()), float(points.inset[members].min())
            found.append(Patch(place, frozen(normal), (), (height, height), breadth, inset))
        left = left[~way]
    return found


def _spread(places: Float, normals: Float, members: Int, apart: float) -> list[Int]:
    """Group points with similar normals within ``apart`` [m]; of more than MOST_POINTS groups, some are chosen."""
    groups: list[list[int]] = []
    centres: list[Float] = []
    for k in members:
        distance = [float(np.linalg.norm(places[k] - c)) for c in centres]
        if distance and min(distance) <= apart:
            groups[int(np.argmin(distance))].append(int(k))
        else:
            groups.append([int(k)])
            centres.append(places[k])
    if len(groups) > MOST_POINTS:
        places_of = np.array(centres)
        frame = np.array(tangents(unit(normals[members].mean(0))))
        chosen = thinned((places_of - places_of[0]) @ frame.T, MOST_POINTS)
        groups = [groups[k] for k in chosen]
    return [np.array(group) for group in groups]


def thinned(points: Float, count: int) -> list[int]:
    """Return the indices of at most ``count`` of the points (n, 2): corners of their hull, then farthest points."""
    hull = shapely.convex_hull(shapely.MultiPoint(points))
    corners = np.array(hull.exterior.coords)[:-1] if isinstance(hull, shapely.Polygon) else np.array(hull.coords)
    pool = [int(np.argmin(((points - c) ** 2).sum(1))) for c in corners]
    chosen = [pool[0]]
    distance = ((points - points[chosen[0]]) ** 2).sum(1)
    for candidates in (np.array(sorted(set(pool))), np.arange(len(points))):
        while len(chosen) < count:
            best = int(candidates[np.argmax(distance[candidates])])
            if distance[best] <= 0:
                break
            chosen.append(best)
            distance = np.minimum(distance, ((points - points[best]) ** 2).sum(1))
    return chosen
