"""Linear systems of a path: the stiffness bordered by a load and by a condition on the displacement.

    [ K + ε D   -w ] [x]
    [   cᵀ       d ] [s]

K and D are sums over sheets of 6x6 blocks. Small systems are solved by dense elimination within compiled code, large
ones by sparse LU from Python: the algorithms (settle.py, path.py) run either way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compilable, compiled
from holdfast.elastic.law import Elastic

SINGULAR = 0.0
SMALL_PIVOT = 0.1  # of the largest in its column: below it the order that suits the symmetric pattern is left
VISCOSITY, CORNER, SIGN, TRANSPOSED = 0, 1, 2, 3  # entries of Work.ask
NO_RESISTANCE = 1e-9  # over that of bonded contacts as wide as the body
NEAR_SINGULAR = 1e-12  # added, so that a singular stiffness can be factored


class Work(NamedTuple):
    """A system and scratch.

    ``K`` (P, 6, 6); ``w``, ``c`` (n,); right-hand sides ``rhs`` (n + 1, 2). ``ask`` (4,) holds ε, d, once solved the
    sign of the determinant (0: singular), and 1 where the transposed system is meant. ``A`` (n + 1, n + 1) is for the
    dense solution, the rest is scratch.
    """

    K: Float
    w: Float
    c: Float
    rhs: Float
    ask: Float
    A: Float
    r: Float
    trial: Float
    v: Float
    F: Float


def make_work(m: Elastic, *, dense: bool) -> Work:
    """Room for a model of n = 6J unknowns."""
    n = len(m.wrench)
    square = np.zeros((n + 1, n + 1)) if dense else np.zeros((0, 0))
    return Work(
        np.zeros_like(m.bonded),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n + 1, 2)),
        np.zeros(4),
        square,
        np.zeros(n),
        np.zeros(n),
        np.zeros(6),
        np.zeros(6),
    )


@compiled
def _add_blocks(m: Elastic, K: Float, factor: float, A: Float, X: Float) -> None:
    """A += factor Σ_p [Tb, -Ta]ᵀ K_p [Tb, -Ta]."""
    for p in range(len(m.a)):
        for side in range(2):
            column = m.b[p] if side == 0 else m.a[p]
            if column < 0:
                continue
            T = m.Tb[p] if side == 0 else m.Ta[p]
            sign = factor if side == 0 else -factor
            X[:] = 0.0
            for i in range(6):
                for l in range(6):  # noqa: E741
                    share = sign * K[p, i, l]
                    if share != 0.0:
                        for j in range(6):  # the inner loop along rows: compiled to vector instructions
                            X[i, j] += share * T[l, j]
            for other in range(2):
                row = m.b[p] if other == 0 else m.a[p]
                if row < 0:
                    continue
                T = m.Tb[p] if other == 0 else m.Ta[p]
                sign_ = 1.0 if other == 0 else -1.0
                for i in range(6):
                    for l in range(6):  # noqa: E741
                        share = sign_ * T[l, i]
                        if share != 0.0:
                            for j in range(6):
                                A[6 * row + i, 6 * column + j] += share * X[l, j]


@compiled
def dense_solve(m: Elastic, work: Work) -> None:
    """Solve the system of ``work`` in place, by Gauss elimination with row scaling and partial pivoting."""
    A, rhs, n = work.A, work.rhs, len(work.w)
    A[:] = 0.0
    X = np.empty((6, 6))
    _add_blocks(m, work.K, 1.0, A, X)
    if work.ask[0] > 0:
        _add_blocks(m, m.bonded, work.ask[0], A, X)
    for i in range(n):
        A[i, n] = -work.w[i]
        A[n, i] = work.c[i]
    A[n, n] = work.ask[1]
    size = n + 1
    if work.ask[3] > 0:
        for i in range(size):
            for j in range(i):
                A[i, j], A[j, i] = A[j, i], A[i, j]
    sign = 1.0
    for i in range(size):
        top = 0.0
        row = A[i]
        for j in range(size):
            top = max(top, abs(row[j]))
        if top > 0:
            inverse = 1 / top
            for j in range(size):
                row[j] *= inverse
            rhs[i, 0] *= inverse
            rhs[i, 1] *= inverse
    for c in range(size):
        pivot = c
        for i in range(c + 1, size):
            if abs(A[i, c]) > abs(A[pivot, c]):
                pivot = i
        if not abs(A[pivot, c]) > 0:
            work.ask[2] = 0.0
            return
        if pivot != c:
            sign = -sign
            for j in range(c, size):
                A[c, j], A[pivot, j] = A[pivot, j], A[c, j]
            for j in range(2):
                rhs[c, j], rhs[pivot, j] = rhs[pivot, j], rhs[c, j]
        if A[c, c] < 0:
            sign = -sign
        inverse = 1 / A[c, c]
        above = A[c, c + 1 :]
        for i in range(c + 1, size):
            factor = A[i, c] * inverse
            if factor != 0.0:
                row = A[i, c + 1 :]  # slices: their loops compile to vector instructions
                for j in range(len(above)):
                    row[j] -= factor * above[j]
                rhs[i, 0] -= factor * rhs[c, 0]
                rhs[i, 1] -= factor * rhs[c, 1]
    for c in range(size - 1, -1, -1):
        one, two = rhs[c, 0], rhs[c, 1]
        for j in range(c + 1, size):
            one -= A[c, j] * rhs[j, 0]
            two -= A[c, j] * rhs[j, 1]
        rhs[c, 0] = one / A[c, c]
        rhs[c, 1] = two / A[c, c]
    work.ask[2] = sign


@compiled
def _blocks(m: Elastic, K: Float, viscosity: float, out: Float) -> None:
    """The 6x6 blocks of every sheet's pairs of bodies (bb, ba, ab, aa), row by row, into ``out`` (P, 4, 6, 6)."""
    for p in range(len(m.a)):
        D = K[p] + viscosity * m.bonded[p]
        X, Y = D @ m.Tb[p], D @ m.Ta[p]
        out[p, 0] = m.Tb[p].T @ X
        out[p, 1] = -(m.Tb[p].T @ Y)
        out[p, 2] = -(m.Ta[p].T @ X)
        out[p, 3] = m.Ta[p].T @ Y


