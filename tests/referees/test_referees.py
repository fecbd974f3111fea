"""Engine ``compliant`` against three dynamic simulations: two optional codes and our own discrete elements.

The whole comparison (30 queries, fine nodes) is ``python tests/referees/referee_table.py``; here are as many of its
queries as a test may take time for, on coarser nodes.
"""

from __future__ import annotations

import sys

import numpy as np
import pytest
from referee_queries import EACH, SCENES, engine, queries, shipped

from bench.baselines import lmgc90, mujoco, penalty, pybullet
from bench.baselines.search import Trial, bracketed, grid_nodes, push
from holdfast import Body, Box, HoldfastError, Scene, assemble

MEDIAN, WORST = 0.03, 0.08  # relative differences
G0 = 9.81  # [m/s²]
X, _, Z = np.eye(3)
EVERY = [pytest.param(name, k, id=f"{name}-{k}") for name in SCENES for k in range(EACH)]


def differences(found: list[tuple[float, float]]) -> np.ndarray:
    mine, theirs = np.array(found).T
    return np.abs(theirs / mine - 1)


def agree(found: list[tuple[float, float]]) -> None:
    off = differences(found)
    assert np.median(off) <= MEDIAN
    assert off.max() <= WORST


def block(size: tuple[float, float, float], mu: float, tilt: float = 0.0, mass: float = 2.0) -> Scene:
    """A box on a floor under gravity that is tilted by the slope ``tilt`` towards x."""
    pose = np.eye(4)
    pose[2, 3] = size[2] / 2
    ground = np.eye(4)
    ground[2, 3] = -0.05
    bodies = [Body("floor", Box(np.array([2, 2, 0.1])), pose=ground, fixed=True)]
    bodies.append(Body("box", Box(np.array(size)), mass=mass, pose=pose))
    return Scene(bodies, mu, G0 * np.array([tilt, 0, -1.0]))


# ---- the referees themselves: closed forms that know nothing of the engine


@pytest.mark.parametrize("height", [0.02, 0.1])
def test_the_dem_on_a_centred_push(height: float) -> None:
    box = assemble(block((0.1, 0.1, 0.1), 0.6))
    found = penalty.peak(box, "box", np.array([-0.05, 0, height]), X)
    assert found.held <= min(0.6, 0.05 / height) * 2 * G0 * (1 + 1e-3)
    assert found.force == pytest.approx(min(0.6, 0.05 / height) * 2 * G0, rel=2e-3)
    assert found.drift_beyond > 10 * found.drift


def test_the_dem_pulls_up_and_presses_down() -> None:
    box = assemble(block((0.1, 0.1, 0.1), 0.6))
    assert penalty.peak(box, "box", np.array([0, 0, 0.1]), Z).force == pytest.approx(2 * G0, rel=2e-3)
    pressed = penalty.peak(box, "box", np.array([0.03, 0.02, 0.1]), -Z)
    assert pressed.force == pressed.moves == np.inf


@pytest.mark.parametrize(("mu", "height"), [(0.5, 0.1), (0.9, 0.4)])
def test_the_dem_on_an_incline(mu: float, height: float) -> None:
    critical = min(mu, 0.1 / height)
    for ratio, holds in ((0.99, True), (1.01, False)):
        assert penalty.holds(assemble(block((0.1, 0.1, height), mu, ratio * critical))).holds is holds


def test_the_dem_sways_the_table() -> None:
    found = penalty.peak(shipped("table"), "slab", np.array([-0.25, 0, 0.225]), X, grid_nodes(shipped("table"), 3))
    assert found.force == pytest.approx(7.3575, rel=3e-3)


def test_friction_that_remembers_is_not_friction_that_looks() -> None:
    """A load that comes and goes leaves tangential springs stretched: the DEM has a history, the engine has none."""
    box = assemble(block((0.1, 0.1, 0.1), 0.6))
    nodes = grid_nodes(box, 3)
    model, weight = penalty.blocks(box, nodes), box.weight_wrench()
    aside = 0.9 * 0.6 * 2 * G0 * push(box, "box", np.array([-0.05, 0.04, 0.0]), X)
    still, _ = penalty.settled(box, model, weight, penalty.still(box, nodes))
    pushed, seen = penalty.settled(box, model, weight + 0.5 * aside, still)
    back, again = penalty.settled(box, model, weight, pushed)
    assert seen.holds
    assert again.holds
    assert np.abs(back.q - still.q).max() > 1e-2 * np.abs(pushed.q - still.q).max()


# ---- search and errors


def test_close_in_brackets_and_gives_up() -> None:
    found = bracketed(lambda s: Trial(s < 3.21, s, 0.0, 1), 0.1, 100.0, 1e-3)
    assert found.held < 3.21 <= found.moves <= found.held * 1.0011
    assert bracketed(lambda s: Trial(True, 0.0, 0.0, 1), 0.1, 100.0, 1e-3).force == np.inf
    unsure = bracketed(lambda s: Trial(None if s > 1 else True, 0.0, 0.0, 1), 0.9, 100.0, 1e-3)
    assert unsure.undecided > 1
    assert unsure.moves == np.inf


