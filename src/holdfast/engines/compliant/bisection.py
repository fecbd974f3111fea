"""Peaks of lost paths: bisection by whether the assembly comes to rest under weight and load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.rest import find_rest
from holdfast.engines.verdict import Status

ACCURACY = 2e-4  # relative accuracy of a peak at which bisection stops
FALLBACK_ACCURACY = 5e-3  # relative accuracy that is accepted where bisection stalls
MOST_TRIALS = 40  # loads tried for one peak
MOST_UNDECIDED = 8  # of them that neither rest nor move: each takes long
FARTHEST = 10.0  # search limit, as a multiple of the last load reached
FIRST_STEP, GROWTH = 1e-4, 4.0  # relative, from a load that holds to the next one tried, while none is known to move
PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)  # between a load that holds and one that moves: tried in turn


class Peak(NamedTuple):
    """A load factor that ``holds`` at displacement ``q`` (6J,), and one at which bodies move with ``motion`` (6J,)."""

    holds: float
    moves: float
    q: Float
    motion: Float


def with_bisected_peaks(grid: Grid, W: Float, paths: PathResult) -> PathResult:
    """The paths of columns W (6J, k), with peaks found by bisection where paths were lost.

    From the highest load that a path did reach, upwards. The highest load that holds becomes the peak if under one
    hardly larger (ACCURACY, at most FALLBACK_ACCURACY) the bodies move: they drift, or there is no equilibrium.
    """
    if grid.settled.outcome is not RestOutcome.RESTS:
        return paths
    outcome, peak, short = paths.outcome.copy(), paths.peak.copy(), paths.short.copy()
    q, motion = paths.q.copy(), paths.motion.copy()
    for k in np.flatnonzero(paths.outcome == PathOutcome.LOST).tolist():
        start = Peak(float(paths.peak[k]), np.inf, paths.q[k], paths.motion[k])
        found = _Bisection(grid, W[:, k], start).run()
        if found.holds > 0 and found.moves - found.holds <= FALLBACK_ACCURACY * found.holds:
            outcome[k], peak[k], short[k] = PathOutcome.PEAK, found.holds, found.moves - found.holds
            q[k], motion[k] = found.q, found.motion
    return paths._replace(outcome=outcome, peak=peak, short=short, q=q, motion=motion).sealed()


@dataclass
class _Bisection:
    """The search for one peak, which it narrows; ``passed`` loads were tried in a row without a verdict."""

    grid: Grid
    column: Float
    peak: Peak
    passed: int = 0
    undecided: int = 0

    def run(self) -> Peak:
        """Narrow the peak down until it is accurate, or nothing more is to be had."""
        step = FIRST_STEP
        for _ in range(MOST_TRIALS):
            holds, moves = self.peak.holds, self.peak.moves
            unbounded = np.isinf(moves) and step > FARTHEST
            if not holds > 0 or unbounded or moves - holds <= ACCURACY * holds or self.undecided == MOST_UNDECIDED:
                break
            share = PLACES[self.passed % len(PLACES)]
            self._try(holds + share * (moves - holds) if np.isfinite(moves) else holds * (1 + step))
            if self._stalls():
                break
            step *= GROWTH
        return self.peak

    def _try(self, s: float) -> None:
        """Narrow the peak by whether the assembly rests under s times the load."""
        system = self.grid.system
        load = self.grid.loads(self.column[:, None])[0]
        end = system.under(system.model.wrench + s * load).come_to_rest(near=self.peak.q)
        self.passed = self.passed + 1 if end.outcome is RestOutcome.LOST else 0
        if end.outcome is RestOutcome.RESTS:
            self.peak = self.peak._replace(holds=s, q=end.q)
        elif end.outcome is RestOutcome.DRIFTS:
            self.peak = self.peak._replace(moves=s, motion=end.drift)
        elif find_rest(self.grid.assembly, self.grid.wrench + s * self.column).verdict.status is Status.UNSTABLE:
            self.peak, self.passed = self.peak._replace(moves=s), 0  # no equilibrium at all
        else:
            self.undecided += 1

    def _stalls(self) -> bool:
        """Whether loads between the two had no verdict, in a row: two if the peak is acceptable, else all PLACES."""
        holds, moves = self.peak.holds, self.peak.moves
        accepted = moves - holds <= FALLBACK_ACCURACY * holds
        return bool(np.isfinite(moves)) and self.passed == (2 if accepted else len(PLACES))
