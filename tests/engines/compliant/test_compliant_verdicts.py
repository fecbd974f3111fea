"""What comes to rest on elastic contacts, and what does not although an equilibrium exists."""

import json
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from compliant_scenes import SMALL, STANDING
from engine_scenes import X, floor, shipped

import holdfast as hf
from bench.suites.reliability import random_pushes
from holdfast import Status, stability
from holdfast.elastic.linear import make_work
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.resting import lessen_drag, move
from holdfast.engines.compliant.bisection import with_bisected_peaks
from holdfast.engines.compliant.rest_verdict import unbalanced

CASES = Path(__file__).parents[4] / "shared" / "cases"
LARGE = {"armadillo": [pytest.mark.slow]}  # masonry_crossvault below is as large, and looked at by default
PUBLISHED = [
    pytest.param(p, id=p.stem, marks=LARGE.get(p.stem, [])) for p in sorted((CASES / "published").glob("*.json"))
]
needed = pytest.mark.skipif(not PUBLISHED, reason=f"needs the case files in {CASES}")
STAND_UNCHECKED = {"bridge", "snake", "shelf_stable", "concave_long_0", "cube_curve_short", "armadillo"}
SELF_STRESSED = {"model_A", "wedge_a_x90", "wedge_a_xy3090"}
ANGLE = {"cube_curve_short": 5.0}  # its faces are warped


@cache
def case(path: Path) -> tuple[dict, hf.Scene]:
    return json.loads(path.read_text()), hf.load_scene(path)


def check(path: Path, assembly: hf.answers.Assembly) -> None:
    expected = case(path)[0]["expected"]
    stands = expected["stands"] if expected["stands"] is not None else path.stem in STAND_UNCHECKED
    result = stability(assembly, engine="compliant")
    assert result.status is (Status.STABLE if stands else Status.UNSTABLE)
    if stands:
        assert result.residual <= 1e-8
        forces = result.forces
        assert (np.einsum("ix,ix->i", forces.force, forces.normal) >= 0).all()
        assert forces.usage.max() <= 1 + 1e-9
    else:
        assert result.moving
        assert result.mechanism is not None
        assert result.equilibrium_exists is expected["equilibrium_exists"]
        assert (result.certificate is None) == (path.stem in SELF_STRESSED)


@needed
@pytest.mark.parametrize("path", PUBLISHED)
def test_published_interfaces(path: Path) -> None:
    data, scene = case(path)
    given = [hf.answers.Interface(tuple(i["between"]), i["polygon"], i["normal"]) for i in data["interfaces"]]
    check(path, hf.assemble(scene, interfaces=given))


@needed
@pytest.mark.parametrize("path", PUBLISHED)
def test_detected_interfaces(path: Path) -> None:
    if path.stem == "armadillo":
        pytest.skip("385 pairs of its blocks overlap: it needs a gap of 50 mm and 20 degrees, tested below")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        check(path, hf.assemble(case(path)[1], angle_degrees=ANGLE.get(path.stem)))


@needed
@pytest.mark.parametrize(
    ("name", "tolerances"),
    [
        ("jenga12", {}),
        ("lack_table", {"gap": 1e-3, "angle_degrees": 3}),
        ("masonry_wall", {}),
        ("masonry_crossvault", {}),
    ],
)
def test_settled_scenes_stand(name: str, tolerances: dict) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        assembly = hf.assemble(hf.load_scene(CASES / "settled" / f"{name}.json"), **tolerances)
    result = stability(assembly, engine="compliant")
    assert result.status is Status.STABLE
    assert result.residual <= 1e-8


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
    work = make_work(system.model, system.fronts)
    end = lessen_drag(system.model, work, 1.0, q, drift, 1e-11, 3000, None)  # from no displacement at all
    assert end.outcome is RestOutcome.RESTS
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
    m, work = grid.system.model, make_work(grid.system.model, grid.system.fronts)
    loads = grid.loads(W)
    for k in pushed:
        for share, end in ((0.97, RestOutcome.RESTS), (1.03, RestOutcome.DRIFTS)):
            q, drift = grid.settled.q.copy(), np.zeros(len(m.wrench))
            loaded = m._replace(wrench=m.wrench + share * paths.peak[k] * loads[k])
            assert move(loaded, work, 1.0, q, drift, 1e-11, 6000, None).outcome is end
            if end is RestOutcome.DRIFTS:  # the load does work on it
                assert drift @ (m.wrench + share * paths.peak[k] * loads[k]) > 0


@pytest.mark.parametrize("name", ["stack", "table", "arch", "cantilever"])
def test_a_lost_path_is_found_again_by_verdicts(name: str) -> None:
    """Paths given up at 60 to 99 % of their peak: verdicts lead to the same peak, or slightly beside it."""
    assembly = shipped(name)
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 4)
    W = W[:, np.flatnonzero(grid.paths(W).outcome == PathOutcome.PEAK)[:3]]
    paths = grid.paths(W)
    lost = paths._replace(
        outcome=np.full(3, PathOutcome.LOST), peak=paths.peak * (0.6, 0.9, 0.99), q=np.tile(grid.settled.q, (3, 1))
    )
    found = with_bisected_peaks(grid, W, lost)
    assert (found.outcome == PathOutcome.PEAK).all()
    np.testing.assert_allclose(found.peak, paths.peak, rtol=5e-3)
    assert (found.peak <= paths.peak * (1 + 4e-3)).all()  # a path may end a little below its peak


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


@pytest.mark.parametrize("name", STANDING)
def test_shipped_scenes_are_more_than_balanced(name: str) -> None:
    assert "balanced" not in stability(shipped(name), engine="compliant").reason
