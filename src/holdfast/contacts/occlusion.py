"""Bodies do not touch through a third: what lies behind another surface, seen from the body touched, is taken away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Float, frozen
from holdfast.contacts.interface import Patch
from holdfast.geometry import polygon as flat

Pair = tuple[str, str]
SAME_WAY = 0.95  # cosine: patches that face the same side of a body
ROUNDING = 1e-9  # share of the sum of two radii
IN_FRONT = 1e-6  # of the gap: how much nearer a surface has to be to hide another


def by_body(found: Mapping[Pair, Sequence[Patch]]) -> dict[str, list[Pair]]:
    """The pairs that each body is in."""
    pairs: dict[str, list[Pair]] = {}
    for pair in found:
        for end in pair:
            pairs.setdefault(end, []).append(pair)
    return pairs


def visible(
    patches: Sequence[Patch],
    pair: Pair,
    found: Mapping[Pair, Sequence[Patch]],
    of_body: Mapping[str, Sequence[Pair]],
    gap: float,
    width: float,
) -> list[Patch]:
    """Some patches of a pair less what those of other pairs in ``found`` hide; untouched ones are the same objects.

    A patch between a and b is hidden where a third body's patch with b, or with a, covers it from nearer: within a gap
    wider than a plate, what is above and what is below the plate would otherwise touch through it. What is left and
    narrower than ``width`` [m] is dropped.
    """
    if not patches:
        return []
    fronts = [
        (patch, 1.0 if (end == other[1]) == (end == pair[1]) else -1.0)
        for end in pair
        for other in of_body[end]
        if other != pair
        for patch in found[other]
        if patch.kind == "face" and patch.separation is not None
    ]
    ways = np.array([patch.normal for patch in patches]).T
    screen = _Screen.of([(f, sense) for f, sense in fronts if (sense * f.normal @ ways).max() >= SAME_WAY])
    left: list[Patch] = []
    for patch in patches:
        before = screen.before(patch, gap)
        left += _less(patch, before, gap, width) if before else [patch]
    return left


class _Screen(NamedTuple):
    """Patches of third bodies as arrays: normals and centroids (n, 3), mean separations and radii (n,)."""

    patches: list[Patch]
    normals: Float
    centroids: Float
    levels: Float
    radii: Float

    @classmethod
    def of(cls, fronts: Sequence[tuple[Patch, float]]) -> _Screen:
        """Of patches, each with 1, or with -1 where its normal is to be reversed."""
        patches = [patch for patch, _ in fronts]
        centroids = np.array([patch.centroid for patch in patches]).reshape(-1, 3)
        radii = [_radius(patch, centroid) for patch, centroid in zip(patches, centroids, strict=True)]
        levels = [sum(patch.separation or (0.0,)) / 2 for patch in patches]
        normals = np.array([sense * patch.normal for patch, sense in fronts]).reshape(-1, 3)
        return cls(patches, normals, centroids, np.array(levels), np.array(radii))

    def before(self, patch: Patch, gap: float) -> list[Patch]:
        """Those that face the same way from nearer, at about the same height, and may cover some of a patch."""
        if patch.separation is None or not self.patches:
            return []
        arm = self.centroids - patch.centroid
        up = arm @ patch.normal
        nearer = self.levels < sum(patch.separation) / 2 - IN_FRONT * gap
        reach = (1 + ROUNDING) * (self.radii + _radius(patch, patch.centroid))
        over = (arm * arm).sum(1) - up * up <= reach * reach
        chosen = nearer & over & (np.abs(up) <= 2 * gap) & (self.normals @ patch.normal >= SAME_WAY)
        return [self.patches[k] for k in np.flatnonzero(chosen)]


def _radius(patch: Patch, centre: Float) -> float:
    """The distance [m] from ``centre`` (3,) to the farthest corner of a patch."""
    return float(np.linalg.norm(patch.polygon - centre, axis=1).max())


def _less(patch: Patch, fronts: Sequence[Patch], gap: float, width: float) -> list[Patch]:
    """What is left of a patch; a strip narrower than the gap hides nothing: neighbours overlap so by the tolerance."""
    whole = _seen(patch, patch)
    hidden = []
    for front in fronts:
        shade = _seen(front, patch)
        shared = shapely.intersection(shade, whole) if patch.kind == "face" else shade
        hidden += [
            part
            for part in getattr(shared, "geoms", [shared])
            if isinstance(part, shapely.Polygon) and 2 * part.area > gap * part.length
        ]
    if not hidden:
        return [patch]
    left = shapely.difference(whole, shapely.union_all(hidden))
    if left.equals(whole):
        return [patch]
    if patch.kind == "face":
        polygons = flat.rings_of(left, 1e-3 * width, width)
    else:
        polygons = [[shapely.get_coordinates(part)] for part in getattr(left, "geoms", [left]) if not part.is_empty]
    parts = []
    for outline, *holes in polygons:
        polygon = frozen(patch.lifted(outline))
        part = replace(patch, polygon=polygon, holes=tuple(frozen(patch.lifted(hole)) for hole in holes))
        if part.kind == "point" or max(part.width, part.length) > width:
            parts.append(part)
    return parts


def _seen(other: Patch, patch: Patch) -> shapely.Geometry:
    """A patch in the frame of another."""
    rings = [(ring - patch.polygon[0]) @ patch.frame.T for ring in (other.polygon, *other.holes)]
    if other.kind == "point":
        return shapely.Point(rings[0][0])
    return shapely.LineString(rings[0]) if other.kind == "line" else flat.shapely_polygon(rings)
