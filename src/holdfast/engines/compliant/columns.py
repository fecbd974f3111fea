"""What engine ``compliant`` knows of load columns: each followed along its own path, or interpolated between paths."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.engines.compliant.interpolated import Solved, Survey, survey
from holdfast.engines.compliant.refinement import Bounded, Refined
from holdfast.engines.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Columns:
    """Of k columns: ``outcome`` of their paths, ``factor`` and its lower bound, and what gives way.

    ``solved`` (k,) says which have a path of their own; ``error`` (k,) is relative, 0 for those.
    """

    outcome: Int
    factor: Float
    lower: Float
    mechanisms: list[Mechanism | None]
    solved: Bool
    error: Float

    @classmethod
    def unknown(cls, count: int) -> Columns:
        """Columns whose paths were lost."""
        lost = np.full(count, PathOutcome.LOST, dtype=np.int64)
        return cls(lost, np.zeros(count), np.zeros(count), [None] * count, np.ones(count, bool), np.zeros(count))


def followed(refined: Refined, W: Float, *, bounds: bool) -> Columns:
    """Every column of W (6J, k) along its own path."""
    answers = refined.answers(W, bounds=bounds)
    paths = answers.paths
    count = W.shape[1]
    mechanisms = mechanisms_of(refined, paths)
    return Columns(paths.outcome, paths.factor, answers.lower, mechanisms, np.ones(count, bool), np.zeros(count))


def surveyed(refined: Refined, W: Float, first: int, error: float) -> Columns:
    """Columns W (6J, k) that load one body, at rows ``first`` to ``first + 6``: few paths, the rest interpolated.

    ``error``: expected relative error, at most.
    """
    surveyor = _Surveyor(refined, W, first)
    found = survey(np.ascontiguousarray(W[first : first + 6].T), surveyor.follow, error)
    return surveyor.columns(found)


def mechanisms_of(refined: Refined, paths: PathResult) -> list[Mechanism | None]:
    """What gives way at the end of each path; None where nothing does, or where it is not known."""
    finite = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
    mechanisms: list[Mechanism | None] = [None] * len(paths.outcome)
    for k, mechanism in zip(finite.tolist(), refined.grid.mechanisms(paths.motion[finite]), strict=True):
        mechanisms[k] = mechanism
    return mechanisms


@dataclass
class _Surveyor:
    """Follows paths as a survey asks for them, and collects what they gave."""

    refined: Refined
    W: Float
    first: int
    order: list[Int] = field(default_factory=list)
    answers: list[Bounded] = field(default_factory=list)
    mechanisms: list[Mechanism | None] = field(default_factory=list)
    kinds: dict[tuple[str, ...], int] = field(default_factory=dict)  # numbers of what gives way

    def follow(self, indices: Int) -> Solved:
        """Follow the paths of some columns."""
        answers = self.refined.answers(self.W[:, indices], cuts=True)
        paths = answers.paths
        mechanisms = mechanisms_of(self.refined, paths)
        self.order.append(indices)
        self.answers.append(answers)
        self.mechanisms += mechanisms
        with np.errstate(divide="ignore"):
            value = np.where(paths.outcome == PathOutcome.PEAK, 1 / paths.peak, 0.0)
        motion = [-1 if m is None else self.kinds.setdefault((m.mode, *m.moving), len(self.kinds)) for m in mechanisms]
        slope = value[:, None] * paths.cut[:, self.first : self.first + 6]
        return Solved(paths.outcome, value, slope, np.array(motion))

    def columns(self, found: Survey) -> Columns:
        """All columns: as their paths say, or as the survey does between paths."""
        count = self.W.shape[1]
        done = np.concatenate(self.order)
        place = np.zeros(count, dtype=np.int64)
        place[done] = np.arange(len(done))
        known_factor = np.concatenate([answers.paths.factor for answers in self.answers])
        known_lower = np.concatenate([answers.lower for answers in self.answers])
        outcome = np.concatenate([answers.paths.outcome for answers in self.answers])[place]
        factor, lower = known_factor[place], known_lower[place]
        mechanisms = [self.mechanisms[k] for k in place]
        between = np.flatnonzero(~found.solved)
        corner, nearest = place[found.corner[between]], np.argmax(found.share[between], axis=1)
        outcome[between] = PathOutcome.PEAK
        factor[between] = 1 / found.value[between]
        with np.errstate(invalid="ignore"):  # what is infinite is no corner
            share = (known_lower / known_factor)[corner].min(1)
        lower[between] = factor[between] * np.maximum(1 - found.error[between], 0.0) * share
        for k, column in enumerate(between.tolist()):
            mechanisms[column] = self.mechanisms[corner[k, nearest[k]]]
        error = np.where(found.solved, 0.0, found.error)
        return Columns(outcome, factor, lower, mechanisms, found.solved, error)
