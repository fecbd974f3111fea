"""Maps of ``compliant``: every point has the answer of a single push; and paths that are asked together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.dense_pallet import pallet
from bench.scenes.random_pushes import columns as pushed
from bench.scenes.random_pushes import random_pushes
from bench.scenes.shelf import shelf
from holdfast.base.arrays import Float
from holdfast.engines.compliant.engine import Compliant, RestingState
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

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


Case = tuple[str, str, tuple[float, ...], tuple[float, ...]]  # scene, body, point [m], direction


def _pushed(case: Case) -> tuple[RestingState, Float]:
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
