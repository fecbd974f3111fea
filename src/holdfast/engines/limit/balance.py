"""Forces near given ones that balance exactly: corrections of least size, with a proved bound.

With node scales T and row scales S, A = S G T, the forces δ = -T Aᵀ (A Aᵀ)⁻¹ S r take away an imbalance r exactly. They
cannot be computed exactly, but they are bounded: |T⁻¹ δ| <= |S r| / σ where σ is at most the smallest singular value of
A. That σ² is not too large is proved by elimination: if Cholesky's method, in floating point, runs to its end for a
symmetric matrix Q, no eigenvalue of Q is below -γ(n + 1) times the sum of its diagonal, n being its size (Rump,
Verification of Positive Definiteness, 2006, theorem 2.3). Q is A Aᵀ less σ² on the diagonal, up to rounding.

A ball on a table resists no force that rolls it: its equations are not independent, and σ is 0. The equations of such
bodies are combined into those that contacts resist and others, which no force enters but by rounding. The latter are
asked to hold to within BALANCED, and all else is proved as if they held exactly: such bodies are only balanced.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dpotrf, dpotrs  # scipy's own functions take ten times as long to call

from holdfast.base.arrays import Bool, Float, Int
from holdfast.engines.limit.rounding import DOWN, UP, Equilibrium, Matrix, Scales, gamma

STEPS = 3  # largest number of refinement steps: the second takes away what rounding left after the first
ENOUGH = 8  # an imbalance that is this many times as large as what rounding leaves is taken away once more
GUESSES = 4  # steps of inverse iteration for the smallest eigenvalue, which is found from above
SHARES = (0.5, 0.02)  # shares of that guess for which a proof is tried
FREE = 1e-14  # square of a resistance that counts as none, where those of contacts are of order one
BALANCED = 1e-9  # imbalance, in usual forces, of a body along what no contact of it resists
TANGENTIAL = float(np.sqrt(2)) * UP  # f_n and f_t / μ change together by no more than this times |T⁻¹ δ| of a node


@dataclass(frozen=True, eq=False)
class Combined:
    """Combinations of n equations: those that contacts resist, ``resisted`` (p, n), and others, ``free`` (n - p, n)."""

    resisted: sparse.csr_matrix
    free: sparse.csr_matrix

    @classmethod
    def of(cls, square: Float, body: Int) -> Combined | None:
        """Combine equations, each of one ``body`` (n,), with A Aᵀ = ``square`` (n, n); None if all are resisted."""
        turn, idle = np.eye(len(body)), np.zeros(len(body), dtype=bool)
        for one in np.unique(body):
            at = np.flatnonzero(body == one)
            values, vectors = np.linalg.eigh(square[np.ix_(at, at)])
            if (values <= FREE).any():
                turn[np.ix_(at, at)] = vectors.T
                idle[at] = values <= FREE
        return cls(sparse.csr_matrix(turn[~idle]), sparse.csr_matrix(turn[idle])) if idle.any() else None


@dataclass(frozen=True, eq=False)
class Balance:
    """Corrections of forces at the nodes that may press.

    ``scale`` (3I,) is T [N] and 0 for the force components that have to be 0, the ``silent`` ones. ``rows`` (6J,) says
    which equations the others enter, and ``share`` (6J,) is S, 0 for the other equations. Where bodies are only
    balanced, ``combined`` is how these equations are combined. ``scaled`` (n, 3I) is A in what remains of them,
    ``factor`` (n, n) the lower triangle of A Aᵀ by Cholesky's method, and ``least`` is σ.
    """

    equilibrium: Equilibrium
    tau: Float
    scale: Float
    silent: Bool
    rows: Bool
    share: Float
    combined: Combined | None
    scaled: Matrix
    factor: Float
    least: float

    @classmethod
    def of(cls, equilibrium: Equilibrium, mu: Float, tau: Float) -> Balance | None:
        """Return the corrections for nodes with usual normal forces ``tau`` (I,) [N], 0 for nodes without force.

        Returns None if the forces cannot balance every wrench on the bodies that they act on, or if that is not proved.
        """
        scales = Scales.of(equilibrium, mu, tau)
        scale, share = scales.force, scales.motion
        rows = share > 0
        if not rows.any():
            return None
        A, unknown = (_scaled(m, share, scale)[rows] for m in (equilibrium.G, equilibrium.unknown))
        square, combined = _square(A), None
        found = _proved(A, unknown, square)
        if found is None:
            combined = Combined.of(square, np.flatnonzero(rows) // 6)
            if combined is None:
                return None
            sizes: Matrix = np.abs(A) if isinstance(A, np.ndarray) else sparse.csr_matrix(abs(A))
            unknown = abs(combined.resisted) @ (unknown + gamma(8) * sizes)
            A = combined.resisted @ A
            found = _proved(A, unknown, _square(A))
        return None if found is None else cls(equilibrium, tau, scale, scale == 0, rows, share, combined, A, *found)

    @property
    def loose(self) -> Bool:
        """Which bodies (J,) are only balanced: no contact of theirs resists some motion of them.

        Among holds, that counts even where no force enters an equation: two fingers let a body turn about their line.
        """
        free, asked = self._free, self.equilibrium.nodes.asked
        if asked is not None:
            free = free | ~self.rows
            free[: len(asked)] &= asked > 0
        return np.asarray(free.reshape(-1, 6).any(1))

    @property
    def _free(self) -> Bool:
        """Which equations (6J,) enter combinations that no contact resists."""
        found = np.zeros(len(self.share), dtype=bool)
        if self.combined is not None:
            found[np.flatnonzero(self.rows)[self.combined.free.getnnz(axis=0) > 0]] = True
        return found

    def forces_for(self, wrench: Float) -> Float:
        """Return forces (3I, k) [N], as small as can be in units of T, that about make up ``wrench`` (6J, k)."""
        asked = self.share[self.rows, None] * wrench[self.rows]
        if self.combined is not None:
            asked = self.combined.resisted @ asked
        found = _solved(self.factor, asked)
        return np.asarray(self.scale[:, None] * (self.scaled.T @ found))

    def motion_for(self, velocities: Float) -> Float:
        """Return the motion (6J,) that is closest to ``velocities`` (3I,) of the nodes, in units of T⁻¹."""
        motion, fitted = np.zeros(len(self.share)), np.asarray(self.scaled @ (self.scale * velocities))
        found = _solved(self.factor, fitted)
        motion[self.rows] = found if self.combined is None else self.combined.resisted.T @ found
        return self.share * motion

    def balanced(self, forces: Float, wrench: Float, loads: Float, factors: Float) -> tuple[Float, Float]:
        """Return forces (3I, k) near these that almost balance w + s w_e, and bounds (I, k) [N] for what is left.

        The bounds are of the change of room that balances exactly. They are infinite where a wrench acts along an
        equation that no force enters, or along what no contact of a body resists.
        """
        if self.silent.any():
            forces = np.where(self.silent[:, None], 0.0, forces)
        left, error = self.equilibrium.imbalance(forces, wrench, loads, factors)
        for _ in range(STEPS):
            forces = forces - self.forces_for(left)
            left, error = self.equilibrium.imbalance(forces, wrench, loads, factors)
            off = np.abs(left)
            if not (off > ENOUGH * error).any():
                break
        change = self.change(off + error)
        unheld = np.zeros(len(factors), dtype=bool)
        if not self.rows.all():
            unheld = (wrench[~self.rows] != 0).any() | ((loads[~self.rows] != 0).any(0) & (factors != 0))
        if self.combined is not None:
            share, free = self.share[self.rows, None], self.combined.free
            along = np.abs(free @ (share * left[self.rows])) + abs(free) @ (share * error[self.rows])
            unheld |= ~(along <= BALANCED).all(0)
        return forces, np.where(unheld, np.inf, change)

    @np.errstate(under="ignore")  # what vanishes is taken up by the error beside it
    def change(self, left: Float) -> Float:
        """Bound the room (I, k) [N] that nodes lose where imbalances of at most ``left`` (6J, k) are taken away."""
        scaled = self.share[:, None] * left * UP
        if self.combined is not None:
            scaled = abs(self.combined.resisted) @ scaled[self.rows] * (1 + gamma(8))
        length = np.sqrt((scaled * scaled).sum(0) * (1 + gamma(len(scaled)))) / self.least * UP
        return np.asarray(TANGENTIAL * self.tau[:, None] * length * UP)

    def slope(self, room: Float) -> Float:
        """Return (6J,): a wrench w is balanced within ``room`` (I,) [N] of all nodes if the sum of slope |w| <= 1."""
        pressing = self.tau > 0
        with np.errstate(divide="ignore"):
            tightest = float((self.tau[pressing] / np.maximum(room[pressing], 0.0)).max(initial=0.0))
        needed = TANGENTIAL * tightest / self.least * UP
        if self.combined is not None:
            needed *= float(abs(self.combined.resisted).sum(0).max()) * (1 + gamma(8))
        return np.where(self.rows & ~self._free, needed * self.share * UP, np.inf)


def _proved(A: Matrix, unknown: Matrix, square: Float) -> tuple[Float, float] | None:
    """Return the Cholesky factor of A Aᵀ and a proved lower bound of the singular values of A, if there is one.

    ``unknown`` and ``square`` are as in ``_least``.
    """
    factor = _factor(square)
    least = None if factor is None else _least(A, unknown, square, factor)
    return None if factor is None or least is None else (factor, least)


def _square(A: Matrix) -> Float:
    """Return A Aᵀ, dense."""
    product = A @ A.T
    return np.asarray(product if isinstance(product, np.ndarray) else product.toarray())


def _least(A: Matrix, unknown: Matrix, square: Float, factor: Float) -> float | None:
    """Return a proved lower bound, above 0, of the singular values of the exact A, if there is one.

    Its computed entries ``A`` (n, m) may be off by ``unknown`` (n, m), and the computed ``square`` (n, n) by rounding.
    """
    count = len(square)
    guess = np.cos(np.arange(count))  # along no axis, and the same each time
    for _ in range(GUESSES):
        guess = _solved(factor, guess / np.linalg.norm(guess))
    lowest = 1 / float(np.linalg.norm(guess))
    terms = int(np.diff(A.indptr).max()) if sparse.issparse(A) else A.shape[1]
    sizes, blur = (_squares(m) * (1 + gamma(count * A.shape[1])) for m in (A, unknown))
    blurred = (float(np.sqrt(blur)) + gamma(2) * float(np.sqrt(sizes))) * UP
    lost = (gamma(count + 1) * 1.01 * float(np.trace(square)) + gamma(terms) * sizes) * UP
    for share in SHARES:
        shift = share * lowest
        lower = shift * (1 - gamma(1)) - lost - gamma(1) * float(square.diagonal().max())
        if not lower > 0:
            return None
        proved = float(np.sqrt(lower)) * DOWN - blurred
        if proved > 0 and _factor(square, shift) is not None:
            return proved * DOWN
    return None


def _squares(matrix: Matrix) -> float:
    """Return the sum of the squares of all entries."""
    entries = matrix if isinstance(matrix, np.ndarray) else matrix.data
    return float((entries * entries).sum())


def _factor(square: Float, shift: float = 0.0) -> Float | None:
    """Return the lower triangle of a symmetric matrix less ``shift`` on its diagonal by Cholesky's method, or None.

    None: the method does not run to its end.
    """
    own = np.array(square, order="F")
    own.reshape(-1, order="F")[:: len(own) + 1] -= shift
    factor, failed = dpotrf(own, lower=True, clean=True, overwrite_a=True)
    return None if failed else np.asarray(factor)


def _solved(factor: Float, asked: Float) -> Float:
    """Return Q⁻¹ times ``asked`` (n,) or (n, k) for the lower triangle (n, n) of Q by Cholesky's method."""
    return np.asarray(dpotrs(factor, asked, lower=True)[0])


def _scaled(matrix: Matrix, share: Float, scale: Float) -> Matrix:
    if isinstance(matrix, np.ndarray):
        return np.asarray(share[:, None] * matrix * scale)
    return sparse.csr_matrix(sparse.diags(share) @ matrix @ sparse.diags(scale))
