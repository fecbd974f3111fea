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
LESS = (2.5e-3, 1e-2)  # relative loads below a peak that a finer grid is asked to hold where it tells nothing else
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
        finer = _on(self.grid.finer, W[:, there], paths.chosen(there))
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

        The lower bound is the peak minus SAFETY times the estimated discretisation error minus LEAST_ERROR times the
        peak. Where forces have gathered on few nodes at a peak, ``_resolved`` estimates the error, else ``_estimated``.
        """
        found = Bounded(paths, np.zeros(W.shape[1]))
        peaked = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        few = self.grid.gathered(paths.q[peaked])
        if few.any() and self._resolving is self:
            few[:] = False
        for rows, bounded in ((peaked[~few], self._estimated), (peaked[few], self._resolved)):
            if len(rows):  # no finer grid is made for nothing
                found = found.replaced(rows, bounded(W[:, rows], paths.chosen(rows), cuts=cuts))
        return found

    def _estimated(self, W: Float, peaks: PathResult, *, cuts: bool) -> Bounded:
        """Give ``peaks`` of columns W (6J, k) lower bounds from the next finer grid, or take paths from there.

        The estimated error is the change of the load there as ``_on`` tells. If it tells nothing, the whole path is
        followed there, and the estimate is the change of its peak (all of the peak if there is none). If that change is
        more than COARSE, the path on the finer grid becomes the answer, as long as refinement is allowed.
        """
        finer = self._finer
        peak, load = peaks.peak, _on(finer.grid, W, peaks)
        found, taken = Bounded(peaks, np.zeros(len(peak))), np.zeros(len(peak), dtype=bool)
        unsure = np.flatnonzero(load < 0)
        if len(unsure):
            paths = finer.grid.paths(W[:, unsure], cuts=cuts)
            load[unsure] = paths.factor
            changed = _changed(peak[unsure], paths.peak)
            better = np.flatnonzero((paths.outcome == PathOutcome.PEAK) & changed & self._may_refine)
            taken[unsure[better]] = True
            found = found.replaced(unsure[better], finer._bounded(W[:, taken], paths.chosen(better), cuts=cuts))
        return found._replace(below=np.where(taken, found.below, _below(peak, load)))

    def _resolved(self, W: Float, peaks: PathResult, *, cuts: bool) -> Bounded:
        """Give ``peaks`` of columns W (6J, k) where forces gather lower bounds from many nodes, or take paths from there.

        Twice as many nodes err there as these do. The estimated error is the change of the load at the displacement of
        the peak on the grid after the resolving one. If there is none, or one that changes by more than COARSE, the
        answer is the path on the resolving grid, whose own peak is treated like that: if the load on the grid after it
        changes by more than COARSE, it is bounded as ``_estimated`` says; if there is none, its error is taken to be
        what the peak has changed, and at least COARSE.
        """
        resolving, peak = self._resolving, peaks.peak
        after = resolving.grid.finer
        load = after.loads_nearby(W, peak, peaks.q, peaks.plane)
        found = Bounded(peaks, _below(peak, load))
        unsure = np.flatnonzero(_changed(peak, load))
        if not len(unsure):
            return found
        paths = resolving.grid.paths(W[:, unsure], cuts=cuts)
        found.below[unsure] = 0.0  # all of the peak where there is none on more nodes
        there = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        rows, paths = unsure[there], paths.chosen(there)
        load = after.loads_nearby(W[:, rows], paths.peak, paths.q, paths.plane)
        change = np.maximum(np.abs(paths.peak - peak[rows]), COARSE * paths.peak)
        answers = Bounded(paths, _below(paths.peak, np.where(load < 0, paths.peak - change, load)))
        coarse = np.flatnonzero((load >= 0) & _changed(paths.peak, load))
        answers = answers.replaced(coarse, resolving._estimated(W[:, rows[coarse]], paths.chosen(coarse), cuts=cuts))
        return found.replaced(rows, answers)


def _changed(peak: Float, load: Float) -> Bool:
    """Tell which peaks (k,) differ from ``load`` (k,), what they become on another grid, by more than COARSE."""
    return np.asarray(np.abs(load - peak) > COARSE * peak)


def _below(peak: Float, load: Float) -> Float:
    """Return lower bounds (k,) of peaks (k,) that have changed to ``load`` (k,) on a finer grid."""
    change = np.where(load < peak, peak - load, np.minimum(load, 2 * peak) - peak)
    return np.maximum(peak - SAFETY * change - LEAST_ERROR * peak, 0.0)


def _on(finer: Grid, W: Float, peaks: PathResult) -> Float:
    """Return what ``peaks`` (k,) of columns W (6J, k) become on a ``finer`` grid, -1 where that is not found.

    This is the load on the finer grid at the displacement of the peak. Far out on a nearly level path there may be
    none, or quite another one, for every node slides and has its own place to begin. There it is the load at a point on
    the way to the peak, or LESS than the peak, above (1 - COARSE) of the peak, if the finer grid is in balance under
    that load in a state nearby: the path on the finer grid leads at least as far. If the finer grid is in balance under
    (1 + COARSE) of the peak, too, that is not what was sought.
    """
    peak, k = peaks.peak, len(peaks.peak)
    found = finer.loads_nearby(W, peak, peaks.q, peaks.plane)
    found[np.abs(found - peak) > LARGE * peak] = -1.0
    told = found >= 0
    if told.all():
        return found
    lower = (1 - np.array(LESS)) * peak[:, None]
    loads = np.hstack([peaks.station_s, lower])
    states = np.hstack([peaks.station_q, peaks.q[:, None].repeat(len(LESS), 1)])
    for at in np.argsort(-loads, axis=1).T:
        s, q = loads[np.arange(k), at], states[np.arange(k), at]
        rows = np.flatnonzero((found < 0) & (s > (1 - COARSE) * peak))
        held = finer.balances(W[:, rows], s[rows], q[rows])
        found[rows[held]] = s[rows[held]]
    for q in (peaks.q, peaks.station_q[np.arange(k), peaks.station_s.argmax(1)]):
        rows = np.flatnonzero((found >= 0) & ~told)
        more = finer.balances(W[:, rows], (1 + COARSE) * peak[rows], q[rows])
        found[rows[more]] = -1.0
    return found
