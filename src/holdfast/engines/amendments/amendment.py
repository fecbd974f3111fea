"""What an amendment is: it takes a table of answers, and returns one that is corrected, bounded or doubted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Protocol

from holdfast.base.arrays import Float, Int
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.balanced import Neutral
from holdfast.engines.compliant.columns import Columns
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.contract import Accuracy, ForcesOnly, State

MATTERS = 0.05  # relative change of an answer above which a note tells of an amendment


@dataclass(frozen=True, eq=False)
class Asked:
    """The question that answers belong to: the load columns W (6J, n) [N, N m] and the ``accuracy`` asked for.

    ``columns`` holds what load paths say of the columns ``loaded`` (k,), those that are not zero.
    """

    W: Float
    accuracy: Accuracy
    loaded: Int
    columns: Columns

    @property
    def bounded(self) -> bool:
        """Whether lower bounds are wanted."""
        return not isinstance(self.accuracy, ForcesOnly)


class AtRest(Protocol):
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

    state: AtRest

    name: ClassVar[str]
    why: ClassVar[str]

    @property
    def grid(self) -> Grid:
        """The grid from which answers are taken."""
        return self.state.grid

    @abstractmethod
    def applies(self, asked: Asked) -> bool:
        """Tell whether anything may have to be amended; it is cheap."""

    @abstractmethod
    def amend(self, found: Answers, asked: Asked) -> Answers:
        """Return the answers ``found`` as amended."""
