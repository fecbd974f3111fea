"""Block-sparse elimination of the linear systems of large models, front by front.

The bodies are put into one order for a model, those with few neighbours first (ordering.py). A front is a small dense
matrix: the rows and columns of the bodies that it eliminates, and of their neighbours that come later. What is left of
it after elimination goes to the front in which the first of these neighbours is eliminated (passing.py; the
multifrontal method: Duff & Reid, "The multifrontal solution of indefinite sparse symmetric linear equations", ACM
Transactions on Mathematical Software 9 (1983)). The border, a load and a condition, is in every front and comes last.

A body without resistance has no pivot of its own: pivots that are too small among their columns wait for a later front,
and at the last one, with the border, all of the matrix that is left is at hand. So what is regular only as a whole, as
at the peak of a path, is solved as stably as what is regular body by body.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compilable, compiled, fused, lean
from holdfast.base.memory import Memory
from holdfast.elastic.elimination import apply_pivots, eliminate, finish
from holdfast.elastic.linear import LINE, SINGULAR, Work, add_body, add_corner, border_unit, dense_solve, lines
from holdfast.elastic.model import Elastic
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.passing import add_rows, find_pieces, pass_on, place_of
from holdfast.elastic.twists import add_stiffness

_KNOWN = Memory(20_000)  # sheets of models whose fronts are kept


def fronts_of(m: Elastic) -> Fronts:
    """Order the bodies of a model, and say what each front takes; what was found for other nodes is taken again."""
    count = len(m.wrench) // 6
    return _KNOWN.recalled((count, m.a.tobytes(), m.b.tobytes()), len(m.a), lambda: Fronts.of(count, m.a, m.b))


@compiled
def grown(memory: NDArray[Any], needed: int) -> NDArray[Any]:
    """The same memory, or a copy with room for ``needed`` numbers."""
    if needed <= len(memory):
        return memory
    larger = np.empty(2 * needed, memory.dtype)
    larger[: len(memory)] = memory
    return larger


@compiled
@lean
def add_own(
    m: Elastic,
    work: Work,
    e: Fronts,
    k: int,
    drag: float,
    corner: float,
    border: float,
    full: int,
    F: Float,
) -> None:
    """Add to front k what its own bodies and sheets bring; ``full``: its rows before those that stay."""
    owned = e.owned[k]
    waiting = full - 6 * owned
    for s in range(e.since[k], e.since[k + 1]):
        a, b = 6 * e.at_a[s], 6 * e.at_b[s]
        a, b = a + waiting if a >= 6 * owned else a, b + waiting if b >= 6 * owned else b
        add_stiffness(m, e.sheet[s], work.K, drag, a, b, F, work.X, work.Y)
    for slot in range(owned):
        add_body(m, work, e.body[e.first[k] + slot], drag, border, F, 6 * slot)
    if k == len(e.owned) - 1:
        add_corner(work, border, corner, F)


@compiled
@lean
def number_columns(n: int, e: Fronts, k: int, full: int, columns: Int) -> None:
    """Write the numbers of a front's columns, but for those that wait."""
    owned = e.owned[k]
    for slot in range(e.first[k + 1] - e.first[k]):
        at = place_of(slot, owned, full - 6 * owned)
        for i in range(6):
            columns[at + i] = 6 * e.body[e.first[k] + slot] + i
    columns[-1] = n


@compiled
@lean
def lead(e: Fronts, k: int) -> int:
    """Where the matrix of front k begins in memory: what stays of its rows, if no pivot waits, begins a cache line."""
    return int(-6 * e.owned[k] % LINE)


@compiled
@lean
def width(e: Fronts, k: int, size: int) -> int:
    """Numbers in the rows of front k, of as many as ``size``."""
    return lines(lead(e, k) + size + 2)


@compiled
@lean
def layout(e: Fronts, k: int, waits: Int) -> tuple[int, int]:
    """Rows of front k before those that stay, and all of them, where of every child ``waits`` rows wait."""
    waiting = 0
    for j in range(e.begin[k], e.begin[k + 1]):
        waiting += waits[e.child[j]]
    return 6 * e.owned[k] + waiting, 6 * (e.first[k + 1] - e.first[k]) + waiting + 1


