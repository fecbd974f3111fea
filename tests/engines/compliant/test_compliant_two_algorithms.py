"""The load path against an independent algorithm for the same model: convex programs with the dilatancy cancelled."""

import numpy as np
import pytest
from compliant_scenes import X, columns, random_pushes, shipped

from holdfast import Compliant
from holdfast.engines.compliant.fixed_point import Fixed, fixed_point
from holdfast.engines.compliant.law import node_forces
from holdfast.engines.compliant.path import PEAK


def outcome(state, wrench: np.ndarray, most: int = 150) -> Fixed:
    return fixed_point(state.assembly, state.nodes, wrench, state.system.model.k, most=most).outcome


@pytest.mark.parametrize(
    ("name", "decided"), [("cube", 0.8), ("stack", 0.9), ("table", 1.0), ("tall_table", 0.8), ("v_groove", 0.5)]
)
def test_rests_below_the_peak_and_moves_above(name: str, decided: float) -> None:
    """Verdicts must never contradict the path; near collapse the plain iteration may stay undecided.

    Walls are left out: bricks that meet head to head can come to rest in other ways than the path's.
    """
    assembly = shipped(name)
    state = Compliant(nodes=5).prepare(assembly)
    W = columns(assembly, random_pushes(assembly, 8, 21))
    paths = state.paths(W)
    answers = []
    for k in np.flatnonzero(paths.kind == PEAK):
        below = outcome(state, state.wrench + 0.98 * paths.peak[k] * W[:, k])
        above = outcome(state, state.wrench + 1.02 * paths.peak[k] * W[:, k])
        assert below is not Fixed.MOVES
        assert above is not Fixed.RESTS
        answers += [below, above]
    assert len(answers) >= 10
    assert sum(a is not Fixed.UNDECIDED for a in answers) >= decided * len(answers)


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
