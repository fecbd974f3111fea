"""Answers of engine ``compliant`` for load columns, each from a load path of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.compliant.refinement import Refined
from holdfast.engines.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Columns:
    """The answers for k load columns.

    ``outcome`` (k,) holds a PathOutcome for each column, ``factor`` (k,) the peak factor, and ``lower`` (k,) its lower
    bound. ``mechanisms`` (k) say what gives way, and are None where nothing does or it is not known. ``before`` (k,) is
    the lower bound of what is reached before contacts slide far, and ``leans`` (k,) is True where contacts that are
    open at rest take part at the peak. ``raw`` (k,) is the factor that the path had on the first grid, before finer
    ones were asked.
    """

    outcome: Int
    factor: Float
    lower: Float
    mechanisms: list[Mechanism | None]
    before: Float
    leans: Bool
    raw: Float

    @classmethod
    def unknown(cls, count: int) -> Columns:
        """Return ``count`` columns whose paths were lost."""
        lost, none = np.full(count, PathOutcome.LOST, dtype=np.int64), np.zeros(count)
        return cls(lost, none, none, [None] * count, none, np.zeros(count, bool), none)


def followed(refined: Refined, W: Float, *, bounds: bool) -> Columns:
    """Follow a load path for every column of W (6J, k); ``lower`` is 0 if no ``bounds`` are wanted."""
    answers = refined.answers(W, bounds=bounds)
    paths, leans = answers.paths, refined.grid.leans(W, answers.paths)
    finite = np.flatnonzero(paths.outcome == PathOutcome.PEAK)
    mechanisms: list[Mechanism | None] = [None] * W.shape[1]
    for k, mechanism in zip(finite.tolist(), refined.grid.mechanisms(paths.motion[finite]), strict=True):
        mechanisms[k] = mechanism
    return Columns(paths.outcome, paths.factor, answers.lower, mechanisms, answers.before, leans, answers.raw)
