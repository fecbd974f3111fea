"""Verdicts: whether an assembly stands, why, and which forces its contacts carry."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum, auto
from typing import Any

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import no_truth
from holdfast.base.public import Of, Record, column
from holdfast.engines.mechanism import Mechanism


@archived
class Status(StrEnum):
    """The kind of an answer.

    A verdict is STABLE, UNSTABLE or UNDECIDED. A query is FINITE, INFINITE, UNSTABLE or UNDECIDED.
    """

    STABLE = auto()
    UNSTABLE = auto()
    UNDECIDED = auto()
    FINITE = auto()
    INFINITE = auto()

    def __bool__(self) -> bool:
        raise no_truth(self, f"compare it: status is hf.Status.{self.name}")


class ContactForces(Record):
    """The contact forces at the I contact nodes of an assembly at rest. All vectors are in the world frame.

    ``points`` (I, 3) [m] are the nodes, and ``interface`` (I,) the number of the interface that each lies on. ``force``
    (I, 3) [N] acts on the second body of the interface, and its negative on the first. ``normal`` (I, 3) is the unit
    normal that points into the second body. ``usage`` (I,) is |f_t| / (μ f_n), the share of the friction limit in use;
    it is 0 at nodes without force.
    """

    points: Float = column("I 3")
    normal: Float = column("I 3")
    force: Float = column("I 3")
    interface: Int = column("I")
    usage: Float = column("I")


class Certificate(Record):
    """Proof that no equilibrium exists (Farkas' lemma): a motion that gains power and that no contact can resist.

    The motion is that of the verdict's mechanism. ``power`` [W] is the power of the loads along it, at the scale of the
    mechanism. At every corner of every patch the relative velocity lies in the dual of the friction cone,
    u_n >= μ |u_t|, except for ``violation``, which is relative to the fastest point of the motion.
    """

    power: float
    violation: float


class Look(Record):
    """One step towards a verdict: ``at`` says what was looked at, and ``found`` what came of it, both in words."""

    at: str
    found: str


class _WhenRead:
    """A field of a Verdict that ``with_evidence`` leaves out, to be worked out by a function when it is first read."""

    def __init__(self, default: object) -> None:
        self._default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, value: object | None, owner: type | None = None) -> Any:  # noqa: ANN401 - of any field
        if value is None:
            return self._default
        content = value.__dict__[self._name] = value.__dict__[f"_{self._name}"]()
        return content


class Verdict(Record, kw_only=True, ask=".stable or .status"):
    """The answer to whether an assembly stands, with the evidence for it.

    - ``status``: STABLE, UNSTABLE or UNDECIDED, explained by ``reason`` in words.
    - ``equilibrium_exists``: True or False if there is evidence, None if it is not known.
    - ``self_stress``: whether contacts can press each other without any load, so that engine ``limit`` may count on
      squeezing that nothing causes; None if that was not settled. If it does not stand, True says that an equilibrium
      exists which needs it.
    - ``forces``: the contact forces if the assembly stands. ``residual`` is their equilibrium error, relative to the
      total weight.
    - ``mechanism``: how bodies move if the assembly does not stand. ``certificate`` proves that no contact can
      prevent it.
    - ``balanced``: the names of bodies that are only balanced if it stands: the slightest push moves them.
    - ``steps``: what was looked at, in that order; the last step decided.
    """

    status: Status
    reason: str
    equilibrium_exists: bool | None = None
    self_stress: bool | None = _WhenRead(None)  # type: ignore[assignment]
    forces: ContactForces | None = _WhenRead(None)  # type: ignore[assignment]
    residual: float = _WhenRead(np.inf)  # type: ignore[assignment]
    mechanism: Mechanism | None = None
    certificate: Certificate | None = None
    balanced: tuple[str, ...] = ()
    steps: tuple[Look, ...] = ()

    def __post_init__(self) -> None:
        """Seal nothing, which would work out evidence that nobody asked for."""

    @property
    def stable(self) -> bool:
        """Whether it certainly stands: False also where that is undecided."""
        return self.status is Status.STABLE

    def after(self, at: str, found: str = "", *, before: Verdict | None = None) -> Verdict:
        """Return this verdict with one more step, what was ``found`` by looking ``at`` something: its reason, if none.

        The steps of the verdict ``before``, whose place it takes, come first.
        """
        earlier = self.steps if before is None else before.steps
        return self._with(steps=(*earlier, Look(at, found or self.reason)))

    def with_evidence(
        self,
        forces: Callable[[], ContactForces | None],
        residual: Callable[[], float],
        self_stress: Callable[[], bool | None],
    ) -> Verdict:
        """Return this verdict with three fields that are worked out when they are first read."""
        other = self._with(_forces=forces, _residual=residual, _self_stress=self_stress)
        for name in ("forces", "residual", "self_stress"):
            other.__dict__.pop(name, None)
        return other

    def _with(self, **content: object) -> Verdict:
        """Return this verdict with other contents; evidence that was not read is not worked out."""
        other = object.__new__(Verdict)
        other.__dict__.update(self.__dict__, **content)
        return other

    @property
    def explained(self) -> str:
        """What was looked at, a line a step, and what follows."""
        lines = [f"- {step.at}: {step.found}" for step in self.steps]
        return "\n".join([*lines, f"so it is {self.status}: {self.reason}"])


class GroupVerdict(Record, kw_only=True, ask=".verdict.stable"):
    """The verdict on one group of bodies, given by their names; contacts join the bodies of a group with each other."""

    bodies: tuple[str, ...]
    verdict: Verdict

    status = Of[Status]("verdict.status", "The status of the verdict.")
    reason = Of[str]("verdict.reason", "The reason for it, in words.")

    plain = "bodies status reason"
