"""Bodies do not touch through a third: what lies behind another surface, seen from the body touched, is taken away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import shapely

from holdfast.base.arrays import frozen
from holdfast.contacts.interface import Patch
from holdfast.geometry import polygon as flat

Pair = tuple[str, str]
SAME_WAY = 0.95  # cosine: patches that face the same side of a body
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
    fronts = [
        (patch, 1.0 if (end == other[1]) == (end == pair[1]) else -1.0)
        for end in pair
        for other in of_body[end]
        if other != pair
        for patch in found[other]
        if patch.kind == "face"
    ]
    left: list[Patch] = []
    for patch in patches:
        before = [front for front, sense in fronts if _before(front, sense, patch, gap)]
        left += _less(patch, before, gap, width) if before else [patch]
    return left


def _before(front: Patch, sense: float, patch: Patch, gap: float) -> bool:
    """Whether a patch of a third body faces the same way from nearer, at about the same height.

    ``sense`` is 1, or -1 where the normal of the front is to be reversed.
    """
    if sense * float(front.normal @ patch.normal) < SAME_WAY or front.separation is None or patch.separation is None:
        return False
    nearer = sum(front.separation) / 2 < sum(patch.separation) / 2 - IN_FRONT * gap
    return bool(nearer and abs((front.centroid - patch.centroid) @ patch.normal) <= 2 * gap)


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
