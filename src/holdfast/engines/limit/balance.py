"""Forces near given ones that balance exactly: a right inverse of G with a proved bound.

With node scales T and row scales S, A = S G T and R about Aᵀ (A Aᵀ)⁻¹, the forces δ = -T R (A R)⁻¹ S r take away an
imbalance r exactly. They cannot be computed exactly, but they are bounded. If all entries of I - A R are proved to be
less than E, with α the largest row sum of E and α < 1, then |(A R)⁻¹ v| <= |v| + α / (1 - α) max |v| component by
component, and with |R| follows what happens at every node.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import cho_solve

from holdfast.base.arrays import Bool, Float
from holdfast.engines.limit.rounding import UP, Equilibrium, Matrix, gamma
from holdfast.engines.limit.scales import Scales

STEPS = 3  # of refinement at most: the second takes away what rounding left of the first
ENOUGH = 8  # an imbalance that is this many times as large as what rounding leaves is taken away once more


@dataclass(frozen=True, eq=False)
class Balance:
    """A right inverse of G on the nodes that may press.

    ``scale`` (3I,) is T [N] and 0 for the force components that have to be 0, the ``silent`` ones. ``rows`` (6J,) says
    which equations the others enter, and ``share`` (6J,) is S, 0 for the other equations. ``inverse`` (3I, 6J) [N] is
    T R, and ``reach`` (I, 6J) [N] bounds the change of a node's room in its cone (``FrictionCone.room``) for every unit
    of each component of S r, if α, ``spill``, is allowed for.
    """

    equilibrium: Equilibrium
    scale: Float
    silent: Bool
    rows: Bool
    share: Float
    inverse: Float
    reach: Float
    spill: float

    @classmethod
    def of(cls, equilibrium: Equilibrium, mu: Float, tau: Float) -> Balance | None:
        """Return the right inverse for nodes with usual normal forces ``tau`` (I,) [N], 0 for nodes without force.

        Returns None if the forces cannot balance every wrench on the bodies that they act on, or if that is not proved.
        """
        scales = Scales.of(equilibrium, mu, tau)
        scale, share = scales.force, scales.motion
        rows = share > 0
        if not rows.any():
            return None
        G, unknown = (_scaled(m, share, scale)[rows] for m in (equilibrium.G, equilibrium.unknown))
        square = G @ G.T
        try:
            factor = np.linalg.cholesky(square if isinstance(square, np.ndarray) else square.toarray())
        except np.linalg.LinAlgError:
            return None
        one = np.eye(len(factor))
        R = np.asarray(G.T @ cho_solve((factor, True), one, check_finite=False))
        length = np.abs(R)
        absolute: Any = abs(G)
        size = np.asarray((gamma(G.shape[1]) * absolute + unknown) @ length) * UP
        error = np.abs(one - np.asarray(G @ R)) + size + gamma(1)
        worst = float(error.sum(1).max()) * UP
        if not worst < 1:
            return None
        inverse, size = np.zeros((len(scale), len(rows))), np.zeros((len(tau), len(rows)))
        inverse[:, rows] = scale[:, None] * R * share[rows]
        # f_n and f_t / μ change by what R says in units of tau, and the length of f_t by no more than the sum
        size[:, rows] = tau[:, None] * length.reshape(len(tau), 3, -1).sum(1) * UP
        return cls(equilibrium, scale, scale == 0, rows, share, inverse, size, worst / (1 - worst) * UP)

    def balanced(self, forces: Float, wrench: Float, loads: Float, factors: Float) -> tuple[Float, Float]:
        """Return forces (3I, k) near these that almost balance w + s w_e, and bounds (I, k) [N] for what is left.

        The bounds are of the change of room that balances exactly. They are infinite where a wrench acts along an
        equation that no force enters.
        """
        if self.silent.any():
            forces = np.where(self.silent[:, None], 0.0, forces)
        left, error = self.equilibrium.imbalance(forces, wrench, loads, factors)
        for _ in range(STEPS):
            forces = forces - self.inverse @ left
            left, error = self.equilibrium.imbalance(forces, wrench, loads, factors)
            off = np.abs(left)
            if not (off > ENOUGH * error).any():
                break
        scaled = self.share[:, None] * (off + error) * UP
        change = self.reach @ (scaled + self.spill * scaled.max(0, initial=0.0)) * (1 + gamma(len(scaled)))
        if self.rows.all():
            return forces, change
        unheld = (wrench[~self.rows] != 0).any() | ((loads[~self.rows] != 0).any(0) & (factors != 0))
        return forces, np.where(unheld, np.inf, change)

    def slope(self, room: Float) -> Float:
        """Return (6J,): a wrench w is balanced within ``room`` (I,) [N] of all nodes if the sum of slope |w| <= 1."""
        pressing = (self.reach > 0).any(1)
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = (self.reach[pressing] / np.maximum(room[pressing], 0.0)[:, None]).max(0, initial=0.0)
            spilled = self.spill * float((self.reach[pressing].sum(1) / np.maximum(room[pressing], 0.0)).max(initial=0))
            return np.where(self.rows, (needed + spilled) * self.share * UP, np.inf)


def _scaled(matrix: Matrix, share: Float, scale: Float) -> Matrix:
    if isinstance(matrix, np.ndarray):
        return np.asarray(share[:, None] * matrix * scale)
    return sparse.csr_matrix(sparse.diags(share) @ matrix @ sparse.diags(scale))
