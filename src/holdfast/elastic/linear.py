"""The linear systems of a path: the stiffness bordered by a load and by a condition on the displacement.

    [ K + ε D + H   -w ] [x]
    [     cᵀ         d ] [s]

K is the stiffness of the contacts as they are, D that of bonded contacts; both are sums over sheets of 6x6 blocks, and
D has a diagonal besides, where bodies on ice are bonded to the world. H is the diagonal of the regularisation spring. ε
is called ``drag`` and d ``corner``. Small systems are solved by dense elimination, large ones front by front
(fronts.py); the algorithms (resting.py, path.py) are compiled for either.
"""

from __future__ import annotations

from itertools import accumulate, pairwise
from math import ceil, prod
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import by_reference, compilable, compiled, fused, lean
from holdfast.elastic.model import Elastic
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.twists import add_stiffness

LINE = 8  # numbers in a cache line
SPARE = 1.3  # memory for delayed pivots, relative to what is needed if no pivot is delayed
APART = 2 * LINE  # numbers between the memories of two threads, so that they share no cache line
BORDER = 0.01  # largest entry of the border's row: others are of order one, and pivots are not to come from it
ROUNDED = 1e-14  # pivots up to this size are nothing but rounding, where entries are of order one
SINGULAR = 0.0  # the sign of the determinant of a system that has no unique solution


@by_reference
class Work(NamedTuple):
    """A system of n = 6J displacements, and memory to work in.

    ``K`` (P, 6, 6); ``w``, ``c`` (n,); ``rhs`` (n + 1, 2) two right-hand sides, which become the solutions. ``A``
    (n + 1, at least n + 3) holds the matrix of dense elimination and both of them; it is empty where there are fronts.
    They need memory for what is ``left`` of those that are taken later, for the ``upper`` triangle, for two that are
    worked on, ``front`` and ``other``, and for a ``panel``. ``r`` (n,) is the unbalance at a displacement (newton.py),
    ``trial`` (n,) a displacement tried; ``v``, ``F`` (6,) a sheet's twist and wrench; ``X``, ``Y`` (6, 6) what a sheet
    adds to the matrix, half-way.
    """

    A: Float
    left: Float
    upper: Float
    front: Float
    other: Float
    panel: Float
    K: Float
    w: Float
    c: Float
    rhs: Float
    r: Float
    trial: Float
    v: Float
    F: Float
    X: Float
    Y: Float


