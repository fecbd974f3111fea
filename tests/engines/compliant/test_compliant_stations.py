"""Points on the way to a peak: they lie on the path, and tell what a finer grid changes where the peak does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from compliant_scenes import shipped
from test_compliant_recovery import asked

import holdfast as hf
from bench.suites.reliability import random_pushes
from holdfast.base.arrays import Bool, Float
from holdfast.elastic.linear import make_work
from holdfast.elastic.newton import Balance, unbalance, worst
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.path import PathResult
from holdfast.elastic.stepper import APART, STATIONS
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import Bounded
from holdfast.queries.request import push_columns
from holdfast.scene.shipped.blocks import at


@pytest.mark.parametrize("name", ["stack", "table", "arch", "wall2x2"])
def test_stations_are_points_of_the_path_below_its_peak(name: str) -> None:
    assembly = shipped(name)
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 3)
    paths, loads = grid.paths(W), grid.loads(W)
    m, work = grid.system.model, make_work(grid.system.model, grid.system.fronts)
    compared = 0
    for k in np.flatnonzero(paths.outcome == PathOutcome.PEAK):
        work.w[:] = loads[k]
        there = np.flatnonzero(paths.station_s[k] > 0)
        for s, q in zip(paths.station_s[k, there], paths.station_q[k, there], strict=True):
            unbalance(m, work, Balance(1.0, 0.0, 0.0, np.zeros_like(q)), q, s)
            assert worst(m, work.r) < 1e-6 * max(1.0, worst(m, loads[k]) * s)
            compared += 1
        ascending = np.sort(paths.station_s[k, there])
        assert (ascending[1:] > (1 + 0.99 * APART) * ascending[:-1]).all()
        assert ascending[-1] <= paths.peak[k] * (1 + 1e-12)
    assert compared > 20


def test_lower_bounds_are_less_where_the_load_has_dipped_on_the_way() -> None:
    paths = PathResult.lost(3, 6, gradients=False)
    paths.outcome[:] = PathOutcome.PEAK, PathOutcome.PEAK, PathOutcome.ENDLESS
    paths.peak[:] = paths.first[:] = 10.0, 10.0, np.inf
    paths.first[1] = 8.0
    bounded = Bounded.unbounded(paths)._replace(below=np.array([9.9, 9.9, 0.0]))
    assert bounded.lower.tolist() == pytest.approx([9.9, 7.92, np.inf])


def test_a_maximum_that_a_path_on_another_grid_passes_over_is_not_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """A push on a wall whose forces are concentrated on an edge: with more nodes there it leads a tenth farther."""
    assembly = shipped("wall2x2")
    state = hf.Compliant().prepare(assembly)
    W = push_columns(
        assembly, assembly.index["b0_1"], *np.array([[[0.0125, 0.05, 0.0875]], [[0.1308, -0.9887, -0.0725]]])
    )
    followed, peaks = Grid.paths, []

    def dipped(grid: Grid, W: Float, *, gradients: bool = False) -> PathResult:
        paths = followed(grid, W, gradients=gradients)
        peaks.append(paths.peak[0])
        return paths._replace(first=0.5 * paths.peak if len(peaks) == 1 else paths.peak)

    monkeypatch.setattr(Grid, "paths", dipped)
    found = state.refined.answers(W)
    assert not found.own[0]
    assert found.paths.peak[0] == peaks[-1] != peaks[0]
    assert found.lower[0] == 0.5 * peaks[0]


Balances = Callable[[Grid, Float, Float, Float], Bool]


def watch(monkeypatch: pytest.MonkeyPatch, balances: Balances) -> list[int]:
    """Let no load be found at the displacement of a peak, and ``balances`` tell what finer grids balance.

    Returns the nodes of the grids whose paths are followed.
    """
    followed, seen = Grid.paths, []

    def paths(grid: Grid, W: Float, *, gradients: bool = False) -> PathResult:
        seen.append(grid.springs.nodes)
        return followed(grid, W, gradients=gradients)

    monkeypatch.setattr(Grid, "paths", paths)
    monkeypatch.setattr(Grid, "loads_nearby", lambda grid, W, s, q, plane: np.full(len(s), -1.0))
    monkeypatch.setattr(Grid, "balances", balances)
    return seen


def test_what_the_finer_grid_balances_tells_how_far_it_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    force, lower = asked()
    seen = watch(monkeypatch, Grid.balances)
    found = asked()
    assert set(seen) == {7}  # no path on a finer grid
    assert found[0] == force
    assert found[1] <= lower * (1 + 1e-9)
    assert found[1] == pytest.approx(lower, rel=0.05)


@pytest.mark.parametrize("most", [0.0, np.inf])
def test_only_the_whole_path_decides_where_that_tells_nothing(monkeypatch: pytest.MonkeyPatch, most: float) -> None:
    """The finer grid balances nothing near the peak, or more than the peak by so much that the answer may change."""
    force, _ = asked()
    seen = watch(monkeypatch, lambda grid, W, s, q: s < most)
    assert asked()[0] == pytest.approx(force, rel=0.02)
    assert 14 in seen


Nearby = Callable[[Grid, Float, Float, Float, Float], Float]


def watch_nearby(monkeypatch: pytest.MonkeyPatch, nearby: Nearby) -> tuple[list[int], list[Float]]:
    """Let finer grids balance nothing, and loads be found by ``nearby``, but none at the displacement of the peak.

    Returns the nodes of the grids whose paths are followed, and the loads near which some are sought.
    """
    calls: list[Float] = []

    def found(grid: Grid, W: Float, s: Float, q: Float, plane: Float) -> Float:
        calls.append(s)
        return np.full(len(s), -1.0) if len(calls) == 1 else nearby(grid, W, s, q, plane)

    seen = watch(monkeypatch, lambda grid, W, s, q: np.zeros(len(s), dtype=bool))
    monkeypatch.setattr(Grid, "loads_nearby", found)
    return seen, calls


def test_a_station_tells_what_the_finer_grid_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    force, lower = asked()
    seen, calls = watch_nearby(monkeypatch, Grid.loads_nearby)
    found = asked()
    assert len(calls) > 1
    assert set(seen) == {7}  # no path on a finer grid
    assert found[0] == force
    assert found[1] == pytest.approx(lower, rel=0.02)


def test_a_station_that_the_finer_grid_does_not_reach_tells_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A load there that is 3 % less may be a change of the answer: only the whole path on the finer grid decides."""
    force, _ = asked()
    seen, calls = watch_nearby(monkeypatch, lambda grid, W, s, q, plane: 0.97 * s)
    assert asked()[0] == pytest.approx(force, rel=0.02)
    assert len(calls) > 1
    assert 14 in seen


