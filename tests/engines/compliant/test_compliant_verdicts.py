"""What comes to rest on elastic contacts, and what does not although an equilibrium exists."""

import numpy as np
import pytest
from compliant_scenes import SMALL, STANDING
from engine_scenes import X, block, floor, shipped

import holdfast as hf
from bench.suites.reliability import random_pushes
from holdfast import Status, stability
from holdfast.elastic.system import PathOutcome, RestOutcome
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.rest_verdict import balanced_forces, unbalanced
from holdfast.native import core


@pytest.mark.parametrize("name", STANDING)
def test_shipped_scenes_stand(name: str) -> None:
    assembly = shipped(name)
    state = hf.Compliant().prepare(assembly)
    result = state.verdict()
    assert result.status is Status.STABLE
    local = np.einsum("ikx,ix->ik", state.grid.nodes.axes, result.forces.force)
    total, each = unbalanced(state.grid.places, local, state.grid.wrench)
    assert total <= 1e-8
    assert each <= 1e-7
    assert result.residual == pytest.approx(total)
    assert "balanced" not in result.reason


@pytest.mark.parametrize(("held", "error"), [(False, 1e-8), (True, 1e-5)])
@pytest.mark.parametrize("name", ["cube", "table"])
def test_forces_that_balance_badly_are_no_rest(name: str, held: bool, error: float) -> None:
    """Contacts that are pressed by a share more carry so much more than the weight; springs may carry a little."""
    grid = hf.Compliant().prepare(shipped(name)).grid
    grid = grid.with_hold if held else grid
    q = grid.settled.q
    assert balanced_forces(grid, q) is not None
    assert balanced_forces(grid, (1 + 0.1 * error) * q) is not None
    assert balanced_forces(grid, (1 + 20 * error) * q) is None


def test_what_nothing_presses_together_falls() -> None:
    """A cube between two walls that it only touches: an equilibrium exists, and nothing brings it about."""
    result = stability(shipped("wedged"), engine="compliant")
    assert result.status is Status.UNSTABLE
    assert result.equilibrium_exists is True
    assert result.self_stress is True
    assert result.moving == ("cube",)
    np.testing.assert_allclose(
        result.mechanism.twists[0] / np.abs(result.mechanism.twists).max(), [0, 0, -1, 0, 0, 0], atol=1e-6
    )
    assert "drift" in result.reason
    pushed = hf.robustness(shipped("wedged"), "cube", (-0.05, 0, 0.15), X, engine="compliant")
    assert pushed.status[0] is Status.UNSTABLE
    assert pushed.force[0] == 0


def test_standing_loads_count() -> None:
    for share, status in ((0.99, Status.STABLE), (1.01, Status.UNSTABLE)):
        push = hf.Load("slab", (-0.25, 0, 0.225), force=share * 7.3575 * X)
        assert stability(shipped("table"), loads=[push], engine="compliant").status is status


@pytest.mark.parametrize("name", SMALL)
def test_rest_does_not_depend_on_the_way_there(name: str) -> None:
    """From bonded contacts by Newton's method, or through all the drag: the same forces."""
    system = hf.Compliant().prepare(shipped(name)).grid.system
    n = len(system.model.wrench)
    q, drift = np.zeros(n), np.zeros(n)
    work = core.Work(system.model, system.fronts)
    end = core.lessen_drag(system.model, work, 1.0, q, drift, 1e-11, 3000, None)  # from no displacement at all
    assert end.outcome == RestOutcome.RESTS
    np.testing.assert_allclose(q, system.come_to_rest().q, atol=1e-6 * np.abs(q).max())


