"""Load paths that are lost half way, on purpose: what takes their place, and what may still be relied upon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from compliant_scenes import watch_paths
from engine_scenes import block, by_paths

import holdfast as hf
from holdfast.base.arrays import Float, objects
from holdfast.elastic.system import PathOutcome, PathResult
from holdfast.engines.compliant.amendment import LimitReview, LoadQuestion
from holdfast.engines.compliant.elastic_model import Places
from holdfast.engines.compliant.engine import RestingState
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import Bounded
from holdfast.engines.contract import EXACT
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, prism

PUSH = ("cube1", (-0.05, 0.01, 0.05), (1.0, 0.2, -0.1))


def asked(**options: Any) -> tuple[float, float]:
    assembly = hf.assemble(shipped_scene("stack"))
    found = hf.robustness(assembly, *PUSH, engine=by_paths(assembly, **options))
    assert found.status[0] is hf.Status.FINITE
    return float(found.force[0]), float(found.lower[0])


def asked_of(W: Float) -> LoadQuestion:
    """The question of loads whose paths say nothing."""
    count = W.shape[1]
    lost = Bounded.unbounded(PathResult.lost(count, len(W)))
    return LoadQuestion(W, EXACT, np.arange(count), lost, np.zeros(count, dtype=bool))


def lose(monkeypatch: pytest.MonkeyPatch, share: Callable[[Grid], float | None]) -> None:
    """Let paths be lost at a share of their peak, which depends on the grid; None leaves them as they are."""

    def change(grid: Grid, found: PathResult) -> PathResult:
        left = share(grid)
        if left is None:
            return found
        lost = np.full(len(found.peak), PathOutcome.LOST)
        return found._replace(outcome=lost, peak=left * found.peak, q=np.tile(grid.settled.q, (len(lost), 1)))

    watch_paths(monkeypatch, change)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_what_is_lost_half_way_on_all_grids_is_not_known(monkeypatch: pytest.MonkeyPatch, share: float) -> None:
    assembly = hf.assemble(shipped_scene("stack"))
    lose(monkeypatch, lambda grid: share)
    found = hf.robustness(assembly, *PUSH, engine=by_paths(assembly))
    assert (found.status[0], found.force[0], found.lower[0]) == (hf.Status.UNDECIDED, 0.0, 0.0)


@pytest.mark.parametrize(("reached", "known"), [(1 - 1e-6, True), (0.99, True), (0.95, False)])
def test_what_is_lost_where_limit_analysis_proves_motion_has_come_to_its_peak(
    monkeypatch: pytest.MonkeyPatch, reached: float, known: bool
) -> None:
    """Its lower bound is what the path reached, less the least error."""
    assembly = hf.assemble(shipped_scene("stack"))
    upper = float(hf.robustness(assembly, *PUSH, engine="limit").upper[0])
    force, _ = asked()
    lose(monkeypatch, lambda grid: reached * upper / force if grid.springs.nodes == 7 else 0.0)
    found = hf.robustness(assembly, *PUSH, engine=by_paths(assembly))
    assert (found.status[0] is hf.Status.FINITE) is known
    assert found.force[0] == pytest.approx(reached * upper if known else 0.0, rel=1e-9)
    assert found.lower[0] == 0.0  # finer nodes were lost at once


def keystone(taper: float) -> hf.answers.Assembly:
    """A wedge of 2 kg between two fixed stones, whose joints lean outwards by ``taper``."""
    low, high, end, top = 0.05, 0.05 + 0.2 * taper, 0.3, 0.2
    outlines = {
        "left": [(-end, 0), (-low, 0), (-high, top), (-end, top)],
        "right": [(low, 0), (end, 0), (end, top), (high, top)],
        "key": [(-low, 0), (low, 0), (high, top), (-high, top)],
    }
    body: dict[str, dict[str, object]] = {"left": {"fixed": True}, "right": {"fixed": True}, "key": {"mass": 2.0}}
    parts = [prism(name, np.array(outline), 0.2, 1, **body[name]) for name, outline in outlines.items()]
    return hf.assemble(hf.Scene(parts, 0.6))


@pytest.mark.parametrize("taper", [0.05, 0.1, 0.3])
def test_a_keystone_is_lifted_by_its_weight(taper: float) -> None:
    """There all joints open at once and the path is lost; limit analysis, in which they may jam, knows no end."""
    assembly, lift = keystone(taper), ("key", (0.0, 0.0, 0.2), (0.0, 0.0, 1.0))
    found = hf.robustness(assembly, *lift)
    assert found.status[0] is hf.Status.FINITE
    assert found.force[0] == pytest.approx(2 * 9.81, rel=1e-6)
    assert found.moving[0] == ("key",)
    # a pull 0.1 mm beside the middle, whose path is not lost, promises as much: what holds only after sliding is not
    beside = hf.robustness(assembly, "key", (1e-4, 0.0, 0.2), (0.0, 0.0, 1.0))
    assert 0 < found.lower[0] <= 2 * 9.81
    assert found.lower[0] == pytest.approx(beside.lower[0], rel=0.01)
    assert hf.robustness(assembly, *lift, engine="limit").status[0] is hf.Status.INFINITE


def test_a_path_that_is_lost_on_few_nodes_is_followed_on_more(monkeypatch: pytest.MonkeyPatch) -> None:
    finer = asked(nodes=14)
    lose(monkeypatch, lambda grid: 0.5 if grid.springs.nodes == 7 else None)
    assert asked() == finer


@pytest.mark.parametrize("few_nodes", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.98])
def test_a_finer_path_that_is_lost_bounds_the_peak_by_what_it_reached(
    monkeypatch: pytest.MonkeyPatch, share: float, few_nodes: bool
) -> None:
    """Whether all contacts have more nodes, or only those at which forces are concentrated."""
    force, _ = asked()
    few = len(Places.of(hf.assemble(shipped_scene("stack")), hf.Compliant().nodes).nodes)
    monkeypatch.setattr(
        Grid, "concentrated", lambda grid, q: np.full((len(q), len(grid.assembly.interfaces)), few_nodes)
    )
    monkeypatch.setattr(Grid, "loads_nearby", lambda grid, W, s, q, plane: np.full(len(s), -1.0))
    lose(monkeypatch, lambda grid: None if len(grid.nodes) == few else share)
    found, lower = asked()
    assert found == pytest.approx(force, rel=1e-9)
    assert lower == pytest.approx(max(1 - 2 * (1 - share) - 0.002, 0.0) * force, rel=0.01)


def test_a_finer_path_that_ends_sooner_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may have left its branch, and so may the other."""
    assembly = hf.assemble(shipped_scene("stack"))

    def change(grid: Grid, found: PathResult) -> PathResult:
        few = grid.springs.nodes == 7
        outcome = np.full(len(found.peak), PathOutcome.LOST if few else PathOutcome.PEAK)
        return found._replace(outcome=outcome, peak=(0.6 if few else 0.2) * found.peak)

    watch_paths(monkeypatch, change)
    found = hf.robustness(assembly, *PUSH, engine=by_paths(assembly))
    assert (found.status[0], found.force[0], found.lower[0]) == (hf.Status.UNDECIDED, 0.0, 0.0)


