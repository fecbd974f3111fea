"""The collapse motion with the least momentum. It moves the bodies that really fall, and no others."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import Outcome, solve
from holdfast.engines.forces import scaled_operator, scaled_wrench

NEGLIGIBLE = 1e-6  # error of a motion; a body that is slower than that, relative to the fastest one, stands still


def least_motion(assembly: Assembly, nodes: ContactNodes, wrench: Float) -> Float | None:
    """Find the twists (J + F, 6) with the least total momentum of the bodies that no contact can resist.

    They are scaled so that the power of ``wrench`` (6J,) is 1, and solve

        min Σ_j m_j |q_j|  s.t.  u = Gᵀq in the dual cones (u_n >= μ |u_t|),  wrench · q = 1.

    Any feasible q proves that no equilibrium exists (Farkas' lemma). The certificate of the force program is feasible
    too, but it may move bodies that need not move. Whoever asks checks the motion, so one at which the solver got stuck
    will do. Returns None if there is none.
    """
    J, count = len(assembly.movable), len(wrench)
    gather = sparse.csr_matrix(scaled_operator(assembly, nodes).T)
    weight = np.ones((len(nodes), 3))
    weight[:, 1:] = nodes.mu[:, None]
    contacts = sparse.diags(weight.ravel()) @ gather
    power = sparse.csr_matrix(scaled_wrench(assembly, nodes, wrench)[None])
    rows, columns = np.arange(7 * J).reshape(J, 7), np.arange(6 * J).reshape(J, 6)
    motion = sparse.csr_matrix((-np.ones(6 * J), (rows[:, 1:].ravel(), columns.ravel())), shape=(7 * J, count))
    speed = sparse.csr_matrix((-np.ones(J), (rows[:, 0], np.arange(J))), shape=(7 * J, J))
    A = sparse.csc_matrix(
        sparse.hstack(
            [
                sparse.vstack([power, -contacts, motion]),
                sparse.vstack([sparse.csr_matrix((1 + contacts.shape[0], J)), speed]),
            ]
        )
    )
    b = np.zeros(A.shape[0])
    b[0] = 1.0
    q = np.concatenate([np.zeros(count), np.ones(J)])
    cones = (("zero", 1), *((("second_order", 3),) * len(nodes)), *((("second_order", 7),) * J))
    solution = solve(ConeProgram(sparse.csc_matrix((len(q), len(q))), q, A, b, cones), tolerance=1e-9)  # type: ignore[arg-type]
    none = solution.outcome in (Outcome.INFEASIBLE, Outcome.UNBOUNDED)
    if none or not solution.residual <= NEGLIGIBLE * np.abs(solution.x).max():
        return None
    scaled = solution.x[:count].reshape(-1, 6)
    size = np.linalg.norm(scaled[:J], axis=1)
    scaled[:J][size < NEGLIGIBLE * size.max(initial=0)] = 0.0
    return np.asarray((nodes.scaled(assembly.equation_scale) * scaled.ravel()).reshape(-1, 6))
