"""What the next finer grid tells of a peak: the load at its displacement, or the peak of its own path."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import watch_paths
from engine_scenes import shipped
from test_compliant_recovery import asked

import holdfast as hf
from bench.suites.reliability import random_pushes
from holdfast.elastic.system import PathOutcome, PathResult, RestOutcome
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import Bounded
from holdfast.queries.request import push_columns
from holdfast.scene.shipped.blocks import at


def test_lower_bounds_are_less_where_the_load_has_dipped_on_the_way() -> None:
    paths = PathResult.lost(3, 6)
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
    peaks = []

    def dipped(_: Grid, paths: PathResult) -> PathResult:
        peaks.append(paths.peak[0])
        return paths._replace(first=0.5 * paths.peak if len(peaks) == 1 else paths.peak)

    watch_paths(monkeypatch, dipped)
    found = state.refined.answers(W)
    assert found.paths.peak[0] == peaks[-1] != peaks[0]
    assert found.lower[0] == 0.5 * peaks[0]


@pytest.mark.parametrize(("load", "follows"), [(0.996, False), (0.994, True), (1.006, True), (None, True)])
def test_the_whole_path_is_followed_where_the_load_at_the_peak_says_too_little(
    load: float | None, follows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next grid has ``load`` times the peak at its displacement: the estimate within MOVED, else its path."""
    force, lower = asked()
    seen = watch_paths(monkeypatch)
    monkeypatch.setattr(Grid, "loads_nearby", lambda grid, W, s, q, plane: s * load if load else np.full(len(s), -1.0))
    found = asked()
    assert (14 in seen) is follows
    assert found[0] == pytest.approx(force, rel=0.02)
    if follows:
        assert found[1] == pytest.approx(lower, rel=0.02)
    else:
        assert load is not None
        assert found[1] == pytest.approx((1 - 2 * (1 - load) - 0.002) * force, rel=1e-4)


def test_the_lower_bound_of_a_tower_is_alike_in_directions_that_are_alike_by_symmetry() -> None:
    """Twenty square boxes on each other tip over an edge, at the same force along all that symmetry makes the same.

    On more nodes an edge gives way more: at the displacement of the peak the finer grid may be on its way up still.
    """
    boxes = [hf.Body(f"b{k}", hf.Box((0.4, 0.4, 0.1)), mass=5.0, pose=at(0, 0, 0.05 + 0.1 * k)) for k in range(20)]
    tower = hf.assemble(hf.Scene([hf.Body("ground", hf.HalfSpace(), fixed=True), *boxes], hf.Friction(0.5)))
    for degrees, share in ((3.6, 0.985), (32.4, 0.955)):
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
