"""The states of engine ``compliant``: an assembly that stands, or one whose loads have no load path."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Event, RLock
from typing import TypeAlias

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.parallel import begin, free_threads
from holdfast.base.text import listed
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.answers import Answers, Bound, Claim
from holdfast.engines.compliant.carriers import HUGE
from holdfast.engines.compliant.columns import Columns, followed, surveyed
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.idle import open_pair
from holdfast.engines.compliant.refinement import Refined
from holdfast.engines.compliant.review import Review
from holdfast.engines.compliant.wedged import MATTERS, Wedged
from holdfast.engines.contract import EXACT, Accuracy, ForcesOnly, Within
from holdfast.engines.directions import by_body
from holdfast.engines.mechanism import NAMED, Mechanism
from holdfast.engines.verdict import Status, Verdict

NAME, CLAIM = "compliant", Claim.HOLDS
MANY = 40  # smallest number of columns on one body for which interpolation pays off
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

    ``loose`` names the bodies that are only balanced: some motion of theirs is resisted by no contact.
    """

    decided: Verdict
    refined: Refined
    loose: tuple[str, ...] = ()
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

        ``lower`` is the peak minus the estimated discretisation error. With ``Within(gap)``, MANY or more columns that
        load one body alone are interpolated between paths (interpolated.py), with expected relative errors of at most
        ``gap``; ``lower`` then also allows for the stated interpolation error. With ``ForcesOnly``, ``lower`` is 0 and
        no finer grid is needed. ``lower`` of wedged bodies covers other springs, too (wedged.py), and leans on no
        contact that is open at rest (idle.py). Of several threads that ask, one waits for the other.
        """
        with self._asking:
            return self._load_factor(W, accuracy)

    def _load_factor(self, W: Float, accuracy: Accuracy) -> Answers:
        loaded = _loaded(W)
        asked = W[:, loaded]
        if len(loaded) and not isinstance(accuracy, ForcesOnly):
            self._begin_bounds()
        if not len(loaded):
            columns = Columns.unknown(0)
        elif isinstance(accuracy, Within) and (groups := by_body(asked, MANY)):
            columns = surveyed(self.refined, asked, groups, accuracy.gap)
        else:
            columns = followed(self.refined, asked, bounds=not isinstance(accuracy, ForcesOnly))
        found = self._review.of(_answers(W.shape[1], loaded, columns, self.decided, accuracy), W, accuracy)
        if isinstance(accuracy, ForcesOnly):
            return found
        found = _before_sliding(self._wedged.covered(found, W), loaded, columns)
        return self._without_idle(found, W, loaded[columns.leans], accuracy)

    def _without_idle(self, found: Answers, W: Float, leaning: Int, accuracy: Accuracy) -> Answers:
        """Return answers for columns W (6J, n), with ``lower`` of those ``leaning`` without contacts idle at rest."""
        if self._bare is None or not len(leaning):
            return found
        there, lower = self._bare.load_factor(W[:, leaning], accuracy), np.array(found.lower)
        least = np.minimum(lower[leaning], there.lower)
        telling = int((least < (1 - MATTERS) * lower[leaning]).sum())
        lower[leaning] = least
        assembly = self.grid.assembly
        which = listed([open_pair(assembly, k) for k in self.grid.idle if assembly.interfaces[k].certain], NAMED)
        if not telling or not which:  # of contacts that are not certain presence.py tells
            return replace(found, lower=lower)
        words = f"{telling} of {len(found)} answers lean on contacts that are open at rest, and lower is without them"
        return replace(found, lower=lower, notes=(*found.notes, f"{words}: {which}"))

    @cached_property
    def _bare(self) -> Standing | None:
        """The same state without contacts that are open and carry nothing at rest; None if there are none."""
        grid = self.grid
        if not grid.idle or grid.springs.faces is not None:
            return None
        bare = Grid.of(grid.assembly.without_interfaces(grid.idle), grid.wrench, grid.springs, hold=grid.hold)
        return Standing(self.decided, replace(self.refined, grid=bare), self.loose)

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where more has to be asked.

        Where a load acts on a body that is only balanced, where bodies are wedged, and where loads are so large that
        paths may leave their branch, it takes what ``load_factor`` does: no path that ends at the load tells.
        """
        small = (np.abs(self.grid.loads(W)).max(axis=1, initial=0.0) <= HUGE) & ~self.grid.loads_held(W)
        rows = np.flatnonzero(small & (W != 0).any(axis=0))
        held = ~(W != 0).any(axis=0)
        if self.grid.springs.faces is not None or not len(rows):
            return np.asarray(held)
        with self._asking:
            if not self._wedged.possible:
                held[rows] = self.refined.held(W[:, rows])
                if self._bare is not None:
                    held &= self._bare.held(W)
        return np.asarray(held)

    def _begin_bounds(self) -> None:
        """Begin once what lower bounds need, while the first long path is followed, which leaves a processor idle."""
        if self.grid.system.long and free_threads() > 1 and not self._begun.is_set():
            self._begun.set()
            begin(lambda: (self.grid.finer, self._wedged.possible))

    @cached_property
    def _wedged(self) -> Wedged:
        return Wedged(self.grid)

    @cached_property
    def _review(self) -> Review:
        return Review(self.grid, self.loose)


CompliantState: TypeAlias = Standing | Unpushable


def _before_sliding(found: Answers, loaded: Int, columns: Columns) -> Answers:
    """Return the answers with ``lower`` of those ``loaded`` at most what is reached before bodies slide far.

    A path that turned out to have left its branch, as the answer has no end, tells nothing.
    """
    slides = (columns.before < columns.lower) & (np.isfinite(found.force[loaded]) | np.isinf(columns.factor))
    most = np.minimum(found.lower[loaded], np.where(slides, columns.before, np.inf))
    telling = int((most < (1 - MATTERS) * found.lower[loaded]).sum())
    if not slides.any():
        return found
    lower = np.array(found.lower)
    lower[loaded] = most
    words = f"{telling} of {len(found)} answers hold only after sliding: lower is what is reached before"
    return replace(found, lower=lower, notes=(*found.notes, words) if telling else found.notes)


def _loaded(W: Float) -> Int:
    """Return the numbers of the columns of W (6J, n) that are not zero."""
    return np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)


def _answers(count: int, loaded: Int, columns: Columns, verdict: Verdict, accuracy: Accuracy) -> Answers:
    """Build the answers for ``count`` columns: ``columns`` for those that are ``loaded``, INFINITE for the others."""
    factor, lower, upper = np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf)
    status = [Status.INFINITE] * count
    mechanisms: list[Mechanism | None] = [None] * count
    solved, error = np.ones(count, dtype=bool), np.zeros(count)
    factor[loaded], lower[loaded] = columns.factor, columns.lower
    solved[loaded], error[loaded] = columns.solved, columns.error
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
        solved=solved,
        error=error,
        lower_bound=Bound.NONE if isinstance(accuracy, ForcesOnly) else Bound.ESTIMATED,
    )
