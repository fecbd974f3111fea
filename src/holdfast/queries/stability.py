"""Does it stand, and why."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived, to_dict
from holdfast.base.public import PublicValue, Summary
from holdfast.engines.answers import Claim
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import Certificate, ContactForces, Status, Verdict
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load, checked_assembly, engine_of, total_wrench
from holdfast.scene.scene import Scene


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Stability(PublicValue):
    """The verdict on an assembly at rest.

    ``status`` STABLE, UNSTABLE or UNDECIDED, with ``reason`` in words. ``equilibrium_exists`` True or False with
    evidence, None if unknown. ``self_stress`` False where the forces need none, None where that was not settled.
    ``forces`` the contact forces where it stands; ``residual`` their equilibrium error over the total weight.
    ``moving``, ``mechanism`` and ``certificate`` tell, where it does not stand, which bodies move, how, and why no
    contact can prevent it. ``notes`` are simplifications the answer rests on. All of these but ``notes`` are those of
    ``verdict``.
    """

    engine: str
    claim: Claim
    verdict: Verdict
    notes: tuple[str, ...]

    @property
    def status(self) -> Status:
        """STABLE, UNSTABLE or UNDECIDED."""
        return self.verdict.status

    @property
    def reason(self) -> str:
        """Why, in words."""
        return self.verdict.reason

    @property
    def equilibrium_exists(self) -> bool | None:
        """True or False with evidence, None if unknown."""
        return self.verdict.equilibrium_exists

    @property
    def self_stress(self) -> bool | None:
        """False where the forces need none, None where that was not settled."""
        return self.verdict.self_stress

    @property
    def forces(self) -> ContactForces | None:
        """The contact forces where it stands."""
        return self.verdict.forces

    @property
    def residual(self) -> float:
        """Equilibrium error of the forces over the total weight."""
        return self.verdict.residual

    @property
    def moving(self) -> tuple[str, ...]:
        """Names of the bodies that move where it does not stand."""
        return () if self.verdict.mechanism is None else self.verdict.mechanism.moving

    @property
    def mechanism(self) -> Mechanism | None:
        """How they begin to move."""
        return self.verdict.mechanism

    @property
    def certificate(self) -> Certificate | None:
        """Why no contact can prevent it."""
        return self.verdict.certificate

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        names = ("engine", "claim", "status", "equilibrium_exists", "self_stress", "forces", "residual", "moving")
        return {name: to_dict(getattr(self, name)) for name in (*names, "mechanism", "certificate", "reason", "notes")}

    def summary(self) -> Summary:
        """The verdict and its reason."""
        facts = [("engine", f"{self.engine} ({self.claim})"), ("reason", self.reason)]
        if self.mechanism is not None:
            facts.append(("moving", ", ".join(self.moving)))
        return Summary(f"{self.status}: {self.reason}", facts, notes=self.notes)


def stability(
    assembly: Assembly | Scene, *, loads: Iterable[Load] = (), engine: EngineChoice = DEFAULT_ENGINE
) -> Stability:
    """Whether the assembly stands under its weight and ``loads``; ``engine`` is a name or an instance."""
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    state = method.prepare(assembly, total_wrench(assembly, loads))
    return Stability(engine=method.name, claim=method.claim, verdict=state.verdict(), notes=state.notes)
