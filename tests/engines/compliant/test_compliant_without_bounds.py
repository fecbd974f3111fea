"""Asked for no bounds, the engine gives the same peaks and promises nothing below."""

from __future__ import annotations

import numpy as np

import holdfast as hf
from holdfast.engines.answers import Bound
from holdfast.engines.contract import FORCES_ONLY
from holdfast.scene.shipped import shipped_scene


def test_forces_only_saves_the_bounds_and_keeps_the_peaks() -> None:
    assembly = hf.assemble(shipped_scene("table"))
    W = np.zeros((6 * len(assembly.movable), 2))
    W[0, 0], W[8, 1] = 1.0, -1.0
    state = hf.Compliant().prepare(assembly)
    with_bounds, without = state.load_factor(W), state.load_factor(W, FORCES_ONLY)
    np.testing.assert_array_equal(with_bounds.force, without.force)
    np.testing.assert_array_equal(with_bounds.status, without.status)
    assert with_bounds.lower[0] > 0.9 * with_bounds.force[0]
    assert (with_bounds.lower_bound, without.lower_bound) == (Bound.ESTIMATED, Bound.NONE)
    assert without.lower[np.isfinite(without.force)].tolist() == [0.0] * int(np.isfinite(without.force).sum())
