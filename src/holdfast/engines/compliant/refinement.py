"""Peaks of load paths on grids that are fine enough, with lower bounds that allow for the discretisation error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.progress import answers_in_parallel, free_threads
from holdfast.elastic.system import STAGE, PathOutcome, PathResult, RestOutcome
from holdfast.engines.compliant.elastic_model import motion_row
from holdfast.engines.compliant.grid import FINER, Grid

T = TypeVar("T")

# Discretisation error divided by the change to the next grid: errors fall at least in proportion to the step
SAFETY = 2.0
LEAST_ERROR = 2e-3  # minimum relative discretisation error
MOVED = 5e-3  # relative change of the load at a peak above which the whole path is followed on the finer grid
COARSE = 0.02  # relative change of the peak of the whole path above which the answer is taken from the finer grid
REFINEMENTS = 3  # largest number of re-solves on ever finer grids: the third counts for a wedge in a floor
AMPLE = 1.02  # to show that a load is held, its path is followed to this multiple, which leaves room for errors
RESOLVED = 28  # nodes along a side, in paths, of contacts whose forces are concentrated on few nodes
# A path on more nodes above this multiple of a peak shows that bodies are self-stressed, not what they hold
SELF_STRESSED = 1.2
SHARP = 0.7  # if a point needs a larger correction than this share of its step, a path without an end is doubtful
MOST_CHUNK = 256  # largest number of columns that a thread takes at a time, between which it can be stopped
ENOUGH = 2  # columns per thread from which they are shared among threads
BEYOND = 1e-4  # relative load beyond the last one of a lost path under which bodies that move there have to drift
MOST_NODES = 20_000  # largest number of nodes of a finer grid from which answers are taken


class Bounded(NamedTuple):
    """Load paths with lower bounds of their peaks.

    ``below`` (k,) is the peak minus the discretisation error; it is 0 if there is no peak or no bound was asked for.
    ``raw`` (k,) are the peaks on the grid that was asked first, or what was reached there.
    """

    paths: PathResult
    below: Float
    raw: Float

    @classmethod
    def unbounded(cls, paths: PathResult) -> Bounded:
        """Return paths of the grid that was asked, without lower bounds."""
        return cls(paths, np.zeros(len(paths.peak)), paths.peak)

    @classmethod
    def joined(cls, parts: Sequence[Bounded], order: Int) -> Bounded:
        """Return the paths of all ``parts``, of which number ``order[k]`` becomes number k."""
        columns = zip(*((*part.paths, *part[1:]) for part in parts), strict=True)
        whole = [np.concatenate(column)[order] for column in columns]
        last = len(PathResult._fields)
        return cls(PathResult._make(whole[:last]).sealed(), *whole[last:])

    @property
    def lower(self) -> Float:
        """The lower bounds (k,): ``below``, or inf where the path is endless.

        Where the load has dipped on the way to the peak they are less, by as much as the first maximum was: bodies snap
        there, and what is found beyond it is for those that come to rest before they have gone far. Of an endless path
        the bound is then the first maximum, less the least error.
        """
        peak, sure = self.paths.peak, self.paths.sure
        less = (self.paths.outcome == PathOutcome.PEAK) & (sure < peak)
        share = np.divide(sure, peak, out=np.ones(len(peak)), where=less)
        return np.where(self.paths.outcome == PathOutcome.ENDLESS, (1 - LEAST_ERROR) * sure, self.below * share)

    @property
    def before(self) -> Float:
        """The lower bounds (k,) of what is reached before contacts slide far: ``lower`` or less."""
        sure, before = self.paths.sure, self.paths.before
        less = before < sure
        share = np.divide(before, sure, out=np.ones(len(sure)), where=less & np.isfinite(sure))
        return np.where(less & np.isinf(sure), (1 - LEAST_ERROR) * before, self.lower * share)

    def replaced(self, at: Int, others: Bounded) -> Bounded:
        """Return the same with ``others`` in the places ``at``, which are in order."""
        if len(at) == len(self.below):  # in all places
            return others._replace(raw=self.raw)
        below = self.below.copy()
        below[at] = others.below
        return Bounded(self.paths.replaced(at, others.paths), below, self.raw)


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
    def _may_resolve(self) -> bool:
        """Tell whether contacts at which forces are concentrated may be looked at with RESOLVED nodes a side."""
        few = self.grid.springs.nodes < RESOLVED and self.refinements > 1
        return few and FINER**2 * len(self.grid.nodes) <= MOST_NODES

    def answers(self, W: Float, *, bounds: bool = True) -> Bounded:
        """Follow the paths of columns W (6J, k).

        With ``bounds`` each path is followed on a grid that is fine enough for it, and has a lower bound. Without, all
        paths are followed on this grid and the lower bounds are 0. Paths that are lost on this grid are recovered as
        ``_recovered`` says.
        """
        count, system = W.shape[1], self.grid.system
        threads = system.threads(count)
        if threads < 2 or system.long:  # long paths make threads of their own
            found = self._bounded(W, self.grid.paths(W), bounds=bounds)
        else:
            number = threads * -(-count // (threads * MOST_CHUNK))
            chunks = [np.arange(first, count, number) for first in range(number)]

            def ask(row: int) -> Bounded:
                columns = W[:, chunks[row]]
                return self._bounded(columns, self.grid.paths(columns), bounds=bounds)

            parts = answers_in_parallel(STAGE, ask, threads, number, count)
            found = Bounded.joined(parts, np.argsort(np.concatenate(chunks)))
        lost = np.flatnonzero(found.paths.outcome == PathOutcome.LOST)
        if not len(lost):
            return found
        return found.replaced(lost, self._recovered(W[:, lost], found.paths.chosen(lost), bounds=bounds))

    def held(self, W: Float) -> Bool:
        """Tell which columns of W (6J, k) certainly move nothing, from paths that are not followed beyond them.

        That is so where the path leads to the load and the discretisation error there, estimated as for a peak by the
        load that a finer grid has at the same displacement, leaves at least the load. Where forces are concentrated on
        few nodes, that grid has most nodes at those contacts.
        """
        paths = self.grid.paths(W, most=AMPLE)
        sure = np.minimum(paths.sure, paths.before) >= 1
        moves_nothing = (paths.outcome == PathOutcome.ENDLESS) & sure
        there = np.flatnonzero(paths.outcome == PathOutcome.REACHED)
        if not len(there):  # no finer grid is made for nothing
            return np.asarray(moves_nothing)
        load = paths.peak[there]
        kinds, alike = _alike(self.grid.concentrated(paths.q[there]))

        def on_finer(number: int) -> Float:
            rows, contacts = there[alike[number]], np.flatnonzero(kinds[number])
            if not len(contacts):
                return _on(self.grid.finer, W[:, rows], paths.chosen(rows), MOVED)
            if not self._may_resolve:
                return np.full(len(rows), -1.0)
            return self._most(contacts).loads_nearby(W[:, rows], paths.peak[rows], paths.q[rows], paths.plane[rows])

        finer = np.empty(len(there))
        for rows, found in zip(alike, self._shared([len(rows) for rows in alike], on_finer), strict=True):
            finer[rows] = found
        change = np.abs(finer - load)
        sure[there] &= finer > 0
        moves_nothing[there] = sure[there] & (load - SAFETY * change - LEAST_ERROR * load >= 1)
        return np.asarray(moves_nothing)

    def _recovered(self, W: Float, lost: PathResult, *, bounds: bool) -> Bounded:
        """Recover paths of columns W (6J, k) that are ``lost`` on this grid.

        Where some bodies are held, a path on which another comes to be only balanced, too, is followed with every body
        held (a push on a messy wall of the bench). A path is taken from the next finer grid if it is not lost there and
        leads at least as far as on this one (pushes on the arch, and on a pallet of ten boxes). Otherwise one that came
        to where bodies move by ``_with_proved_peaks`` has its peak there, and its lower bound is what it reached on
        both grids; all others stay lost.
        """
        peaks, reached = Bounded.unbounded(lost), lost.peak.copy()
        partly_held = self.grid.hold is not None and not self.grid.hold.all()
        others = [replace(self, grid=self.grid.with_hold)] if partly_held else []
        for other in [*others, self._finer] if self._may_refine else others:
            left = np.flatnonzero(peaks.paths.outcome == PathOutcome.LOST)
            if not len(left):
                break
            there = other.grid.paths(W[:, left])
            agree = (there.outcome != PathOutcome.LOST) & (there.peak >= (1 - COARSE) * reached[left])
            agreed = np.flatnonzero(agree)
            better = other._bounded(W[:, left[agreed]], there.chosen(agreed), bounds=bounds)
            peaks = peaks.replaced(left[agreed], better)
            reached[left] = np.minimum(reached[left], there.peak)
        rest = np.flatnonzero(peaks.paths.outcome == PathOutcome.LOST)
        found = _with_proved_peaks(self.grid, W[:, rest], lost.chosen(rest))
        known = (found.outcome == PathOutcome.PEAK) & bounds
        below = np.where(known, (1 - LEAST_ERROR) * np.minimum(reached[rest], found.peak), 0.0)
        return peaks.replaced(rest, Bounded.unbounded(found)._replace(below=below))

    def _bounded(self, W: Float, paths: PathResult, *, bounds: bool = True) -> Bounded:
        """Give the paths of this grid lower bounds, and take paths from finer grids where this one is too coarse.

        Without ``bounds`` they are left as they are. The lower bound is the peak minus SAFETY times the estimated
        discretisation error minus LEAST_ERROR times the peak. Where forces are concentrated on few nodes at a peak,
        ``_resolved`` estimates the error, else ``_estimated``.
        """
        found = Bounded.unbounded(paths)
        if not bounds:
            return found
        at = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
        kinds, alike = _alike(self.grid.concentrated(paths.q[at]) & self._may_resolve)

        def better(number: int) -> Bounded:
            rows = at[alike[number]]
            columns, peaks = W[:, rows], paths.chosen(rows)
            if kinds[number].any():
                return self._resolved(columns, peaks, np.flatnonzero(kinds[number]))
            return self._estimated(columns, peaks)

        for lot, bounded in zip(alike, self._shared([len(rows) for rows in alike], better), strict=True):
            found = found.replaced(at[lot], bounded)
        found = self._with_ends(W, paths, found)
        passed = (paths.first < paths.peak) & (found.paths.first >= found.paths.peak)  # a maximum, on another grid
        found.below[passed] = np.minimum(found.below, paths.first)[passed]
        return found

    def _shared(self, sizes: Sequence[int], ask: Callable[[int], T]) -> list[T]:
        """Ask for lots of columns of these ``sizes``, by number; returns the answers.

        Lots of long paths that are too few for all threads are asked one in each thread, for each makes grids of its
        own; the others share their own columns among threads.
        """
        threads = free_threads() if self.grid.system.long else 1
        few = [number for number, size in enumerate(sizes) if size < ENOUGH * threads]
        threads = min(threads, len(few))
        found: dict[int, T] = {}
        if threads > 1:
            total = sum(sizes[number] for number in few)
            answers = answers_in_parallel(STAGE, lambda place: ask(few[place]), threads, len(few), total)
            found = dict(zip(few, answers, strict=True))
        for number in range(len(sizes)):
            if number not in found:
                found[number] = ask(number)
        return [found[number] for number in range(len(sizes))]

    def _with_ends(self, W: Float, paths: PathResult, found: Bounded) -> Bounded:
        """Return the answers ``found`` for columns W (6J, k), with those of the finer grid where only it has an end.

        A path of this grid that turned sharply, or whose load dipped, may have passed over a maximum that bodies do not
        come back from; and among many bodies the nodes may decide whether there is one. If the finer grid's path ends,
        it is the answer; else what that has dipped from bounds it. The error is at least COARSE where no finer grid is
        allowed to tell it. Among many bodies all paths are followed there. Presses on the edge of a pallet and on a
        wedge in a floor need it.
        """
        doubtful = (paths.sharpest > SHARP) | (paths.first < paths.peak) | (self.grid.system.fronts is not None)
        rows = np.flatnonzero((paths.outcome == PathOutcome.ENDLESS) & doubtful)
        if not len(rows):
            return found
        there = self._finer.grid.paths(W[:, rows])
        first, before = found.paths.first.copy(), found.paths.before.copy()
        endless = there.outcome == PathOutcome.ENDLESS
        first[rows] = np.where(endless, there.first, first[rows])
        before[rows] = np.where(endless, there.before, before[rows])
        found = found._replace(paths=found.paths._replace(first=first, before=before).sealed())
        ends = np.flatnonzero(there.outcome == PathOutcome.PEAK)
        peaks = there.chosen(ends)
        if self._may_refine:
            better = self._finer._bounded(W[:, rows[ends]], peaks)
        else:
            better = Bounded.unbounded(peaks)._replace(below=_below(peaks.peak, (1 - COARSE) * peaks.peak))
        return found.replaced(rows[ends], better)

    def _estimated(self, W: Float, peaks: PathResult) -> Bounded:
        """Give ``peaks`` of columns W (6J, k) lower bounds from the next finer grid.

        Where it moves a peak too far and refinement is allowed, its path is the answer, and is bounded in its turn.
        """
        finer = self._finer
        found, rows, paths = _compared(finer.grid, W, peaks, MOVED)
        if not len(rows) or not self._may_refine:
            return found
        return found.replaced(rows, finer._bounded(W[:, rows], paths))

    def _resolved(self, W: Float, peaks: PathResult, contacts: Int) -> Bounded:
        """Give ``peaks`` of columns W (6J, k), concentrated at ``contacts``, lower bounds, or take other paths.

        Twice as many nodes err there as these do. The error is the change of the load at the displacement of the peak
        with twice RESOLVED nodes a side at these contacts and FINER times as many at all others. Where that is more
        than COARSE, the answer is the path with RESOLVED nodes at these contacts alone, and its error COARSE. Where
        these have changed the peak by more than that, its error is found as that of the first, or by the whole path
        with most nodes, which is the answer if its peak is another one. A path with RESOLVED nodes that leads beyond
        SELF_STRESSED times the peak, or has none, is no answer but a change.
        """
        most = self._most(contacts)
        load = _on(most, W, peaks, COARSE)
        found = Bounded.unbounded(peaks)._replace(below=_below(peaks.peak, load))
        rows = np.flatnonzero(load < 0)
        if not len(rows):  # no grid is made for nothing
            return found
        paths, before = self.grid.with_more(contacts, RESOLVED).paths(W[:, rows]), peaks.peak[rows]
        found.below[rows] = _below(before, paths.peak)
        there = np.flatnonzero((paths.outcome == PathOutcome.PEAK) & (paths.peak <= SELF_STRESSED * before))
        rows, paths, before = rows[there], paths.chosen(there), before[there]
        resolved = Bounded.unbounded(paths)._replace(below=_below(paths.peak, (1 - COARSE) * paths.peak))
        moved = np.flatnonzero(np.abs(before - paths.peak) > COARSE * paths.peak)
        if len(moved):
            last, more, better = _compared(most, W[:, rows[moved]], paths.chosen(moved), COARSE)
            other = Bounded.unbounded(better)._replace(below=_below(better.peak, paths.peak[moved[more]]))
            resolved = resolved.replaced(moved, last.replaced(more, other))
        return found.replaced(rows, resolved)

    def _most(self, contacts: Int) -> Grid:
        """Return the grid with most nodes at these contacts, and FINER times as many at all others."""
        return self.grid.with_more(contacts, FINER * RESOLVED, FINER)


def _alike(contacts: Bool) -> tuple[Bool, list[Int]]:
    """Return the kinds (m, interfaces) of rows of ``contacts`` (k, interfaces), and which rows are of each kind."""
    if len(contacts) and not contacts.any():  # as mostly
        return contacts[:1], [np.arange(len(contacts))]
    kinds, kind = np.unique(contacts, axis=0, return_inverse=True)
    return kinds, [np.flatnonzero(kind.ravel() == number) for number in range(len(kinds))]


def _with_proved_peaks(grid: Grid, W: Float, lost: PathResult) -> PathResult:
    """Return ``lost`` paths of columns W (6J, k), with a peak where they came as far as bodies bear the load.

    That is where limit analysis proves that they move: glue tears there, as a cube that hangs by it is carried to the
    last digit, and no state lies beyond. An acceleration of three bodies on a slope is lost 1 % before. Bodies move as
    they begin to there or, where all that begins is resisted, as limit analysis says. Where that knows no end, as of a
    keystone that is lifted from between two held stones, it is where they do not come to rest any more under a little
    more load, but drift. The peak is what the path reached: it may be too low by COARSE.
    """
    begun = lost.peak > 0
    if grid.settled.outcome is not RestOutcome.RESTS or not begun.any():
        return lost
    certain = grid.certain.load_factor(W)
    outcome, motion = lost.outcome.copy(), lost.motion.copy()
    for k in np.flatnonzero(begun & (np.abs(certain.upper - lost.peak) <= COARSE * lost.peak)).tolist():
        outcome[k], mechanism = PathOutcome.PEAK, certain.mechanism[k]
        if not motion[k].any() and mechanism is not None:
            motion[k] = motion_row(grid.assembly, mechanism.twists)
    for k in np.flatnonzero(begun & np.isinf(certain.upper)).tolist():
        more = (1 + BEYOND) * lost.peak[k] * grid.loads(W[:, [k]])[0]
        end = grid.system.under(grid.system.model.wrench + more).come_to_rest(near=lost.q[k])
        if end.outcome is RestOutcome.DRIFTS:
            outcome[k], motion[k] = PathOutcome.PEAK, end.drift
    return lost._replace(outcome=outcome, motion=motion).sealed()


def _below(peak: Float, load: Float) -> Float:
    """Return lower bounds (k,) of peaks (k,) that have changed to ``load`` (k,) on a finer grid."""
    change = np.where(load < peak, peak - load, np.minimum(load, 2 * peak) - peak)
    return np.maximum(peak - SAFETY * change - LEAST_ERROR * peak, 0.0)


def _compared(finer: Grid, W: Float, peaks: PathResult, near: float) -> tuple[Bounded, Int, PathResult]:
    """Give ``peaks`` (k,) of columns W (6J, k) lower bounds by what they become on a ``finer`` grid.

    The estimated error is the change of the load at the displacement of the peak where that is at most ``near``, else
    the change of the peak of the whole path, which is followed there, or to what it reached if lost. Also returns which
    peaks (m,) changed by more than COARSE to another answer, and the paths of these.
    """
    load = _on(finer, W, peaks, near)
    unsure = np.flatnonzero(load < 0)
    if not len(unsure):
        return Bounded.unbounded(peaks)._replace(below=_below(peaks.peak, load)), unsure, peaks.chosen(unsure)
    paths = finer.paths(W[:, unsure])
    load[unsure] = paths.peak
    there = np.flatnonzero(
        (paths.outcome == PathOutcome.PEAK) & (np.abs(paths.peak - peaks.peak[unsure]) > COARSE * peaks.peak[unsure])
    )
    found = Bounded.unbounded(peaks)._replace(below=_below(peaks.peak, load))
    return found, unsure[there], paths.chosen(there)


def _on(finer: Grid, W: Float, peaks: PathResult, near: float) -> Float:
    """Return the load (k,) on a ``finer`` grid at the displacement of ``peaks`` (k,) of columns W (6J, k).

    It is -1 where it is off by more than ``near``, or is not found: an edge gives way more on more nodes, so at that
    displacement the load may still be rising, and says where the path was left, not what the contacts bear.
    """
    found = finer.loads_nearby(W, peaks.peak, peaks.q, peaks.plane)
    return np.where(np.abs(found - peaks.peak) > near * peaks.peak, -1.0, found)
