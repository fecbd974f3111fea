"""Half-spaces a·x <= 1 in any dimension, many at a time."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float

PIECE = 4_000_000  # numbers held at a time: 32 MB


def largest_row(A: Float, points: Float) -> Float:
    """(n,) the largest of A x for each point x of (n, d), in pieces that fit into memory; -inf where A has no rows."""
    step = max(1, PIECE // max(len(A), 1))
    pieces = [(points[k : k + step] @ A.T).max(axis=1, initial=-np.inf) for k in range(0, len(points), step)]
    return np.concatenate(pieces) if pieces else np.empty(0)
