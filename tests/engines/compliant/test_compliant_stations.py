"""Points on the way to a peak: they lie on the path, and tell what a finer grid changes where the peak does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from compliant_scenes import shipped
from test_compliant_recovery import asked

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.elastic.newton import on_path, unbalance, worst
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.path import PathResult
from holdfast.elastic.stepper import APART
from holdfast.engines.compliant.grid import Grid
from holdfast.validation.benchmarks.reliability import random_pushes


@pytest.mark.parametrize("name", ["stack", "table", "arch", "wall2x2"])
def test_stations_are_points_of_the_path_below_its_peak(name: str) -> None:
    assembly = shipped(name)
    grid = hf.Compliant().prepare(assembly).grid
    W = random_pushes(assembly, 12, 3)
    paths, loads = grid.paths(W), grid.loads(W)
    m, work = grid.system.model, grid.system.work
    compared = 0
    for k in np.flatnonzero(paths.outcome == PathOutcome.PEAK):
        work.w[:] = loads[k]
        there = np.flatnonzero(paths.station_s[k] > 0)
        for s, q in zip(paths.station_s[k, there], paths.station_q[k, there], strict=True):
            unbalance(m, work, on_path(np.zeros_like(q)), q, s)
            assert worst(m, work.r) < 1e-6 * max(1.0, worst(m, loads[k]) * s)
            compared += 1
        ascending = np.sort(paths.station_s[k, there])
        assert (ascending[1:] > (1 + 0.99 * APART) * ascending[:-1]).all()
        assert ascending[-1] <= paths.peak[k] * (1 + 1e-12)
    assert compared > 20


Nearby = Callable[[Grid, Float, Float, Float, Float], Float]


def watch(monkeypatch: pytest.MonkeyPatch, nearby: Nearby) -> list[int]:
    """Let loads near points be found by ``nearby``; returns the nodes of the grids whose paths are followed."""
    followed, seen = Grid.paths, []

    def paths(grid: Grid, W: Float, *, cuts: bool = False) -> PathResult:
        seen.append(grid.springs.nodes)
        return followed(grid, W, cuts=cuts)

    monkeypatch.setattr(Grid, "paths", paths)
    monkeypatch.setattr(Grid, "loads_nearby", nearby)
    return seen


def test_a_station_tells_what_the_finer_grid_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    force, lower = asked()
    truly, calls = Grid.loads_nearby, []

    def only_stations(grid: Grid, W: Float, s: Float, q: Float, plane: Float) -> Float:
        calls.append(s)
        return np.full(len(s), -1.0) if len(calls) == 1 else truly(grid, W, s, q, plane)

    seen = watch(monkeypatch, only_stations)
    found = asked()
    assert len(calls) > 1
    assert set(seen) == {7}  # no path on a finer grid
    assert found[0] == force
    assert found[1] == pytest.approx(lower, rel=0.02)


def test_a_station_that_the_finer_grid_does_not_reach_tells_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A load there that is 3 % less may be a change of the answer: only the whole path on the finer grid decides."""
    force, _ = asked()
    calls: list[Float] = []

    def far_below(grid: Grid, W: Float, s: Float, q: Float, plane: Float) -> Float:
        calls.append(s)
        return -np.ones(len(s)) if len(calls) == 1 else 0.97 * s

    seen = watch(monkeypatch, far_below)
    assert asked()[0] == pytest.approx(force, rel=0.02)
    assert len(calls) > 1
    assert 14 in seen


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
