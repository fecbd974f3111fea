"""The states of engine ``compliant``: an assembly that stands, or one whose loads have no load path."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Event, RLock
from typing import TypeAlias

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.parallel import begin, free_threads
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.amendments.amendment import Amendment, Asked
from holdfast.engines.amendments.amendment_list import amended, amendments_of
from holdfast.engines.amendments.self_stressed import SelfStressed
from holdfast.engines.answers import Answers, Bound, Claim, Step
from holdfast.engines.compliant.balanced import Neutral
from holdfast.engines.compliant.columns import Columns, followed
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.load_bearing import HUGE
from holdfast.engines.compliant.refinement import Refined
from holdfast.engines.compliant.rest_verdict import balanced_forces
from holdfast.engines.contract import EXACT, Accuracy, ForcesOnly
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.rest import contact_forces
from holdfast.engines.verdict import ContactForces, Status, Verdict

NAME, CLAIM = "compliant", Claim.HOLDS
STATUS = {
    PathOutcome.PEAK: Status.FINITE,
    PathOutcome.ENDLESS: Status.INFINITE,
    PathOutcome.LOST: Status.UNDECIDED,
}


@dataclass(frozen=True, eq=False)
class Unpushable:
    """An assembly without a known state of rest on elastic contacts, so that no load path can start."""

    decided: Verdict

    def verdict(self) -> Verdict:
        """Say whether the assembly comes to rest."""
        return self.decided

    @property
    def notes(self) -> tuple[str, ...]:
        """No notes: the claim of the engine already states what the answers rest on."""
        return ()

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Answer for each column of W (6J, n) without a load path.

        All rows have force 0 if the assembly does not stand or may not stand. Otherwise a column is UNDECIDED, or
        INFINITE if it is zero.
        """
        if self.decided.status is not Status.STABLE:
            return Answers.not_standing(W.shape[1], engine=NAME, claim=CLAIM, verdict=self.decided)
        loaded = _loaded(W)
        return _answers(W.shape[1], loaded, Columns.unknown(len(loaded)), self.decided, accuracy)


