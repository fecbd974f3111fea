"""Peaks of load paths on grids that are fine enough, with lower bounds that allow for the discretisation error."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.bisection import with_bisected_peaks
from holdfast.engines.compliant.grid import FINER, Grid

SAFETY = 2.0  # discretisation error over the change to the next grid: errors fall at least in proportion to the step
LEAST_ERROR = 2e-3  # minimum relative discretisation error
LARGE = 0.05  # relative change of the load at a peak above which the whole path is followed on the finer grid
COARSE = 0.02  # relative change of the peak of the whole path above which the answer is taken from the finer grid
REFINEMENTS = 3  # largest number of re-solves on ever finer grids
AMPLE = 1.02  # times a load, to which its path is followed to tell that it is held: what errors may take is left
RESOLVED = 28  # nodes a side of the grid on which paths are followed whose forces have gathered on few nodes
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

    def replaced(self, at: Int, others: Bounded) -> Bounded:
        """Return the same with ``others`` in the places ``at``."""
        below = self.below.copy()
        below[at] = others.below
        return Bounded(self.paths.replaced(at, others.paths), below)


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

    @property
    def _resolving(self) -> Refined:
        """The grid on which peaks are looked at where forces gather on few nodes; this one if there is no finer one.

        It has RESOLVED nodes a side or more, or as many as leave its own next finer grid MOST_NODES.
        """
        coarse = self.grid.springs.nodes < RESOLVED and self.refinements > 0
        return self._finer._resolving if coarse and FINER**4 * len(self.grid.nodes) <= MOST_NODES else self

    def answers(self, W: Float, *, cuts: bool = False, bounds: bool = True) -> Bounded:
        """Follow the paths of columns W (6J, k).

        With ``bounds`` each path is followed on a grid that is fine enough for it, and has a lower bound. Without, all
        paths are followed on this grid and the lower bounds are 0. Paths that are lost on this grid are recovered as
        ``_recovered`` says. ``cuts`` is as in ``Grid.paths``.
        """
        found = self._given(W, self.grid.paths(W, cuts=cuts), cuts=cuts, bounds=bounds)
        lost = np.flatnonzero(found.paths.outcome == PathOutcome.LOST)
        if not len(lost):
            return found
        return found.replaced(lost, self._recovered(W[:, lost], found.paths.chosen(lost), cuts=cuts, bounds=bounds))

    def held(self, W: Float) -> Bool:
        """Tell which columns of W (6J, k) certainly move nothing, from paths that are not followed beyond them.

        That is so where the path leads to the load and the discretisation error there, estimated as for a peak by the
        load that the finer grid has at the same displacement, leaves at least the load.
        """
        paths = self.grid.paths(W, most=AMPLE)
        held = paths.outcome == PathOutcome.ENDLESS
        there = np.flatnonzero(paths.outcome == PathOutcome.REACHED)
        if not len(there):  # no finer grid is made for nothing
            return np.asarray(held)
        load = paths.peak[there]
        finer = self._on_finer_grid(W[:, there], paths.chosen(there))
        change = np.abs(finer - load)
        sure = (finer > 0) & (change <= LARGE * load) & ~self.grid.gathered(paths.q[there])
        held[there] = sure & (load - SAFETY * change - LEAST_ERROR * load >= 1)
        return np.asarray(held)

    def _recovered(self, W: Float, lost: PathResult, *, cuts: bool, bounds: bool) -> Bounded:
        """Recover paths of columns W (6J, k) that are ``lost`` on this grid.

        A path is taken from the next finer grid if it is not lost there and leads at least as far as on this grid.
        Otherwise the peak is found by bisection on this grid. Its lower bound is what the path itself reached on both
        grids: bodies that come to rest under a larger load need not have stayed where they were while it rose.
        """
        peaks, reached = Bounded(lost, np.zeros(W.shape[1])), lost.peak
        if self._may_refine:
            there = self._finer.grid.paths(W, cuts=cuts)
            agree = (there.outcome != PathOutcome.LOST) & (there.peak >= (1 - COARSE) * reached)
            kept = np.flatnonzero(agree)
            better = self._finer._given(W[:, kept], there.chosen(kept), cuts=cuts, bounds=bounds)
            peaks, reached = peaks.replaced(kept, better), np.minimum(reached, there.peak)
        rest = np.flatnonzero(peaks.paths.outcome == PathOutcome.LOST)
        found = with_bisected_peaks(self.grid, W[:, rest], lost.chosen(rest))
        known = (found.outcome == PathOutcome.PEAK) & bounds
        below = np.where(known, (1 - LEAST_ERROR) * np.minimum(reached[rest], found.peak), 0.0)
        return peaks.replaced(rest, Bounded(found, below))

    def _given(self, W: Float, paths: PathResult, *, cuts: bool, bounds: bool) -> Bounded:
        """Return the paths of this grid with bounds if they are wanted, else as they are."""
        return self._bounded(W, paths, cuts=cuts) if bounds else Bounded(paths, np.zeros(W.shape[1]))

    def _bounded(self, W: Float, paths: PathResult, *, cuts: bool) -> Bounded:
        """Give the paths of this grid lower bounds, and take paths from finer grids where this one is too coarse.

        Peaks are bounded as ``_estimated`` says. Where forces have gathered on few nodes at a peak, that says little:
        there the path is followed on the resolving grid, too. If its peak is lower by more than COARSE, it becomes the
        answer; else the lower bound is the lesser of both.
        """
        peaked = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        few = peaked[self.grid.gathered(paths.q[peaked])]
        resolving = self._resolving if len(few) else self
        if resolving is self:
            return self._estimated(W, paths, cuts=cuts)
        there = resolving._estimated(W[:, few], resolving.grid.paths(W[:, few], cuts=cuts), cuts=cuts)
        known = there.paths.outcome == PathOutcome.PEAK
        off = known & (there.paths.peak < (1 - COARSE) * paths.peak[few])
        found = Bounded(paths, np.zeros(W.shape[1]))
        found = found.replaced(few[off], Bounded(there.paths.chosen(off), there.below[off]))
        rest = np.setdiff1d(np.arange(W.shape[1]), few[off])
        found = found.replaced(rest, self._estimated(W[:, rest], paths.chosen(rest), cuts=cuts))
        found.below[few[known]] = np.minimum(found.below[few[known]], there.below[known])
        return found

    def _estimated(self, W: Float, paths: PathResult, *, cuts: bool) -> Bounded:
        """Give the paths of this grid lower bounds, and take paths from finer grids where this one is too coarse.

        The lower bound is the peak minus SAFETY times the estimated discretisation error minus LEAST_ERROR times the
        peak. The estimate is the change of the load when the finer grid takes the displacement of the peak, or of a
        point before it (``_on_finer_grid``). If that load is not found or changes by more than LARGE, the whole path is
        followed on the finer grid, and the estimate is the change of its peak (all of the peak if the finer grid has
        none). If that change is more than COARSE, the path on the finer grid becomes the answer, as long as refinement
        is allowed.
        """
        below = np.zeros(W.shape[1])
        peaked = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        if not len(peaked):  # no finer grid is made for nothing
            return Bounded(paths, below)
        peaks = paths.chosen(peaked)
        peak = peaks.peak
        finer = self._on_finer_grid(W[:, peaked], peaks)
        unsure = np.flatnonzero((finer < 0) | (np.abs(finer - peak) > LARGE * peak))
        if len(unsure):
            asked = W[:, peaked[unsure]]
            there = self._finer.grid.paths(asked, cuts=cuts)
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

    def _on_finer_grid(self, W: Float, peaks: PathResult) -> Float:
        """Return what ``peaks`` (k,) of columns W (6J, k) become on the finer grid, -1 where that is not found.

        This is the load on the finer grid at the displacement of the peak. Far out on a nearly level path there may be
        none, for every node slides and has its own place to begin. Then a point on the way to the peak is taken whose
        load on the finer grid is above (1 - COARSE) of the peak: the path on the finer grid leads at least as far, and
        the peak is changed in proportion to the load at that point.
        """
        finer = self.grid.finer
        found = finer.loads_nearby(W, peaks.peak, peaks.q, peaks.plane)
        latest = np.argsort(-peaks.station_s, axis=1)
        for turn in range(latest.shape[1]):
            at = latest[:, turn]
            s = peaks.station_s[np.arange(len(at)), at]
            open_ = np.flatnonzero((found < 0) & (s > (1 - COARSE) * peaks.peak))
            if not len(open_):
                break
            q, plane = peaks.station_q[open_, at[open_]], peaks.station_plane[open_, at[open_]]
            there = finer.loads_nearby(W[:, open_], s[open_], q, plane)
            near = (there > (1 - COARSE) * peaks.peak[open_]) & (there < (1 + COARSE) * s[open_])
            found[open_[near]] = peaks.peak[open_[near]] * there[near] / s[open_[near]]
        return found
