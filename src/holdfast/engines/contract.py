"""What every engine takes and gives: ``prepare(assembly)``, then ``verdict()`` and ``load_factor(W)`` of the state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum, auto
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Int


class Claim(StrEnum):
    """What an engine's answer promises."""

    EXISTS = auto()  # an equilibrium exists up to the answer, none does above it
    HOLDS = auto()  # elastic contacts with Coulomb friction rest up to the answer
    ESTIMATED = auto()  # the method of Nadeau & Kelly: neither a lower nor an upper bound


class Status(StrEnum):
    """The kind of an answer: of a verdict (the first three) or of one query (the last four)."""

    STABLE = auto()
    UNSTABLE = auto()
    UNDECIDED = auto()
    FINITE = auto()
    INFINITE = auto()


Mode = Literal["slip", "topple", "mixed", "none"]


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Contact forces at rest.

    At ``points`` (I, 3) [m] of ``interface`` (I,), ``force`` (I, 3) [N] acts on the interface's second body and minus
    it on the first; ``normal`` (I, 3) points into the second body.

    ``usage`` (I,) is |f_t| / (μ f_n), the share of friction in use (0 at nodes without force).
    """

    points: Float
    normal: Float
    force: Float
    interface: Int
    usage: Float


@dataclass(frozen=True, eq=False)
class Mechanism:
    """How bodies begin to move: ``twists`` (J, 6) velocities of all movable bodies about their centres of mass.

    Scaled so that the fastest point of the assembly's extent moves at about 1; zero for bodies at rest. ``text`` tells
    the motion of each group of bodies in words.
    """

    moving: tuple[str, ...]
    twists: Float
    mode: Mode
    tell: Callable[[], str] = field(repr=False)

    @cached_property
    def text(self) -> str:
        """The motion in words, composed when asked for: maps hold thousands of mechanisms that nobody reads."""
        return self.tell()


@dataclass(frozen=True)
class Certificate:
    """Proof that no equilibrium exists (Farkas): a motion of the mechanism that gains ``power`` [W at its scale].

    Along it no contact can resist: the relative velocity at every corner of every patch lies in the dual of the
    friction cone, u_n >= μ |u_t|, up to ``violation`` (relative to the fastest point of the motion).
    """

    power: float
    violation: float


@dataclass(frozen=True, eq=False)
class Verdict:
    """Whether the assembly stands, and why."""

    status: Status
    equilibrium_exists: bool | None
    self_stress: bool | None
    forces: ContactForces | None
    residual: float
    mechanism: Mechanism | None
    certificate: Certificate | None
    reason: str


@dataclass(frozen=True, eq=False)
class Capacity:
    """For each load column: the largest ``factor`` (n,) by which it may be multiplied, with bounds, and what gives way.

    ``status`` (n,) FINITE, INFINITE, UNSTABLE (factor 0) or UNDECIDED (factor 0); ``moving``, ``mode`` and
    ``mechanism`` (n,), None where nothing gives way. Where ``solved`` (n,) is false the answer was carried over from
    neighbouring loads; ``error`` (n,) is how far the factor may then be off, relative (0 where solved).
    """

    factor: Float
    lower: Float
    upper: Float
    status: tuple[Status, ...]
    moving: tuple[tuple[str, ...], ...]
    mode: tuple[Mode, ...]
    mechanism: tuple[Mechanism | None, ...]
    solved: Bool
    error: Float

    @classmethod
    def told(
        cls,
        factor: Float,
        lower: Float,
        upper: Float,
        status: Sequence[Status],
        mechanisms: Sequence[Mechanism | None],
        solved: Bool | None = None,
        error: Float | None = None,
    ) -> Capacity:
        """The capacity whose ``moving`` and ``mode`` are those of its mechanisms; all solved unless told."""
        return cls(
            factor,
            lower,
            upper,
            tuple(status),
            tuple(() if m is None else m.moving for m in mechanisms),
            tuple("none" if m is None else m.mode for m in mechanisms),
            tuple(mechanisms),
            np.ones(len(factor), dtype=bool) if solved is None else solved,
            np.zeros(len(factor)) if error is None else error,
        )


class State(Protocol):
    """An engine made ready for one assembly under given standing loads; factors are shared by all queries."""

    def verdict(self) -> Verdict:
        """Whether the assembly stands under its weight and the standing loads."""
        ...

    def load_factor(self, W: Float, gap: float | None = None) -> Capacity:
        """For each column of W (6J, n), wrenches on the movable bodies: the largest factor before motion.

        ``gap`` allows an engine that gives bounds to stop at (upper - lower) / upper <= gap, and others to carry over
        answers between loads on one body with about that relative error.
        """
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


def no_capacity(count: int, verdict: Verdict) -> Capacity:
    """Factor 0 for every column: the assembly does not stand, or it is not known whether it does."""
    status = Status.UNSTABLE if verdict.status is Status.UNSTABLE else Status.UNDECIDED
    zero = np.zeros(count)
    upper = zero if status is Status.UNSTABLE else np.full(count, np.inf)
    return Capacity.told(zero, zero, upper, [status] * count, [verdict.mechanism] * count)
