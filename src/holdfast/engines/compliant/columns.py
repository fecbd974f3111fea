"""Answers of engine ``compliant`` for load columns: from a load path of their own, or interpolated between paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.interpolated import Solved, Survey, survey
from holdfast.engines.compliant.refinement import Around, Bounded, Refined
from holdfast.engines.mechanism import Mechanism

# If lower bounds at three corners, as shares of their peaks, differ by no more, the least of them holds in between
ALIKE = 0.01


@dataclass(frozen=True, eq=False)
class Columns:
    """The answers for k load columns.

    ``outcome`` (k,) holds a PathOutcome for each column, ``factor`` (k,) the peak factor, and ``lower`` (k,) its lower
    bound. ``mechanisms`` (k) say what gives way. ``solved`` (k,) is True for columns with a path of their own.
    ``error`` (k,) is the relative error of interpolated factors, and 0 for the others. ``before``
    (k,) is the lower bound of what is reached before contacts slide far, and ``leans`` (k,) is True
    where contacts that are open at rest take part at the peak. ``raw`` (k,) is the factor that the path had on the
    first grid, before finer ones were asked.
    """

    outcome: Int
    factor: Float
    lower: Float
    mechanisms: list[Mechanism | None]
    solved: Bool
    error: Float
    before: Float
    leans: Bool
    raw: Float

    @classmethod
    def unknown(cls, count: int) -> Columns:
        """Return ``count`` columns whose paths were lost."""
        lost, none, no = np.full(count, PathOutcome.LOST, dtype=np.int64), np.zeros(count), np.zeros(count, bool)
        return cls(lost, none, none, [None] * count, np.ones(count, bool), none, none, no, none)


def followed(refined: Refined, W: Float, *, bounds: bool) -> Columns:
    """Follow a load path for every column of W (6J, k); ``lower`` is 0 if no ``bounds`` are wanted."""
    answers = refined.answers(W, bounds=bounds)
    paths = answers.paths
    count = W.shape[1]
    mechanisms, leans = mechanisms_of(refined, paths), refined.grid.leans(W, paths)
    known = np.ones(count, bool), np.zeros(count)
    return Columns(paths.outcome, paths.factor, answers.lower, mechanisms, *known, answers.before, leans, answers.raw)


def surveyed(refined: Refined, W: Float, groups: Sequence[tuple[int, Int]], error: float) -> Columns:
    """Follow few of the paths of columns W (6J, k) that load a single body, and interpolate the others of these.

    Each of ``groups`` is the number of a body and the columns that load it alone. ``error`` is the largest expected
    relative error.
    """
    first, loads = np.zeros(W.shape[1], dtype=np.int64), np.zeros((W.shape[1], 6))
    for body, members in groups:
        first[members], loads[members] = 6 * body, W[6 * body : 6 * body + 6, members].T
    surveyor = _Surveyor(refined, W, first)
    return surveyor.columns(survey(loads, [members for _, members in groups], surveyor.follow, error))


def mechanisms_of(refined: Refined, paths: PathResult) -> list[Mechanism | None]:
    """Return the mechanism at the end of each path, or None if nothing gives way or the mechanism is not known."""
    finite = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
    mechanisms: list[Mechanism | None] = [None] * len(paths.outcome)
    for k, mechanism in zip(finite.tolist(), refined.grid.mechanisms(paths.motion[finite]), strict=True):
        mechanisms[k] = mechanism
    return mechanisms


@dataclass
class _Surveyor:
    """Follows the paths that a survey asks for, and collects their answers.

    ``first`` (k,) is the first row of W (6J, k) of the body that is loaded, where that is a single one.
    """

    refined: Refined
    W: Float
    first: Int
    order: list[Int] = field(default_factory=list)
    answers: list[Bounded] = field(default_factory=list)
    mechanisms: list[Mechanism | None] = field(default_factory=list)
    leans: list[Bool] = field(default_factory=list)
    kinds: dict[tuple[str, ...], int] = field(default_factory=dict)  # a number for each kind of mechanism

    def __post_init__(self) -> None:
        self.share = np.full(self.W.shape[1], np.nan)  # of lower bounds in peaks of the first grid
        self.few = np.zeros(self.W.shape[1], dtype=bool)  # whether forces are concentrated at these peaks
        self.endless = np.zeros(self.W.shape[1], dtype=bool)  # which paths have no end

    def follow(self, indices: Int, corners: Int) -> Solved:
        """Follow the paths of the columns with these numbers, which lie between ``corners`` (k, 3)."""
        answers = self.refined.answers(self.W[:, indices], gradients=True, around=self._around(corners))
        paths = answers.paths
        known = np.flatnonzero(answers.own)
        self.share[indices[known]], self.few[indices] = answers.below[known] / paths.peak[known], answers.few
        self.endless[indices] = np.isinf(answers.lower)
        mechanisms = mechanisms_of(self.refined, paths)
        self.order.append(indices)
        self.answers.append(answers)
        self.mechanisms += mechanisms
        self.leans.append(self.refined.grid.leans(self.W[:, indices], paths))
        with np.errstate(divide="ignore"):
            value = np.where(paths.outcome == PathOutcome.PEAK, 1 / paths.peak, 0.0)
        motion = [-1 if m is None else self.kinds.setdefault((m.mode, *m.moving), len(self.kinds)) for m in mechanisms]
        rows = self.first[indices, None] + np.arange(6)
        slope = value[:, None] * np.take_along_axis(paths.gradient, rows, 1)
        share = np.where(paths.outcome == PathOutcome.PEAK, answers.below * value, 1.0)
        return Solved(paths.outcome, value, slope, np.array(motion), share)

    def _around(self, corners: Int) -> Around:
        """Return what columns have in common with their ``corners`` (k, 3), where these are ALIKE."""
        share, few = self.share[corners], self.few[corners]
        with np.errstate(invalid="ignore"):
            alike = (np.ptp(share, axis=1) <= ALIKE) & (few == few[:, :1]).all(1)
        endless = np.asarray(self.endless[corners].all(1))
        return Around(np.where(alike, share.min(1), np.nan), few[:, 0], endless)

    def columns(self, found: Survey) -> Columns:
        """Return the answers for all columns, from their paths or interpolated by the survey."""
        count = self.W.shape[1]
        done = np.concatenate(self.order)
        place = np.zeros(count, dtype=np.int64)
        place[done] = np.arange(len(done))
        known_factor = np.concatenate([answers.paths.factor for answers in self.answers])
        known_lower = np.concatenate([answers.lower for answers in self.answers])
        known_before = np.concatenate([answers.before for answers in self.answers])
        known_leans = np.concatenate(self.leans)
        outcome = np.concatenate([answers.paths.outcome for answers in self.answers])[place]
        factor, lower, before = known_factor[place], known_lower[place], known_before[place]
        leans, raw = known_leans[place], np.concatenate([answers.raw for answers in self.answers])[place]
        mechanisms = [self.mechanisms[k] for k in place]
        between = np.flatnonzero(~found.solved)
        corner, nearest = place[found.corner[between]], np.argmax(found.share[between], axis=1)
        outcome[between] = PathOutcome.PEAK
        factor[between] = raw[between] = 1 / found.value[between]
        with np.errstate(invalid="ignore"):  # what is infinite is no corner
            share, sliding = ((known / known_factor)[corner].min(1) for known in (known_lower, known_before))
        sure = factor[between] * np.maximum(1 - found.error[between], 0.0)
        lower[between], before[between], leans[between] = sure * share, sure * sliding, known_leans[corner].any(1)
        for k, column in enumerate(between.tolist()):
            mechanisms[column] = self.mechanisms[corner[k, nearest[k]]]
        error = np.where(found.solved, 0.0, found.error)
        return Columns(outcome, factor, lower, mechanisms, found.solved, error, before, leans, raw)
