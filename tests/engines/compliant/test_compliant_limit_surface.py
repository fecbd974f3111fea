"""Engine ``compliant`` against the coupled truth (docs/coupled_truth.md), which has no nodes, springs or paths."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import columns, even_grid, random_pushes, shipped

from holdfast import Assembly, Compliant
from holdfast.truth import coupled

Pushes = list[tuple[str, np.ndarray, np.ndarray]]


def truth(assembly: Assembly, pushes: Pushes) -> np.ndarray:
    return np.array([coupled.robustness(assembly, body, point, force)[0] for body, point, force in pushes])


def straight(assembly: Assembly, count: int, seed: int) -> Pushes:
    """Pushes straight into random faces of random boxes."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        body = assembly.movable[rng.integers(len(assembly.movable))]
        normal = rng.choice([-1.0, 1.0]) * np.eye(3)[rng.integers(3)]
        local = np.where(normal != 0, normal, rng.uniform(-1, 1, 3)) * body.shape.size / 2
        found.append((body.name, body.com_world + local, -normal))
    return found


@pytest.mark.parametrize(("name", "seed"), [("cube", 3), ("stack", 4)])
def test_any_push_on_many_nodes(name: str, seed: int) -> None:
    assembly = shipped(name)
    pushes = random_pushes(assembly, 50, seed)
    got = Compliant().on(assembly, assembly.weight_wrench(), even_grid(assembly, 41)).paths(columns(assembly, pushes))
    expected = truth(assembly, pushes)
    np.testing.assert_array_equal(np.isfinite(got.peak), np.isfinite(expected))
    np.testing.assert_allclose(got.peak, expected, rtol=0.01)
    assert np.isfinite(expected).sum() >= 35


@pytest.mark.parametrize(("nodes", "limit"), [(7, 0.02), (21, 0.01)])
@pytest.mark.parametrize("name", ["cube", "stack"])
def test_a_hundred_straight_pushes(name: str, nodes: int, limit: float) -> None:
    assembly = shipped(name)
    pushes = straight(assembly, 100, seed=11)
    got = Compliant(nodes=nodes).prepare(assembly).load_factor(columns(assembly, pushes)).factor
    expected = truth(assembly, pushes)
    np.testing.assert_array_equal(np.isfinite(got), np.isfinite(expected))
    np.testing.assert_allclose(got, expected, rtol=limit)
    assert 70 <= np.isfinite(expected).sum() < 100
