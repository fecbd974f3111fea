"""What every engine takes and gives: ``prepare(assembly)``, then ``verdict()`` and ``load_factor(W)`` of the state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_number
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.verdict import Verdict


@dataclass(frozen=True)
class Exact:
    """Every load is answered on its own, with all bounds that the engine has."""


@dataclass(frozen=True)
class Within:
    """Loads on one body may share work, within a relative ``gap``.

    An engine that proves both bounds may stop at (upper - lower) / upper <= gap; one that does not may carry answers
    over between neighbouring loads with about that relative error.
    """

    gap: float

    def __post_init__(self) -> None:
        checked_number(self.gap, "Within: gap", above=0)


@dataclass(frozen=True)
class ForcesOnly:
    """Every load is answered on its own; bounds that take further work are not wanted."""


Accuracy: TypeAlias = Exact | Within | ForcesOnly

EXACT, FORCES_ONLY = Exact(), ForcesOnly()


class State(Protocol):
    """An engine made ready for one assembly under given standing loads; factors are shared by all queries."""

    def verdict(self) -> Verdict:
        """Whether the assembly stands under its weight and the standing loads."""
        ...

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """For each column of W (6J, n), wrenches on the movable bodies: the largest factor before motion."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """Simplifications that the answers rest on, in plain words."""
        ...


class Engine(Protocol):
    """A method with its options."""

    @property
    def name(self) -> str:
        """Its name, as in ``engine="graph"``."""
        ...

    @property
    def claim(self) -> Claim:
        """What its answers promise."""
        ...

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> State:
        """Ready the engine; ``standing`` (6J,) wrenches act besides weight, on a support with ``acceleration`` (3,)."""
        ...