@compiled
@lean
def passes_on(e: Fronts, k: int) -> bool:
    """Whether what is left of front k is written to the next front at once: whether that takes from any."""
    return bool(k + 1 < len(e.owned) and e.begin[k + 1] < e.begin[k + 2])


class Book(NamedTuple):
    """What is written down of every front.

    Its ``size``; the number of pivots ``done``, and of those that wait, ``waits``; where its matrix begins in the
    memory of those that stay, ``at_left``, which is free from ``base`` on when it has been taken; where the numbers of
    its columns begin, ``at_number``; and where the rows of its pivots begin, ``at_upper``, ``wide`` each.
    """

    size: Int
    done: Int
    waits: Int
    at_left: Int
    base: Int
    at_number: Int
    at_upper: Int
    wide: Int


@compiled
@lean
def take_children(
    e: Fronts, k: int, own: int, book: Book, left: Float, numbers: Int, F: Float, columns: Int, piece: Int
) -> int:
    """Add to front k what is left of its children but for the last, and write the numbers of all columns that wait.

    Returns from where on the memory ``left`` is free of these children.
    """
    at, base = 6 * e.owned[k], len(left)
    for j in range(e.begin[k], e.begin[k + 1]):
        c = e.child[j]
        for i in range(book.waits[c]):
            columns[at + i] = numbers[book.at_number[c] + book.done[c] + i]
        if c < k - 1:
            base = min(base, book.base[c])
            pieces = find_pieces(e, c, book.waits[c], at, k, own, len(F), piece)
            add_rows(left[book.at_left[c] :], width(e, c, book.size[c]), book.size[c], book.done[c], F, piece, pieces)
        at += book.waits[c]
    return base


@compiled
def fronts_solve(m: Elastic, work: Work, e: Fronts, drag: float, corner: float, least: float) -> float:
    """As ``dense_solve``, front by front."""
    n, count = len(work.w), len(e.owned)
    left, upper, here, other, panel = work.left, work.upper, work.front, work.other, work.panel
    most = (e.first[1:] - e.first[:-1]).max()
    numbers, place = np.empty(6 * len(e.body) + count, np.int64), np.empty(6 * most + 1, np.int64)
    piece = np.empty((most + 2, 3), np.int64)
    zeros = np.zeros((8, count), np.int64)
    book = Book(zeros[0], zeros[1], zeros[2], zeros[3], zeros[4], zeros[5], zeros[6], zeros[7])
    top, above, last, full, sign = 0, 0, 0, 0, 1.0
    border = border_unit(work.c, m.unit)
    F = P = X = here[:0].reshape((0, 0))
    for k in range(count):
        own, t = layout(e, k, book.waits)
        start, stop = lead(e, k), lead(e, k) + t * width(e, k, t)
        if passes_on(e, k) or k == count - 1:
            here, other = grown(other, stop), here
            G = here[start:stop].reshape((t, width(e, k, t)))
        else:
            book.at_left[k], book.base[k] = top + start, top
            left = grown(left, top + stop)
            G = left[top + start : top + stop].reshape((t, width(e, k, t)))
            top = lines(top + stop)
        if e.begin[k] < e.begin[k + 1]:
            place, waiting = grown(place, len(F)), book.waits[k - 1]
            pieces = find_pieces(e, k - 1, waiting, own - waiting, k, own, t, piece)
            pass_on(F, P, X, full, G, piece, pieces, place)
        else:
            G[:] = 0.0
        F = G
        numbers = grown(numbers, last + t)
        columns = numbers[last : last + t]
        number_columns(n, e, k, own, columns)
        add_own(m, work, e, k, drag, corner, border, own, F)
        free = take_children(e, k, own, book, left, numbers, F, columns, piece)
        if passes_on(e, k) or k == count - 1:
            top = min(top, free)
        else:
            book.base[k] = min(book.base[k], free)
        full = t if k == count - 1 else own
        panel, upper = grown(panel, full * t), grown(upper, above + full * (F.shape[1] + LINE))
        P = panel[: full * t].reshape((full, t))
        done, turned = eliminate(F, P, columns, full, least)
        sign *= turned
        wide = min(lines(t - done + 2), F.shape[1] - done)
        book.size[k], book.done[k], book.waits[k], book.wide[k] = t, done, full - done, wide
        book.at_number[k], book.at_upper[k] = last, above
        X = upper[above : above + done * wide].reshape((done, wide))
        finish(F, P, X, full)
        keep_pivots(P, upper[above + done * wide :], done)
        if not passes_on(e, k):
            apply_pivots(F, done, P, X, done, t, full - done)
        last, above = last + t, lines(above + done * (wide + done))
    if book.waits[count - 1] > 0:
        return SINGULAR
    here = grown(here, 2 * book.size.max())
    for k in range(count - 1, -1, -1):
        columns = numbers[book.at_number[k] : book.at_number[k] + book.size[k]]
        substitute(upper[book.at_upper[k] :], book.done[k], book.wide[k], columns, work.rhs, here)
    for i in range(n + 1):
        unit = m.unit[i] if i < n else 1.0
        for j in range(2):
            work.rhs[i, j] *= unit
        if not (np.isfinite(work.rhs[i, 0]) and np.isfinite(work.rhs[i, 1])):
            return SINGULAR
    return sign