@pytest.mark.parametrize(("weights", "status"), [(1.0, hf.Status.UNDECIDED), (100.0, hf.Status.INFINITE)])
def test_a_path_without_end_may_be_lost_far_out(
    monkeypatch: pytest.MonkeyPatch, weights: float, status: hf.Status
) -> None:
    """Far above the weight rounding decides where it is lost: there limit analysis and a state of rest tell the end."""
    followed = Grid.paths

    def paths(grid: Grid, W: Float) -> PathResult:
        found = followed(grid, W)
        reached = weights / np.abs(grid.loads(W)).max(axis=1)
        return found._replace(outcome=np.full(len(reached), PathOutcome.LOST), peak=reached)

    monkeypatch.setattr(Grid, "paths", paths)
    assembly = hf.assemble(shipped_scene("cube"))
    found = hf.robustness(assembly, "cube", (0.01, 0.0, 0.1), (0.0, 0.0, -1.0), engine=by_paths(assembly))
    assert found.status[0] is status
    assert found.lower[0] == (np.inf if status is hf.Status.INFINITE else 0.0)


def test_a_push_above_the_middle_third_of_a_face_that_bears_nothing_at_rest() -> None:
    """Two blocks side by side: at rest every node between them is on the verge, and the first step may leave the path.

    Such a path is lost, it has no peak of 0: both blocks slide at mu m g, wherever the push acts.
    """
    whole = hf.shipped_scene("wall2x2")
    row = hf.assemble(hf.Scene([b for b in whole.bodies if b.name in ("floor", "b0_0", "b0_1")], whole.friction))
    points = [(-0.2, y, z) for y in (0.0, -0.0125) for z in (0.08, 0.085, 0.0875, 0.095)]
    force = hf.robustness(row, "b0_0", points, [(1, 0, 0)] * len(points)).force
    assert force[:4] == pytest.approx(0.6 * 8 * 9.81, rel=1e-4)
    assert force[4:] == pytest.approx(0.6 * 8 * 9.81, rel=0.01)


