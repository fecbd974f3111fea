"""Proof that an equilibrium exists where the program for the forces at rest was not solved well enough to tell."""

from __future__ import annotations

from dataclasses import replace

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.cones import FrictionCone
from holdfast.engines.limit.carrying_proof import Carried
from holdfast.engines.limit.interior import interior_forces
from holdfast.engines.limit.rounding import Equilibrium
from holdfast.engines.limit.scales import usual_forces
from holdfast.engines.rest import Rest, contact_forces
from holdfast.engines.verdict import Status, Verdict

ROUNDS = 3  # of forces at rest, each in units of the forces of the round before


def proved_rest(assembly: Assembly, rest: Rest, wrench: Float, cone: FrictionCone) -> Rest:
    """Return ``rest`` with contact forces that are proved to balance ``wrench`` (6J,), if it has none but some exist.

    Bodies that bear a million times their own weight defeat units of force that fit the weights.
    """
    if rest.verdict.status is not Status.UNDECIDED or assembly.hanging or not len(rest.nodes):
        return rest
    equilibrium = Equilibrium.of(assembly, rest.nodes)
    doubtful = rest
    for _ in range(ROUNDS):
        tau = usual_forces(assembly, doubtful)
        carried = Carried(equilibrium, cone, rest.nodes.mu, wrench, doubtful.forces.ravel(), tau)
        if carried.reference is not None:
            forces = carried.reference.forces.reshape(-1, 3)
            verdict = Verdict(
                status=Status.STABLE,
                reason="contact forces balance every body",
                equilibrium_exists=True,
                forces=contact_forces(assembly, rest.nodes, forces),
                residual=0.0,
            )
            return Rest(rest.nodes, forces, verdict)
        guess = interior_forces(equilibrium, wrench, rest.nodes.mu, tau)[0]
        doubtful = replace(doubtful, forces=guess.reshape(-1, 3))
    return rest
