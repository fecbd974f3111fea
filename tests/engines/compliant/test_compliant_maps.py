"""Maps of ``compliant``: every point has the answer of a single push; and paths that are asked together."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.dense_pallet import pallet
from bench.scenes.random_pushes import columns as pushed
from bench.scenes.random_pushes import random_pushes
from bench.scenes.shelf import shelf
from holdfast.base.arrays import Float
from holdfast.elastic.path import PathResult
from holdfast.engines.answers import joined
from holdfast.engines.compliant.compliant_state import Standing
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.contract import Within
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import about_y, at, floor

MAPPED: dict[str, tuple[Callable[[], hf.Scene], float]] = {  # spacings [m] for 100 to 200 points
    "a cube": (lambda: shipped_scene("cube"), 0.016),
    "a table on long legs": (lambda: shipped_scene("tall_table"), 0.075),
    "a wedge": (lambda: shipped_scene("v_groove"), 0.017),
    "loose cubes on a slope": (lambda: shipped_scene("slope_two"), 0.035),
    "an orange among unlike things": (shelf, 0.13),
    "a pallet": (lambda: pallet(2, 2, 2), 0.11),
}


@pytest.mark.parametrize("name", MAPPED)
def test_every_point_of_a_map_says_what_a_single_push_says(name: str) -> None:
    """The single pushes are asked of a scene of their own, one by one, last point first."""
    scene, spacing = MAPPED[name]
    found, alone = hf.robustness_map(scene(), spacing=spacing), hf.assemble(scene())
    assert 80 < len(found.force) < 250
    for k in reversed(range(len(found.force))):
        push = hf.robustness(alone, found.body[k], found.points[k], -found.normals[k])
        assert found.lower[k] <= push.force[0]
        for column in ("force", "lower", "upper"):
            assert getattr(found, column)[k] == pytest.approx(getattr(push, column)[0], rel=1e-9), (column, k)
        assert (found.status[k], found.moving[k]) == (push.status[0], push.moving[0])


def test_an_error_that_is_allowed_changes_nothing() -> None:
    """Of a tin that lies and may roll, so that limit analysis looks at every push on its end."""
    tin = hf.Body("tin", hf.Cylinder(0.05, 0.06), mass=0.5, pose=at(0, 0, 0.05, about_y(np.pi / 2)))
    state = hf.Compliant().prepare(hf.assemble(hf.Scene([floor(), tin], 0.9)))
    points = [(-0.03, y, z) for z in np.linspace(0.02, 0.085, 9) for y in np.linspace(-0.02, 0.02, 7)]
    W = push_columns(state.grid.assembly, 0, np.array(points), np.tile([1.0, 0, 0], (63, 1)))
    allowed, exact = state.load_factor(W, Within(0.05)), state.load_factor(W)
    assert np.isfinite(exact.upper).all()
    for name in ("force", "lower", "upper"):
        np.testing.assert_array_equal(getattr(allowed, name), getattr(exact, name))


@pytest.mark.parametrize("engine", [hf.Compliant(), hf.Limit()])
def test_bodies_that_are_asked_about_together_are_answered_as_on_their_own(engine: hf.plugins.Engine) -> None:
    assembly = hf.assemble(shipped_scene("stack"))
    result = hf.robustness_map(assembly, spacing=0.013, engine="limit")
    rows = [np.flatnonzero(result.body == name)[:80] for name in ("cube1", "cube3", "cube2")]
    columns = [
        push_columns(assembly, assembly.index[result.body[r[0]]], result.points[r], -result.normals[r]) for r in rows
    ]
    mixed = np.random.default_rng(3).permutation(240)
    together = engine.prepare(assembly).load_factor(np.hstack(columns)[:, mixed], Within(0.01))
    alone = joined([engine.prepare(assembly).load_factor(W, Within(0.01)) for W in columns]).rows(mixed)
    if engine.name == "limit":  # its bounds draw on earlier solves: they differ, and both hold
        assert (together.lower <= alone.upper * (1 + 1e-9)).all()
        assert (alone.lower <= together.upper * (1 + 1e-9)).all()
        return
    for name in ("force", "lower", "upper"):
        np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
    assert together.mode.tolist() == alone.mode.tolist()


def test_answers_do_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a table whose legs tip over corners, where forces are concentrated, so that local grids are made, too."""
    assembly = hf.assemble(shipped_scene("tall_table"))
    cells, _ = exposed_cells(assembly, "slab", 0.08)
    W = push_columns(assembly, assembly.index["slab"], cells.points, -cells.normals)
    found = []
    for threads in (1, 2, 5):
        monkeypatch.setattr("holdfast.elastic.system.free_threads", lambda count=threads: count)
        state = hf.Compliant().prepare(assembly)
        found.append(state.load_factor(W, Within(0.01)))
        assert state.grid._local
    for other in found[1:]:
        for name in ("force", "lower"):
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
