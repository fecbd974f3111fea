"""Whether an assembly stands, why, and which forces its contacts carry."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum, auto

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int
from holdfast.base.values import Value, seal
from holdfast.engines.mechanism import Mechanism


@archived
class Status(StrEnum):
    """The kind of an answer: of a verdict (the first three) or of one query (the last four)."""

    STABLE = auto()
    UNSTABLE = auto()
    UNDECIDED = auto()
    FINITE = auto()
    INFINITE = auto()


@archived
@dataclass(frozen=True, eq=False, repr=False)
class ContactForces(Value):
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

    def __post_init__(self) -> None:
        seal(self)


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Certificate(Value):
    """Proof that no equilibrium exists (Farkas): a motion of the mechanism that gains ``power`` [W at its scale].

    Along it no contact can resist: the relative velocity at every corner of every patch lies in the dual of the
    friction cone, u_n >= μ |u_t|, up to ``violation`` (relative to the fastest point of the motion).
    """

    power: float
    violation: float


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Verdict(Value):
    """Whether the assembly stands, and why.

    ``status`` STABLE, UNSTABLE or UNDECIDED, with ``reason`` in words. ``equilibrium_exists`` True or False with
    evidence, None if unknown. ``self_stress`` False where the forces need none, None where that was not settled.
    ``forces`` the contact forces where it stands; ``residual`` their equilibrium error over the total weight.
    ``mechanism`` and ``certificate`` tell, where it does not stand, how bodies move and why no contact can prevent it.
    """

    status: Status
    reason: str
    equilibrium_exists: bool | None = None
    self_stress: bool | None = None
    forces: ContactForces | None = None
    residual: float = np.inf
    mechanism: Mechanism | None = None
    certificate: Certificate | None = None
