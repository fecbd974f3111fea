"""Maps of ``compliant``: few paths, the rest interpolated with a stated error."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from threading import Event
from typing import Any

import numpy as np
import pytest
from scipy.spatial import Delaunay

import holdfast as hf
from bench.scenes.dense_pallet import pallet
from bench.scenes.random_pushes import columns as pushed
from bench.scenes.random_pushes import random_pushes
from holdfast.base.arrays import Float, Int
from holdfast.elastic.outcome import PathOutcome
from holdfast.elastic.path import PathResult
from holdfast.elastic.system import System
from holdfast.engines.answers import Answers, joined
from holdfast.engines.compliant import columns
from holdfast.engines.compliant.compliant_state import MANY, Standing
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.interpolated import Solved, Survey, survey
from holdfast.engines.contract import Within
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import corner_numbers
from holdfast.geometry.triangulation import fan, inserted
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.map import RobustnessMap
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

GAP = 0.01
CASES = {"cube": 0.008, "stack": 0.013, "table": 0.03}


@cache
def _case(scene: str) -> tuple[Standing, RobustnessMap, Answers]:
    """A map, and every one of its points by a path of its own."""
    assembly = hf.assemble(shipped_scene(scene))
    result = hf.robustness_map(assembly, None, spacing=CASES[scene], engine="compliant", accuracy=GAP)
    groups = prepared(Compliant(), assembly)
    state = groups.group(0).state
    assert isinstance(state, Standing)
    columns = [
        push_columns(assembly, assembly.index[name], result.points[here], -result.normals[here])
        for name in dict.fromkeys(result.body)
        for here in [result.body == name]
    ]
    return state, result, groups.load_factor(np.hstack(columns))


@pytest.mark.parametrize("scene", CASES)
def test_a_map_says_what_single_paths_say_within_its_stated_error(scene: str) -> None:
    _, result, exact = _case(scene)
    decided = np.array([status is not Status.UNDECIDED for status in exact.status])
    assert decided.mean() > 0.99
    assert (result.status == np.array(exact.status, dtype=object))[decided].all()
    ends = exact.force[result.solved]  # to 1e-7: a peak at the proved bound ends at that, which is solved for anew
    assert np.allclose(result.force[result.solved], ends, rtol=1e-7, atol=0)
    assert not result.error[result.solved].any()
    between = ~result.solved & np.isfinite(exact.force) & decided
    off = np.abs(exact.force[between] / result.force[between] - 1)
    assert between.sum() > 0.2 * len(between)  # loads jump from point to point where a path ends at a dip
    assert off.mean() <= 0.005
    assert off.max() <= 0.03
    assert (off <= result.error[between]).all()
    assert (result.error[between] <= 3 * GAP).all()
    assert off.max() > 1e-6  # otherwise nothing was interpolated


@pytest.mark.parametrize("scene", CASES)
def test_lower_bounds_between_paths_allow_for_the_interpolation(scene: str) -> None:
    _, result, exact = _case(scene)
    between = ~result.solved & np.isfinite(result.force)
    assert (result.lower[between] <= result.force[between] * (1 - result.error[between])).all()
    decided = np.array([status is not Status.UNDECIDED for status in exact.status])
    assert (result.lower <= exact.force)[decided].all()
    assert np.median(result.lower[between] / exact.lower[between]) > 0.97


def test_pushes_that_nothing_moves_have_paths_of_their_own() -> None:
    """Where bodies wedge (slope_two at 70 weights) paths between endless ones end."""
    _, result, exact = _case("cube")
    top = result.normals[:, 2] > 0.5
    assert set(result.status[top]) == {Status.INFINITE}
    assert result.solved[np.isinf(result.force)].all()
    assert not result.solved.all()
    assert np.array_equal(np.isinf(result.force), np.isinf(exact.force))


def test_points_say_whether_they_were_solved() -> None:
    _, result, _ = _case("cube")
    for index in (int(np.flatnonzero(result.solved)[0]), int(np.flatnonzero(result.error > 0)[0])):
        assert result.at(index).solved == result.solved[index]
        assert result.at(index).error == result.error[index]


def test_without_a_gap_with_few_columns_or_loads_on_several_bodies_every_column_is_solved() -> None:
    state, result, _ = _case("stack")
    body = result.body == "cube3"
    assembly = state.grid.assembly
    W = push_columns(assembly, assembly.index["cube3"], result.points[body], -result.normals[body])
    assert not state.load_factor(W, Within(GAP)).solved.all()
    assert state.load_factor(W[:, : MANY - 1], Within(GAP)).solved.all()
    assert state.load_factor(W).solved.all()
    other = 6 * assembly.index["cube1"]
    W[other, 0] = 0.1
    mixed = state.load_factor(W, Within(GAP))
    assert mixed.solved[0]
    assert not mixed.solved.all()
    W[other] = 0.1
    assert state.load_factor(W[:, :60], Within(GAP)).solved.all()


@pytest.mark.parametrize("engine", [hf.Compliant(), hf.Limit()])
def test_bodies_that_are_asked_about_together_are_answered_as_on_their_own(engine: hf.plugins.Engine) -> None:
    _, result, _ = _case("stack")
    assembly = hf.assemble(shipped_scene("stack"))
    rows = [np.flatnonzero(result.body == name)[:80] for name in ("cube1", "cube3", "cube2")]
    columns = [
        push_columns(assembly, assembly.index[result.body[r[0]]], result.points[r], -result.normals[r]) for r in rows
    ]
    mixed = np.random.default_rng(3).permutation(240)
    together = engine.prepare(assembly).load_factor(np.hstack(columns)[:, mixed], Within(GAP))
    alone = joined([engine.prepare(assembly).load_factor(W, Within(GAP)) for W in columns]).rows(mixed)
    if engine.name == "limit":  # its bounds draw on earlier solves: they differ, and both hold
        assert (together.lower <= alone.upper * (1 + 1e-9)).all()
        assert (alone.lower <= together.upper * (1 + 1e-9)).all()
        return
    for name in ("force", "lower", "upper", "solved", "error"):
        np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
    assert together.mode.tolist() == alone.mode.tolist()
    assert not together.solved.all()


def test_answers_do_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a table whose legs tip over corners, where forces are concentrated, so that local grids are made, too."""
    assembly = hf.assemble(shipped_scene("tall_table"))
    cells, _ = exposed_cells(assembly, "slab", 0.08)
    W = push_columns(assembly, assembly.index["slab"], cells.points, -cells.normals)
    found = []
    for threads in (1, 2, 5):
        monkeypatch.setattr("holdfast.elastic.system.free_threads", lambda count=threads: count)
        state = hf.Compliant().prepare(assembly)
        found.append(state.load_factor(W, Within(GAP)))
        assert state.grid._local
    for other in found[1:]:
        for name in ("force", "lower", "solved", "error"):
            np.testing.assert_array_equal(getattr(other, name), getattr(found[0], name))


