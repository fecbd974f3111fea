"""Known points of the set of loads that are carried, until combinations of them come close to it where it matters.

The hull of points that are carried is itself carried. Its gauge at a load (geometry/hull_gauge.py) is a small linear
program, whose multiplier is the facet of the hull that the ray of the load goes through. The corner of the true set
farthest beyond that facet is one cone program away (support.py): if it is not beyond it at all, the facet lies on the
border of the true set, for all loads whose rays go through it; if it is, it becomes a known point. This is column
generation, after Dantzig and Wolfe (Operations Research 8, 1960), and few points are needed because they are corners.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.progress import report
from holdfast.engines.capabilities import LoadHull
from holdfast.engines.limit.family import Family, Ray
from holdfast.engines.limit.rounding import UP
from holdfast.engines.limit.support import Corner, Support
from holdfast.geometry.hull_gauge import hull_gauge

ROUNDS = 500  # the most batches: facets that were looked at before cost no solve
BATCH = 20  # loads of each kind whose facets are looked at before their gauges are computed again
USUAL = 0.9  # share of the loads that must be as close as asked for
LARGEST = 2.0  # boxes: a known point goes no farther
TILT = 0.01  # of a facet, so that the farthest load is a corner and not the middle of a face that is parallel to it
ALIKE = 9  # digits to which facets are the same
FINER = 0.25  # a facet that is this share of the wanted gap from the true set is left as it is


def find_hull(family: Family, support: Support, near: Float, gap: float, budget: int) -> LoadHull:
    """Find points that the ``family`` carries, until most loads that are drawn are within ``gap`` of the true set.

    Half of the loads that are drawn point anywhere, and half are among ``near`` (n, d). ``budget`` bounds the solves.
    """
    search = _Growth(family, support, near, np.random.default_rng(0))
    reached = search.run(gap, budget)
    return LoadHull(np.array(search.known), np.array(search.price), reached, search.solves)


@dataclass(eq=False)
class _Growth:
    """The known points, each with its price: an upper bound of the gauge of the true set there.

    Points are scaled to lie on the border as far as it is known, at the price 1. Where a ray does not end within
    LARGEST boxes, its point is its direction, and the price what is known of it. ``seen`` has the gap of each facet
    that was looked at.
    """

    family: Family
    support: Support
    near: Float
    rng: np.random.Generator
    known: list[Float] = field(default_factory=list)
    price: list[float] = field(default_factory=list)
    seen: dict[bytes, float] = field(default_factory=dict)
    solves: int = 0

    def run(self, wanted: float, budget: int) -> float:
        """Add corners until enough facets are within ``wanted`` of the true set; returns the gap of the last batch."""
        axes = self.family.axes()
        unit = np.minimum([ray.reach for ray in axes], 1.0).reshape(2, -1).mean(0)
        self.solves = len(axes)
        self._learn(axes)
        reached = 1.0
        for _ in range(ROUNDS):
            if reached <= wanted or self.solves >= budget:
                break
            report(self.family.where, self.solves, budget)
            reached = float(np.quantile(self._grow(self._drawn(unit), wanted), USUAL))
        report(self.family.where, budget, budget)
        return reached

    def _drawn(self, unit: Float) -> Float:
        """Loads (n, d): some anywhere, with coordinates in ``unit`` (d,), and some among those asked for."""
        anywhere = self.rng.normal(size=(BATCH, len(unit))) * unit
        if not len(self.near):
            return anywhere
        return np.vstack([anywhere, self.near[self.rng.integers(len(self.near), size=BATCH)]])

    def _grow(self, loads: Float, wanted: float) -> Float:
        """Push out the facets that the rays of these loads go through; returns the gaps (n,) there."""
        facets = hull_gauge(np.array(self.known), np.array(self.price), loads)[1]
        gaps, corners = [], []
        for facet in facets:
            key = np.round(facet / max(float(np.abs(facet).max()), 1e-300), ALIKE).tobytes()
            if not facet.any():  # the ray has no end
                self.seen[key] = 0.0
            if key not in self.seen:
                corner = self._beyond(facet)
                self.seen[key] = 1.0 if corner is None else max(1 - 1 / max(float(facet @ corner.x), 1.0), 0.0)
                if corner is not None and self.seen[key] > FINER * wanted:
                    corners.append(corner)
            gaps.append(self.seen[key])
        self._learn(self.family.through(corners))
        return np.array(gaps)

    def _beyond(self, facet: Float) -> Corner | None:
        """Return the corner of the true set that is farthest beyond a facet, or None if the solver fails."""
        self.solves += 1
        return self.support.farthest(facet * (1 + TILT * self.rng.normal(size=len(facet))))

    def _learn(self, rays: list[Ray]) -> None:
        for ray in rays:
            if not ray.reach > 0:
                continue
            size = float(np.abs(ray.direction).max())
            reach = min(ray.reach, LARGEST / size)
            self.known.append(reach * ray.direction)
            self.price.append(reach / ray.reach * UP)
