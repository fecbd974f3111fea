"""Forces near given ones that balance exactly: corrections of least size, with a proved bound.

The exact operator G is that of the points and axes of the nodes and of the centres of mass as the double-precision
numbers that they are. Its stored entries, and all sums of products, differ from it by rounding. For a sum of n products
computed in any order, |computed - exact| <= γ Σ |a||b| with γ = n u / (1 - n u) and u = 2⁻⁵³ (Higham, Accuracy and
Stability of Numerical Algorithms, chapter 3). The entries themselves are off by at most 4 u times the sums of absolute
products that they are computed from, which ``Equilibrium.magnitude`` holds.

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
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dpotrf, dpotrs  # scipy's own functions take ten times as long to call

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import (
    ContactNodes,
    arms,
    by_bodies,
    counted_part,
    dense_by_bodies,
    equilibrium_blocks,
)
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.ranges import UNIT
from holdfast.engines.forces import lighter_share
from holdfast.engines.rest import Rest

SPARE = 6  # roundings of entries, of absolute values and of the bounds themselves, in u
LEAST = 1e-290  # covers underflow: products smaller than the normal range lose more than u of themselves
EXTENDED = np.finfo(np.longdouble).nmant in (63, 112)  # whether numpy has a precision beyond double, of IEEE kind
DENSE = 16_384  # entries up to which a dense matrix multiplies faster than a sparse one
UP, DOWN = 1 + 8 * UNIT, 1 - 8 * UNIT  # factors that outweigh the rounding of the last few operations

Matrix = Float | sparse.csr_matrix


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """The operator G (6J, 3I) of an assembly, its transpose ``gather``, and bounds of their rounding.

    ``magnitude`` (6J, 3I) is zero only where G is zero exactly. ``unknown`` (6J, 3I) bounds the errors of the entries
    of G and of products with them; ``spread`` (3I, 6J) does so for the transpose.
    """

    nodes: ContactNodes
    com: Float
    G: Matrix
    gather: Matrix
    magnitude: Matrix
    unknown: Matrix
    spread: Matrix

    @classmethod
    def of(cls, assembly: Assembly, nodes: ContactNodes) -> Equilibrium:
        """Return the operator of these nodes."""
        bodies = len(assembly.movable) + nodes.fasteners
        # H is G with absolute values of all factors, zero only where G is; that of holds is exact as it is stored
        contacts = nodes.contacts
        magnitudes = np.empty((len(contacts), 3, 2, 6))
        magnitudes[:, :, :, :3] = np.abs(contacts.axes)[:, :, None]
        fx, fy, fz = np.moveaxis(np.abs(contacts.axes), 2, 0)
        for side, body in enumerate((contacts.b, contacts.a)):
            x, y, z = np.abs(arms(assembly, contacts, body)).T[:, :, None]
            magnitudes[:, :, side, 3], magnitudes[:, :, side, 4] = y * fz + z * fy, z * fx + x * fz
            magnitudes[:, :, side, 5] = x * fy + y * fx
        blocks = equilibrium_blocks(assembly, nodes)
        sizes = counted_part(nodes, np.concatenate([magnitudes, np.abs(nodes.blocks)]))
        G: Matrix
        H: Matrix
        if 18 * bodies * len(nodes) <= DENSE:
            G, H = dense_by_bodies(bodies, nodes, blocks), dense_by_bodies(bodies, nodes, sizes)
        else:
            G, H = (sparse.csr_matrix(by_bodies(bodies, nodes, each)) for each in (blocks, sizes))
            H.eliminate_zeros()
        most = np.count_nonzero(H, axis=1) if isinstance(H, np.ndarray) else np.diff(H.indptr)
        terms = max(int(most.max(initial=0)), 12) + 2
        return cls(nodes, assembly.com, G, _transpose(G), H, gamma(terms) * H, _transpose(gamma(12) * H))

    def velocities(self, motions: Float) -> tuple[Float, Float]:
        """Return Gᵀ y (3I, k) for motions y (6J, k), and bounds (3I, k) of their errors.

        Motions in extended precision (EXTENDED) are multiplied in it.
        """
        if motions.dtype == np.longdouble:
            gather, spread = self._extended
            return np.asarray(gather @ motions), np.asarray(spread @ np.abs(motions)) + LEAST
        return np.asarray(self.gather @ motions), np.asarray(self.spread @ np.abs(motions)) + LEAST

    @cached_property
    def _extended(self) -> tuple[Any, Any]:
        """The transpose of G (3I, 6J) and the bounds of its products in extended precision."""
        contacts, bodies = self.nodes.contacts, len(self.com) + self.nodes.fasteners
        count, of_holds = len(self.nodes), np.arange(len(contacts), len(self.nodes))
        axes = contacts.axes.astype(np.longdouble)
        G, H = np.zeros((2, count, 3, bodies + 1, 6), dtype=np.longdouble)  # FIXED is -1, the last one
        for side, body in enumerate((self.nodes.b[of_holds], self.nodes.a[of_holds])):
            G[of_holds, :, body] += self.nodes.blocks[:, :, side]
            H[of_holds, :, body] += np.abs(self.nodes.blocks[:, :, side])
        for body, sign in ((contacts.b, 1), (contacts.a, -1)):
            com = np.vstack([self.com, np.zeros((1, 3))])[body].astype(np.longdouble)
            arm = (contacts.points.astype(np.longdouble) - com)[:, None]
            size = np.abs(arm)
            around = [
                size[..., k - 2] * np.abs(axes[..., k - 1]) + size[..., k - 1] * np.abs(axes[..., k - 2])
                for k in range(3)
            ]
            node = np.arange(len(contacts))
            G[node, :, body] += sign * np.concatenate([axes, np.cross(arm, axes)], axis=2)
            H[node, :, body] += np.concatenate([np.abs(axes), np.stack(around, axis=2)], axis=2)
        if self.nodes.counted is not None:
            for m in (G, H):
                m[:, :, : len(self.com)] *= self.nodes.counted.reshape(-1, 6)
        unit = np.finfo(np.longdouble).eps
        gather, spread = (m[:, :, :bodies].reshape(3 * count, 6 * bodies) for m in (G, H))
        return gather, gamma(12) / UNIT * unit * spread

    def imbalance(self, forces: Float, wrench: Float, loads: Float, factors: Float) -> tuple[Float, Float]:
        """Return G f + w + s w_e (6J, k), and bounds of the errors.

        The forces f are (3I, k), the wrench w (6J,), the loads w_e (6J, k) and the factors s (k,).
        """
        pushed, found = factors * loads, np.asarray(self.G @ forces)
        size = np.abs(wrench)[:, None] + np.abs(pushed) + np.abs(found)
        return found + (wrench[:, None] + pushed), np.asarray(self.unknown @ np.abs(forces)) + gamma(4) * size + LEAST


def inner(a: Float, b: Float) -> tuple[Float, Float]:
    """Return the inner products (k,) of the columns of a and b (n, k) or (n, 1), and bounds of their errors."""
    products = a * b
    unit = float(np.finfo(products.dtype).eps)
    return products.sum(0), gamma(len(a)) / UNIT * unit * np.abs(products).sum(0) + LEAST


def gamma(terms: int) -> float:
    """Return a bound of γ for sums of this many products, with some roundings to spare."""
    return (terms + SPARE) * UNIT * 1.01


def _transpose(matrix: Matrix) -> Matrix:
    """Return the transpose, by rows."""
    return np.ascontiguousarray(matrix.T) if isinstance(matrix, np.ndarray) else sparse.csr_matrix(matrix.T)


LIGHT = 0.25  # share of the weight of a node's lighter body that counts as its usual force, if it rests on nothing


@dataclass(frozen=True, eq=False)
class Scales:
    """Units of contact forces, ``force`` (3I,) [N], and of motions, ``motion`` (6J,).

    Forces are in units of the usual normal force of their node, times μ along the surface where μ < 1. An equation is
    multiplied by its unit of motion: its largest terms are then of order one.
    """

    force: Float
    motion: Float

    @classmethod
    def of(cls, equilibrium: Equilibrium, mu: Float, tau: Float) -> Scales:
        """Return the units for nodes with usual normal forces ``tau`` (I,) [N].

        They are 0 for forces that have to be 0 and for equations that none of the others enters.
        """
        force = np.repeat(tau, 3)
        force.reshape(-1, 3)[:, 1:] *= np.minimum(mu, 1.0)[:, None]
        H = equilibrium.magnitude
        squares = H * H if isinstance(H, np.ndarray) else H.multiply(H)
        size = np.sqrt(np.asarray(squares @ (force * force)).ravel())
        return cls(force, np.divide(1.0, size, out=np.zeros(len(size)), where=size > 0))


def usual_forces(assembly: Assembly, rest: Rest) -> Float:
    """Return the usual normal force (I,) [N] of every node: that at rest on its interface, or a share of a weight.

    Nodes of holds have their own.
    """
    nodes, owner = rest.nodes.contacts, rest.nodes.contacts.interface
    count = np.maximum(np.bincount(owner), 1)
    resting = np.bincount(owner, np.maximum(rest.forces[: len(nodes), 0], 0.0)) / count
    own = LIGHT * lighter_share(assembly, nodes) * assembly.weight
    return np.concatenate([np.maximum(resting[owner], own / count[owner]), rest.nodes.usual])


STEPS = 3  # largest number of refinement steps: the second takes away what rounding left after the first
ENOUGH = 8  # an imbalance that is this many times as large as what rounding leaves is taken away once more
GUESSES = 4  # steps of inverse iteration for the smallest eigenvalue, which is found from above
SHARES = (0.5, 0.02)  # shares of that guess for which a proof is tried
FREE = 1e-14  # square of a resistance that counts as none, where those of contacts are of order one
BALANCED = 1e-9  # imbalance, in usual forces, of a body along what no contact of it resists
TANGENTIAL = float(np.sqrt(2)) * UP  # f_n and f_t / μ change together by no more than this times |T⁻¹ δ| of a node


@dataclass(frozen=True, eq=False)
class CombinedEquations:
    """Combinations of n equations: those that contacts resist, ``resisted`` (p, n), and others, ``free`` (n - p, n)."""

    resisted: sparse.csr_matrix
    free: sparse.csr_matrix

    @classmethod
    def of(cls, square: Float, body: Int) -> CombinedEquations | None:
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
    combined: CombinedEquations | None
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
        square, combined = _times_transpose(A), None
        found = _proved(A, unknown, square)
        if found is None:
            combined = CombinedEquations.of(square, np.flatnonzero(rows) // 6)
            if combined is None:
                return None
            sizes: Matrix = np.abs(A) if isinstance(A, np.ndarray) else sparse.csr_matrix(abs(A))
            unknown = abs(combined.resisted) @ (unknown + gamma(8) * sizes)
            A = combined.resisted @ A
            found = _proved(A, unknown, _times_transpose(A))
        return None if found is None else cls(equilibrium, tau, scale, scale == 0, rows, share, combined, A, *found)

    @property
    def loose(self) -> Bool:
        """Which bodies (J,) are only balanced: no contact of theirs resists some motion of them.

        Among holds, that counts even where no force enters an equation: two fingers let a body turn about their line.
        """
        free, counted = self._unresisted_rows, self.equilibrium.nodes.counted
        if counted is not None:
            free = free | ~self.rows
            free[: len(counted)] &= counted > 0
        return np.asarray(free.reshape(-1, 6).any(1))

    @property
    def _unresisted_rows(self) -> Bool:
        """Which equations (6J,) enter combinations that no contact resists."""
        found = np.zeros(len(self.share), dtype=bool)
        if self.combined is not None:
            found[np.flatnonzero(self.rows)[self.combined.free.getnnz(axis=0) > 0]] = True
        return found

    def forces_for(self, wrench: Float) -> Float:
        """Return forces (3I, k) [N], as small as can be in units of T, that about make up ``wrench`` (6J, k)."""
        balanced = self.share[self.rows, None] * wrench[self.rows]
        if self.combined is not None:
            balanced = self.combined.resisted @ balanced
        found = _solved_by_cholesky(self.factor, balanced)
        return np.asarray(self.scale[:, None] * (self.scaled.T @ found))

    def motion_for(self, velocities: Float) -> Float:
        """Return the motion (6J,) that is closest to ``velocities`` (3I,) of the nodes, in units of T⁻¹."""
        motion, fitted = np.zeros(len(self.share)), np.asarray(self.scaled @ (self.scale * velocities))
        found = _solved_by_cholesky(self.factor, fitted)
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
        return np.where(self.rows & ~self._unresisted_rows, needed * self.share * UP, np.inf)


def _proved(A: Matrix, unknown: Matrix, square: Float) -> tuple[Float, float] | None:
    """Return the Cholesky factor of A Aᵀ and a proved lower bound of the singular values of A, if there is one.

    ``unknown`` and ``square`` are as in ``_least_singular_value``.
    """
    factor = _cholesky(square)
    least = None if factor is None else _least_singular_value(A, unknown, square, factor)
    return None if factor is None or least is None else (factor, least)


def _times_transpose(A: Matrix) -> Float:
    """Return A Aᵀ, dense."""
    product = A @ A.T
    return np.asarray(product if isinstance(product, np.ndarray) else product.toarray())


def _least_singular_value(A: Matrix, unknown: Matrix, square: Float, factor: Float) -> float | None:
    """Return a proved lower bound, above 0, of the singular values of the exact A, if there is one.

    Its computed entries ``A`` (n, m) may be off by ``unknown`` (n, m), and the computed ``square`` (n, n) by rounding.
    """
    count = len(square)
    guess = np.cos(np.arange(count))  # along no axis, and the same each time
    for _ in range(GUESSES):
        guess = _solved_by_cholesky(factor, guess / np.linalg.norm(guess))
    lowest = 1 / float(np.linalg.norm(guess))
    terms = int(np.diff(A.indptr).max()) if sparse.issparse(A) else A.shape[1]
    sizes, blur = (_sum_of_squares(m) * (1 + gamma(count * A.shape[1])) for m in (A, unknown))
    blurred = (float(np.sqrt(blur)) + gamma(2) * float(np.sqrt(sizes))) * UP
    lost = (gamma(count + 1) * 1.01 * float(np.trace(square)) + gamma(terms) * sizes) * UP
    for share in SHARES:
        shift = share * lowest
        lower = shift * (1 - gamma(1)) - lost - gamma(1) * float(square.diagonal().max())
        if not lower > 0:
            return None
        proved = float(np.sqrt(lower)) * DOWN - blurred
        if proved > 0 and _cholesky(square, shift) is not None:
            return proved * DOWN
    return None


def _sum_of_squares(matrix: Matrix) -> float:
    """Return the sum of the squares of all entries."""
    entries = matrix if isinstance(matrix, np.ndarray) else matrix.data
    return float((entries * entries).sum())


def _cholesky(square: Float, shift: float = 0.0) -> Float | None:
    """Return the lower triangle of a symmetric matrix less ``shift`` on its diagonal by Cholesky's method, or None.

    None: the method does not run to its end.
    """
    own = np.array(square, order="F")
    own.reshape(-1, order="F")[:: len(own) + 1] -= shift
    factor, failed = dpotrf(own, lower=True, clean=True, overwrite_a=True)
    return None if failed else np.asarray(factor)


def _solved_by_cholesky(factor: Float, right_side: Float) -> Float:
    """Return Q⁻¹ times ``right_side`` (n,) or (n, k) for the lower triangle (n, n) of Q by Cholesky's method."""
    return np.asarray(dpotrs(factor, right_side, lower=True)[0])


def _scaled(matrix: Matrix, share: Float, scale: Float) -> Matrix:
    if isinstance(matrix, np.ndarray):
        return np.asarray(share[:, None] * matrix * scale)
    return sparse.csr_matrix(sparse.diags(share) @ matrix @ sparse.diags(scale))
