"""Weights of nodes, corrected so that sums over the nodes are integrals over what they stand for."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float

MET = 1e-5  # relative error of an integral that counts as matched
LEAST_SHARES = (0.1, 0.01)  # no corrected weight falls below this share of the given one; the larger if it can


def corrected(weights: Float, basis: Float, wanted: Float, matched: Sequence[int]) -> Float:
    """Return the weights (n,) nearest to the given ones with ``basis @ weights = wanted``.

    ``basis`` (m, n) holds the values of m functions at the nodes, and ``wanted`` (m,) their integrals. Only the first
    of them are matched, as many as one of the counts ``matched``: the first count that positive weights can match. If
    there is none, the weights remain as they are.
    """
    for count, share in itertools.product(matched, LEAST_SHARES):
        found = _corrected(weights, basis[:count], wanted[:count], share * weights)
        if found is not None:
            return found
    return weights


def _corrected(tributary: Float, basis: Float, wanted: Float, floor: Float) -> Float | None:
    """The weights nearest to ``tributary`` with ``basis @ weights = wanted`` and none below ``floor``; None if none."""
    free = np.ones(len(tributary), dtype=bool)
    weights = tributary
    while free.sum() > len(wanted):
        base = np.where(free, tributary, floor)
        metric = np.where(free, tributary, 0.0)
        multipliers, *_ = np.linalg.lstsq((basis * metric) @ basis.T, wanted - basis @ base, rcond=1e-10)
        weights = base + metric * (basis.T @ multipliers)
        if not (np.abs(basis @ weights - wanted) <= MET * np.abs(wanted) + 1e-9 * wanted[0]).all():
            return None
        low = free & (weights < floor)
        if not low.any():
            return np.asarray(weights)
        free &= ~low
    return None
