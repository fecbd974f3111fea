"""Proof that a body comes loose once its weight is supported: no contact can clamp it or drag it down."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import contact_nodes, equilibrium_operator
from holdfast.base.arrays import Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import Outcome, solve
from holdfast.engines.cones import EXACT


def comes_loose(assembly: Assembly, name: str, up: Float) -> bool:
    """Return True if it is proved that no contact holds the body ``name`` once its weight is supported.

    Suppose that the weight is supported and that an additional force c >= 0 acts along ``up`` (3,) at the centre of
    mass. The contacts of the body then have to balance this force alone. The function returns True if

        G_b f + c (up, 0) = 0,   f in the friction cones,   Σ f_n = 1,   c >= 0

    has no solution. All contact forces on the body are then zero from that moment on, whatever the other bodies do, and
    the body takes none of them along. The nodes are the corners of the patches, which can carry every load that the
    whole patches can carry. A body without contacts is loose.
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
