"""Peaks of lost load paths, found by bisection on whether the assembly comes to rest under weight and load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.elastic_model import motion_row
from holdfast.engines.compliant.grid import Grid

ACCURACY = 2e-4  # relative accuracy of a peak at which bisection stops
FALLBACK_ACCURACY = 5e-3  # relative accuracy beyond which bisection does not insist where it stalls
WIDEST = 0.5  # width of a bracket, relative to its upper end, up to which the largest load that holds is an answer
MOST_TRIALS = 40  # largest number of loads tried for one peak
MOST_STEPS = 3000  # of Newton's method on all loads tried for one peak, after which no further load is tried
MOST_UNDECIDED = 8  # largest number of trials that remain undecided: each takes long
FARTHEST = 10.0  # search limit, as a multiple of the last load reached
FIRST_STEP, GROWTH = 1e-4, 4.0  # first relative step of the load, and its growth, where no load is known to move bodies
PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)  # where to try next between a load that holds and one that moves bodies, in turn


class Peak(NamedTuple):
    """The bracket around a peak.

    Under the load factor ``holds`` the assembly rests at the displacement ``q`` (6J,). Under the larger factor
    ``moves`` the bodies move with ``motion`` (6J,). Both vectors are in the units of the elastic model.
    """

    holds: float
    moves: float
    q: Float
    motion: Float


def with_bisected_peaks(grid: Grid, W: Float, paths: PathResult) -> PathResult:
    """Return the load paths of columns W (6J, k), with the peaks of lost paths found by bisection.

    The search lies between the highest load that the path reached, or none, and the load above which limit analysis
    proves that bodies move; where that is infinite, it goes upwards from the load that the path reached. Bisection aims
    at ACCURACY. The highest load that holds becomes the peak, which may be too low by the width of the bracket
    (``short``), but never too high. Paths whose bracket remains wider than WIDEST remain lost.
    """
    lost = np.flatnonzero(paths.outcome == PathOutcome.LOST)
    if grid.settled.outcome is not RestOutcome.RESTS or not len(lost):
        return paths
    outcome, peak, short = paths.outcome.copy(), paths.peak.copy(), paths.short.copy()
    q, motion = paths.q.copy(), paths.motion.copy()
    for k in lost.tolist():
        found = _Bisection(grid, W[:, k], _bracket(grid, W[:, k], paths, k)).run()
        if found.holds > 0 and found.moves - found.holds <= WIDEST * found.moves < np.inf:
            outcome[k], peak[k], short[k] = PathOutcome.PEAK, found.holds, found.moves - found.holds
            q[k], motion[k] = found.q, found.motion
    return paths._replace(outcome=outcome, peak=peak, first=peak, before=peak, short=short, q=q, motion=motion).sealed()


def _bracket(grid: Grid, column: Float, paths: PathResult, k: int) -> Peak:
    """Return what path k and limit analysis say of the peak under a load ``column`` (6J,).

    If the path was lost at once, the assembly holds no more than its weight. Bodies move with the path's motion or,
    where all that begins there is resisted, with the mechanism of limit analysis.
    """
    certain = grid.certain.load_factor(column[:, None])
    begun = paths.peak[k] > 0
    holds, q = (float(paths.peak[k]), paths.q[k]) if begun else (0.0, grid.settled.q)
    mechanism = certain.mechanism[0]
    known = mechanism is None or paths.motion[k].any()
    motion = paths.motion[k] if known else motion_row(grid.assembly, mechanism.twists)
    moves = float(certain.upper[0])
    return Peak(holds, moves if moves > holds else np.inf, q, motion)


@dataclass
class _Bisection:
    """The search for one peak by bisection.

    ``passed`` counts the loads that were tried in a row without a verdict, ``undecided`` all loads without one, and
    ``steps`` the steps of Newton's method that all of them took.
    """

    grid: Grid
    column: Float
    peak: Peak
    passed: int = 0
    undecided: int = 0
    steps: int = 0

    def run(self) -> Peak:
        """Narrow the bracket until it is accurate or bisection stalls, and return it."""
        step = FIRST_STEP
        for _ in range(MOST_TRIALS):
            holds, moves = self.peak.holds, self.peak.moves
            unbounded = np.isinf(moves) and step > FARTHEST
            spent = self.undecided == MOST_UNDECIDED or self.steps > MOST_STEPS
            if (np.isinf(moves) and not holds > 0) or unbounded or moves - holds <= ACCURACY * holds or spent:
                break
            share = PLACES[self.passed % len(PLACES)]
            self._try(holds + share * (moves - holds) if np.isfinite(moves) else holds * (1 + step))
            if self._stalls():
                break
            step *= GROWTH
        return self.peak

    def _try(self, s: float) -> None:
        """Narrow the bracket by finding out whether the assembly comes to rest under ``s`` times the load."""
        system = self.grid.system
        load = self.grid.loads(self.column[:, None])[0]
        end = system.under(system.model.wrench + s * load).come_to_rest(near=self.peak.q)
        self.steps += end.steps
        self.passed = self.passed + 1 if end.outcome is RestOutcome.LOST else 0
        if end.outcome is RestOutcome.RESTS:
            self.peak = self.peak._replace(holds=s, q=end.q)
        elif end.outcome is RestOutcome.DRIFTS:
            self.peak = self.peak._replace(moves=s, motion=end.drift)
        else:
            self.undecided += 1

    def _stalls(self) -> bool:
        """Say whether bisection stalls: too many loads in a row inside the bracket had no verdict.

        Two are too many if the bracket is already accurate to FALLBACK_ACCURACY, else as many as there are PLACES.
        """
        holds, moves = self.peak.holds, self.peak.moves
        accepted = moves - holds <= FALLBACK_ACCURACY * holds
        return bool(np.isfinite(moves)) and self.passed == (2 if accepted else len(PLACES))
