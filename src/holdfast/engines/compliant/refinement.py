"""Peaks of load paths on grids that are fine enough, with lower bounds that allow for the discretisation error."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.bisection import with_bisected_peaks
from holdfast.engines.compliant.grid import FINER, Grid

SAFETY = 2.0  # discretisation error over the change to the next grid: errors fall at least in proportion to the step
LEAST_ERROR = 2e-3  # minimum relative discretisation error
LARGE = 0.05  # relative change of the load at a peak above which the whole path is followed on the finer grid
COARSE = 0.02  # relative change of the peak of the whole path above which the answer is taken from the finer grid
REFINEMENTS = 3  # largest number of re-solves on ever finer grids
MOST_NODES = 20_000  # largest number of nodes of a finer grid from which answers are taken


class Bounded(NamedTuple):
    """Load paths with lower bounds of their peaks.

    ``below`` (k,) is the peak minus the discretisation error; it is 0 if there is no peak or no bound was asked for.
    """

    paths: PathResult
    below: Float

    @property
    def lower(self) -> Float:
        """The lower bounds (k,): ``below``, or inf where the path is endless."""
        return np.where(self.paths.outcome == PathOutcome.ENDLESS, np.inf, self.below)


@dataclass(frozen=True, eq=False)
class Refined:
    """Answers from ``grid``, re-solved on finer grids at most ``refinements`` times where its nodes are too coarse."""

    grid: Grid
    refinements: int = REFINEMENTS

    @property
    def _finer(self) -> Refined:
        return replace(self, grid=self.grid.finer, refinements=self.refinements - 1)

    @property
    def _may_refine(self) -> bool:
        return self.refinements > 0 and FINER**2 * len(self.grid.nodes) <= MOST_NODES

    def found(self, W: Float, *, cuts: bool = False) -> PathResult:
        """Follow the paths of columns W (6J, k) on this grid, and find the peaks of lost paths by bisection."""
        return with_bisected_peaks(self.grid, W, self.grid.paths(W, cuts=cuts))

    def answers(self, W: Float, *, cuts: bool = False, bounds: bool = True) -> Bounded:
        """Follow the paths of columns W (6J, k).

        With ``bounds`` each path is followed on a grid that is fine enough for it, and has a lower bound. Without, all
        paths are followed on this grid and the lower bounds are 0. ``cuts`` is as in ``Grid.paths``.
        """
        paths = self.found(W, cuts=cuts)
        return self._bounded(W, paths, cuts=cuts) if bounds else Bounded(paths, np.zeros(W.shape[1]))

    def _bounded(self, W: Float, paths: PathResult, *, cuts: bool) -> Bounded:
        """Give the paths of this grid lower bounds, and take paths from finer grids where this one is too coarse.

        The lower bound is the peak minus SAFETY times the estimated discretisation error minus LEAST_ERROR times the
        peak. The estimate is the change of the load when the finer grid takes the displacement of the peak. If that
        load is not found or changes by more than LARGE, the whole path is followed on the finer grid, and the estimate
        is the change of its peak (all of the peak if the finer grid has none). If that change is more than COARSE, the
        path on the finer grid becomes the answer, as long as refinement is allowed.
        """
        below = np.zeros(W.shape[1])
        peaked = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        peaks = paths.chosen(peaked)
        peak = peaks.peak
        finer = self.grid.finer.loads_at_peaks(W[:, peaked], peaks)
        unsure = np.flatnonzero((finer < 0) | (np.abs(finer - peak) > LARGE * peak))
        if len(unsure):
            asked = W[:, peaked[unsure]]
            there = self._finer.found(asked, cuts=cuts)
            finer[unsure] = there.factor
            if self._may_refine:
                changed = np.abs(there.peak - peak[unsure]) > COARSE * peak[unsure]
                coarse = (there.outcome == PathOutcome.PEAK) & changed
                better = self._finer._bounded(asked[:, coarse], there.chosen(coarse), cuts=cuts)
                taken = peaked[unsure[coarse]]
                paths = paths.replaced(taken, better.paths)
                below[taken] = better.below
                kept = np.ones(len(peaked), dtype=bool)
                kept[unsure[coarse]] = False
                peaked, peak, finer = peaked[kept], peak[kept], finer[kept]
        change = np.where(finer < peak, peak - finer, np.minimum(finer, 2 * peak) - peak)
        below[peaked] = np.maximum(peak - SAFETY * change - LEAST_ERROR * peak, 0.0)
        return Bounded(paths, below)
