"""Which contacts can carry self-stress, that is forces that balance each other without any load.

The forces on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie on
one side of a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others one-sided: a
stack of boxes is peeled from its corners, in a hundredth of the time that a program takes. What is left may be clamped.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.engines.forces import EXACT, FrictionCone, scaled_operator
from holdfast.engines.rest import corner_nodes
from holdfast.native import core


def clampable(nodes: ContactNodes, corner: float = 1.0) -> Bool:
    """Return which nodes (I,) are left; the others press only if there is a load.

    Forces may lie outside the friction cone by the factor ``corner`` (``FrictionCone.corner``).
    """
    left = np.ones(len(nodes), dtype=bool)
    body, other = np.concatenate([nodes.b, nodes.a]), np.concatenate([nodes.a, nodes.b])
    inward, mu = np.concatenate([nodes.normals, -nodes.normals]), np.tile(corner * nodes.mu, 2)
    order = np.argsort(body, kind="stable")
    order = order[body[order] >= 0]
    first = np.searchsorted(body[order], np.arange(body.max(initial=-1) + 2))
    core.peel(inward[order], mu[order], order % max(len(nodes), 1), other[order], first, left)
    return left


def self_stressed(assembly: Assembly) -> bool | None:
    """Tell whether contacts of an assembly can press each other without any load; None if that is not settled."""
    pressed = self_stressed_nodes(assembly, corner_nodes(assembly).contacts, EXACT)
    return None if pressed is None else bool(pressed.any())


def self_stressed_nodes(assembly: Assembly, nodes: ContactNodes, cone: FrictionCone) -> Bool | None:
    """Return which nodes (I,) can press without any load (G f = 0, f in the cones), or None if not settled.

    Of nodes that cannot be ruled out body by body the program is max Σ t_i with 0 <= t_i <= f_n,i and
    t_i <= 1. Self-stress forces can be added and scaled, so each t_i is 0 or 1 at the optimum.
    """
    found = clampable(nodes, cone.corner)
    if found.any():
        pressing = _pressing(assembly, nodes.chosen(found), cone)
        if pressing is None:
            return None
        found[found] = pressing
    return found


def _pressing(assembly: Assembly, nodes: ContactNodes, cone: FrictionCone) -> Bool | None:
    """Which nodes (I,) press where as many as can do: the optimum of the program, or None if it is not settled."""
    G = scaled_operator(assembly, nodes)
    C, cones = cone.rows(nodes)
    count = len(nodes)
    normal = sparse.csr_matrix((-np.ones(count), (np.arange(count), 3 * np.arange(count))), (count, 3 * count))
    forces = sparse.vstack([G, C, normal, sparse.csr_matrix((2 * count, 3 * count))])
    eye = sparse.eye(count)
    shares = sparse.vstack([sparse.csr_matrix((G.shape[0] + C.shape[0], count)), eye, eye, -eye])
    A = sparse.csc_matrix(sparse.hstack([forces, shares]))
    b = np.concatenate([np.zeros(G.shape[0] + C.shape[0] + count), np.ones(count), np.zeros(count)])
    q = np.concatenate([np.zeros(3 * count), -np.ones(count)])
    P = sparse.csc_matrix((4 * count, 4 * count))
    program = ConeProgram(P, q, A, b, (("zero", G.shape[0]), *cones, ("nonnegative", 3 * count)))
    solution = solve(program, tolerance=1e-8)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED) or solution.residual > 1e-6:
        return None
    return np.asarray(solution.x[3 * count :] > 0.5)
