"""The contract that every engine fulfils.

``Engine.prepare(assembly)`` returns a ``State``. ``State.verdict()`` says whether the assembly stands, and
``State.load_factor(W)`` gives the largest factor of every load in W.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_number
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.verdict import Verdict


@dataclass(frozen=True)
class Exact:
    """Accuracy: every load is solved on its own, and all bounds that the engine can give are computed."""


@dataclass(frozen=True)
class Within:
    """Accuracy: an engine that proves both bounds may stop as soon as (upper - lower) / upper <= ``relative`` > 0.

    Loads on one body may then share work. An engine without proved bounds solves every load as ``Exact`` does.
    """

    relative: float

    def __post_init__(self) -> None:
        checked_number(self.relative, "Within: relative", above=0)


@dataclass(frozen=True)
class ForcesOnly:
    """Accuracy: every load is solved on its own, and bounds that take further work are left out."""


Accuracy: TypeAlias = Exact | Within | ForcesOnly

EXACT, FORCES_ONLY = Exact(), ForcesOnly()


class State(Protocol):
    """An engine prepared for one assembly under given standing loads.

    All queries share what was computed once during the preparation, such as the state of rest.
    """

    def verdict(self) -> Verdict:
        """Say whether the assembly stands under its weight and the standing loads."""
        ...

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each load before something moves.

        Each column of W (6J, n) is one load: the wrenches (force [N], torque [N m]) on the J movable bodies, about
        their centres of mass and along the world axes. It acts in addition to the weight and the standing loads.
        Row k of the result answers for column k.
        """
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """The simplifications that the answers rest on, in plain words."""
        ...


class Engine(Protocol):
    """A method of computing answers, together with its options."""

    @property
    def name(self) -> str:
        """The name of the engine, as in ``engine="graph"``."""
        ...

    @property
    def claim(self) -> Claim:
        """What the answers of this engine promise."""
        ...

    def prepare(self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None) -> State:
        """Prepare the engine for one assembly.

        ``standing`` (6J,) are wrenches [N, N m] on the movable bodies that act all the time, in addition to the weight.
        They are about the centres of mass and along the world axes; None means no such loads. ``acceleration`` (3,)
        [m/s²] is that of the support, along the world axes; None means a support at rest.
        """
        ...