@compilable
@lean
def lines(count: int) -> int:
    """As many numbers, or a few more, so that they end where a cache line does."""
    return -(-count // LINE) * LINE


def room_for(e: Fronts) -> list[int]:
    """How many numbers ``left``, ``upper``, ``front`` and ``panel`` of ``Work`` need, if few pivots wait."""
    sizes, kept = 6 * np.diff(e.first) + 1, 6 * e.owned
    widths = sizes + 3 * LINE  # what it takes to begin and end where cache lines do
    stays = np.append(np.diff(e.begin)[1:] == 0, False)  # fronts before one that takes from none
    needed = ((sizes * widths)[stays].sum(), (kept * widths).sum(), (sizes * widths).max(), (kept * sizes).max())
    return [lines(ceil(SPARE * each)) for each in needed]


def make_work(m: Elastic, fronts: Fronts | None) -> Work:
    """The memory that one thread needs for a model: one block, so that no two threads write to the same cache line.

    The rows of ``A`` begin where cache lines do: elimination takes half as long again where they begin anywhere. So
    does the memory for ``fronts``, which is empty where there are none.
    """
    n = len(m.wrench)
    left, upper, front, panel = (0, 0, 0, 0) if fronts is None else room_for(fronts)
    shapes = [(n + 1, lines(n + 3)) if fronts is None else (0, 0), (left,), (upper,), (front,), (front,), (panel,)]
    shapes += [m.bonded.shape, (n,), (n,), (n + 1, 2), (n,), (n,), (6,), (6,), (6, 6), (6, 6)]
    ends = list(accumulate((prod(shape) for shape in shapes), initial=0))
    block = np.zeros(ends[-1] + 3 * APART)
    first = APART + (-block.ctypes.data // block.itemsize) % LINE
    parts = (block[first + a : first + b] for a, b in pairwise(ends))
    return Work(*(part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)))


@compiled
@lean
def border_unit(row: Float, unit: Float) -> float:
    """What the border's row is multiplied by, besides the ``unit`` of its columns."""
    top = 0.0
    for i in range(len(row)):
        top = max(top, abs(unit[i] * row[i]))
    return BORDER / top if top > 0 else 1.0


@compiled
@lean
def add_body(m: Elastic, work: Work, body: int, drag: float, border: float, A: Float, at: int) -> None:
    """Add to a matrix (t, t + 2 or more) what a body brings besides contacts, in its rows and columns from ``at`` on.

    That is its hold, its own share of the drag, the border in row and column t - 1, and the right-hand sides in columns
    t and t + 1; ``border`` is what the border's row is multiplied by.
    """
    last = A.shape[0] - 1
    for i in range(6):
        here, place = 6 * body + i, at + i
        unit = m.unit[here]
        A[place, place] += unit * unit * (m.hold[here] + drag * m.still[here])
        A[place, last] -= unit * work.w[here]
        A[last, place] += border * unit * work.c[here]
        A[place, last + 1] += unit * work.rhs[here, 0]
        A[place, last + 2] += unit * work.rhs[here, 1]


@compiled
@lean
def add_corner(work: Work, border: float, corner: float, A: Float) -> None:
    """Add to a matrix as ``add_body`` has it what the border's row brings where it meets no body."""
    last, n = A.shape[0] - 1, len(work.w)
    A[last, last] += border * corner
    A[last, last + 1] += border * work.rhs[n, 0]
    A[last, last + 2] += border * work.rhs[n, 1]


@compiled
@lean
def dense_solve(m: Elastic, work: Work, drag: float, corner: float, least: float) -> float:
    """Solve the system of ``work`` in place by Gauss elimination with scaling and pivoting.

    Returns the sign of the determinant, or SINGULAR where no pivot is above ``least``: 0 where any step will do,
    ROUNDED where a solution that only rounding makes unique is none.
    """
    A, rhs, n, unit = work.A, work.rhs, len(work.w), m.unit
    A[:] = 0.0
    for p in range(len(m.a)):
        add_stiffness(m, p, work.K, drag, 6 * m.a[p], 6 * m.b[p], A, work.X, work.Y)
    border = border_unit(work.c, unit)
    for body in range(n // 6):
        add_body(m, work, body, drag, border, A, 6 * body)
    add_corner(work, border, corner, A)
    sign = eliminate_all(A, least)
    for i in range(n + 1):
        scale = unit[i] if i < n else 1.0
        rhs[i, 0], rhs[i, 1] = scale * A[i, n + 1], scale * A[i, n + 2]
    return sign


@compiled
@lean
@fused
def eliminate_all(A: Float, least: float) -> float:
    """Solve for the right-hand sides in columns t and t + 1 of a matrix with t rows, in place; what follows is unused.

    Returns the sign of the determinant, or SINGULAR where no pivot of a column is above ``least``.
    """
    size, sign = A.shape[0], 1.0
    for c in range(size):
        pivot = c
        for i in range(c + 1, size):
            if abs(A[i, c]) > abs(A[pivot, c]):
                pivot = i
        if not abs(A[pivot, c]) > least:
            return SINGULAR
        above = A[c, c:]
        if pivot != c:
            sign, other = -sign, A[pivot, c:]
            for j in range(len(above)):
                above[j], other[j] = other[j], above[j]
        if above[0] < 0:
            sign = -sign
        inverse = 1 / above[0]
        for i in range(c + 1, size):
            row = A[i, c:]  # slices: their loops compile to vector instructions
            factor = row[0] * inverse
            if factor != 0.0:
                for j in range(len(above)):
                    row[j] -= factor * above[j]
    for c in range(size - 1, -1, -1):
        one, two = A[c, size] / A[c, c], A[c, size + 1] / A[c, c]
        A[c, size], A[c, size + 1] = one, two
        for i in range(c):
            A[i, size] -= A[i, c] * one
            A[i, size + 1] -= A[i, c] * two
    return sign
