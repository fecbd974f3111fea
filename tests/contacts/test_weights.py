"""Weights of nodes that are corrected so that sums over nodes are integrals."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.contacts.spots import corrected


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("twice", [False, True])
def test_corrected_weights_are_the_nearest_that_integrate_exactly(seed: int, twice: bool) -> None:
    """Nearest in the sum of squares over the given weights; also where functions at the nodes depend on each other."""
    random = np.random.default_rng(seed)
    given, basis = random.uniform(1, 2, 30), np.vstack([np.ones(30), random.normal(size=(3, 30))])
    if twice:
        basis = np.vstack([basis, basis[1] + basis[2], basis[3] * (1 + 1e-9)])
    wanted = basis @ (given * random.uniform(0.95, 1.05, 30))
    found = corrected(given, basis, wanted, (len(basis),))
    np.testing.assert_allclose(basis @ found, wanted, rtol=1e-7, atol=1e-7)
    root = np.sqrt(given)
    shortest = np.linalg.lstsq(basis[:4] * root, wanted[:4] - basis[:4] @ given, rcond=None)[0]
    np.testing.assert_allclose(found, given + root * shortest, rtol=1e-6)


def test_weights_that_would_be_too_small_are_held_and_the_others_make_up_for_them() -> None:
    x = np.linspace(-1, 1, 11)
    given, basis = np.ones(11), np.array([np.ones(11), x])
    found = corrected(given, basis, np.array([11.0, 6.0]), (2,))
    np.testing.assert_allclose(basis @ found, [11, 6], rtol=1e-7)
    assert found.min() == pytest.approx(0.1)
    assert (np.diff(found) >= -1e-12).all()
