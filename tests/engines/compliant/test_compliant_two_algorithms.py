"""The load path against an independent algorithm for the same model: convex programs with the dilatancy cancelled."""

import numpy as np
import pytest
from compliant_scenes import X, shipped

from holdfast import Compliant
from holdfast.elastic.law import node_forces
from holdfast.elastic.path import PEAK
from holdfast.engines.compliant.fixed_point import Fixed, fixed_point
from holdfast.validation.benchmarks.reliability import random_pushes


def outcome(state, wrench: np.ndarray, most: int = 150) -> Fixed:
    return fixed_point(state.assembly, state.nodes, wrench, state.system.model.k, most=most).outcome


def agreement(name: str, count: int) -> tuple[int, int]:
    """Verdicts beside the peaks of ``count`` random pushes, and how many came to one; none may contradict the path."""
    assembly = shipped(name)
    state = Compliant(nodes=5).prepare(assembly)
    W = random_pushes(assembly, 5 * count, 5)
    paths = state.paths(W)
    answers = []
    for k in np.flatnonzero(paths.kind == PEAK)[:count]:
        below = outcome(state, state.wrench + 0.98 * paths.peak[k] * W[:, k])
        above = outcome(state, state.wrench + 1.02 * paths.peak[k] * W[:, k])
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
    state = Compliant(nodes=5).prepare(shipped(name))
    other = fixed_point(state.assembly, state.nodes, state.wrench, state.system.model.k)
    assert other.outcome is Fixed.RESTS
    forces = np.zeros((len(state.nodes), 3))
    node_forces(state.system.model, state.start, forces)
    np.testing.assert_allclose(other.forces, forces * state.assembly.weight, atol=1e-5 * state.assembly.weight)


def test_no_equilibrium_and_no_way_to_it() -> None:
    cube = Compliant(nodes=5).prepare(shipped("cube"))
    push = np.r_[7 * X, np.zeros(3)]  # more than μ m g
    assert outcome(cube, cube.wrench + push) is Fixed.MOVES
    wedged = Compliant(nodes=5).on(shipped("wedged"), shipped("wedged").weight_wrench())
    found = fixed_point(shipped("wedged"), wedged.nodes, wedged.wrench, wedged.nodes.weights)
    assert found.outcome is Fixed.MOVES
    assert found.twists[0, 2] < 0
    assert -found.twists[0, 2] == pytest.approx(np.abs(found.twists).max())
