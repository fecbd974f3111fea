"""What an amendment is: it takes a table of answers, and returns one that is corrected, bounded or doubted.

``LimitReview``: answers that deserve doubt are compared with limit analysis, which proves above which load bodies
move. Others lower bounds; a long one has a module of its own (self_stressed.py). ``Sliding``: friction opposes where a
contact came from in this law, and where it goes in reality. Both agree while contacts give; of rows that lean and of
jams the law finds peaks that bodies reach only after sliding for long, and they let go earlier. ``OpenContacts``: why
no bound may lean on contacts that are open and idle at rest is said in grid.py.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.text import listed
from holdfast.elastic.system import PathOutcome
from holdfast.engines.answers import Answers, only_balanced
from holdfast.engines.compliant.balanced import Neutral
from holdfast.engines.compliant.grid import Grid, open_pair
from holdfast.engines.compliant.load_bearing import HUGE, rests_alone
from holdfast.engines.compliant.refinement import Bounded
from holdfast.engines.contract import Accuracy, ForcesOnly, State
from holdfast.engines.mechanism import NAMED, Mechanism
from holdfast.engines.verdict import Status
from holdfast.native import core

MATTERS = 0.05  # relative change of an answer above which a note tells of an amendment


@dataclass(frozen=True, eq=False)
class LoadQuestion:
    """The question that answers belong to: the load columns W (6J, n) [N, N m] and the ``accuracy`` asked for.

    ``solved`` are the load paths of the columns ``loaded`` (k,), those that are not zero. ``leans`` (k,) is True where
    contacts that are open at rest take part at the peak.
    """

    W: Float
    accuracy: Accuracy
    loaded: Int
    solved: Bounded
    leans: Bool

    @cached_property
    def bounded(self) -> bool:
        """Whether lower bounds are wanted."""
        return not isinstance(self.accuracy, ForcesOnly)


class ElasticRest(Protocol):
    """An assembly at rest on elastic contacts, as amendments see it."""

    @property
    def grid(self) -> Grid:
        """The grid from which answers are taken."""
        ...

    @property
    def neutral(self) -> Neutral | None:
        """The motions that no contact resists, of bodies that are only balanced; None if nothing may have any."""
        ...

    @property
    def without_idle(self) -> State | None:
        """The same state without contacts that are open and carry nothing at rest; None if there are none."""
        ...


@dataclass(frozen=True, eq=False)
class Amendment(ABC):
    """One amendment of the answers about an assembly at rest, ``state``.

    ``name`` says in the words of an explanation what it looks at, and ``why`` what it does and for which reason.
    """

    state: ElasticRest

    name: ClassVar[str]
    why: ClassVar[str]

    @cached_property
    def grid(self) -> Grid:
        """The grid from which answers are taken."""
        return self.state.grid

    @abstractmethod
    def amend(self, answers: Answers, question: LoadQuestion) -> Answers | None:
        """Return the ``answers`` as amended, or None if they are none of its business, which is cheap to tell."""


@dataclass(frozen=True, eq=False)
class OpenContacts(Amendment):
    """Lowers the bounds of answers in which contacts take part that need not exist."""

    name: ClassVar[str] = "contacts that are open at rest"
    why: ClassVar[str] = "contacts that are open and carry nothing at rest may never close, so lower is without them"

    def amend(self, answers: Answers, question: LoadQuestion) -> Answers | None:
        """Return the answers; of those that lean on contacts idle at rest, ``lower`` is as without all of these."""
        if not question.bounded or not question.leans.any() or (bare := self.state.without_idle) is None:
            return None
        leaning = question.loaded[question.leans]
        there, lower = bare.load_factor(question.W[:, leaning], question.accuracy), np.array(answers.lower)
        least = np.minimum(lower[leaning], there.lower)
        telling = int((least < (1 - MATTERS) * lower[leaning]).sum())
        lower[leaning] = least
        assembly = self.grid.assembly
        which = listed([open_pair(assembly, k) for k in self.grid.idle if assembly.interfaces[k].certain], NAMED)
        if not telling or not which:  # of contacts that are not certain doubtful_contacts.py tells
            return replace(answers, lower=lower)
        words = f"{telling} of {len(answers)} answers lean on contacts that are open at rest, and lower is without them"
        return replace(answers, lower=lower, notes=(*answers.notes, f"{words}: {which}"))


@dataclass(frozen=True, eq=False)
class Sliding(Amendment):
    """Lowers the bounds of answers that are reached only after sliding SLID times as far as contacts give."""

    name: ClassVar[str] = "sliding far"
    why: ClassVar[str] = f"what holds only after sliding {core.SLID:g} times as far as contacts give is not promised"

    def amend(self, answers: Answers, question: LoadQuestion) -> Answers | None:
        """Return the answers with ``lower`` at most what is reached before contacts have slid far.

        A path that turned out to have left its branch, as the answer has no end, tells nothing. Of faces that touch at
        high points only, what bonded contacts give is far too little; the ideal ones are asked.
        """
        if not question.bounded or self.grid.springs.faces is not None:
            return None
        before, loaded = question.solved.before, question.loaded
        far_before = before < question.solved.lower
        if not far_before.any():
            return None
        slides = far_before & (np.isfinite(answers.force[loaded]) | np.isinf(question.solved.paths.factor))
        if not slides.any():
            return answers
        most = np.minimum(answers.lower[loaded], np.where(slides, before, np.inf))
        telling = int((most < (1 - MATTERS) * answers.lower[loaded]).sum())
        lower = np.array(answers.lower)
        lower[loaded] = most
        far = f"{core.SLID:g} times as far as they give, which lower leaves out"
        words = f"{telling} of {len(answers)} answers hold more only after contacts slide {far}"
        return replace(answers, lower=lower, notes=(*answers.notes, words) if telling else answers.notes)


# Share by which a peak may lie above the proved bound before it counts as wrong: four of the experiments with a robot's
# pushes do by more (tests/cases/test_experiments.py)
CONTRADICTION = 0.05
PATIENCE = 200  # largest number of Newton steps in the search for rest under a load alone
ENDLESS = 1e3  # a lower bound above this many weights of the group leaves it to limit analysis whether there is an end


class _Answer(NamedTuple):
    """One answer, with the names that the columns of a table have."""

    status: Status
    force: float
    lower: float
    mechanism: Mechanism | None


ENDLESS_ANSWER = _Answer(Status.INFINITE, np.inf, np.inf, None)
UNDECIDED_ANSWER = _Answer(Status.UNDECIDED, 0.0, 0.0, None)


@dataclass(frozen=True, eq=False)
class LimitReview(Amendment):
    """Compares answers with limit analysis where they deserve doubt.

    That is where an answer is undecided, has no lower bound, or exceeds HUGE times the weight, and where a load acts on
    a body that a regularisation spring keeps in its place (``Grid.hold``): bodies that are only balanced need one.
    """

    name: ClassVar[str] = "limit analysis"
    why: ClassVar[str] = "limit analysis proves when something moves at the latest, and which loads have no end"

    def amend(self, answers: Answers, question: LoadQuestion) -> Answers:
        """Return the ``answers``, mended where limit analysis proves more.

        - A push becomes 0 if it gains power in a motion that no contact resists (balanced.py).
        - An answer above the proved bound by more than CONTRADICTION is undecided; one that is less far above it is
          lowered to it.
        - A peak above HUGE times the weight is infinite if contact forces balance the load alone, with friction, by
          both methods. So is a peak whose lower bound, which the finer grid confirms, is above ENDLESS times the
          weight, if limit analysis finds forces that balance the load alone: there the weight is nothing but a
          disturbance of the balance, of the size of those that a path is lost by. If nothing of this is found, such a
          peak without a lower bound is, where limit analysis finds no end, infinite if the finer grid finds none
          either, and undecided otherwise. An undecided answer is infinite if its path was lost above HUGE times the
          weight that counts beside its load and one of the two searches for rest succeeds, or if it has no end, on the
          finer grid neither, where every body is held.
        """
        W, grid, neutral = question.W, self.grid, self.state.neutral
        # sizes of the loads relative to all weights, and which of them act on a body with a regularisation spring
        size, on_spring = np.abs(grid.loads(W)).max(axis=1, initial=0.0), grid.loads_held(W)
        gained = np.zeros(len(size), dtype=bool) if neutral is None else neutral.gained(W)
        finite = answers.status == Status.FINITE
        peak = np.where(finite, answers.force, 0.0)
        unsure = on_spring | (answers.status == Status.UNDECIDED) | (finite & (peak * size > HUGE))
        if question.bounded:
            unsure |= finite & (answers.lower <= 0)
        doubtful = np.flatnonzero(gained | np.asarray((size > 0) & unsure))
        if not len(doubtful) or not grid.certain.verdict().equilibrium_exists:
            return answers
        certain = grid.certain.load_factor(W[:, doubtful])
        upper = np.array(answers.upper)
        known: dict[str, Any] = {name: np.array(getattr(answers, name)) for name in _Answer._fields}
        upper[doubtful] = np.minimum(upper[doubtful], certain.upper)
        for k, row in enumerate(doubtful.tolist()):
            answer = _Answer._make(column[row] for column in known.values())
            if gained[row]:
                mechanism = certain.mechanism[k] if answer.mechanism is None else answer.mechanism
                mended = _Answer(Status.FINITE, 0.0, 0.0, mechanism)
            else:
                load, endless = W[:, row], certain.status[k] is Status.INFINITE
                mended = self._mended(
                    answer,
                    load,
                    float(size[row]),
                    float(upper[row]),
                    endless,
                    on_spring=on_spring[row],
                    bounded=question.bounded,
                )
            for column, value in zip(known.values(), mended, strict=True):
                column[row] = value
        names = () if neutral is None else neutral.named(grid.assembly)
        notes = (*answers.notes, only_balanced(names)) if names else answers.notes
        return replace(answers, **known, upper=upper, notes=notes)

    def _mended(
        self, answer: _Answer, load: Float, size: float, top: float, endless: bool, *, on_spring: bool, bounded: bool
    ) -> _Answer:
        """Return the answer for one ``load`` (6J,) of a ``size`` relative to all weights, mended as ``amend`` says.

        Limit analysis proves that it is at most ``top``, or finds it ``endless``; ``on_spring`` tells whether the load
        acts on a body with a regularisation spring, and ``bounded`` whether lower bounds are wanted.
        """
        if answer.status is Status.UNDECIDED:
            return ENDLESS_ANSWER if endless and self._endless_behind(load, size) else answer
        if answer.force > (1 + CONTRADICTION) * top:
            return UNDECIDED_ANSWER
        confirmed = not on_spring and answer.lower * size > ENDLESS  # a regularisation spring may have helped
        if endless and (confirmed or self._endless(load, float(answer.force))):
            return ENDLESS_ANSWER
        if endless and bounded and answer.lower <= 0 and answer.force * size > HUGE:
            finer = self.grid.finer.paths(load[:, None]).outcome[0]
            return ENDLESS_ANSWER if finer == PathOutcome.ENDLESS else UNDECIDED_ANSWER
        force = min(answer.force, top)
        return answer._replace(force=force, lower=min(answer.lower, force))

    def _endless_behind(self, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) was lost although it has no end."""
        reached = float(self.grid.paths(column[:, None]).peak[0])
        beside = self.grid.load_bearing.weight(self.grid.loads(column[:, None])[0])
        if HUGE * beside < reached * size < np.inf and self._endless(column, reached):
            return True
        # where bodies lie on whole multiples of their size, some of them come to be only balanced on the way
        for grid in (self.grid, self.grid.finer):
            paths = grid.with_hold.paths(column[:, None])
            if paths.outcome[0] != PathOutcome.ENDLESS and not paths.peak[0] * size > ENDLESS:
                return False
        return True

    def _endless(self, column: Float, peak: float) -> bool:
        """Tell whether elastic contacts balance one load (6J,) without any weight, or its ``peak`` is infinite."""
        if not np.isfinite(peak):
            return True
        load = self.grid.loads(column[:, None])[0]
        if self.grid.load_bearing.balance(load):
            return True
        return rests_alone(self.grid.with_hold.system.under(load / np.abs(load).max()), PATIENCE)