def _pattern(m: Elastic) -> tuple[Bool, Int, Int]:
    """Which entries of ``_blocks`` belong to free bodies, and the rows and columns of those."""
    ends = np.stack([np.stack([m.b, m.b, m.a, m.a], 1), np.stack([m.b, m.a, m.b, m.a], 1)], 2)
    rows = (6 * ends[:, :, 0, None, None] + np.arange(6)[:, None] + np.zeros((1, 6), int)).ravel()
    columns = (6 * ends[:, :, 1, None, None] + np.arange(6) + np.zeros((6, 1), int)).ravel()
    kept = np.repeat((ends >= 0).all(2).ravel(), 36)
    return kept, rows[kept], columns[kept]


def loose(m: Elastic, K: Float) -> Float:
    """How far each body (J,) moves in a motion (largest: 1) that the stiffness ``K`` (P, 6, 6) does not resist.

    Zero where there is none. By inverse iteration from a fixed random start, so that of several such motions a general
    combination is found; each body's rows and columns in units of its own bonded contacts and size.
    """
    n = len(m.wrench)
    kept, rows, columns = _pattern(m)
    blocks = np.zeros((len(m.a), 4, 6, 6))
    _blocks(m, m.bonded, 0.0, blocks)
    firmest = np.zeros(n)
    on = (rows == columns) & (rows % 6 < 3)
    np.add.at(firmest, rows[on], blocks.ravel()[kept][on])
    size = m.scale[::6] / m.scale[3::6]
    unit = np.repeat(np.sqrt(firmest.reshape(-1, 6).max(1)), 6) * np.stack([np.ones_like(size), size], 1).repeat(3)
    _blocks(m, K, 0.0, blocks)
    scaled = blocks.ravel()[kept] / (unit[rows] * unit[columns])
    A = sparse.csc_matrix((scaled, (rows, columns)), shape=(n, n))
    factors = splu(A + NEAR_SINGULAR * sparse.eye(n, format="csc"))
    x = np.random.default_rng(0).normal(size=n)
    for _ in range(3):
        x = factors.solve(x)
        x /= np.abs(x).max()
    if np.abs(np.asarray(A @ x)).max() > NO_RESISTANCE:
        return np.zeros(n // 6)
    return np.asarray(np.abs(x).reshape(-1, 6).max(1))


class SparseSolver:
    """Sparse LU of the systems of one model; the pattern is found once."""

    def __init__(self, m: Elastic) -> None:
        self._m = m
        self._blocks = np.zeros((len(m.a), 4, 6, 6))
        n = len(m.wrench)
        kept, rows, columns = _pattern(m)
        edge = np.arange(n)
        rows = np.concatenate([rows, edge, np.full(n, n), [n]])
        columns = np.concatenate([columns, np.full(n, n), edge, [n]])
        places, slot = np.unique(columns * (n + 1) + rows, return_inverse=True)
        self._kept = kept
        self._slot = slot.reshape(-1)  # where each value is added
        self._row = (places % (n + 1)).astype(np.int32)
        self._start = np.searchsorted(places, (n + 1) * np.arange(n + 2)).astype(np.int32)
        self._by_row = np.argsort(self._row, kind="stable")
        self._row_start = np.searchsorted(self._row[self._by_row], np.arange(n + 1))

    def solve(self, work: Work) -> None:
        """Solve the system of ``work`` in place."""
        viscosity, corner, _, transposed = work.ask
        _blocks(self._m, work.K, viscosity, self._blocks)
        values = np.concatenate([self._blocks.ravel()[self._kept], -work.w, work.c, [corner]])
        data = np.bincount(self._slot, values, len(self._row))
        top = np.maximum.reduceat(np.abs(data)[self._by_row], self._row_start)
        scale = 1 / np.where(top > 0, top, 1.0)
        matrix = sparse.csc_matrix((data * scale[self._row], self._row, self._start), copy=True)
        matrix.eliminate_zeros()  # of open contacts: they would fill the factors
        try:
            factors = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=SMALL_PIVOT,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            work.ask[SIGN] = SINGULAR
            return
        if transposed:
            work.rhs[:] = factors.solve(work.rhs.copy(), "T") * scale[:, None]  # type: ignore[call-overload]
        else:
            work.rhs[:] = factors.solve(work.rhs * scale[:, None])
        diagonal = factors.U.diagonal()
        sign = np.sign(diagonal).prod() * _parity(factors.perm_r) * _parity(factors.perm_c)
        work.ask[SIGN] = sign if np.isfinite(work.rhs).all() else SINGULAR


@compilable
def solve(m: Elastic, work: Work, sparse: SparseSolver | None) -> None:
    """Solve the system of ``work`` in place: by ``sparse``, or by dense elimination."""
    if sparse is None:
        dense_solve(m, work)
    else:
        sparse.solve(work)


def _parity(permutation: Int) -> float:
    """1 for even permutations, -1 for odd ones: by the number of cycles."""
    n = len(permutation)
    graph = sparse.csr_matrix((np.ones(n), (np.arange(n), permutation)), shape=(n, n))
    cycles, _ = connected_components(graph, directed=False)
    return 1.0 if (n - cycles) % 2 == 0 else -1.0
