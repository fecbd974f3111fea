"""The facets of a convex hull, and how a heavy body rolls from one to another on a level plane.

Such a body turns over the edges of its hull. Its energy is its weight times the height of its centre of mass: h on a
facet, and up to the distance of the edge about which it turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush

import numpy as np

from holdfast.base.arrays import Float, Int, unit
from holdfast.geometry.hull import qhull


@dataclass(frozen=True, eq=False)
class HullGraph:
    """The facets of a hull, seen from a ``centre`` (3,) inside it, and the ridges between them.

    ``normals`` (F, 3) point outwards, ``heights`` (F,) [m] are the distances of the centre from the planes of the
    facets, and ``solid`` (F,) is the share of all directions from the centre that meet each of them. ``corners`` holds
    the corners (k, 3) [m] of each facet. ``ridges`` (R, 2) are the pairs of facets on both sides of each edge, in both
    orders, and ``inside`` (R,) [m] is how far from the edge the centre's projection lies in the first one, negative
    beyond it.
    """

    normals: Float
    heights: Float
    solid: Float
    corners: list[Float]
    ridges: Int
    inside: Float

    @classmethod
    def of(cls, points: Float, centre: Float, flat: float) -> HullGraph:
        """Return that of points (n, 3); neighbours whose normals differ by less than ``flat`` [rad] are one facet."""
        hull = qhull(points)
        normals, simplices = hull.equations[:, :3], hull.simplices
        neighbours = hull.neighbors.astype(np.int64)
        label = _joined(normals, neighbours, flat)
        members = [np.flatnonzero(label == k) for k in range(label.max() + 1)]
        corners = [points[np.unique(simplices[own])] for own in members]
        facing = np.array([unit(normals[own].mean(0)) for own in members])
        heights = [float(((own - centre) @ normal).max()) for own, normal in zip(corners, facing, strict=True)]
        solid = np.bincount(label, _solid_angles(points[simplices] - centre))
        at, opposite = np.nonzero(label[neighbours] != label[:, None])
        one, other, beyond = (points[simplices[at, (opposite + k) % 3]] - centre for k in (1, 2, 0))
        into = np.cross(facing[label[at]], unit(other - one))
        into *= np.sign(((beyond - one) * into).sum(1))[:, None]
        ridges = np.column_stack([label[at], label[neighbours[at, opposite]]])
        return cls(facing, np.array(heights), solid / solid.sum(), corners, ridges, -(one * into).sum(1))

    @cached_property
    def margins(self) -> Float:
        """How far (F,) [m] within each facet the centre's projection lies; negative if the body rolls off it."""
        found = np.full(len(self.heights), np.inf)
        np.minimum.at(found, self.ridges[:, 0], self.inside)
        return found

    @cached_property
    def turns(self) -> Float:
        """The angle (R,) [rad] by which the body turns over each ridge."""
        one, other = np.moveaxis(self.normals[self.ridges], 1, 0)
        return np.asarray(np.arccos(np.clip((one * other).sum(1), -1, 1)))

    @cached_property
    def tilts(self) -> Float:
        """The tilt (R,) [rad] of the plane, the worst way round, at which the body turns over each ridge."""
        return np.asarray(np.arctan2(self.inside, self.heights[self.ridges[:, 0]]))

    @cached_property
    def passes(self) -> Float:
        """The greatest height (R,) [m] of the centre while the body turns from the first facet to the second."""
        first, second = self.heights[self.ridges].T
        beyond = first * np.sin(self.turns) - self.inside * np.cos(self.turns)  # ``inside``, seen from the second facet
        over = (self.inside > 0) & (beyond > 0)
        return np.asarray(np.where(over, np.hypot(first, self.inside), np.maximum(first, second)))

    @cached_property
    def rests(self) -> Int:
        """The facet (F,) on which the body comes to rest, slowly, if it is let go on each.

        It turns over the edge that the centre is farthest beyond. Where rounding lets it turn from one facet to another
        and back, it rests on the one whose edges it is least beyond.
        """
        order = np.argsort(self.inside, kind="stable")[::-1]
        over = np.arange(len(self.heights))
        over[self.ridges[order, 0]] = self.ridges[order, 1]  # the last one counts, with the least ``inside``
        found = np.where(self.margins < 0, -1, np.arange(len(over)))
        for k in range(len(over)):
            way = [k]
            while found[way[-1]] < 0 and over[way[-1]] not in way:
                way.append(int(over[way[-1]]))
            end = found[way[-1]]
            if end < 0:
                round_ = way[way.index(over[way[-1]]) :]
                end = max(round_, key=lambda one: self.margins[one])
            found[way] = end
        return found

    def families(self, level: float, gap: float) -> Int:
        """Return the family (F,) of each facet: the number of one on which the body comes to rest.

        Facets on which the centre is equally high, and also between them, up to the share ``level`` and ``gap`` [m],
        are a family: a body rolls on a round side from one to another.
        """
        family, h = self.rests.copy(), self.heights
        for k in np.argsort(self.passes, kind="stable"):
            one, other = self.rests[self.ridges[k]]
            low, high = sorted((h[one], h[other]))
            if family[one] != family[other] and max(high, self.passes[k]) <= (1 + level) * low + gap:
                family[family == family[other]] = family[one]
        return family

    def steady(self, family: Int, costs: Float, least: float, drop: float = np.inf) -> Int:
        """Return the families without those that cost up to ``least`` to leave: they belong to where the body goes.

        A family stays if one of its facets costs more, as on a round side whose lowest facet is at its end.
        ``costs`` (R,) are those of ridges, as in ``way_out``. Those that are seen under the smallest shares of the
        directions go first, and those where the centre of mass falls by more than ``drop`` [m] stay.
        """
        family = family.copy()
        shares = np.bincount(family, self.solid)
        for number in np.unique(family)[np.argsort(shares[np.unique(family)], kind="stable")].tolist():
            if any(self.way_out(family, k, costs)[0] > least for k in self.members(family, number).tolist()):
                continue
            lowest = self.lowest(family, number)
            _, after = self.way_out(family, lowest, costs)
            if self.heights[lowest] - self.heights[self.lowest(family, after)] <= drop:
                family[family == number] = after
        return family

    def members(self, family: Int, number: int) -> Int:
        """Return the facets of a family on which the body rests."""
        return np.flatnonzero((family == number) & (self.rests == np.arange(len(family))))

    def lowest(self, family: Int, number: int) -> int:
        """Return the facet of a family on which the centre is lowest."""
        members = self.members(family, number)
        return int(members[np.argmin(self.heights[members])])

    def way_out(self, family: Int, start: int, costs: Float) -> tuple[float, int]:
        """Return what it takes to turn the body from a facet out of its family, and the family where it goes.

        Of all ways, over one edge or several, it is the one whose largest cost is least, of the ``costs`` (R,) of
        ridges. If there is no other family the cost is inf.
        """
        queue, seen = [(-np.inf, start)], set[int]()
        while queue:
            cost, at = heappop(queue)
            if family[at] != family[start]:
                return cost, int(family[at])
            if at not in seen:
                seen.add(at)
                for k in self._leaving[at]:
                    heappush(queue, (max(cost, float(costs[k])), int(self.ridges[k, 1])))
        return np.inf, int(family[start])

    @cached_property
    def _leaving(self) -> list[list[int]]:
        """The ridges that leave each facet, by number."""
        found: list[list[int]] = [[] for _ in self.heights]
        for k, first in enumerate(self.ridges[:, 0].tolist()):
            found[first].append(k)
        return found


def _joined(normals: Float, neighbours: Int, flat: float) -> Int:
    """Return the facet (n,) of each triangle: neighbours with almost the normal of its first one."""
    label = np.full(len(normals), -1, dtype=np.int64)
    count = 0
    for k in range(len(normals)):
        if label[k] >= 0:
            continue
        label[k], waiting = count, [k]
        while waiting:
            for other in neighbours[waiting.pop()]:
                if label[other] < 0 and normals[other] @ normals[k] > np.cos(flat):
                    label[other] = count
                    waiting.append(int(other))
        count += 1
    return label


def _solid_angles(triangles: Float) -> Float:
    """Return the solid angles (n,) under which triangles (n, 3, 3) are seen from the origin (van Oosterom)."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.asarray(2 * np.arctan2(np.abs((a * np.cross(b, c)).sum(1)), below))
