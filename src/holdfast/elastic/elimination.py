"""Elimination within a front (fronts.py): pivots by columns, those too small left waiting, and rows in blocks."""

from __future__ import annotations

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, fused, lean

SMALL_PIVOT = 0.02  # share of a column's largest entry below which no entry is used as pivot
BLOCK = 6  # number of pivots that are applied together


@compiled
@lean
def eliminate(F: Float, P: Float, columns: Int, full: int, least: float) -> tuple[int, float]:
    """Eliminate in a front (t, at least t + 2) what its first ``full`` rows and columns allow, pivots above ``least``.

    Returns the number of pivots, which come first in the new order of rows and columns, and the sign of their product
    and of the new order. Columns t and t + 1 are right-hand sides. The first ``full`` columns are worked on as rows of
    ``P`` (full, t), along which memory runs: they hold the pivots, what is above them, and the factors of the rows
    below. Other columns have their rows in the new order, and are else as they were.

    Pivots are applied at once to as many columns as may follow them in a block, to later ones with their whole block.
    """
    size = F.shape[0]
    transpose(F, P, 0, size, 0, full)
    done, last, before, sign = 0, full, 0, 1.0
    first, ahead = 0, min(BLOCK, full)  # columns from ``ahead`` on lack the pivots from ``first`` on
    while done < full:
        if done == last:  # the rest failed: after other pivots they may not
            if done == before:
                break
            before, last = done, full
        if done == ahead:
            catch_up(P, first, done, ahead, full)
            first, ahead = done, min(done + BLOCK, full)
        column = P[done]
        best, pivot, larger = 0.0, done, 0
        for i in range(done, full):
            here = abs(column[i])
            if here > best:
                best, pivot = here, i
        rest, limit = column[full:], best / SMALL_PIVOT
        for i in range(len(rest)):
            larger += not abs(rest[i]) <= limit
        if larger > 0 or not best > least:
            catch_up(P, first, done, ahead, full)
            first, ahead = done, min(done + BLOCK, full)
            last -= 1
            if last != done:
                swap_rows(P, 0, done, last)
                columns[done], columns[last] = columns[last], columns[done]
                sign = -sign
            continue
        if pivot != done:
            for c in range(full):
                P[c, done], P[c, pivot] = P[c, pivot], P[c, done]
            swap_rows(F, full, done, pivot)
            sign = -sign
        if column[done] < 0:
            sign = -sign
        inverse = 1 / column[done]
        below = column[done + 1 :]
        for i in range(len(below)):
            below[i] *= inverse
        for c in range(done + 1, ahead):
            take(P[c, done + 1 :], P[c, done], below)
        done += 1
    catch_up(P, first, done, ahead, full)
    return done, sign


@compiled
@lean
def transpose(A: Float, B: Float, low: int, high: int, start: int, stop: int) -> None:
    """Copy rows ``low`` to ``high`` - 1 of a matrix, their columns ``start`` to ``stop`` - 1, to columns of another.

    Four rows come at a time, for each line of memory of the other matrix is then fetched less often.
    """
    fours = high - (high - low) % 4
    for i in range(low, fours, 4):
        a, b, c, d = A[i], A[i + 1], A[i + 2], A[i + 3]
        for j in range(start, stop):
            to = B[j, i : i + 4]
            to[0], to[1], to[2], to[3] = a[j], b[j], c[j], d[j]
    for i in range(fours, high):
        a = A[i]
        for j in range(start, stop):
            B[j, i] = a[j]


@compiled
@lean
def catch_up(P: Float, first: int, done: int, ahead: int, full: int) -> None:
    """Apply pivots ``first`` to ``done`` - 1, at most BLOCK, to columns ``ahead`` to ``full`` - 1: rows of ``P``."""
    for c in range(ahead, full):
        solve_above(P, first, done, P[c])
    if done - first == BLOCK:  # factors by rows or by columns: [:, :] makes one type of both, compiled once
        take_block(P, 0, P.T[:, :], P, first, ahead, full, done)
        return
    for j in range(first, done):
        for c in range(ahead, full):
            take(P[c, done:], P[c, j], P[j, done:])


@compiled
@lean
@fused
def solve_above(P: Float, first: int, done: int, column: Float) -> None:
    """Apply pivots ``first`` to ``done`` - 1 to each other's rows of a ``column``."""
    for i in range(first + 1, done):
        here = column[i]
        for j in range(first, i):
            here -= column[j] * P[j, i]
        column[i] = here


@compiled
@lean
def swap_rows(F: Float, start: int, one: int, two: int) -> None:
    """Exchange two rows from column ``start`` on."""
    a, b = F[one, start:], F[two, start:]
    for j in range(len(a)):
        a[j], b[j] = b[j], a[j]


@compiled
@lean
@fused
def take(row: Float, factor: float, other: Float) -> None:
    """Take ``factor`` times another row away from one."""
    if factor != 0.0:
        for c in range(len(row)):
            row[c] -= factor * other[c]