def test_presses_of_a_dense_pallet_are_endless_as_limit_analysis_says() -> None:
    """Sixty boxes side by side: paths are lost at a thousand times the weight of all of them and more (S2).

    Where exactly, and which of them, is decided by rounding, and so by the processor. That no end is told where
    two grids lead to a thousand weights is not.
    """
    size, boxes = np.array([0.2, 0.15, 0.1]), []
    for i, j, k in np.ndindex(5, 4, 3):
        centre = size * (i - 2, j - 1.5, k + 0.5)
        boxes.append(block(f"b{i}_{j}_{k}", size, centre, 2 + 0.1 * ((i + 2 * j + 3 * k) % 5)))
    assembly = hf.assemble(hf.Scene([block("floor", (6, 6, 0.1), (0, 0, -0.05), fixed=True), *boxes], 0.5))
    points = [[x, y, 0.3] for x, y in ((-3 / 35, 0.105), (2 / 35, 0.105), (3 / 35, 0.135))]
    for engine, weights in (("limit", 0.0), ("compliant", 1e3)):
        lower = hf.robustness(assembly, "b2_2_2", points, [0, 0, -1], engine=engine).lower
        assert (np.isinf(lower) | (lower < weights * assembly.weight)).all()


@pytest.mark.parametrize(("finer", "status"), [(PathOutcome.PEAK, "undecided"), (PathOutcome.ENDLESS, "infinite")])
def test_a_peak_far_above_the_weight_is_endless_only_if_its_lower_bound_or_the_finer_grid_says_so(
    finer: PathOutcome, status: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A path that ends sooner on finer nodes leaves no lower bound: then two methods contradict each other."""
    monkeypatch.setattr(LimitReview, "_endless", lambda *_: False)
    assembly = hf.assemble(shipped_scene("stack"))
    W = push_columns(assembly, 0, assembly.com[:1], -np.eye(3)[2:]).repeat(3, 1)
    state = hf.Compliant().prepare(assembly)
    assert isinstance(state, RestingState)
    found, far = state.load_factor(W), 1e4 * assembly.weight
    assert (found.status == hf.Status.INFINITE).all()
    lower = np.array([0.9, 0.01, 0.0]) * far
    ended = replace(found, status=objects(3 * [hf.Status.FINITE]), force=np.full(3, far), lower=lower)

    def change(grid: Grid, found: PathResult) -> PathResult:
        return found if grid.springs.nodes == 7 else found._replace(outcome=np.full(len(found.peak), finer))

    watch_paths(monkeypatch, change)
    told = LimitReview(state).amend(ended, asked_of(W))
    assert told.status.tolist() == ["infinite", "finite", status]
    assert told.lower[1:].tolist() == [lower[1], np.inf if status == "infinite" else 0.0]


@pytest.mark.parametrize(("above", "status"), [(1.04, hf.Status.FINITE), (1.1, hf.Status.UNDECIDED)])
def test_a_peak_far_above_what_limit_analysis_proves_is_not_believed(above: float, status: hf.Status) -> None:
    """Of a path that a balanced body may have led astray; a little above the proof, rounding and nodes explain it."""
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05))
    walls = [block(name, (0.1, 0.1, 0.2), (x, 0, 0.1), 1.0) for name, x in (("left", -0.1), ("right", 0.1))]
    assembly = hf.assemble(hf.Scene([block("floor", (6, 6, 0.1), (0, 0, -0.05), fixed=True), *walls, ball], 0.3))
    W = push_columns(assembly, assembly.index["ball"], np.array([[-0.05, 0, 0.05]]), np.array([[1.0, 0, 0]]))
    state = hf.Compliant().prepare(assembly)
    assert isinstance(state, RestingState)
    found = state.load_factor(W)
    high = above * found.upper
    told = LimitReview(state).amend(replace(found, force=high, lower=high), asked_of(W))
    assert told.status[0] is status
    assert told.lower[0] <= found.upper[0]
