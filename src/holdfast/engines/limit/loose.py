"""Whether a body comes loose for certain once its weight is taken: nothing can clamp it or drag it down."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import contact_nodes, equilibrium_operator
from holdfast.base.arrays import Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import Outcome, solve
from holdfast.engines.cones import EXACT


def comes_loose(assembly: Assembly, name: str, up: Float) -> bool:
    """True if no contact forces on the body, other than none, add up to zero or to a downward force through its centre.

    With its weight taken and an upward force c >= 0 besides, its contacts must balance that force alone:

        G_b f + c (up, 0) = 0,   f in the friction cones,   Σ f_n = 1

    has no solution: then all its contacts are empty from that moment on, whatever the other bodies do, and it takes
    none of them along. The corners of the patches carry whatever the whole patches can.
    """
    k = assembly.index[name]
    every = contact_nodes(assembly, 4, "corners")
    nodes = every.chosen((every.a == k) | (every.b == k))
    if not len(nodes):
        return True
    size = assembly.scene.body(name).size
    G = sparse.csr_matrix(equilibrium_operator(assembly, nodes))[6 * k : 6 * k + 6]
    G = sparse.diags(np.repeat([1.0, 1 / size], 3)) @ G
    C, cones = EXACT.rows(nodes)
    count = 3 * len(nodes)
    pressing = np.zeros((1, count))
    pressing[0, ::3] = 1.0
    lift = np.concatenate([up, np.zeros(4 + C.shape[0])])
    A = sparse.hstack([sparse.vstack([G, sparse.csr_matrix(pressing), C]), sparse.csr_matrix(lift[:, None])])
    A = sparse.csc_matrix(sparse.vstack([A, sparse.csr_matrix(([-1.0], ([0], [count])), shape=(1, count + 1))]))
    b = np.zeros(A.shape[0])
    b[6] = 1.0
    program = ConeProgram(
        sparse.csc_matrix((count + 1, count + 1)),
        np.zeros(count + 1),
        A,
        b,
        (("zero", 7), *cones, ("nonnegative", 1)),
    )
    return solve(program, tolerance=1e-9).outcome is Outcome.INFEASIBLE