def test_grids_carry_the_area() -> None:
    table = shipped("table")
    for side in (2, 5):
        nodes = grid_nodes(table, side)
        assert len(nodes) == side * side * len(table.interfaces)
        sums = np.bincount(nodes.interface, nodes.weights)
        assert sums == pytest.approx([interface.area for interface in table.interfaces])
    with pytest.raises(HoldfastError, match="at least 2"):
        grid_nodes(table, 1)
    with pytest.raises(HoldfastError, match="grids need"):
        grid_nodes(shipped("tabletop"), 3)


@pytest.mark.parametrize(("module", "name"), [(mujoco, "mujoco"), (lmgc90, "compas_lmgc90"), (pybullet, "pybullet")])
def test_a_missing_referee_says_how_to_get_it(module: object, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for loaded in [m for m in sys.modules if m.split(".")[0] == name]:
        monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(HoldfastError, match="pip install"):
        module.holds(shipped("cube"))  # type: ignore[attr-defined]


def test_pushes_on_what_is_fixed_are_refused() -> None:
    with pytest.raises(HoldfastError, match="fixed"):
        penalty.peak(shipped("cube"), "floor", np.zeros(3), X)


# ---- the engine against them


def test_the_dem_on_a_few_queries() -> None:
    """Cheap enough for every run."""
    found = []
    for name, k in (("cube", 0), ("cube", 2), ("cube", 4), ("stack", 0), ("table", 1)):
        q = queries(name)[k]
        nodes = grid_nodes(shipped(name), 5)
        found.append((engine(q, nodes), penalty.peak(shipped(name), q.body, q.point, q.direction, nodes).force))
    assert differences(found).max() < 5e-3


@pytest.mark.referee
def test_the_dem_on_all_queries() -> None:
    found = []
    for q in (q for name in SCENES for q in queries(name)):
        nodes = grid_nodes(shipped(q.scene), 4)
        found.append((engine(q, nodes), penalty.peak(shipped(q.scene), q.body, q.point, q.direction, nodes).force))
    agree(found)


@pytest.mark.referee
def test_lmgc90_on_its_own_points() -> None:
    """All queries on the corners: LMGC90 finds them itself, where the grid of 2 x 2 has them."""
    pytest.importorskip("compas_lmgc90")
    found = []
    for name in SCENES:
        assembly = shipped(name)
        corners = grid_nodes(assembly, 2)
        points, _ = lmgc90.contact_points(assembly)
        apart = np.linalg.norm(points[:, None] - corners.points, axis=2)
        assert len(points) == len(corners)
        assert max(apart.min(0).max(), apart.min(1).max()) < 1e-5
        answers = [lmgc90.peak(assembly, q.body, q.point, q.direction).force for q in queries(name)]
        found += [(engine(q, corners), answer) for q, answer in zip(queries(name), answers, strict=True)]
    agree(found)


@pytest.mark.referee
def test_pybullet_beside_the_corners() -> None:
    """All queries; a coarser referee: contacts creep and tip, most of all where bricks wedge (notes/baselines.md)."""
    pytest.importorskip("pybullet")
    found = []
    for q in (q for name in SCENES for q in queries(name)):
        answer = pybullet.peak(shipped(q.scene), q.body, q.point, q.direction).force
        found.append((engine(q, grid_nodes(shipped(q.scene), 2)), answer))
    off = differences(found)
    assert np.median(off) <= 0.03
    assert off.mean() <= 0.05
    assert off.max() <= 0.2


@pytest.mark.referee
def test_mujoco_has_the_springs_asked_for() -> None:
    """The stiffness of every contact, from MuJoCo's own constraint constants, is in proportion to its area."""
    pytest.importorskip("mujoco")
    table = shipped("table")
    nodes = grid_nodes(table, 3)
    data = mujoco.World(table, nodes).data
    rows = 3 * np.arange(len(nodes))
    assert data.nefc == 3 * len(nodes)
    stiffness = (data.efc_KBIP[:, 0] * data.efc_KBIP[:, 2] / data.efc_R)[rows] / nodes.weights
    assert stiffness == pytest.approx(stiffness[0], rel=1e-9)


@pytest.mark.referee
@pytest.mark.parametrize("side", [3, 5])
def test_mujoco_on_its_own_points_and_on_more(side: int) -> None:
    """The first queries of every scene; all of them, and finer, in the table."""
    pytest.importorskip("mujoco")
    found = []
    for q in (q for name in SCENES for q in queries(name)[:2]):
        nodes = grid_nodes(shipped(q.scene), side)
        found.append((engine(q, nodes), mujoco.peak(shipped(q.scene), q.body, q.point, q.direction, nodes).force))
    agree(found)


@pytest.mark.referee
@pytest.mark.parametrize(("name", "number"), EVERY)
def test_the_dem_rests_below_and_moves_above(name: str, number: int) -> None:
    """By verdict, the load brought on at a constant rate: rests at 0.97 R, moves at 1.03 R."""
    q = queries(name)[number]
    nodes = grid_nodes(shipped(name), 4)
    load = engine(q, nodes) * push(shipped(name), q.body, q.point, q.direction)
    assert penalty.holds(shipped(name), 0.97 * load, nodes).holds is True
    assert penalty.holds(shipped(name), 1.03 * load, nodes).holds is False
