"""The load path against an independent algorithm for the same model: convex programs with the dilatancy cancelled."""

import numpy as np
import pytest
from compliant_scenes import X, columns, random_pushes, shipped

from holdfast import Compliant
from holdfast.engines.compliant.fixed_point import Fixed, fixed_point
from holdfast.engines.compliant.law import levers, node_forces
from holdfast.engines.compliant.path import PEAK


def outcome(state, wrench: np.ndarray, most: int = 150) -> Fixed:
    return fixed_point(state.assembly, state.nodes, wrench, state.system.model.k, most=most).outcome


@pytest.mark.parametrize("name", ["cube", "stack", "table", "wall2x2", "v_groove"])
def test_rests_below_the_peak_and_moves_above(name: str) -> None:
    """Verdicts must never contradict the path; near collapse the plain iteration may stay undecided."""
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
    assert sum(a is not Fixed.UNDECIDED for a in answers) >= 0.6 * len(answers)


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
    motion = levers(shipped("wedged")) * found.twists.ravel()
    assert motion[2] < 0
    assert abs(motion[2]) == pytest.approx(np.abs(motion).max())
