"""Contact forces at rest: the quadratic program of eq. 8-11 with the exact friction cone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from holdfast.arrays import Float
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes, equilibrium_operator
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import ConeSolution, Outcome, solve
from holdfast.engines.cones import EXACT, FrictionCone

ACCEPTED_RESIDUAL = 1e-7  # of the total weight: forces with a larger equilibrium error are no answer


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """``forces`` (I, 3) local [N] or None; ``twists`` (J, 6) of the certificate or None.

    ``residual`` is the larger of equilibrium error and cone violation over the total weight, recomputed from G.
    ``dilatancy`` is the share of elastic energy that the friction law's associated flow puts in: 0 means the forces
    are also those of elastic contacts with plain Coulomb friction, so that no self-stress is needed.
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
    """G with torques in units of the assembly's size, so that all rows are of order one."""
    return sparse.csc_matrix(sparse.diags(row_scale(assembly)) @ G)


def scaled_wrench(assembly: Assembly, wrench: Float) -> Float:
    """(6J,) in units of the total weight and size."""
    return row_scale(assembly) * wrench / assembly.weight


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
        twists = (row_scale(assembly) * solution.z[: G.shape[0]]).reshape(-1, 6)
        return ForceSolution(solution.outcome, None, twists, np.inf, 0.0, solution.iterations)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return ForceSolution(solution.outcome, None, None, np.inf, 0.0, solution.iterations)
    forces = solution.x.reshape(-1, 3)
    return ForceSolution(
        solution.outcome,
        forces * assembly.weight,
        None,
        _residual(nodes, G, forces, program.b[: G.shape[0]]),
        _dilatancy(program, nodes, solution) if cone.kind == "exact" else np.inf,
        solution.iterations,
    )


def row_scale(assembly: Assembly) -> Float:
    """(6J,) 1 for forces, 1/size for torques."""
    return np.tile(np.repeat([1.0, 1 / assembly.size], 3), len(assembly.movable))


def _residual(nodes: ContactNodes, G: sparse.csc_matrix, forces: Float, balance: Float) -> float:
    equilibrium = np.abs(G @ forces.ravel() - balance).max(initial=0.0)
    excess = np.linalg.norm(forces[:, 1:], axis=1) - nodes.mu * forces[:, 0]
    return float(max(equilibrium, excess.max(initial=0.0), -forces[:, 0].min(initial=0.0)))


def _dilatancy(program: ConeProgram, nodes: ContactNodes, solution: ConeSolution) -> float:
    rough = np.flatnonzero(nodes.mu > 0)
    energy = float(solution.x @ (program.P @ solution.x))
    if not len(rough) or not energy > 0:
        return 0.0
    multiplier = solution.z[-3 * len(rough) :].reshape(-1, 3)[:, 0]
    normal = solution.x.reshape(-1, 3)[rough, 0]
    opening = np.maximum(nodes.mu[rough] * multiplier, 0)
    return float(np.maximum(normal, 0) @ opening) / energy
