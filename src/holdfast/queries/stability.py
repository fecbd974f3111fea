"""Does it stand, and why."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from holdfast.assembly.assembly import Assembly
from holdfast.engines.contract import Certificate, Claim, ContactForces, Mechanism, Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load, checked_assembly, engine_of, total_wrench
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Stability:
    """The verdict on an assembly at rest.

    ``status`` STABLE, UNSTABLE or UNDECIDED, with ``reason`` in words. ``equilibrium_exists`` True or False with
    evidence, None if unknown. ``self_stress`` False where the forces need none, None where that was not settled.
    ``forces`` the contact forces where it stands; ``residual`` their equilibrium error over the total weight.
    ``moving``, ``mechanism`` and ``certificate`` tell, where it does not stand, which bodies move, how, and why no
    contact can prevent it. ``notes`` are simplifications the answer rests on.
    """

    engine: str
    claim: Claim
    status: Status
    equilibrium_exists: bool | None
    self_stress: bool | None
    forces: ContactForces | None
    residual: float
    moving: tuple[str, ...]
    mechanism: Mechanism | None
    certificate: Certificate | None
    reason: str
    notes: tuple[str, ...]


def stability(
    assembly: Assembly | Scene, *, loads: Iterable[Load] = (), engine: EngineChoice = DEFAULT_ENGINE
) -> Stability:
    """Whether the assembly stands under its weight and ``loads``; ``engine`` is a name or an instance."""
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    state = method.prepare(assembly, total_wrench(assembly, loads))
    verdict = state.verdict()
    return Stability(
        method.name,
        method.claim,
        verdict.status,
        verdict.equilibrium_exists,
        verdict.self_stress,
        verdict.forces,
        verdict.residual,
        () if verdict.mechanism is None else verdict.mechanism.moving,
        verdict.mechanism,
        verdict.certificate,
        verdict.reason,
        state.notes,
    )
