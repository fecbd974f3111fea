"""Correction of node weights, so that sums over the nodes equal integrals over the patch that they represent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float
from holdfast.native import core

LEAST = 0.02  # share of the mean weight that is added to every spot or node of merged patches before a correction


def corrected(weights: Float, basis: Float, wanted: Float, matched: Sequence[int]) -> Float:
    """Return the weights (n,) nearest to the given ones with ``basis @ weights = wanted``.

    ``basis`` (m, n) holds the values of m functions at the nodes, and ``wanted`` (m,) their integrals. Only the first
    of them are matched, as many as one of the counts ``matched``: the first count that positive weights can match. If
    there is none, the weights remain as they are.
    """
    return core.corrected(weights, np.ascontiguousarray(basis), wanted, np.array(matched))
