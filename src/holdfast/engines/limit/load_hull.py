"""Known points of the set of loads that are carried, until combinations of them come close to it where it matters.

The hull of points that are carried is itself carried. Its gauge at a load (geometry/hull_gauge.py) is a small linear
program, whose multiplier is the facet of the hull that the ray of the load goes through. The corner of the true set
farthest beyond that facet is one cone program away (family.py): if it is not beyond it at all, the facet lies on
the border of the true set, for all loads whose rays go through it; if it is, it becomes a known point. This is column
generation, after Dantzig and Wolfe (Operations Research 8, 1960), and few points are needed because they are corners.

How far the true set reaches beyond a facet also bounds it from outside, everywhere: no load that is carried goes
farther in that direction. Between these cutting planes and the hull lies the gap of every ray, without a solve, and
solves go where the gap is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.progress import report
from holdfast.engines.contract import LoadHull
from holdfast.engines.limit.family import Family, Ray, Support
from holdfast.engines.limit.rounding import UP
from holdfast.geometry.hull_gauge import hull_gauge

DRAWN = 100  # loads of each kind whose gaps are looked at in a round
BATCH = 20  # facets that are pushed out before gaps are looked at again
MOST, WIDER = 0.9, 3.0  # share of the loads whose gaps are to be at most so many times the wanted one
LARGEST = 2.0  # a known point goes no farther than this many boxes
TILT = 0.01  # of a facet, so that the farthest load is a corner and not the middle of a face that is parallel to it
ALIKE = 6  # number of digits to which two facets must agree to be the same
FINER = 0.25  # a ray whose gap is this share of the wanted one is left as it is


def find_hull(family: Family, support: Support, near: Float, accuracy: float, solves: int) -> LoadHull:
    """Find points that the ``family`` carries, until half of the loads drawn are within ``accuracy`` of the set.

    Half of the loads that are drawn point anywhere, and half are among ``near`` (n, d). ``solves`` bounds the solves.
    """
    search = _Growth(family, support, near, np.random.default_rng(0))
    gaps = search.run(accuracy, solves)
    reached, most = np.quantile(gaps, (0.5, MOST)).tolist()
    return LoadHull(np.array(search.known), np.array(search.price), reached, most, search.solves)


@dataclass(eq=False)
class _Growth:
    """The known points, each with its price: an upper bound of the gauge of the true set there.

    Points are scaled to lie on the border as far as it is known, at the price 1. Where a ray does not end within
    LARGEST boxes, its point is its direction, and the price what is known of it. ``planes`` are rows a with a·x <= 1
    for every x that is carried, as far as the solver is right: gaps are measured by them, and no point depends on them.
    """

    family: Family
    support: Support
    near: Float
    rng: np.random.Generator
    known: list[Float] = field(default_factory=list)
    price: list[float] = field(default_factory=list)
    planes: list[Float] = field(default_factory=list)
    solves: int = 0

    def run(self, wanted: float, most: int) -> Float:
        """Add corners until half of the gaps are as wanted; returns the gaps (n,) of the loads that were drawn last."""
        axes = self.family.axes()
        unit = np.minimum([ray.reach for ray in axes], 1.0).reshape(2, -1).min(0)  # pressed down, it may take any load
        self.solves = len(axes)
        self._learn(axes)
        while True:
            loads = self._drawn(unit)
            gaps, facets = self._gaps(loads)
            report(self.family.where, min(self.solves, most), most)
            wide = np.flatnonzero(gaps > FINER * wanted)
            close = np.median(gaps) <= wanted and np.quantile(gaps, MOST) <= WIDER * wanted
            if close or self.solves >= most or not len(wide):
                report(self.family.where, most, most)
                return gaps
            if not self._pushed_out(facets[self.rng.permutation(wide)], min(BATCH, most - self.solves)):
                report(self.family.where, most, most)
                return gaps

    def _drawn(self, unit: Float) -> Float:
        """Loads (n, d): some anywhere, with coordinates in ``unit`` (d,), and some among those asked for."""
        anywhere = self.rng.normal(size=(DRAWN, len(unit))) * unit
        if not len(self.near):
            return anywhere
        return np.vstack([anywhere, self.near[self.rng.integers(len(self.near), size=DRAWN)]])

    def _gaps(self, loads: Float) -> tuple[Float, Float]:
        """The gaps (n,) of loads (n, d), by which share of the largest factor theirs may be too small; their facets."""
        used, facets = hull_gauge(np.array(self.known), np.array(self.price), loads)
        least = (loads @ np.array(self.planes).reshape(-1, loads.shape[1]).T).max(1, initial=0.0)
        share = np.divide(least, used, out=np.ones(len(used)), where=used > 0)  # a ray without an end has no gap
        return np.clip(1 - share, 0.0, 1.0), facets

    def _pushed_out(self, facets: Float, most: int) -> bool:
        """Find the corners beyond ``most`` of these facets (n, d) at the most; tell whether any was looked at."""
        corners, seen = [], set[bytes]()
        for facet in facets:
            key = np.round(facet / max(float(np.abs(facet).max()), 1e-300), ALIKE).tobytes()
            if len(seen) >= most or key in seen or not facet.any():
                continue
            seen.add(key)
            self.solves += 1
            aim = facet * (1 + TILT * self.rng.normal(size=len(facet)))
            corner = self.support.farthest(aim)
            if corner is None:
                continue
            reach = float(aim @ corner.x)
            if reach > 0:
                self.planes.append(aim / reach)
            if float(facet @ corner.x) > 1:
                corners.append(corner)
        self._learn(self.family.through(corners))
        return bool(seen)

    def _learn(self, rays: list[Ray]) -> None:
        for ray in rays:
            if ray.row is not None:
                self.planes.append(ray.row)
            if not ray.reach > 0:
                continue
            size = float(np.abs(ray.direction).max())
            reach = min(ray.reach, LARGEST / size)
            self.known.append(reach * ray.direction)
            self.price.append(reach / ray.reach * UP)
