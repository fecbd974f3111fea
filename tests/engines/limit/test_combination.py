"""Bounds from combinations of known loads, on a gauge known in closed form."""

from __future__ import annotations

import numpy as np

from holdfast.engines.limit.combination import combined


def test_what_a_combination_misses_is_paid_for() -> None:
    """γ(w) = |D w| is a gauge known in closed form: no bound may fall below it, inside or outside the known loads."""
    rng = np.random.default_rng(0)
    D = rng.normal(size=(6, 6))
    ahead = np.array([3.0, 0, 0, 0, 0, 0])
    known = rng.normal(size=(40, 6)) + ahead
    points = np.vstack([rng.normal(size=(60, 6)), rng.normal(size=(60, 6)) * 0.3 + ahead])
    near = np.argsort(((points[:, None] - known) ** 2).sum(2), axis=1)[:, :10]
    gauge = np.linalg.norm(known @ D.T, axis=1)
    axes = np.tile(np.linalg.norm(D, axis=0), (2, 1))
    bound = combined(points, known, near.astype(np.int64), gauge, axes)
    exact = np.linalg.norm(points @ D.T, axis=1)
    assert (bound >= exact * (1 - 1e-9)).all()
    np.testing.assert_allclose(
        combined(2 * known, known, near[:40] * 0 + np.arange(40)[:, None], gauge, axes), 2 * gauge
    )