def test_answers_among_many_bodies_do_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where forces are concentrated in many ways, each has grids of its own, made in the thread that asks."""
    assembly = hf.assemble(pallet(3, 2, 2))
    W = pushed(assembly, random_pushes(assembly, np.random.default_rng(2), 30, slant=30))
    found = []
    for threads in (1, 2, 5):
        for module in ("elastic.system", "engines.compliant.refinement"):
            monkeypatch.setattr(f"holdfast.{module}.free_threads", lambda count=threads: count)
        state = hf.Compliant().prepare(assembly)
        assert state.grid.system.long
        found.append(state.load_factor(W))
        assert len(state.grid._local) > 4
    for other in found[1:]:
        for name in ("force", "lower"):
            np.testing.assert_array_equal(getattr(other, name), getattr(found[0], name))


def test_lower_bounds_are_begun_while_a_long_path_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The finer grid is made in another thread, where there is a processor for it; answers are the same."""
    followed, made, seen, found = Grid.paths, Event(), [], []

    def paths(grid: Grid, W: Float, **options: Any) -> PathResult:
        seen.append(made.wait(0 if threads == 1 else 60))
        return followed(grid, W, **options)

    def finer(grid: Grid) -> Grid:
        result = grid._finer
        made.set()
        return result

    monkeypatch.setattr(Grid, "paths", paths)
    monkeypatch.setattr(Grid, "finer", property(finer))
    for threads in (1, 2):
        made.clear()
        monkeypatch.setattr("holdfast.engines.compliant.compliant_state.free_threads", lambda: threads)  # noqa: B023
        assembly = hf.assemble(shipped_scene("bonded_wall"))
        W = push_columns(assembly, 7, assembly.com[[7]], np.eye(3)[:1])
        state = hf.Compliant().prepare(assembly)
        assert state.grid.system.long
        found.append(state.load_factor(W))
    assert seen[0] is False
    assert seen[-1] is True
    for name in ("force", "lower"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


@pytest.mark.parametrize("count", [1, 2, 7])
def test_every_long_path_may_have_a_thread_of_its_own(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("holdfast.elastic.system.free_threads", lambda: 4)
    for name, threads in (("bonded_wall", min(count, 4)), ("stack", max(count // 3, 1))):
        assert hf.Compliant().prepare(hf.assemble(shipped_scene(name))).grid.system.threads(count) == threads


def test_with_a_gap_of_nothing_a_map_solves_every_point() -> None:
    assembly = hf.assemble(shipped_scene("cube"))
    result = hf.robustness_map(assembly, None, spacing=0.02, engine="compliant", accuracy=0)
    assert result.solved.all()
    assert not result.error.any()
    assert not hf.robustness_map(assembly, None, spacing=0.008, engine="compliant").solved.all()


def _pushes(state: Standing, directions: Float) -> Float:
    at = state.grid.assembly.com[[2, 2, 2]] + [[-0.04, 0.01, 0.02], [0.02, -0.04, -0.01], [0.01, 0.03, 0.03]]
    return push_columns(state.grid.assembly, 2, at, directions)


def test_cuts_are_the_slopes_of_the_peak() -> None:
    """Against differences of the peaks of neighbouring pushes, in random directions of the load."""
    state, _, _ = _case("stack")
    W = _pushes(state, np.array([[1.0, 0, 0], [0, 1, 0.2], [1, 1, 0]]))
    paths = state.grid.paths(W, gradients=True)
    assert (np.abs((paths.gradient * W.T).sum(1) - 1) < 1e-8).all()  # the model is rounded to nine digits
    other = W + 1e-3 * np.random.default_rng(1).normal(size=W.shape) * np.tile(np.repeat([1, 0.05], 3), 3)[:, None]
    measured = paths.peak / state.grid.paths(other).peak - 1
    expected = (paths.gradient * other.T).sum(1) - 1
    assert np.abs(measured).max() > 5e-4
    assert np.allclose(measured, expected, rtol=0.1, atol=1e-4)


def test_sparse_and_dense_elimination_give_the_same_cuts() -> None:
    state, _, _ = _case("stack")
    other = replace(state.grid, system=System.by_fronts(state.grid.system.model))
    W = _pushes(state, np.array([[1.0, 0, 0], [0, 1, 0.2], [1, 1, 0]]))
    one, two = state.grid.paths(W, gradients=True), other.paths(W, gradients=True)
    assert np.allclose(one.peak, two.peak, rtol=1e-4)
    assert np.allclose(one.gradient, two.gradient, rtol=1e-2, atol=1e-3 * np.abs(one.gradient).max())


def _plane_pushes(count: int) -> Float:
    """Pushes along x at a grid of points: (n, 6)."""
    y, z = (v.ravel() for v in np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count)))
    one = np.ones(count * count)
    return np.column_stack([one, 0 * one, 0 * one, 0 * one, z, -y])


def _surveyed(loads: Float, value: Float, slopes: Float, kind: Int | None = None, gap: float = GAP) -> Survey:
    kinds = np.full(len(loads), PathOutcome.PEAK) if kind is None else kind

    def follow(k: Int, corners: Int) -> Solved:
        return Solved(kinds[k], value[k], slopes[k], np.zeros(len(k), dtype=int), np.ones(len(k)))

    return survey(loads, [np.arange(len(loads))], follow, gap)


def test_quadratic_resistance_is_interpolated_exactly() -> None:
    """γ = (w1² + a w5² + b w6²) / w1 is homogeneous; with w1 = 1 the mean of values and planes is exact."""
    loads = _plane_pushes(25)
    value = 1 + 0.1 * loads[:, 4] ** 2 + 0.2 * loads[:, 5] ** 2
    slopes = np.zeros((len(loads), 6))
    slopes[:, 0], slopes[:, 4], slopes[:, 5] = 2 - value, 0.2 * loads[:, 4], 0.4 * loads[:, 5]
    assert np.allclose((slopes * loads).sum(1), value)
    found = _surveyed(loads, value, slopes)
    between = ~found.solved
    assert between.mean() > 0.9
    assert np.allclose(found.value[between], value[between], rtol=1e-9)


def test_kinks_are_followed_down_to_the_gap() -> None:
    """Two mechanisms that meet along a slanted line: γ is the larger of two planes."""
    loads = _plane_pushes(31)
    planes = np.array([[1.0, 0, 0, 0, 0.9, 0.2], [1.1, 0, 0, 0, -0.7, 0.3]])
    which = np.argmax(loads @ planes.T, axis=1)
    value = (loads @ planes.T).max(1)
    found = _surveyed(loads, value, planes[which])
    between = ~found.solved
    off = np.abs(value[between] / found.value[between] - 1)
    assert between.mean() > 0.8
    assert (off <= found.error[between]).all()
    assert found.error.max() <= 3 * GAP
    far = np.abs(loads @ (planes[0] - planes[1])) > 0.3
    near = np.abs(loads @ (planes[0] - planes[1])) < 0.05
    assert (~between)[near].mean() > 2 * (~between)[far].mean()


def test_the_stated_error_covers_every_convex_resistance_that_the_paths_allow() -> None:
    """Between the highest tangent plane and the chord of the corners any γ would fit what was solved."""
    loads = _plane_pushes(31)
    value = np.sqrt(1 + 1.5 * loads[:, 4] ** 2 + 0.8 * loads[:, 5] ** 2)
    slopes = np.column_stack(
        [1 / value, 0 * value, 0 * value, 0 * value, 1.5 * loads[:, 4] / value, 0.8 * loads[:, 5] / value]
    )
    assert np.allclose((slopes * loads).sum(1), value)
    found = _surveyed(loads, value, slopes, gap=0.1)
    between = np.flatnonzero(~found.solved)
    corners = found.corner[between]
    chord = (found.share[between] * value[corners]).sum(1)
    plane = np.einsum("nkc,nc->nk", slopes[corners], loads[between]).max(1)
    room = np.maximum(found.value[between] / plane - 1, 1 - found.value[between] / chord)
    assert room.max() > 0.05
    assert (room <= found.error[between]).all()


def test_a_map_states_the_error_of_its_interpolation(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the survey states reaches ``error`` and is taken from ``lower``."""
    state, result, _ = _case("cube")
    surveys: list[Survey] = []
    monkeypatch.setattr(columns, "survey", lambda *given: surveys.append(survey(*given)) or surveys[-1])
    W = push_columns(state.grid.assembly, 0, result.points, -result.normals)
    found = state.load_factor(W, Within(GAP))
    (stated,) = surveys
    between = ~found.solved
    assert between.any()
    assert np.array_equal(found.error[between], stated.error[between])
    assert (found.lower[between] <= found.force[between] * (1 - stated.error[between])).all()


def test_what_cannot_be_interpolated_is_followed_in_few_rounds() -> None:
    """γ jumps from point to point on half of the face: that is followed together, and not all of the rest."""
    loads = _plane_pushes(31)
    rugged = loads[:, 4] > 0
    value = np.where(rugged, np.random.default_rng(0).uniform(1, 2, len(loads)), 1.0)
    slopes = value[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    rounds = []

    def follow(k: Int, corners: Int) -> Solved:
        rounds.append(k)
        return Solved(np.full(len(k), PathOutcome.PEAK), value[k], slopes[k], np.zeros(len(k), int), np.ones(len(k)))

    found = survey(loads, [np.arange(len(loads))], follow, GAP)
    assert found.solved[rugged].mean() > 0.95
    assert found.solved[~rugged].mean() < 0.8
    assert len(rounds) <= 25


def test_nothing_is_interpolated_between_finite_and_endless() -> None:
    loads = _plane_pushes(15)
    endless = loads[:, 4] > 0.3
    value = np.where(endless, 0.0, 1.0)
    slopes = value[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    found = _surveyed(loads, value, slopes, np.where(endless, PathOutcome.ENDLESS, PathOutcome.PEAK))
    assert np.array_equal(found.value == 0, endless)
    between = ~found.solved
    assert 0.2 < between.mean() < 0.9
    assert not endless[between].any()
    assert not endless[found.corner[between]].any()


def test_an_undecided_neighbour_spoils_interpolation() -> None:
    loads = _plane_pushes(9)
    value, kind = np.ones(81), np.full(81, PathOutcome.PEAK)
    kind[0], value[0] = PathOutcome.LOST, 0.0
    slopes = value[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    found = _surveyed(loads, value, slopes, kind)
    assert (found.corner[~found.solved] != 0).all()


Case = tuple[str, str, tuple[float, ...], tuple[float, ...]]  # scene, body, point [m], direction


def _pushed(case: Case) -> tuple[Standing, Float]:
    """The state of a case's scene, and its push as a load column."""
    scene, body, point, direction = case
    assembly = hf.assemble(shipped_scene(scene))
    along = np.array(direction) / np.linalg.norm(direction)
    return Compliant().prepare(assembly), push_columns(assembly, assembly.index[body], np.array([point]), along[None])


# Pushes whose long steps once ended on another branch of the path
BRANCHES: tuple[Case, ...] = (
    ("slope_two", "cube2", (0, 0.0799, 0.1389), (0, -2, -1)),  # 4.97 N
    ("v_groove", "cube", (-0.0275, 0, 0.1139), (1, 0, -1)),  # 0.81 N, though nothing moves it
    ("wall2x2", "b1_0", (-0.05, 0.05, 0.15), (0, -1, 0)),  # 25.4 N
)


@pytest.mark.parametrize(("case", "expected"), list(zip(BRANCHES, (12.284, np.inf, 23.544), strict=True)))
def test_steps_stay_on_the_branch_that_short_steps_follow(case: Case, expected: float) -> None:
    """Expected: the same paths in steps a tenth as long."""
    state, push = _pushed(case)
    found = state.load_factor(push).force[0]
    assert found == expected or found == pytest.approx(expected, rel=1e-3)


# Pushes whose long steps once passed over a maximum, to a higher one
MAXIMA: tuple[Case, ...] = (
    ("slope_two", "cube2", (-0.05, -0.0112, 0.1533), (0.9389, -0.1526, -0.3085)),  # 13.01 N
    ("wall2x2", "b0_1", (0.0875, -0.05, 0.0375), (-0.079, 0.9853, -0.1516)),  # 75.12 N
    ("arch", "v3", (-0.0542, -0.0214, 0.192), (0.1301, -0.2757, 0.9524)),  # 39.67 N
)


@pytest.mark.parametrize(("case", "expected"), list(zip(MAXIMA, (12.895, 74.541, 37.634), strict=True)))
def test_steps_do_not_pass_over_a_maximum_that_short_steps_find(case: Case, expected: float) -> None:
    """Expected: the first maximum in steps a sixth as long, on the same nodes."""
    state, push = _pushed(case)
    assert state.grid.paths(push).first[0] == pytest.approx(expected, rel=4e-3)


def test_triangulations_grow_as_delaunay_says() -> None:
    points = np.random.default_rng(2).random((60, 2))
    corners = corner_numbers(points)
    assert set(corners) == set(Delaunay(points).convex_hull.ravel())
    triangles = fan(corners)
    for k in range(len(points)):
        triangles = inserted(points, triangles, k)
    mine = {tuple(sorted(t)) for t in triangles.tolist()}
    theirs = {tuple(sorted(t)) for t in Delaunay(points).simplices.tolist()}
    assert len(mine & theirs) >= 0.95 * len(theirs)  # the first fan is not Delaunay


def test_triangulations_of_grids_cover_them_once() -> None:
    """Points on edges and on common circles, in random order."""
    points = np.stack(np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)), 2).reshape(-1, 2)
    corners = corner_numbers(points)
    assert sorted(corners) == [0, 8, 72, 80]
    triangles = fan(corners)
    for k in np.random.default_rng(3).permutation(81):
        triangles = inserted(points, triangles, int(k))
    u, v = (points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))
    area = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
    assert len(triangles) == 128
    assert np.allclose(area, 1 / 128)
