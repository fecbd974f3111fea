"""Engine ``compliant`` made ready for one assembly: standing, or not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.compliant.columns import Columns, followed, surveyed
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import Refined
from holdfast.engines.contract import Capacity, Mechanism, Status, Verdict, no_capacity

MANY = 40  # columns on one body from which on it pays to interpolate
STATUS = {
    PathOutcome.PEAK: Status.FINITE,
    PathOutcome.ENDLESS: Status.INFINITE,
    PathOutcome.LOST: Status.UNDECIDED,
}


@dataclass(frozen=True, eq=False)
class Unpushable:
    """An assembly without a state of rest on elastic contacts at which load paths could begin."""

    decided: Verdict

    def verdict(self) -> Verdict:
        """Whether the assembly comes to rest."""
        return self.decided

    @property
    def notes(self) -> tuple[str, ...]:
        """None: what the answers rest on is their claim."""
        return ()

    def load_factor(self, W: Float, gap: float | None = None) -> Capacity:
        """For each column of W (6J, n): undecided, unless the assembly does not stand or the column is zero."""
        if self.decided.status is not Status.STABLE:
            return no_capacity(W.shape[1], self.decided)
        loaded = _loaded(W)
        return _capacity(W.shape[1], loaded, Columns.unknown(len(loaded)))


@dataclass(frozen=True, eq=False)
class Standing:
    """An assembly at rest on elastic contacts: all load paths begin there."""

    decided: Verdict
    refined: Refined

    @property
    def grid(self) -> Grid:
        """The nodes that answers come from unless they are too coarse."""
        return self.refined.grid

    def verdict(self) -> Verdict:
        """Whether the assembly comes to rest."""
        return self.decided

    @property
    def notes(self) -> tuple[str, ...]:
        """None: what the answers rest on is their claim."""
        return ()

    def load_factor(self, W: Float, gap: float | None = None) -> Capacity:
        """For each column of W (6J, n) the peak of its load path; ``lower`` is that less the discretisation estimate.

        With ``gap`` MANY columns on one body are interpolated between paths (interpolated.py) with expected errors of
        at most ``gap``: ``lower`` then also lies below what the stated error allows.
        A ``gap`` of 1 asks for no bounds: ``lower`` is then 0, and no finer nodes are needed.
        """
        loaded = _loaded(W)
        asked = W[:, loaded]
        bodies = np.flatnonzero((asked != 0).reshape(-1, 6, len(loaded)).any((1, 2)))
        if not len(loaded):
            columns = Columns.unknown(0)
        elif gap is None or gap >= 1 or len(loaded) < MANY or len(bodies) > 1:
            columns = followed(self.refined, asked, bounds=gap is None or gap < 1)
        else:
            columns = surveyed(self.refined, asked, 6 * int(bodies[0]), gap)
        return _capacity(W.shape[1], loaded, columns)


CompliantState: TypeAlias = Standing | Unpushable


def _loaded(W: Float) -> Int:
    """The numbers of the columns of W (6J, n) that are not zero."""
    return np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)


def _capacity(count: int, loaded: Int, columns: Columns) -> Capacity:
    """The answer for ``count`` columns: what is known of those that are ``loaded``, infinite for the rest."""
    factor, lower, upper = np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf)
    status = [Status.INFINITE] * count
    mechanisms: list[Mechanism | None] = [None] * count
    solved, error = np.ones(count, dtype=bool), np.zeros(count)
    factor[loaded], lower[loaded] = columns.factor, columns.lower
    solved[loaded], error[loaded] = columns.solved, columns.error
    for k, column in enumerate(loaded.tolist()):
        mechanisms[column], status[column] = columns.mechanisms[k], STATUS[PathOutcome(columns.outcome[k])]
    return Capacity.told(factor, lower, upper, status, mechanisms, solved, error)
