"""Points whose gauge stays below an engine's ``lower`` in every direction that was asked, convex or not in between.

The set that an elastic engine carries is not convex, so a combination of wrenches that hold need not hold. Each known
point begins at the price of its own direction. Where a combination is cheaper than a direction that was asked allows,
all points of that combination become dearer by the missing factor. Dearer points make no other combination cheaper, so
what is satisfied stays satisfied. Wrenches that nobody asked for measure how often the value lies above in between.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import report
from holdfast.base.rounding import SUM
from holdfast.engines.capabilities import LoadHull
from holdfast.engines.limit.load_hull import LARGEST, MOST, WIDER
from holdfast.geometry.hull_gauge import SLIGHT, hull_gauge

ROUND = 250  # directions that are measured, then learnt
FARTHEST = 200.0  # boxes up to which a factor counts, so that no price is 0: 0 could not become dearer
PASSES = 100  # after which all prices are raised alike

Lower = Callable[[Float], Float]  # the lower bounds (n,) of the factors of loads (n, 6), in units of the box


@dataclass(frozen=True, eq=False)
class CheckedHull:
    """A hull whose value is at most ``lower`` at all directions that were asked, but for ``zeros``, where that is 0.

    Before they were asked, the share ``above`` of the last directions had a value above ``lower``. ``by`` is the
    largest excess at any direction before it was asked, as a share of ``lower`` where that is not 0.
    """

    hull: LoadHull
    above: float
    by: float
    zeros: int

    @property
    def notes(self) -> tuple[str, ...]:
        """What may surprise, in words."""
        of = f"of {self.hull.solves:,} wrenches that were asked lower is 0, where the value is that of their neighbours"
        return (f"at {self.zeros} {of}",) if self.zeros else ()


def checked_hull(lower: Lower, near: Float, accuracy: float, solves: int, where: str) -> CheckedHull:
    """Find a hull for wrenches like ``near`` (n, 6) and any others, until it is as accurate, or after the ``solves``.

    Raises HoldfastError if a direction along an axis has no factor above 0.
    """
    rng = np.random.default_rng(0)
    near = near[near.any(1)]
    loads = np.vstack([np.eye(6), -np.eye(6)])
    factor = np.minimum(lower(loads), FARTHEST)
    if not (factor > 0).all():
        remedy = "the body is about to move, or what moves it is not known"
        raise HoldfastError(message(where, "0 is not inside the set", remedy))
    unit = np.minimum(factor, 1.0).reshape(2, 6).min(0)
    by = 0.0
    while True:
        report(where, min(len(loads), solves), solves)
        known, price = _points(loads, factor)
        _raise(known, price, known, price)
        fresh = rng.normal(size=(min(ROUND, max(solves - len(loads), 2)), 6)) * unit
        if len(near):
            fresh[::2] = near[rng.integers(len(near), size=len(fresh[::2]))]
        fresh /= np.abs(fresh).max(1, keepdims=True)
        found = np.minimum(lower(fresh), FARTHEST)
        used, told = hull_gauge(known, price, fresh)[0], found > 0
        by = max(by, float((1 / (used * found)[told] - 1).max(initial=0.0)))
        _raise(known, price, fresh[told], 1 / found[told])
        value = 1 / hull_gauge(known, price, fresh)[0]
        short = 1 - np.minimum(value, 1.0)[told] / np.minimum(found, 1.0)[told]  # beyond the box nobody asks
        half, most = np.quantile(short, (0.5, MOST)).tolist() if len(short) else (1.0, 1.0)
        loads, factor = np.vstack([loads, fresh]), np.concatenate([factor, found])
        if len(loads) >= solves or (half <= accuracy and most <= WIDER * accuracy):
            break
    report(where, solves, solves)
    hull = LoadHull(known, price, half, most, len(loads))
    above = float((used * found < 1 - SUM).mean())
    return CheckedHull(hull, above, by, int((factor == 0).sum()))


def _points(loads: Float, factor: Float) -> tuple[Float, Float]:
    """Return the points (m, 6) along ``loads`` (n, 6) with a ``factor`` (n,) above 0, and the prices (m,) there."""
    loads, factor = loads[factor > 0], factor[factor > 0]
    reach = np.minimum(factor, LARGEST)
    return loads * reach[:, None], reach / factor


def _raise(known: Float, price: Float, points: Float, least: Float) -> None:
    """Raise prices (m,) until the gauge at all ``points`` (n, 6) is at least ``least`` (n,)."""
    left, least = points, least.copy()
    for _ in range(PASSES):
        used, facets = hull_gauge(known, price, left)
        bad = used < least
        if not bad.any():
            return
        left, least = left[bad], least[bad]
        missing = least / used[bad] * (1 + SUM)
        tight = known @ facets[bad].T >= price[:, None] - SLIGHT  # the combination that each of them is
        price *= np.where(tight, missing, 1.0).max(1)
    price *= max(float((least / hull_gauge(known, price, left)[0]).max()) * (1 + SUM), 1.0)
