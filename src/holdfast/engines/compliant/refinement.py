"""Peaks on nodes that are fine enough, with lower bounds that allow for the discretisation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.bisection import with_bisected_peaks
from holdfast.engines.compliant.grid import FINER, Grid

SAFETY = 2.0  # discretisation error over the change from one grid to the next: errors fall at least in proportion
LEAST_ERROR = 2e-3  # minimum relative discretisation error
LARGE = 0.05  # relative change of the load at a peak above which the whole path is followed on the finer grid
COARSE = 0.02  # relative change of the whole path above which the answer is that of the finer grid
REFINEMENTS = 3  # re-solves on a finer grid, at most
MOST_NODES = 20_000  # of a finer grid that may give answers


class Bounded(NamedTuple):
    """Load paths, and ``below`` (k,): their peaks less the discretisation error; 0 where there is none or no bound."""

    paths: PathResult
    below: Float

    @property
    def lower(self) -> Float:
        """(k,) ``below``, inf where the path is endless."""
        return np.where(self.paths.outcome == PathOutcome.ENDLESS, np.inf, self.below)


@dataclass(frozen=True, eq=False)
class Refined:
    """Answers of ``grid``, re-solved on finer ones at most ``refinements`` times where its nodes are too coarse."""

    grid: Grid
    refinements: int = REFINEMENTS

    @property
    def _finer(self) -> Refined:
        return replace(self, grid=self.grid.finer, refinements=self.refinements - 1)

    @property
    def _may_refine(self) -> bool:
        return self.refinements > 0 and FINER**2 * len(self.grid.nodes) <= MOST_NODES

    def found(self, W: Float, *, cuts: bool = False) -> PathResult:
        """The paths of columns W (6J, k) on this grid; where they are lost, their peaks by bisection."""
        return with_bisected_peaks(self.grid, W, self.grid.paths(W, cuts=cuts))

    def answers(self, W: Float, *, cuts: bool = False, bounds: bool = True) -> Bounded:
        """The paths of columns W (6J, k) on grids fine enough for each, with lower bounds; or on this one without."""
        paths = self.found(W, cuts=cuts)
        return self._bounded(W, paths, cuts=cuts) if bounds else Bounded(paths, np.zeros(W.shape[1]))

    def _bounded(self, W: Float, paths: PathResult, *, cuts: bool) -> Bounded:
        """Lower bounds of paths of this grid: the peak less SAFETY times the discretisation estimate, and LEAST_ERROR.

        The estimate is the change of the load when the displacement of the peak is taken up by the finer grid. Where
        that load is not found or changes much, it is the change of the whole path there (all of the peak where there is
        none); and where that is more than COARSE, the path there is the answer, if it may be.
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
