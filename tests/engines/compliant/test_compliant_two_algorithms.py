"""The load path against an independent algorithm for the same model: convex programs with the dilatancy cancelled."""

import numpy as np
import pytest
from engine_scenes import shipped

from bench.baselines.fixed_point import Fixed, fixed_point
from bench.suites.reliability import random_pushes
from holdfast import Compliant
from holdfast.elastic.system import PathOutcome
from holdfast.native import core


def outcome(grid, wrench: np.ndarray, most: int = 150) -> Fixed:
    return fixed_point(grid.assembly, grid.nodes, wrench, grid.system.model.k, most=most).outcome


def agreement(name: str, count: int) -> tuple[int, int]:
    """Verdicts beside the peaks of ``count`` random pushes, and how many came to one; none may contradict the path."""
    assembly = shipped(name)
    grid = Compliant(nodes=5).prepare(assembly).grid
    W = random_pushes(assembly, 5 * count, 5)
    paths = grid.paths(W)
    answers = []
    for k in np.flatnonzero(paths.outcome == PathOutcome.PEAK)[:count]:
        below = outcome(grid, grid.wrench + 0.98 * paths.peak[k] * W[:, k])
        above = outcome(grid, grid.wrench + 1.02 * paths.peak[k] * W[:, k])
        assert below is not Fixed.MOVES
        assert above is not Fixed.RESTS
        answers += [below, above]
    return len(answers), sum(a is not Fixed.UNDECIDED for a in answers)


@pytest.mark.parametrize("name", ["cube", "stack", "table", "slope", "cantilever"])
def test_rests_below_the_peak_and_moves_above(name: str) -> None:
    assert agreement(name, 2) == (4, 4)


@pytest.mark.slow
def test_a_hundred_pushes_rest_below_the_peak_and_move_above() -> None:
    """On arches and grooves growth settles slowly: some stay undecided."""
    names = ["cube", "stack", "table", "tall_table", "v_groove", "slope", "wall2x2", "arch", "cantilever"]
    given, decided = np.sum([agreement(name, 12) for name in names], axis=0)
    assert given >= 200
    assert decided >= 0.9 * given


@pytest.mark.parametrize("name", ["cube", "stack", "table", "arch", "slope"])
def test_the_same_forces_at_rest(name: str) -> None:
    grid = Compliant(nodes=5).prepare(shipped(name)).grid
    other = fixed_point(grid.assembly, grid.nodes, grid.wrench, grid.system.model.k)
    assert other.outcome is Fixed.RESTS
    forces = np.zeros((len(grid.nodes), 3))
    core.node_forces(grid.system.model, grid.settled.q, forces)
    np.testing.assert_allclose(other.forces, forces * grid.assembly.weight, atol=1e-5 * grid.assembly.weight)
