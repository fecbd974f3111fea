"""Contact forces at rest: the quadratic program of eq. 8-11 with the exact friction cone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes, equilibrium_operator
from holdfast.base.arrays import Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import ConeSolution, Outcome, solve
from holdfast.engines.cones import EXACT, FrictionCone

ACCEPTED_RESIDUAL = 1e-7  # of each body's weight: forces with a larger equilibrium error are no answer
NO_FORCE = 1e-6  # of the lighter body's weight: nodes with less normal force are not pressed


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """``forces`` (I, 3) local [N] or None; ``twists`` (J, 6) of the certificate or None.

    ``residual`` is the largest equilibrium error over each body's own weight, or cone violation over the total one,
    recomputed from the program's data. ``dilatancy`` is the normal force that the friction law's associated flow puts
    in, over the lighter body's weight: 0 means that the forces are also those of elastic contacts with plain Coulomb
    friction, so that no self-stress is needed.
    """

    outcome: Outcome
    forces: Float | None
    twists: Float | None
    residual: float
    dilatancy: float
    iterations: int


def force_program(
    assembly: Assembly, nodes: ContactNodes, wrench: Float, cone: FrictionCone = EXACT
) -> tuple[ConeProgram, sparse.csc_matrix]:
    """Min ½ Σ |f_i|²/w_i  s.t.  G f + wrench = 0, friction, in units of the total weight and size.

    Rows: 6J equilibrium, then friction (``FrictionCone.rows``). Returns the program and the scaled G.
    """
    G = scaled_operator(assembly, equilibrium_operator(assembly, nodes))
    C, cones = cone.rows(nodes)
    b = np.zeros(G.shape[0] + C.shape[0])
    b[: G.shape[0]] = -scaled_wrench(assembly, wrench)
    share = nodes.weights / nodes.weights.mean() if len(nodes) else nodes.weights
    P = sparse.diags(np.repeat(1 / share, 3), format="csc")
    A = sparse.csc_matrix(sparse.vstack([G, C]))
    return ConeProgram(P, np.zeros(A.shape[1]), A, b, (("zero", G.shape[0]), *cones)), G


def scaled_operator(assembly: Assembly, G: sparse.csc_matrix) -> sparse.csc_matrix:
    """G with every body's rows in units of its own weight and size, so that all are of order one."""
    return sparse.csc_matrix(sparse.diags(assembly.equation_scale) @ G)


def scaled_wrench(assembly: Assembly, wrench: Float) -> Float:
    """(6J,) in the same units."""
    return assembly.equation_scale * wrench / assembly.weight


def solve_forces(
    assembly: Assembly,
    nodes: ContactNodes,
    wrench: Float,
    *,
    tolerance: float = 1e-10,
    cone: FrictionCone = EXACT,
) -> ForceSolution:
    """Forces that balance ``wrench`` (6J,), or the motion that proves there are none."""
    program, G = force_program(assembly, nodes, wrench, cone)
    solution = solve(program, tolerance=tolerance)
    if solution.outcome is Outcome.INFEASIBLE:
        twists = (assembly.equation_scale * solution.z[: G.shape[0]]).reshape(-1, 6)
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
    """(I,) mass of the lighter of a node's two bodies over the total: what counts as much force there."""
    mass = np.append(assembly.mass, np.inf)  # FIXED is -1
    return np.asarray(np.minimum(mass[nodes.a], mass[nodes.b]) / assembly.mass.sum())


def _dilatancy(assembly: Assembly, nodes: ContactNodes, solution: ConeSolution) -> float:
    """The largest normal force that slip alone puts into a pressed node, over the lighter body's weight."""
    rough = np.flatnonzero(nodes.mu > 0)
    if not len(rough):
        return 0.0
    share = (nodes.weights / nodes.weights.mean())[rough]
    light = lighter_share(assembly, nodes)[rough]
    opening = np.maximum(nodes.mu[rough] * solution.z[-3 * len(rough) :].reshape(-1, 3)[:, 0], 0)
    pressed = solution.x.reshape(-1, 3)[rough, 0] > NO_FORCE * light
    return float((share * opening / light)[pressed].max(initial=0.0))
