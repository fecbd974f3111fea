"""What an amendment is: it takes a table of answers, and returns one that is corrected, bounded or doubted.

The short ones are here, those that lower bounds. ``Sliding``: friction opposes where a contact came from in this law,
and where it goes in reality. Both agree while contacts give; of rows that lean and of jams the law finds peaks that
bodies reach only after sliding for long, and they let go earlier. ``OpenContacts``: why no bound may lean on contacts
that are open and idle at rest is said in grid.py.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.text import listed
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.grid import Grid, open_pair
from holdfast.engines.compliant.refinement import Bounded
from holdfast.engines.contract import Accuracy, ForcesOnly
from holdfast.engines.mechanism import NAMED
from holdfast.native import core

if TYPE_CHECKING:
    from holdfast.engines.compliant.compliant_state import RestingState

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


@dataclass(frozen=True, eq=False)
class Amendment(ABC):
    """One amendment of the answers about an assembly at rest, ``state``.

    ``name`` says in the words of an explanation what it looks at, and ``why`` what it does and for which reason.
    """

    state: RestingState

    name: ClassVar[str]
    why: ClassVar[str]

    @cached_property
    def grid(self) -> Grid:
        """The grid from which answers are taken."""
        return self.state.grid

    @abstractmethod
    def amend(self, found: Answers, asked: LoadQuestion) -> Answers | None:
        """Return the answers ``found`` as amended, or None if they are none of its business, which is cheap to tell."""


@dataclass(frozen=True, eq=False)
class OpenContacts(Amendment):
    """Lowers the bounds of answers in which contacts take part that need not exist."""

    name: ClassVar[str] = "contacts that are open at rest"
    why: ClassVar[str] = "contacts that are open and carry nothing at rest may never close, so lower is without them"

    def amend(self, found: Answers, asked: LoadQuestion) -> Answers | None:
        """Return the answers; of those that lean on contacts idle at rest, ``lower`` is as without all of these."""
        if not asked.bounded or not asked.leans.any() or (bare := self.state.without_idle) is None:
            return None
        leaning = asked.loaded[asked.leans]
        there, lower = bare.load_factor(asked.W[:, leaning], asked.accuracy), np.array(found.lower)
        least = np.minimum(lower[leaning], there.lower)
        telling = int((least < (1 - MATTERS) * lower[leaning]).sum())
        lower[leaning] = least
        assembly = self.grid.assembly
        which = listed([open_pair(assembly, k) for k in self.grid.idle if assembly.interfaces[k].certain], NAMED)
        if not telling or not which:  # of contacts that are not certain doubtful_contacts.py tells
            return replace(found, lower=lower)
        words = f"{telling} of {len(found)} answers lean on contacts that are open at rest, and lower is without them"
        return replace(found, lower=lower, notes=(*found.notes, f"{words}: {which}"))


@dataclass(frozen=True, eq=False)
class Sliding(Amendment):
    """Lowers the bounds of answers that are reached only after sliding SLID times as far as contacts give."""

    name: ClassVar[str] = "sliding far"
    why: ClassVar[str] = f"what holds only after sliding {core.SLID:g} times as far as contacts give is not promised"

    def amend(self, found: Answers, asked: LoadQuestion) -> Answers | None:
        """Return the answers with ``lower`` at most what is reached before contacts have slid far.

        A path that turned out to have left its branch, as the answer has no end, tells nothing. Of faces that touch at
        high points only, what bonded contacts give is far too little; the ideal ones are asked.
        """
        if not asked.bounded or self.grid.springs.faces is not None:
            return None
        before, loaded = asked.solved.before, asked.loaded
        far_before = before < asked.solved.lower
        if not far_before.any():
            return None
        slides = far_before & (np.isfinite(found.force[loaded]) | np.isinf(asked.solved.paths.factor))
        if not slides.any():
            return found
        most = np.minimum(found.lower[loaded], np.where(slides, before, np.inf))
        telling = int((most < (1 - MATTERS) * found.lower[loaded]).sum())
        lower = np.array(found.lower)
        lower[loaded] = most
        far = f"{core.SLID:g} times as far as contacts give"
        words = f"{telling} of {len(found)} answers hold more only after sliding {far}"
        return replace(found, lower=lower, notes=(*found.notes, words) if telling else found.notes)