@compiled
@lean
def finish(F: Float, P: Float, X: Float, full: int) -> None:
    """Write the rows of the pivots that ``eliminate`` found to ``X`` (done, at least t + 2 - done), from them on.

    Columns that wait are written to the other rows of the front. The rows of pivots come BLOCK by BLOCK, and one by one
    within a block, for each needs those before it.
    """
    size, done = F.shape[0], len(X)
    skip, many = full - done, done - done % BLOCK
    for i in range(done):
        row, into = F[i, full:], X[i, skip:]
        for j in range(len(into)):
            into[j] = row[j]
        for j in range(skip):
            X[i, j] = P[done + j, i]
    transpose(P, F, done, full, done, size)
    for first in range(0, many, BLOCK):
        take_own(X, P, first, skip)
        take_block(X, 0, P[:, :], X, first, first + BLOCK, done, skip)
    for i in range(many + 1, done):
        for j in range(many, i):
            take(X[i, skip:], P[j, i], X[j, skip:])


@compiled
@lean
def apply_pivots(F: Float, shift: int, P: Float, X: Float, low: int, high: int, skip: int) -> None:
    """Apply all pivots, with rows ``X``, to rows ``low`` to ``high`` - 1 of a front.

    Columns of F from ``shift`` on go with those of X; the first ``skip`` of these are done with.
    """
    done = len(X)
    many = done - done % BLOCK
    for first in range(0, many, BLOCK):
        take_block(F, shift, P[:, :], X, first, low, high, skip)
    for j in range(many, done):
        for i in range(low, high):
            take(F[i, shift + skip :], P[j, i], X[j, skip:])


@compiled
@lean
@fused
def take_own(X: Float, P: Float, first: int, skip: int) -> None:
    """Apply BLOCK pivots from ``first`` on to each other's rows, from column ``skip`` on."""
    x0, x1, x2 = X[first, skip:], X[first + 1, skip:], X[first + 2, skip:]
    x3, x4, x5 = X[first + 3, skip:], X[first + 4, skip:], X[first + 5, skip:]
    f0, f1, f2, f3, f4 = P[first], P[first + 1], P[first + 2], P[first + 3], P[first + 4]
    one, two, three, four, five = first + 1, first + 2, first + 3, first + 4, first + 5
    b0, c0, d0, e0, g0 = f0[one], f0[two], f0[three], f0[four], f0[five]
    c1, d1, e1, g1 = f1[two], f1[three], f1[four], f1[five]
    d2, e2, g2 = f2[three], f2[four], f2[five]
    e3, g3, g4 = f3[four], f3[five], f4[five]
    for k in range(len(x0)):
        y0 = x0[k]
        y1 = x1[k] - b0 * y0
        y2 = x2[k] - (c0 * y0 + c1 * y1)
        y3 = x3[k] - (d0 * y0 + d1 * y1 + d2 * y2)
        y4 = x4[k] - (e0 * y0 + e1 * y1 + e2 * y2 + e3 * y3)
        x1[k], x2[k], x3[k], x4[k] = y1, y2, y3, y4
        x5[k] -= g0 * y0 + g1 * y1 + g2 * y2 + g3 * y3 + g4 * y4


@compiled
@lean
@fused
def take_block(F: Float, shift: int, factors: Float, X: Float, j: int, low: int, high: int, skip: int) -> None:
    """Apply BLOCK pivots from j on, with rows ``X``, to rows ``low`` to ``high`` - 1 of a front, by their ``factors``.

    Columns of F from ``shift`` on go with those of X; the first ``skip`` of these are done with. Four rows come at a
    time: what is read once serves many products.
    """
    x0, x1, x2 = X[j, skip:], X[j + 1, skip:], X[j + 2, skip:]
    x3, x4, x5 = X[j + 3, skip:], X[j + 4, skip:], X[j + 5, skip:]
    f0, f1, f2 = factors[j], factors[j + 1], factors[j + 2]
    f3, f4, f5 = factors[j + 3], factors[j + 4], factors[j + 5]
    width, at, fours = len(x0), shift + skip, high - (high - low) % 4
    for i in range(low, fours, 4):
        a, b, c, d = F[i, at:], F[i + 1, at:], F[i + 2, at:], F[i + 3, at:]
        a0, a1, a2, a3, a4, a5 = f0[i], f1[i], f2[i], f3[i], f4[i], f5[i]
        b0, b1, b2, b3, b4, b5 = f0[i + 1], f1[i + 1], f2[i + 1], f3[i + 1], f4[i + 1], f5[i + 1]
        c0, c1, c2, c3, c4, c5 = f0[i + 2], f1[i + 2], f2[i + 2], f3[i + 2], f4[i + 2], f5[i + 2]
        d0, d1, d2, d3, d4, d5 = f0[i + 3], f1[i + 3], f2[i + 3], f3[i + 3], f4[i + 3], f5[i + 3]
        for k in range(width):
            y0, y1, y2, y3, y4, y5 = x0[k], x1[k], x2[k], x3[k], x4[k], x5[k]
            a[k] -= a0 * y0 + a1 * y1 + a2 * y2 + a3 * y3 + a4 * y4 + a5 * y5
            b[k] -= b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3 + b4 * y4 + b5 * y5
            c[k] -= c0 * y0 + c1 * y1 + c2 * y2 + c3 * y3 + c4 * y4 + c5 * y5
            d[k] -= d0 * y0 + d1 * y1 + d2 * y2 + d3 * y3 + d4 * y4 + d5 * y5
    for i in range(fours, high):
        a = F[i, at:]
        a0, a1, a2, a3, a4, a5 = f0[i], f1[i], f2[i], f3[i], f4[i], f5[i]
        for k in range(width):
            a[k] -= a0 * x0[k] + a1 * x1[k] + a2 * x2[k] + a3 * x3[k] + a4 * x4[k] + a5 * x5[k]
