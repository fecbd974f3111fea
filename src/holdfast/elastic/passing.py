"""What is left of a front after elimination goes to the front that takes it (fronts.py), piece by piece.

The last of the fronts that one takes from comes right before it: what is left of it is written to where the other one
will stand, row by row while the processor still holds them, and zeros to where nothing goes. What is left of the others
is kept until then, and added.
"""

from __future__ import annotations

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.elastic.elimination import apply_pivots
from holdfast.elastic.ordering import Fronts

ROWS = 32  # rows that take over all pivots of a block before the next rows are read


@compiled
@lean
def place_of(slot: int, owned: int, waiting: int) -> int:
    """Where the rows of a body begin in a front whose own bodies are followed by ``waiting`` rows."""
    return 6 * slot if slot < owned else 6 * slot + waiting


@compiled
@lean
def find_pieces(e: Fronts, child: int, waits: int, at: int, k: int, full: int, size: int, piece: Int) -> int:
    """Find which rows and columns of what is left of a ``child`` stay together in front k, of ``size`` rows.

    The first ``waits`` wait for a pivot, and go to the place ``at``; ``full``: rows of front k before those that stay.
    Writes into ``piece`` (as many as bodies, and two; 3) where each begins, how many it has, and where it goes; returns
    their number. The last ends with the border and two right-hand sides.
    """
    owned, i, count = e.owned[k], waits, with_piece(piece, 0, 0, waits, at)
    for slot in range(e.first[child] + e.owned[child], e.first[child + 1]):
        count = with_piece(piece, count, i, 6, place_of(e.onward[slot], owned, full - 6 * owned))
        i += 6
    return with_piece(piece, count, i, 3, size - 1)


@compiled
@lean
def with_piece(piece: Int, count: int, start: int, length: int, to: int) -> int:
    """Write one more piece, or make the last one longer; returns their number."""
    if length == 0:
        return count
    if count > 0:
        last = piece[count - 1]
        if last[0] + last[1] == start and last[2] + last[1] == to:
            last[1] += length
            return count
    piece[count, 0], piece[count, 1], piece[count, 2] = start, length, to
    return count + 1


@compiled
@lean
def pass_on(F: Float, P: Float, X: Float, full: int, G: Float, piece: Int, count: int, place: Int) -> None:
    """Apply the pivots of a front to its other rows, and write these, by ``count`` pieces, to another matrix ``G``.

    ``F``, ``P`` and ``X`` are as ``eliminate`` and ``finish`` leave them; G holds anything before, and zeros where
    nothing comes to. ``place`` (as many as rows) is scratch.
    """
    done, size, end = len(X), F.shape[0], 0
    for p in range(count):
        start, to = piece[p, 0], piece[p, 2]
        for i in range(end, to):  # where nothing comes to, or what is written below
            row = G[i]
            for j in range(len(row)):
                row[j] = 0.0
        for i in range(min(piece[p, 1], size - done - start)):
            place[start + i] = to + i
        end = to + piece[p, 1]
    for low in range(done, size, ROWS):
        high = min(low + ROWS, size)
        apply_pivots(F, done, P, X, low, high, full - done)
        for i in range(low, high):
            move_row(F[i, done:], G[place[i - done]], piece, count)


@compiled
@lean
def move_row(row: Float, into: Float, piece: Int, count: int) -> None:
    """Copy the pieces of a ``row`` to another one, which is zero but for them."""
    for j in range(len(into)):
        into[j] = 0.0
    for p in range(count):
        start, length, to = piece[p, 0], piece[p, 1], piece[p, 2]
        here, there = row[start : start + length], into[to : to + length]
        for j in range(length):
            there[j] = here[j]


@compiled
@lean
def add_rows(left: Float, width: int, size: int, done: int, F: Float, piece: Int, count: int) -> None:
    """Add to a front, by ``count`` pieces, what ``done`` pivots left of another one: (size, width), in ``left``."""
    for p in range(count):
        start, to = done + piece[p, 0], piece[p, 2]
        for i in range(min(piece[p, 1], size - start)):
            add_row(left[(start + i) * width + done : (start + i + 1) * width], F[to + i], piece, count)


@compiled
@lean
def add_row(row: Float, into: Float, piece: Int, count: int) -> None:
    """Add the pieces of a ``row`` to another one."""
    for p in range(count):
        start, length, to = piece[p, 0], piece[p, 1], piece[p, 2]
        here, there = row[start : start + length], into[to : to + length]
        for j in range(length):
            there[j] += here[j]
