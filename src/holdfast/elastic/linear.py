"""The linear systems of a path: the stiffness bordered by a load and by a condition on the displacement.

    [ K + ε D + H   -w ] [x]
    [     cᵀ         d ] [s]

K is the stiffness of the contacts as they are, D that of bonded contacts; both are sums over sheets of 6x6 blocks. H is
the diagonal of the faint hold. ε is called ``drag`` and d ``corner``. Small systems are solved by dense elimination,
large ones front by front (fronts.py); the algorithms (resting.py, path.py) are compiled for either.
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, lean
from holdfast.elastic.law import Elastic

APART = 16  # numbers between the memories of two threads
SINGULAR = 0.0  # the sign of the determinant of a system that has no unique solution


class Work(NamedTuple):
    """A system of n = 6J displacements, and memory to work in.

    ``K`` (P, 6, 6); ``w``, ``c`` (n,); ``rhs`` (n + 1, 2) two right-hand sides, which become the solutions. ``A``
    (n + 1, n + 1) is the matrix of dense elimination, empty (0, 0) where there are fronts. ``r`` (n,) is the
    unbalance at a displacement (newton.py), ``trial`` (n,) a displacement tried; ``v``, ``F`` (6,) a sheet's twist and
    wrench; ``X`` (6, 6) half of what a sheet adds to the matrix.
    """

    K: Float
    w: Float
    c: Float
    rhs: Float
    A: Float
    r: Float
    trial: Float
    v: Float
    F: Float
    X: Float


def make_work(m: Elastic, *, dense: bool) -> Work:
    """The memory that one thread needs for a model: one block, so that no two threads write to the same cache line."""
    n = len(m.wrench)
    square = n + 1 if dense else 0
    shapes = [m.bonded.shape, (n,), (n,), (n + 1, 2), (square, square), (n,), (n,), (6,), (6,), (6, 6)]
    ends = np.cumsum([prod(shape) for shape in shapes])
    block = np.zeros(ends[-1] + 2 * APART)[APART:]
    return Work._make(part.reshape(shape) for part, shape in zip(np.split(block, ends)[:-1], shapes, strict=True))


@compiled
@lean
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
@lean
def dense_solve(m: Elastic, work: Work, drag: float, corner: float, transposed: bool) -> float:
    """Solve the system of ``work``, or its transpose, in place by Gauss elimination with row scaling and pivoting.

    Returns the sign of the determinant, or SINGULAR.
    """
    A, rhs, n = work.A, work.rhs, len(work.w)
    A[:] = 0.0
    _add_blocks(m, work.K, 1.0, A, work.X)
    if drag > 0:
        _add_blocks(m, m.bonded, drag, A, work.X)
    for i in range(n):
        A[i, i] += m.hold[i]
        A[i, n] = -work.w[i]
        A[n, i] = work.c[i]
    A[n, n] = corner
    size = n + 1
    if transposed:
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
            return SINGULAR
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
    return sign
