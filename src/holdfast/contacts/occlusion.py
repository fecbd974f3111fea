"""Occlusion: bodies do not touch through a third one, so patches behind the surface of another body are removed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Float, frozen
from holdfast.base.ranges import COORDINATES
from holdfast.contacts.interface import Patch
from holdfast.geometry import polygon as flat

Pair = tuple[str, str]
SAME_WAY = 0.95  # cosine of the largest angle between patches on the same side of a body
IN_FRONT = 1e-6  # [gaps] how much nearer a surface has to be in order to hide another one


class Fronts:
    """The patches of all pairs of bodies, each of which may hide patches of other pairs."""

    def __init__(self, found: Mapping[Pair, Sequence[Patch]]) -> None:
        self._found = found
        self._pairs: dict[str, list[Pair]] = {}
        self._nearest: dict[str, float] = {}  # the least mean separation of the faces of each body [m]
        self._screens: dict[str, _Screen] = {}
        self._extents: dict[Pair, Float] = {}
        self._extents_at: dict[str, Float] = {}
        for pair, patches in found.items():
            nearest = min([_level(patch) for patch in patches if _hides(patch)], default=np.inf)
            for end in pair:
                self._pairs.setdefault(end, []).append(pair)
                self._nearest[end] = min(self._nearest.get(end, np.inf), nearest)

    def visible(self, patches: Sequence[Patch], pair: Pair, gap: float, width: float) -> tuple[Patch, ...]:
        """Return the visible parts of patches of a pair; patches of which nothing is hidden are the same objects.

        A patch between a and b is hidden where a patch of a third body with b, or with a, covers it and has a smaller
        separation. Otherwise two bodies on either side of a plate thinner than the gap would touch through it. Parts
        narrower than ``width`` [m] are dropped.
        """
        nearest = min(self._nearest[pair[0]], self._nearest[pair[1]])
        if max(map(_level, patches)) - IN_FRONT * gap <= nearest:
            return tuple(patches)  # mostly so
        if not any(self._others_near(end, pair, gap) for end in pair):
            return tuple(patches)
        left: list[Patch] = []
        for patch in patches:
            before = self._before(patch, pair, gap)
            left += _less(patch, before, gap, width) if before else [patch]
        return tuple(left)

    def _others_near(self, name: str, pair: Pair, gap: float) -> bool:
        """Tell whether a patch of another pair of the body ``name`` may be as near to one of ``pair`` as a screen is.

        ``_Screen.before`` says how near that is.
        """
        if name not in self._extents_at:
            self._extents_at[name] = np.array([self._extent(each) for each in self._pairs[name]])
        others, own = self._extents_at[name], self._extent(pair)
        apart = np.maximum(np.maximum(others[:, :3] - own[3:6], own[:3] - others[:, 3:6]), 0)
        reach = (1 + 2 * COORDINATES) * (others[:, 6] + own[6] + 2 * gap)
        return int(((apart * apart).sum(1) <= reach * reach).sum()) > 1  # the pair is near itself

    def _extent(self, pair: Pair) -> Float:
        """Return the box (7,) of the centroids of a pair's patches, low and high, and the largest radius [m]."""
        if pair not in self._extents:
            patches = self._found[pair]
            centroids = np.array([patch.centroid for patch in patches])
            counts = [len(patch.polygon) for patch in patches]
            arms = np.vstack([patch.polygon for patch in patches]) - np.repeat(centroids, counts, axis=0)
            radius = np.sqrt((arms * arms).sum(1).max())
            self._extents[pair] = np.array([*centroids.min(0), *centroids.max(0), radius])
        return self._extents[pair]

    def _before(self, patch: Patch, pair: Pair, gap: float) -> list[Patch]:
        """Return the patches of third bodies that may hide a part of a patch."""
        if patch.separation is None:
            return []
        farthest = _level(patch) - IN_FRONT * gap
        return [
            front
            for end, inward in zip(pair, (-1.0, 1.0), strict=True)
            if self._nearest[end] < farthest
            for front in self._screen(end).before(patch, pair, inward, farthest, gap)
        ]

    def _screen(self, name: str) -> _Screen:
        if name not in self._screens:
            self._screens[name] = _Screen.of(name, {pair: self._found[pair] for pair in self._pairs[name]})
        return self._screens[name]


def _hides(patch: Patch) -> bool:
    return patch.separation is not None and patch.kind == "face"


def _level(patch: Patch) -> float:
    """Return the mean of the least and the largest separation at a patch [m]; -inf, before everything, if not known."""
    if patch.separation is None:
        return -np.inf
    least, largest = patch.separation
    return (least + largest) / 2


class _Screen(NamedTuple):
    """The n face patches at which a body touches, with the pairs to which they belong.

    ``normals`` (n, 3) point into the body. ``centroids`` (n, 3), mean separations ``levels`` (n,) and ``radii`` (n,)
    are in metres.
    """

    patches: list[Patch]
    pairs: list[Pair]
    normals: Float
    centroids: Float
    levels: Float
    radii: Float

    @classmethod
    def of(cls, name: str, found: Mapping[Pair, Sequence[Patch]]) -> _Screen:
        """Return the screen of the body ``name`` from the patches of all its pairs."""
        fronts = [(patch, pair) for pair, patches in found.items() for patch in patches if _hides(patch)]
        patches = [patch for patch, _ in fronts]
        normals = np.array([patch.normal if pair[1] == name else -patch.normal for patch, pair in fronts])
        centroids = np.array([patch.centroid for patch in patches]).reshape(-1, 3)
        radii = [_radius(patch, centroid) for patch, centroid in zip(patches, centroids, strict=True)]
        levels = np.array([_level(patch) for patch in patches])
        return cls(patches, [pair for _, pair in fronts], normals.reshape(-1, 3), centroids, levels, np.array(radii))

    def before(self, patch: Patch, pair: Pair, inward: float, farthest: float, gap: float) -> list[Patch]:
        """Return the patches of other pairs that may hide a part of ``patch``.

        They face the same way, are at about the same height and have a separation below ``farthest`` [m]. ``inward`` is
        1 if the normal of ``patch`` points into this body, and -1 otherwise.
        """
        arm = self.centroids - patch.centroid
        up = arm @ patch.normal
        radius = (1 + COORDINATES) * (self.radii + _radius(patch, patch.centroid))
        over = (arm * arm).sum(1) - up * up <= radius * radius
        alike = self.normals @ (inward * patch.normal) >= SAME_WAY
        chosen = (self.levels < farthest) & over & (np.abs(up) <= 2 * gap) & alike
        return [self.patches[k] for k in np.flatnonzero(chosen) if self.pairs[k] != pair]


def _radius(patch: Patch, centre: Float) -> float:
    """Return the distance [m] from ``centre`` (3,) to the farthest corner of a patch."""
    return float(np.linalg.norm(patch.polygon - centre, axis=1).max())


def _less(patch: Patch, fronts: Sequence[Patch], gap: float, width: float) -> list[Patch]:
    """Return the parts of a patch that ``fronts`` do not hide.

    A strip narrower than the gap hides nothing, because neighbouring patches overlap that much within the tolerance.
    """
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
    """Return the patch ``other`` projected to the frame of ``patch``."""
    rings = [(ring - patch.polygon[0]) @ patch.frame.T for ring in (other.polygon, *other.holes)]
    if other.kind == "point":
        return shapely.Point(rings[0][0])
    return shapely.LineString(rings[0]) if other.kind == "line" else flat.shapely_polygon(rings)
