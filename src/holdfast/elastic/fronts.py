"""Block-sparse elimination of the linear systems of large models, front by front.

The bodies are put into one order for a model, by minimum degree: those with few neighbours first. A front is a small
dense matrix: the rows and columns of the bodies that it eliminates, and of their neighbours that come later. What is
left of it after elimination is added to the front in which the first of these neighbours is eliminated (the
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
from holdfast.base.compiled import compilable, compiled, lean
from holdfast.elastic.elimination import eliminate
from holdfast.elastic.frames import add_stiffness
from holdfast.elastic.linear import SINGULAR, Work, add_body, add_corner, border_unit, dense_solve
from holdfast.elastic.model import Elastic
from holdfast.elastic.ordering import Tree

SPARE = 1.3  # memory for pivots that wait, over what is needed if none does


class Fronts(NamedTuple):
    """The fronts of a model in the order of elimination, and all of its sheets, each in one front; see ``Tree``.

    Front k holds bodies ``body[first[k]:first[k + 1]]``, of which it eliminates the first ``owned[k]``; ``onward`` is
    each body's place in the front that takes what is left, where the bodies are not eliminated before. It takes what is
    left of the fronts ``child[begin[k]:begin[k + 1]]``, and the sheets ``sheet[since[k]:since[k + 1]]``, whose bodies
    have the places ``at_a`` and ``at_b`` in it (-1: fixed). ``memory``: numbers held at once of what is left, and in
    all of the rows of pivots, if none waits.
    """

    first: Int
    body: Int
    owned: Int
    onward: Int
    begin: Int
    child: Int
    since: Int
    sheet: Int
    at_a: Int
    at_b: Int
    memory: Int


def fronts_of(m: Elastic) -> Fronts:
    """Order the bodies of a model, and say what each front takes."""
    tree = Tree.of(len(m.wrench) // 6, m.a, m.b)
    sizes = 6 * np.diff(tree.first) + 1
    kept = 6 * tree.owned
    memory = np.array([((sizes - kept) * (sizes - kept + 2)).sum(), (kept * (sizes + 2)).sum(), sizes.sum()])
    return Fronts(*tree, np.ceil(SPARE * memory).astype(np.int64))


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
    transposed: bool,
    full: int,
    F: Float,
) -> None:
    """Add to front k what its own bodies and sheets bring; ``full``: its rows before those that stay."""
    owned = e.owned[k]
    waiting = full - 6 * owned
    for s in range(e.since[k], e.since[k + 1]):
        a, b = 6 * e.at_a[s], 6 * e.at_b[s]
        a, b = a + waiting if a >= 6 * owned else a, b + waiting if b >= 6 * owned else b
        add_stiffness(m, e.sheet[s], work.K, drag, transposed, a, b, F, work.X, work.Y)
    for slot in range(owned):
        add_body(m, work, e.body[e.first[k] + slot], border, transposed, F, 6 * slot)
    if k == len(e.owned) - 1:
        add_corner(work, border, corner, F)


@compiled
@lean
def place_of(slot: int, owned: int, waiting: int) -> int:
    """Where the rows of a body begin in a front whose own bodies are followed by ``waiting`` rows."""
    return 6 * slot if slot < owned else 6 * slot + waiting


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
def add_child(
    e: Fronts,
    child: int,
    left: Float,
    numbers: Int,
    at: int,
    waits: int,
    F: Float,
    columns: Int,
    k: int,
    full: int,
    start: Int,
    to: Int,
) -> None:
    """Add to front k what is left of a ``child``: a matrix (t, t + 2) in ``left`` and the ``numbers`` of its columns.

    Its first ``waits`` rows and columns wait for a pivot, and go to the place ``at``. ``start`` and ``to`` are memory
    for the pieces of columns that stay together: as many as bodies, and three.
    """
    size, owned, pieces = len(numbers), e.owned[k], 0
    if waits > 0:
        start[0], to[0], pieces = 0, at, 1
        for i in range(waits):
            columns[at + i] = numbers[i]
    i = waits
    for slot in range(e.first[child] + e.owned[child], e.first[child + 1]):
        place = place_of(e.onward[slot], owned, full - 6 * owned)
        if pieces == 0 or place - to[pieces - 1] != i - start[pieces - 1]:
            start[pieces], to[pieces] = i, place
            pieces += 1
        i += 6
    start[pieces], to[pieces] = i, F.shape[0] - 1  # the border and the right-hand sides
    pieces += 1
    start[pieces] = size + 2
    for piece in range(pieces):
        for i in range(start[piece], min(start[piece + 1], size)):
            add_pieces(F[to[piece] + i - start[piece]], left[i * (size + 2) : (i + 1) * (size + 2)], start, to, pieces)


@compiled
@lean
def add_pieces(row: Float, part: Float, start: Int, to: Int, pieces: int) -> None:
    """Add to a ``row``, from its places ``to`` on, the pieces of ``part``, each between one ``start`` and the next."""
    for piece in range(pieces):
        here, there = part[start[piece] : start[piece + 1]], row[to[piece] :]
        for j in range(len(here)):
            there[j] += here[j]


@compiled
def fronts_solve(
    m: Elastic, work: Work, e: Fronts, drag: float, corner: float, transposed: bool, least: float
) -> float:
    """As ``dense_solve``, front by front."""
    n, count = len(work.w), len(e.owned)
    left, numbers = np.empty(e.memory[0]), np.empty(e.memory[2], np.int64)
    upper, room = np.empty(e.memory[1]), np.empty(0)
    most = (e.first[1:] - e.first[:-1]).max() + 3
    start, to = np.empty(most, np.int64), np.empty(most, np.int64)
    size, done, waits = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(count, np.int64)
    at_left, at_number, at_upper = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(count, np.int64)
    top, above, last, sign = 0, 0, 0, 1.0
    border = border_unit(work.w if transposed else work.c, m.unit)
    for k in range(count):
        waiting = 0
        for j in range(e.begin[k], e.begin[k + 1]):
            waiting += waits[e.child[j]]
        full = 6 * e.owned[k] + waiting
        size[k] = t = 6 * (e.first[k + 1] - e.first[k]) + waiting + 1
        if k == count - 1:
            full = t
        F = np.zeros((t, t + 2))
        numbers = grown(numbers, last + t)
        columns = numbers[last : last + t]
        number_columns(n, e, k, full - (k == count - 1), columns)
        add_own(m, work, e, k, drag, corner, border, transposed, full - (k == count - 1), F)
        at, base = 6 * e.owned[k], top
        for j in range(e.begin[k], e.begin[k + 1]):
            c = e.child[j]
            base = min(base, at_left[c])
            rest = numbers[at_number[c] + done[c] : at_number[c] + size[c]]
            add_child(e, c, left[at_left[c] :], rest, at, waits[c], F, columns, k, full - (k == count - 1), start, to)
            at += waits[c]
        room = grown(room, full * t)
        done[k], turned = eliminate(F, room[: full * t].reshape((full, t)), columns, full, least)
        sign *= turned
        waits[k] = full - done[k]
        at_number[k], at_left[k], at_upper[k] = last, base, above
        last += t
        top, above = base + (t - done[k]) * (t - done[k] + 2), above + done[k] * (t + 2)
        left, upper = grown(left, top), grown(upper, above)
        keep(F, done[k], upper[at_upper[k] :], left[base:])
    if waits[count - 1] > 0:
        return SINGULAR
    for k in range(count - 1, -1, -1):
        rows = upper[at_upper[k] : at_upper[k] + done[k] * (size[k] + 2)].reshape((done[k], size[k] + 2))
        substitute(rows, numbers[at_number[k] : at_number[k] + size[k]], work.rhs)
    for i in range(n + 1):
        unit = m.unit[i] if i < n else 1.0
        for j in range(2):
            work.rhs[i, j] *= unit
        if not (np.isfinite(work.rhs[i, 0]) and np.isfinite(work.rhs[i, 1])):
            return SINGULAR
    return sign


@compiled
@lean
def keep(F: Float, done: int, upper: Float, left: Float) -> None:
    """Copy the rows of pivots of a front to ``upper``, and what is left of it to ``left``."""
    size = F.shape[0]
    for i in range(done):
        row, to = F[i], upper[i * (size + 2) : (i + 1) * (size + 2)]
        for j in range(size + 2):
            to[j] = row[j]
    stays = size - done + 2
    for i in range(size - done):
        row, to = F[done + i, done:], left[i * stays : (i + 1) * stays]
        for j in range(stays):
            to[j] = row[j]


@compiled
@lean
def substitute(rows: Float, columns: Int, solution: Float) -> None:
    """Find the unknowns of a front's pivots; those of its later columns are in ``solution`` (n + 1, 2) by then."""
    size = len(columns)
    for i in range(len(rows) - 1, -1, -1):
        row = rows[i]
        one, two = row[size], row[size + 1]
        for j in range(i + 1, size):
            one -= row[j] * solution[columns[j], 0]
            two -= row[j] * solution[columns[j], 1]
        solution[columns[i], 0] = one / row[i]
        solution[columns[i], 1] = two / row[i]


@compilable
@lean
def solve(
    m: Elastic, work: Work, drag: float, corner: float, transposed: bool, fronts: Fronts | None, least: float = 0.0
) -> float:
    """Solve the system of ``work``, or its transpose, in place: by ``fronts``, or by dense elimination where None.

    Returns the sign of the determinant, or SINGULAR; ``least`` is as in ``dense_solve``.
    """
    if fronts is None:
        return dense_solve(m, work, drag, corner, transposed, least)
    return fronts_solve(m, work, fronts, drag, corner, transposed, least)
