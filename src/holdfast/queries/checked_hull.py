"""Points whose gauge stays below an engine's ``lower`` in every direction that was asked, convex or not in between.

The set that an elastic engine carries is not convex, so a combination of loads that hold need not hold. Each known
point begins at the price of its own direction. Where a combination is cheaper than a direction that was asked allows,
all points of that combination become dearer by the missing factor. Dearer points make no other combination cheaper, so
what is satisfied stays satisfied. Then as many directions are asked again, from which nothing is learnt but where the
value is too large: half of them are middles of combinations, which lie farthest from all that was asked before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import report
from holdfast.base.ranges import SUM
from holdfast.engines.contract import LoadHull
from holdfast.engines.limit.load_sets import LARGEST, MOST, WIDER
from holdfast.geometry.hull import SLIGHT, hull_gauge

ROUND = {3: 30, 6: 250}  # directions by dimension that are measured, then learnt
FARTHEST = 200.0  # boxes up to which a factor counts, so that no price is 0: 0 could not become dearer
# Share by which the whole hull is drawn in: ``lower`` scatters by so much from one direction to the next, as 0.2 to 4 %
# are subtracted for the grid. Without, 18 of 2,762 directions were above, bench/suites/holding.py; most by less
SCATTER = 0.05
PASSES = 100  # after which all prices are raised alike

Lower = Callable[[Float], Float]  # the lower bounds (n,) of the factors of loads (n, d), in units of the box


@dataclass(frozen=True, eq=False)
class CheckedHull:
    """A hull whose value is at most ``lower`` at all directions that were asked, but for ``zeros``, where that is 0.

    After it was found, ``checks`` directions in between were asked. At ``failed`` of them the value was above
    ``lower``, before it was lowered there, by at most the share ``by`` of ``lower``.
    """

    hull: LoadHull
    checks: int
    failed: int
    by: float
    zeros: int

    @property
    def above(self) -> float:
        """The share of the checks that failed."""
        return self.failed / max(self.checks, 1)

    def notes(self, what: str) -> tuple[str, ...]:
        """Say how it was checked: not by a proof, but at so many of ``what`` was asked, in the plural."""
        by = f" by up to {self.by:.1%}, and the value was lowered there" if self.failed else ""
        found = f"checked, not proved: of {self.checks:,} {what} asked in between {self.failed:,} were above lower"
        of = f"of {self.hull.solves:,} {what} that were asked lower is 0, where the value is that of their neighbours"
        return (f"{found}{by}", *((f"at {self.zeros} {of}",) if self.zeros else ()))


def checked_hull(lower: Lower, near: Float, accuracy: float, solves: int, where: str) -> CheckedHull:
    """Find a hull for loads like ``near`` (n, d) and any others, until it is as accurate, or after the ``solves``.

    Half of the solves are checks. Raises HoldfastError if a direction along an axis has no factor above 0.
    """
    rng, size = np.random.default_rng(0), near.shape[1]
    near = near[near.any(1)]
    loads = np.vstack([np.eye(size), -np.eye(size)])
    factor = np.minimum(lower(loads), FARTHEST)
    if not (factor > 0).all():
        along = ", ".join(f"{value:g}" for value in loads[np.argmin(factor)] + 0.0)
        remedy = "the body is about to move, or what moves it is not known"
        raise HoldfastError(message(where, f"0 is not inside the set: nothing surely holds along ({along})", remedy))
    unit = np.minimum(factor, 1.0).reshape(2, size).min(0)
    half, most = 1.0, 1.0

    def drawn(count: int) -> Float:
        fresh = rng.normal(size=(count, size)) * unit
        if len(near):
            fresh[: count // 2] = near[rng.integers(len(near), size=count // 2)]
        return np.asarray(fresh / np.abs(fresh).max(1, keepdims=True))

    while len(loads) < solves // 2 and not (half <= accuracy and most <= WIDER * accuracy):
        report(where, len(loads), solves)
        known, price = _points(loads, factor)
        _raise_prices(known, price, known, price)
        fresh = drawn(min(ROUND[size], solves // 2 - len(loads)))
        found = np.minimum(lower(fresh), FARTHEST)
        value, positive = 1 / hull_gauge(known, price, fresh)[0], found > 0
        half, most = _shortfall(value[positive], found[positive])
        loads, factor = np.vstack([loads, fresh]), np.concatenate([factor, found])
    known, price = _points(loads, factor)
    above_zero = factor > 0
    _raise_prices(known, price, loads[above_zero], 1 / factor[above_zero])
    between = drawn(len(loads))
    tight = _tight(known, price, hull_gauge(known, price, between[1::2])[1])
    middles = tight.T.astype(float) @ (known / price[:, None])  # of the combinations that the rays go through
    between[1::2] = middles / np.abs(middles).max(1, keepdims=True)
    found = np.minimum(lower(between), FARTHEST)
    used, positive = hull_gauge(known, price, between)[0], found > 0
    excess = 1 / (used * found)[positive] - 1
    by = max(float(excess.max(initial=0.0)), 0.0)
    _raise_prices(known, price, between[positive], 1 / found[positive])
    price *= 1 + SCATTER
    report(where, solves, solves)
    positive = positive & (np.arange(len(between)) % 2 == 0)  # as anybody would ask, not the middles
    half, most = _shortfall(1 / hull_gauge(known, price, between[positive])[0], found[positive])
    hull = LoadHull(known, price, half, most, len(loads) + len(between))
    return CheckedHull(hull, len(between), int((excess > SUM).sum()), by, int((factor == 0).sum() + (found == 0).sum()))


def _shortfall(value: Float, found: Float) -> tuple[float, float]:
    """Return by which share half of the values (n,) at the most are below those ``found`` (n,), and MOST of them."""
    if not len(found):
        return 1.0, 1.0
    short = 1 - np.minimum(value, 1.0) / np.minimum(found, 1.0)  # beyond the box nobody asks
    half, most = np.maximum(np.quantile(short, (0.5, MOST)), 0.0).tolist()
    return half, most


def _points(loads: Float, factor: Float) -> tuple[Float, Float]:
    """Return the points (m, d) along ``loads`` (n, d) with a ``factor`` (n,) above 0, and the prices (m,) there."""
    loads, factor = loads[factor > 0], factor[factor > 0]
    reach = np.minimum(factor, LARGEST)
    return loads * reach[:, None], reach / factor


def _tight(known: Float, price: Float, facets: Float) -> Bool:
    """Tell which points (m,) make up the combinations of which these are the ``facets`` (n, d)."""
    return np.asarray(known @ facets.T >= price[:, None] - SLIGHT)


def _raise_prices(known: Float, price: Float, points: Float, least: Float) -> None:
    """Raise prices (m,) until the gauge at all ``points`` (n, d) is at least ``least`` (n,)."""
    left, least = points, least.copy()
    for _ in range(PASSES):
        used, facets = hull_gauge(known, price, left)
        bad = used < least
        if not bad.any():
            return
        left, least = left[bad], least[bad]
        missing = least / used[bad] * (1 + SUM)
        price *= np.where(_tight(known, price, facets[bad]), missing, 1.0).max(1)
    price *= max(float((least / hull_gauge(known, price, left)[0]).max()) * (1 + SUM), 1.0)
