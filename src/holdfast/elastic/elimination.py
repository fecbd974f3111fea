"""Elimination within a front (fronts.py): pivots by columns, those too small left waiting, and rows in blocks."""

from __future__ import annotations

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, fused, lean

SMALL_PIVOT = 0.02  # share of a column's largest entry below which no entry is used as pivot
BLOCK = 6  # pivots that are applied together


@compiled
@lean
def eliminate(F: Float, P: Float, columns: Int, full: int, least: float) -> tuple[int, float]:
    """Eliminate in a front (t, t + 2) what its first ``full`` rows and columns allow, with pivots above ``least``.

    Returns the number of pivots, which come first in the new order of rows and columns, and the sign of their product
    and of the new order. The last two columns are right-hand sides. The first ``full`` columns are worked on as rows of
    ``P`` (full, t), along which memory runs. Of pivots in their own rows, columns before them are not kept.

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
        best, pivot, top = 0.0, done, 0.0
        for i in range(done, full):
            here = abs(column[i])
            if here > best:
                best, pivot = here, i
        for i in range(done, size):
            top = max(top, abs(column[i]))
        if not (best > least and best >= SMALL_PIVOT * top):
            catch_up(P, first, done, ahead, full)
            first, ahead = done, min(done + BLOCK, full)
            last -= 1
            if last != done:
                swap_rows(P, done, last)
                columns[done], columns[last] = columns[last], columns[done]
                sign = -sign
            continue
        if pivot != done:
            for c in range(full):
                P[c, done], P[c, pivot] = P[c, pivot], P[c, done]
            swap_rows(F[:, full:], done, pivot)
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
    transpose(P, F, 0, full, 0, done)
    transpose(P, F, done, full, done, size)
    complete(F, P, done, full)
    return done, sign


@compiled
@lean
def transpose(A: Float, B: Float, low: int, high: int, start: int, stop: int) -> None:
    """Copy rows ``low`` to ``high`` - 1 of a matrix, their columns ``start`` to ``stop`` - 1, to columns of another."""
    for i in range(low, high):
        row = A[i]
        for j in range(start, stop):
            B[j, i] = row[j]


@compiled
@lean
@fused
def catch_up(P: Float, first: int, done: int, ahead: int, full: int) -> None:
    """Apply pivots ``first`` to ``done`` - 1, at most BLOCK, to columns ``ahead`` to ``full`` - 1: rows of ``P``."""
    for c in range(ahead, full):
        row = P[c]
        for j in range(first, done):
            take(row[j + 1 : done], row[j], P[j, j + 1 : done])
        if done - first < BLOCK:
            for j in range(first, done):
                take(row[done:], row[j], P[j, done:])
            continue
        x0, x1, x2 = P[first, done:], P[first + 1, done:], P[first + 2, done:]
        x3, x4, x5 = P[first + 3, done:], P[first + 4, done:], P[first + 5, done:]
        f0, f1, f2, f3, f4, f5 = (
            row[first],
            row[first + 1],
            row[first + 2],
            row[first + 3],
            row[first + 4],
            row[first + 5],
        )
        a = row[done:]
        for k in range(len(a)):
            a[k] -= f0 * x0[k] + f1 * x1[k] + f2 * x2[k] + f3 * x3[k] + f4 * x4[k] + f5 * x5[k]


@compiled
@lean
def swap_rows(F: Float, one: int, two: int) -> None:
    """Exchange two rows."""
    for j in range(F.shape[1]):
        F[one, j], F[two, j] = F[two, j], F[one, j]


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
@fused
def complete(F: Float, P: Float, done: int, full: int) -> None:
    """Apply ``done`` pivots, whose factors are the rows of ``P``, to the columns of a front from ``full`` on.

    The rows of pivots come BLOCK by BLOCK, and one by one within a block, for each needs those before it.
    """
    size, many = F.shape[0], done - done % BLOCK
    for first in range(0, many, BLOCK):
        take_blocks(F, P, first, first + BLOCK, first, full)
        take_own(F, P, first, full)
    take_blocks(F, P, many, size, many, full)
    for i in range(many + 1, size):
        for j in range(many, min(i, done)):
            take(F[i, full:], P[j, i], F[j, full:])


@compiled
@lean
@fused
def take_own(F: Float, P: Float, first: int, full: int) -> None:
    """Apply BLOCK pivots from ``first`` on to each other's rows, from column ``full`` on."""
    x0, x1, x2 = F[first, full:], F[first + 1, full:], F[first + 2, full:]
    x3, x4, x5 = F[first + 3, full:], F[first + 4, full:], F[first + 5, full:]
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
def take_blocks(F: Float, P: Float, low: int, high: int, count: int, full: int) -> None:
    """Apply the first ``count`` pivots, a multiple of BLOCK, to rows ``low`` to ``high`` - 1, from column ``full`` on.

    Four rows come at a time, with six pivots at a time: what is read once serves many products.
    """
    width, fours = F.shape[1] - full, high - (high - low) % 4
    for j in range(0, count, BLOCK):
        x0, x1, x2 = F[j, full:], F[j + 1, full:], F[j + 2, full:]
        x3, x4, x5 = F[j + 3, full:], F[j + 4, full:], F[j + 5, full:]
        f0, f1, f2, f3, f4, f5 = P[j], P[j + 1], P[j + 2], P[j + 3], P[j + 4], P[j + 5]
        for i in range(low, fours, 4):
            a, b, c, d = F[i, full:], F[i + 1, full:], F[i + 2, full:], F[i + 3, full:]
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
            a = F[i, full:]
            a0, a1, a2, a3, a4, a5 = f0[i], f1[i], f2[i], f3[i], f4[i], f5[i]
            for k in range(width):
                a[k] -= a0 * x0[k] + a1 * x1[k] + a2 * x2[k] + a3 * x3[k] + a4 * x4[k] + a5 * x5[k]