def test_a_finer_grid_balances_what_it_holds_and_not_more() -> None:
    assembly = shipped("stack")
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 3)
    coarse, fine = grid.paths(W), grid.finer.paths(W)
    both = np.flatnonzero((coarse.outcome == PathOutcome.PEAK) & (fine.outcome == PathOutcome.PEAK))
    W, coarse, peak = W[:, both], coarse.chosen(both), fine.peak[both]
    assert len(both) >= 6
    asked, told = 0, 0
    for k in range(STATIONS):
        there = np.flatnonzero(coarse.station_s[:, k] > 0)
        for share in (0.98, 1.0, 1.02, 1.1):
            s = share * coarse.station_s[there, k]
            held = grid.finer.balances(W[:, there], s, coarse.station_q[there, k])
            assert not held[s > (1 + 1e-3) * peak[there]].any()
            within = s < (1 - 1e-2) * peak[there]
            asked, told = asked + int(within.sum()), told + int(held[within].sum())
    assert asked > 30
    assert told > 0.7 * asked


def test_the_lower_bound_of_a_tower_is_alike_in_directions_that_are_alike_by_symmetry() -> None:
    """Twenty square boxes on each other tip over an edge, at the same force along all that symmetry makes the same.

    On more nodes an edge gives way more: at the displacement of the peak the finer grid may be on its way up still.
    """
    boxes = [hf.Body(f"b{k}", hf.Box((0.4, 0.4, 0.1)), mass=5.0, pose=at(0, 0, 0.05 + 0.1 * k)) for k in range(20)]
    tower = hf.assemble(hf.Scene([hf.Body("ground", hf.HalfSpace(), fixed=True), *boxes], hf.Friction(0.5)))
    for degrees, share in ((3.6, 0.985), (32.4, 0.97)):
        around = np.radians([side + turn for side in (0, 90, 180, 270) for turn in (-degrees, degrees)])
        ways = np.stack([np.cos(around), np.sin(around), np.zeros(8)], axis=1)
        found = hf.transport_limits(tower, ways)
        np.testing.assert_allclose(found.acceleration, 9.81 * 0.2 / np.cos(np.radians(degrees)), rtol=2e-3)
        assert found.lower.min() > share * found.acceleration.min()


def test_the_search_for_rest_gives_up_when_told() -> None:
    assembly = shipped("stack")
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 3)
    paths, loads = grid.paths(W), grid.loads(W)
    k = int(np.flatnonzero(paths.outcome == PathOutcome.PEAK)[0])
    above = grid.system.under(grid.system.model.wrench + 1.03 * paths.peak[k] * loads[k])
    assert above.come_to_rest().outcome is RestOutcome.DRIFTS
    few = above.come_to_rest(most=10)
    assert few.outcome is RestOutcome.LOST
    assert few.steps < 120  # two searches, each of which ends the points that it has begun