@compiled
@lean
def keep_pivots(P: Float, into: Float, done: int) -> None:
    """Copy pivots, and what is above each, from the first rows of ``P`` to a matrix (done, done) in ``into``."""
    for c in range(done):
        row, to = P[c], into[c * done : (c + 1) * done]
        for i in range(c + 1):
            to[i] = row[i]


@compiled
@lean
@fused
def substitute(rows: Float, done: int, width: int, columns: Int, solution: Float, memory: Float) -> None:
    """Find the unknowns of a front's pivots; those of its later columns are in ``solution`` (n + 1, 2) by then.

    ``rows`` (done, width), in one row, are as ``finish`` leaves them, and ``keep_pivots`` what follows.
    """
    size = len(columns)
    rest = size - done
    one, two = memory[:size], memory[size : 2 * size]
    for j in range(done, size):
        one[j], two[j] = solution[columns[j], 0], solution[columns[j], 1]
    x, y = one[done:], two[done:]
    fours = done - done % 4
    for i in range(0, fours, 4):
        p, q = rows[i * width : (i + 1) * width], rows[(i + 1) * width : (i + 2) * width]
        r, s = rows[(i + 2) * width : (i + 3) * width], rows[(i + 3) * width : (i + 4) * width]
        p0, q0, r0, s0 = p[rest], q[rest], r[rest], s[rest]
        p1, q1, r1, s1 = p[rest + 1], q[rest + 1], r[rest + 1], s[rest + 1]
        for j in range(rest):
            p0 -= p[j] * x[j]
            q0 -= q[j] * x[j]
            r0 -= r[j] * x[j]
            s0 -= s[j] * x[j]
            p1 -= p[j] * y[j]
            q1 -= q[j] * y[j]
            r1 -= r[j] * y[j]
            s1 -= s[j] * y[j]
        one[i], one[i + 1], one[i + 2], one[i + 3] = p0, q0, r0, s0
        two[i], two[i + 1], two[i + 2], two[i + 3] = p1, q1, r1, s1
    for i in range(fours, done):
        p = rows[i * width : (i + 1) * width]
        p0, p1 = p[rest], p[rest + 1]
        for j in range(rest):
            p0 -= p[j] * x[j]
            p1 -= p[j] * y[j]
        one[i], two[i] = p0, p1
    for c in range(done - 1, -1, -1):
        above = rows[done * width + c * done : done * width + c * done + c + 1]
        a, b = one[c] / above[c], two[c] / above[c]
        for i in range(c):
            one[i] -= above[i] * a
            two[i] -= above[i] * b
        solution[columns[c], 0], solution[columns[c], 1] = a, b


@compilable
@lean
def solve(m: Elastic, work: Work, drag: float, corner: float, fronts: Fronts | None, least: float = 0.0) -> float:
    """Solve the system of ``work`` in place: by ``fronts``, or by dense elimination where None.

    Returns the sign of the determinant, or SINGULAR; ``least`` is as in ``dense_solve``.
    """
    if fronts is None:
        return dense_solve(m, work, drag, corner, least)
    return fronts_solve(m, work, fronts, drag, corner, least)
