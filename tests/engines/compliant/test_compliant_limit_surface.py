"""Engine ``compliant`` against the coupled truth (bench/truth/coupled.py), which has no nodes, springs or paths."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import columns, even_grid, random_pushes
from engine_scenes import shipped

from bench.truth import coupled
from holdfast import Compliant
from holdfast.answers import Assembly

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
    pushes = random_pushes(assembly, 25, seed)
    got = (
        Compliant()
        .on(assembly, assembly.weight_wrench(), even_grid(assembly, 41))
        .grid.paths(columns(assembly, pushes))
    )
    expected = truth(assembly, pushes)
    np.testing.assert_array_equal(np.isfinite(got.peak), np.isfinite(expected))
    np.testing.assert_allclose(got.peak, expected, rtol=0.01)
    assert np.isfinite(expected).sum() >= 15


@pytest.mark.parametrize(("nodes", "limit"), [(7, 0.02), (21, 0.01)])
@pytest.mark.parametrize("name", ["cube", "stack"])
def test_a_hundred_straight_pushes(name: str, nodes: int, limit: float) -> None:
    assembly = shipped(name)
    pushes = straight(assembly, 100, seed=11)
    got = Compliant(nodes=nodes).prepare(assembly).load_factor(columns(assembly, pushes)).force
    expected = truth(assembly, pushes)
    np.testing.assert_array_equal(np.isfinite(got), np.isfinite(expected))
    np.testing.assert_allclose(got, expected, rtol=limit)
    assert 70 <= np.isfinite(expected).sum() < 100


def test_pressure_gathered_in_a_corner_is_seen_to_be_too_coarse() -> None:
    """On seven nodes a side this push reads 230 N; the truth is 143 N, and so is the limit of fine nodes."""
    cube = shipped("cube")
    (push,) = [("cube", np.array([0.0489232, 0.05, 0.00157536]), np.array([-0.30653885, -0.43417224, -0.84707048]))]
    W, (expected,) = columns(cube, [push]), truth(cube, [push])
    plain = Compliant().on(cube, cube.weight_wrench())
    assert plain.load_factor(W).force[0] > 1.5 * expected
    found = Compliant().prepare(cube).load_factor(W)
    assert found.force[0] == pytest.approx(expected, rel=0.05)
    assert found.lower[0] <= expected
