"""Half-spaces a·x <= 1 in any dimension, for many points at a time."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float

PIECE = 4_000_000  # numbers that are in memory at a time, 32 MB


def largest_row(A: Float, points: Float) -> Float:
    """Return the largest entry (n,) of A x for each x of ``points`` (n, d); -inf if A (m, d) has no rows.

    Points are processed in pieces that fit into memory.
    """
    step = max(1, PIECE // max(len(A), 1))
    pieces = [(points[k : k + step] @ A.T).max(axis=1, initial=-np.inf) for k in range(0, len(points), step)]
    return np.concatenate(pieces) if pieces else np.empty(0)