@dataclass(frozen=True, eq=False)
class Standing:
    """An assembly at rest on elastic contacts. All load paths start at this state of rest.

    ``neutral`` are the motions that no contact resists, of bodies that are only balanced; None if nothing may have any.
    """

    decided: Verdict
    refined: Refined
    neutral: Neutral | None = None
    _asking: RLock = field(default_factory=RLock, init=False, repr=False)  # searches for rest work in the grids' memory
    _begun: Event = field(default_factory=Event, init=False, repr=False)  # what lower bounds need

    @property
    def grid(self) -> Grid:
        """The grid from which answers are taken unless it is too coarse."""
        return self.refined.grid

    def verdict(self) -> Verdict:
        """Say that the assembly comes to rest, with the contact forces."""
        return self.decided

    @property
    def notes(self) -> tuple[str, ...]:
        """No notes: the claim of the engine already states what the answers rest on."""
        return ()

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the peak of the load path of each column of W (6J, n) [N, N m].

        ``lower`` is the peak minus the estimated discretisation error. Every column is answered as if it were asked
        alone, ``Within`` an error, too: a neighbour's error says nothing certain about its own. With ``ForcesOnly``,
        ``lower`` is 0 and no finer grid is needed. What paths do not know is amended (amendments/amendment_list.py).
        Of several threads that ask, one waits for the other.
        """
        with self._asking:
            return self._load_factor(W, accuracy)

    def _load_factor(self, W: Float, accuracy: Accuracy) -> Answers:
        loaded = _loaded(W)
        asked = W[:, loaded]
        if len(loaded) and not isinstance(accuracy, ForcesOnly):
            self._begin_bounds()
        bounds = not isinstance(accuracy, ForcesOnly)
        columns = followed(self.refined, asked, bounds=bounds) if len(loaded) else Columns.unknown(0)
        found = _answers(W.shape[1], loaded, columns, self.decided, accuracy)
        return amended(found, Asked(W, accuracy, loaded, columns), self._amendments)

    @cached_property
    def without_idle(self) -> Standing | None:
        """The same state without contacts that are open and carry nothing at rest; None if there are none."""
        grid = self.grid
        if not grid.idle or grid.springs.faces is not None:
            return None
        bare = Grid.of(grid.assembly.without_interfaces(grid.idle), grid.wrench, grid.springs, hold=grid.hold)
        return Standing(self.decided, replace(self.refined, grid=bare), self.neutral)

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where more has to be asked.

        Where a load acts on a body that is only balanced, where bodies are self-stressed, and where loads are so large
        that paths may leave their branch, it takes what ``load_factor`` does: no path that ends at the load tells.
        """
        small = (np.abs(self.grid.loads(W)).max(axis=1, initial=0.0) <= HUGE) & ~self.grid.loads_held(W)
        rows = np.flatnonzero(small & (W != 0).any(axis=0))
        held = ~(W != 0).any(axis=0)
        if self.grid.springs.faces is not None or not len(rows):
            return np.asarray(held)
        with self._asking:
            if not self._self_stressed.by_stiffness:
                held[rows] = self.refined.held(W[:, rows])
                if self.without_idle is not None:
                    held &= self.without_idle.held(W)
        return np.asarray(held)

    def forces_under(self, load: Float) -> ContactForces | None:
        """Return the contact forces once a ``load`` (6J,) [N, N m] has grown from 0, None if its path ends before."""
        grid = self.grid
        with self._asking:
            path = grid.paths(load[:, None], most=1.0)
            if path.outcome[0] != PathOutcome.REACHED:
                return None
            system = grid.system.under(grid.system.model.wrench + grid.loads(load[:, None])[0])
            back = grid.settled.q + (path.q[0] - grid.settled.q) / path.peak[0]  # the path steps beyond the load
            q = system.rest_near(back)
            found = None if q is None else balanced_forces(grid, q, load)
            found = found or balanced_forces(grid, system.come_to_rest(near=path.q[0]).q, load)
        return None if found is None else contact_forces(grid.assembly, grid.nodes, found[0])

    def _begin_bounds(self) -> None:
        """Begin once what lower bounds need, while the first long path is followed, which leaves a processor idle."""
        if self.grid.system.long and free_threads() > 1 and not self._begun.is_set():
            self._begun.set()
            begin(lambda: (self.grid.finer, self._self_stressed.by_stiffness))

    @cached_property
    def _amendments(self) -> tuple[Amendment, ...]:
        return amendments_of(self)

    @cached_property
    def _self_stressed(self) -> SelfStressed:
        return next(one for one in self._amendments if isinstance(one, SelfStressed))


CompliantState: TypeAlias = Standing | Unpushable


def _loaded(W: Float) -> Int:
    """Return the numbers of the columns of W (6J, n) that are not zero."""
    return np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)


def _answers(count: int, loaded: Int, columns: Columns, verdict: Verdict, accuracy: Accuracy) -> Answers:
    """Build the answers for ``count`` columns: ``columns`` for those that are ``loaded``, INFINITE for the others."""
    factor, lower, upper = np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf)
    status = [Status.INFINITE] * count
    mechanisms: list[Mechanism | None] = [None] * count
    raw = np.full(count, np.inf)
    raw[loaded] = columns.raw
    factor[loaded], lower[loaded] = columns.factor, columns.lower
    for k, column in enumerate(loaded.tolist()):
        mechanisms[column], status[column] = columns.mechanisms[k], STATUS[PathOutcome(columns.outcome[k])]
    return Answers.of(
        engine=NAME,
        claim=CLAIM,
        verdict=verdict,
        force=factor,
        lower=lower,
        upper=upper,
        status=status,
        mechanism=mechanisms,
        lower_bound=Bound.NONE if isinstance(accuracy, ForcesOnly) else Bound.ESTIMATED,
        steps=(
            Step(
                "load path on the first grid", "the load at which its path from rest has a peak", raw, np.zeros(count)
            ),
        ),
    ).after("finer grids", "lower is less by twice the change from one grid to the next and by 0.2 %")
