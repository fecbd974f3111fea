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


class Fronts:
    """Where all pairs of bodies touch, ``found``: what may hide a part of where other pairs do."""

    def __init__(self, found: Mapping[Pair, Sequence[Patch]]) -> None:
        self._found = found
        self._pairs: dict[str, list[Pair]] = {}
        self._nearest: dict[str, float] = {}
        self._screens: dict[str, _Screen] = {}
        for pair in found:
            for end in pair:
                self._pairs.setdefault(end, []).append(pair)

    def visible(self, patches: Sequence[Patch], pair: Pair, gap: float, width: float) -> list[Patch]:
        """Return some patches of a pair less what those of other pairs hide; untouched ones are the same objects.

        A patch between a and b is hidden where a third body's patch with b, or with a, covers it from nearer: within a
        gap wider than a plate, what is above and what is below the plate would otherwise touch through it. What is left
        and narrower than ``width`` [m] is dropped.
        """
        left: list[Patch] = []
        for patch in patches:
            before = self._before(patch, pair, gap)
            left += _less(patch, before, gap, width) if before else [patch]
        return left

    def _before(self, patch: Patch, pair: Pair, gap: float) -> list[Patch]:
        """Return the patches of third bodies that may hide some of a patch."""
        if patch.separation is None:
            return []
        farthest = _level(patch) - IN_FRONT * gap
        return [
            front
            for end, inward in zip(pair, (-1.0, 1.0), strict=True)
            if self._nearest_of(end) < farthest  # as nearly nowhere
            for front in self._screen(end).before(patch, pair, inward, farthest, gap)
        ]

    def _nearest_of(self, name: str) -> float:
        """Return the least mean separation of the faces of a body [m]."""
        if name not in self._nearest:
            faces = (patch for pair in self._pairs[name] for patch in self._found[pair] if _hides(patch))
            self._nearest[name] = min((_level(patch) for patch in faces), default=np.inf)
        return self._nearest[name]

    def _screen(self, name: str) -> _Screen:
        if name not in self._screens:
            self._screens[name] = _Screen.of(name, {pair: self._found[pair] for pair in self._pairs[name]})
        return self._screens[name]


def _hides(patch: Patch) -> bool:
    return patch.kind == "face" and patch.separation is not None


def _level(patch: Patch) -> float:
    """The mean separation of the surfaces at a patch [m]."""
    return sum(patch.separation or (0.0,)) / 2


class _Screen(NamedTuple):
    """The faces where a body touches as arrays, with the pairs they are of.

    ``normals`` into the body and centroids (n, 3), mean separations and radii (n,).
    """

    patches: list[Patch]
    pairs: list[Pair]
    normals: Float
    centroids: Float
    levels: Float
    radii: Float

    @classmethod
    def of(cls, name: str, found: Mapping[Pair, Sequence[Patch]]) -> _Screen:
        """Of the body of this name, of which all pairs are ``found``."""
        fronts = [(patch, pair) for pair, patches in found.items() for patch in patches if _hides(patch)]
        patches = [patch for patch, _ in fronts]
        normals = np.array([patch.normal if pair[1] == name else -patch.normal for patch, pair in fronts])
        centroids = np.array([patch.centroid for patch in patches]).reshape(-1, 3)
        radii = [_radius(patch, centroid) for patch, centroid in zip(patches, centroids, strict=True)]
        levels = np.array([_level(patch) for patch in patches])
        return cls(patches, [pair for _, pair in fronts], normals.reshape(-1, 3), centroids, levels, np.array(radii))

    def before(self, patch: Patch, pair: Pair, inward: float, farthest: float, gap: float) -> list[Patch]:
        """Those of other pairs that face the same way at about the same height and may cover some of a patch.

        The normal of the patch times ``inward`` points into this body; only what is nearer than ``farthest`` [m] hides.
        """
        arm = self.centroids - patch.centroid
        up = arm @ patch.normal
        reach = (1 + ROUNDING) * (self.radii + _radius(patch, patch.centroid))
        over = (arm * arm).sum(1) - up * up <= reach * reach
        alike = self.normals @ (inward * patch.normal) >= SAME_WAY
        chosen = (self.levels < farthest) & over & (np.abs(up) <= 2 * gap) & alike
        return [self.patches[k] for k in np.flatnonzero(chosen) if self.pairs[k] != pair]


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
