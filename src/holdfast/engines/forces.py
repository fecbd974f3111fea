"""Contact forces at rest from the quadratic program of eq. 8-11, with the exact friction cone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import (
    ContactNodes,
    entries_by_bodies,
    equilibrium_blocks,
    equilibrium_operator,
)
from holdfast.base.arrays import Float
from holdfast.base.entries import diagonal, together
from holdfast.conic.solve import ConeProgram, ConeSolution, Outcome, solve
from holdfast.engines.cones import EXACT, FrictionCone, size_of

ACCEPTED_RESIDUAL = 1e-7  # largest equilibrium error of accepted forces, relative to each body's own weight
NO_FORCE = 1e-6  # normal force below which a node counts as unloaded, relative to the weight of its lighter body


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """The outcome of the force program: contact forces, or the motion that proves that there are none.

    ``forces`` (I, 3) [N] are along the local axes (normal, t1, t2) of each node, or None. ``twists`` (J, 6) are those
    of the certificate of infeasibility, or None. ``residual`` is recomputed from the program's data: it is the larger
    of the equilibrium error, relative to each body's own weight, and the cone violation, relative to the total weight.

    ``dilatancy`` is the largest normal force that the associated flow of the program's friction law adds at a node,
    relative to the weight of the node's lighter body. If it is 0, the forces are also those of elastic contacts with
    plain Coulomb friction, so no self-stress is needed.
    """

    outcome: Outcome
    forces: Float | None
    twists: Float | None
    residual: float
    dilatancy: float
    iterations: int


def force_program(assembly: Assembly, nodes: ContactNodes, wrench: Float, cone: FrictionCone = EXACT) -> ConeProgram:
    """Set up min ½ Σ |f_i|²/w_i  s.t.  G f + wrench = 0, f in the friction cones (eq. 8-11).

    Forces are in units of the total weight, and each body's equilibrium in units of its own weight and size. The first
    6J rows are the equilibrium, the others the friction cones (``FrictionCone.rows``). ``wrench`` (6J,) is in [N, N m].
    """
    count, (friction, cones) = len(wrench), cone.entries(nodes)
    scale = nodes.scaled(assembly.equation_scale)
    balance = entries_by_bodies(nodes, equilibrium_blocks(assembly, nodes)).scaled(scale).stored
    b = np.zeros(count + size_of(cones))
    b[:count] = -scaled_wrench(assembly, nodes, wrench)
    share = nodes.weights / nodes.weights.mean() if len(nodes) else nodes.weights
    A = together(balance, friction.stored.below(count)).matrix((len(b), 3 * len(nodes)))
    P = diagonal(np.repeat(1 / share, 3))
    return ConeProgram(P, np.zeros(A.shape[1]), A, b, (("zero", count), *cones))


def scaled_operator(assembly: Assembly, nodes: ContactNodes) -> sparse.csc_matrix:
    """Return G with the rows of every body in units of its own weight and size, so that all are of order one."""
    scaled = equilibrium_operator(assembly, nodes)
    scaled.data *= nodes.scaled(assembly.equation_scale)[scaled.indices]
    scaled.eliminate_zeros()
    return scaled


def scaled_wrench(assembly: Assembly, nodes: ContactNodes, wrench: Float) -> Float:
    """Return ``wrench`` (6J,) in the units that ``scaled_operator`` gives to forces in units of the total weight."""
    return nodes.scaled(assembly.equation_scale) * wrench / assembly.weight


def solve_forces(
    assembly: Assembly,
    nodes: ContactNodes,
    wrench: Float,
    *,
    tolerance: float = 1e-10,
    cone: FrictionCone = EXACT,
) -> ForceSolution:
    """Find contact forces that balance ``wrench`` (6J,) [N, N m], or a motion that proves that there are none."""
    program = force_program(assembly, nodes, wrench, cone)
    solution = solve(program, tolerance=tolerance)
    if solution.outcome is Outcome.INFEASIBLE:
        twists = (nodes.scaled(assembly.equation_scale) * solution.z[: len(wrench)]).reshape(-1, 6)
        return ForceSolution(solution.outcome, None, twists, np.inf, 0.0, solution.iterations)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return ForceSolution(solution.outcome, None, None, np.inf, 0.0, solution.iterations)
    forces = solution.x.reshape(-1, 3)
    return ForceSolution(
        solution.outcome,
        forces * assembly.weight,
        None,
        solution.residual,
        _dilatancy(assembly, nodes, solution) if cone.kind == "exact" else np.inf,
        solution.iterations,
    )


def lighter_share(assembly: Assembly, nodes: ContactNodes) -> Float:
    """Return (I,) the mass of the lighter body of each node over the total mass: the scale of forces at that node."""
    mass = np.append(assembly.mass, np.full(1 + nodes.fasteners, np.inf))  # FIXED is -1
    return np.asarray(np.minimum(mass[nodes.a], mass[nodes.b]) / assembly.mass.sum())


def _dilatancy(assembly: Assembly, nodes: ContactNodes, solution: ConeSolution) -> float:
    """Return the largest normal force that slip adds at a loaded contact, relative to its lighter body's weight."""
    rough = np.flatnonzero(nodes.mu > 0)
    if not len(rough):
        return 0.0
    share = (nodes.weights / nodes.weights.mean())[rough]
    light = lighter_share(assembly, nodes)[rough]
    opening = np.maximum(np.minimum(nodes.mu[rough], 1.0) * solution.z[-3 * len(rough) :].reshape(-1, 3)[:, 0], 0)
    pressed = (solution.x.reshape(-1, 3)[rough, 0] > NO_FORCE * light) & (rough < len(nodes.contacts))
    return float((share * opening / light)[pressed].max(initial=0.0))
