"""What load paths gave, from rest to their peaks and beyond; ``native/path.hpp`` follows them."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int


class PathOutcome(IntEnum):
    """How a load path ends."""

    LOST = 0  # no further point was found before the end was clear
    PEAK = 1  # the load has a largest value
    ENDLESS = 2  # contact forces balance any multiple of the load
    REACHED = 3  # it leads to the load up to which it was to be followed


class RestOutcome(IntEnum):
    """How the search for a state of rest ends."""

    LOST = 0  # neither of the two was found
    RESTS = 1
    DRIFTS = 2  # bodies keep moving at a constant velocity


class StepControl(NamedTuple):
    """How closely a path is followed.

    ``growth``: the largest growth of the step from one point to the next; ``correction``: that of a point that is
    wanted, as a share of the step; ``patience``: points without a new peak after which none is waited for; ``most``
    points of a path.
    """

    growth: float
    correction: float
    patience: int
    most: int


QUICK = StepControl(2.5, 0.2, 80, 600)
BRIEF = QUICK._replace(patience=40)  # where linear systems are expensive
CLOSE = StepControl(1.5, 0.05, 1000, 20_000)  # slow and misses less: the reference for the quick step control


class PathResult(NamedTuple):
    """What k load paths gave, among n = 6J displacements.

    ``outcome`` (k,) of PathOutcome; ``peak`` (k,) the largest s found, inf where the path is endless, that of the last
    point where it was not followed further; ``first`` (k,) the first maximum of s from which it dipped before it rose
    to the peak, the peak if there was none; ``before`` (k,) the largest s, at most the peak, before contacts have slid
    far (SLID); ``sharpest`` (k,) the largest correction of a point after the first, as a share of its step; ``last``
    (k,) s where it ended (residual strength); ``systems`` (k,) linear systems solved; ``q`` (k, n) at the peak, of
    endless paths under the load alone; ``motion`` (k, n) what begins to move above the peak, 0 where the path was lost
    and nothing does; ``plane`` (k, n) across which the peak was found.
    """

    outcome: Int
    peak: Float
    first: Float
    before: Float
    sharpest: Float
    last: Float
    systems: Int
    q: Float
    motion: Float
    plane: Float

    @classmethod
    def lost(cls, count: int, n: int) -> PathResult:
        """``count`` paths of which nothing is known yet."""
        rows: dict[str, tuple[int, ...]] = {"q": (n,), "motion": (n,), "plane": (n,)}
        kinds = {"outcome": np.int64, "systems": np.int64}
        return cls._make(np.zeros((count, *rows.get(name, ())), kinds.get(name, np.float64)) for name in cls._fields)

    @property
    def factor(self) -> Float:
        """(k,) the peak, inf where the path is endless, 0 where it was lost."""
        endless = np.where(self.outcome == PathOutcome.ENDLESS, np.inf, 0.0)
        return np.where(self.outcome == PathOutcome.PEAK, self.peak, endless)

    @property
    def sure(self) -> Float:
        """(k,) the load before which nothing snaps: the peak, or the first maximum from which the load dipped."""
        return np.minimum(self.first, self.peak)

    def chosen(self, which: Int | Bool | slice) -> PathResult:
        """Some of the paths."""
        return PathResult._make(column[which] for column in self)

    def replaced(self, at: Int, others: PathResult) -> PathResult:
        """The same with ``others`` in the places ``at``."""
        columns = [column.copy() for column in self]
        for column, other in zip(columns, others, strict=True):
            column[at] = other
        return PathResult._make(columns).sealed()

    def sealed(self) -> PathResult:
        """Itself, after which nobody can write to it."""
        for column in self:
            column.setflags(write=False)
        return self