@pytest.mark.parametrize("name", ["stack", "table", "arch", "wall2x2"])
def test_the_motion_itself_rests_below_the_peak_and_drifts_above(name: str) -> None:
    """What verdicts fall back on: the overdamped motion, followed from bonded contacts without a single longer step."""
    assembly = shipped(name)
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 3)
    paths = grid.paths(W)
    pushed = np.flatnonzero(paths.outcome == PathOutcome.PEAK)[:3]
    assert len(pushed) == 3
    m, work = grid.system.model, core.Work(grid.system.model, grid.system.fronts)
    loads = grid.loads(W)
    for k in pushed:
        for share, end in ((0.97, RestOutcome.RESTS), (1.03, RestOutcome.DRIFTS)):
            q, drift = grid.settled.q.copy(), np.zeros(len(m.wrench))
            loaded = m._replace(wrench=m.wrench + share * paths.peak[k] * loads[k])
            assert core.move(loaded, work, 1.0, q, drift, 1e-11, 6000, None).outcome == end
            if end is RestOutcome.DRIFTS:  # the load does work on it
                assert drift @ (m.wrench + share * paths.peak[k] * loads[k]) > 0


def test_what_slides_off_on_ice_takes_nothing_along() -> None:
    """A plank lies on a shelf, and with its end on a heavy block on ice that nothing holds, on ice, too."""
    bodies = [
        floor(),
        block("shelf", (0.1, 0.1, 0.1), (0.15, 0, 0.05), fixed=True),
        block("low", (0.1, 0.1, 0.1), (0, 0, 0.05), 5.0),
        block("plank", (0.3, 0.1, 0.02), (0.15, 0, 0.11), 0.1),
    ]
    ice = hf.Friction(0.5, {("floor", "low"): 0.0, ("low", "plank"): 0.0})
    assembly = hf.assemble(hf.Scene(bodies, ice, (0, 2, -9.81)))
    end = Grid.of(assembly, assembly.weight_wrench(), hf.Compliant().springs).settled
    assert end.outcome is RestOutcome.DRIFTS
    low, plank = end.drift.reshape(-1, 6) @ np.eye(6)[:, :3]
    assert low @ (assembly.axes @ [0, 1, 0]) > 0.99 * np.linalg.norm(low)
    assert np.linalg.norm(plank) < 1e-3 * np.linalg.norm(low)


def resting(shape: object, height: float, turned: np.ndarray | None = None) -> hf.answers.Assembly:
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) if turned is None else turned
    pose[2, 3] = height
    return hf.assemble(hf.Scene([floor(), hf.Body("it", shape, mass=1.0, pose=pose)], 0.5))


EDGE = np.array([[1, 0, 0], [0, 1, -1], [0, 1, 1]]) / np.array([[1], [2**0.5], [2**0.5]])
CORNER = np.array([[1, -1, 0], [1, 1, -2], [1, 1, 1]]) / np.sqrt([[2], [6], [3]])
LYING = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
BOX = hf.Box((0.1, 0.1, 0.1))


@pytest.mark.parametrize(
    ("shape", "height", "turned", "only_balanced"),
    [
        pytest.param(BOX, 0.05, None, False, id="cube on a face"),
        pytest.param(BOX, 0.05 * 2**0.5, EDGE, True, id="cube on an edge"),
        pytest.param(BOX, 0.05 * 3**0.5, CORNER, True, id="cube on a corner"),
        pytest.param(hf.Sphere(0.05), 0.05, None, True, id="sphere"),
        pytest.param(hf.Cylinder(0.05, 0.2), 0.05, LYING, True, id="cylinder on its side"),
        pytest.param(hf.Cylinder(0.05, 0.2), 0.1, None, False, id="cylinder on its base"),
        pytest.param(hf.Box((0.004, 0.004, 0.004)), 0.002, None, False, id="small cube"),
    ],
)
def test_what_is_only_balanced_is_said_to_be(
    shape: object, height: float, turned: np.ndarray | None, only_balanced: bool
) -> None:
    result = stability(resting(shape, height, turned), engine="compliant")
    assert result.status is Status.STABLE
    assert ("only balanced" in result.reason) is only_balanced
    assert ("side: it" in result.reason) is only_balanced
