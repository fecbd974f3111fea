"""The drop test: what stands stays, what does not goes, and poses that the planner returns stay."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.baselines.drop import describe, drop
from bench.scenes.placement_scenes import TABLE_II, TABLE_III
from holdfast.applications.placement.planner import planner
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import about_x, box, floor

pytestmark = pytest.mark.referee


def test_shipped_scenes_stay() -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    for name in ("cube", "stack", "table", "slope", "cantilever"):
        fall = drop(hf.assemble(shipped_scene(name)))
        assert fall.stands, (name, fall)
        assert fall.moved < 1e-5


@pytest.mark.parametrize(("x", "stands"), [(0.045, True), (0.055, False)])
def test_a_cube_over_a_rim_goes_as_its_centre_does(x: float, stands: bool) -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    scene = hf.Scene([floor(0.1, 0.1), box("cube", (0.1, 0.1, 0.1), 1, (x, 0, 0.05))], 0.5)
    assert drop(hf.assemble(scene), "cube").stands == stands


@pytest.mark.parametrize(("mu", "stands"), [(0.55, True), (0.45, False)])
def test_friction_is_that_of_the_pair(mu: float, stands: bool) -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    tilt = np.arctan(0.5)
    slope = hf.Body("slope", hf.Box((0.2, 0.4, 0.1)), pose=pose_from(np.zeros(3), about_x(tilt)), fixed=True)
    above = 0.075 * np.array([0, -np.sin(tilt), np.cos(tilt)])
    block = hf.Body("block", hf.Box((0.1, 0.1, 0.05)), mass=1, pose=pose_from(above, about_x(tilt)))
    scene = hf.Scene([slope, block], hf.Friction(default=0.05, pairs={("slope", "block"): mu}))
    assert drop(hf.assemble(scene), seconds=2.0).stands == stands


def test_a_pose_that_floats_or_overlaps_is_seen() -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    for height in (0.054, 0.045):
        scene = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, height))], 0.5)
        assert not drop(hf.assemble(scene, interfaces=[])).stands


def test_a_body_that_is_not_convex_is_refused() -> None:
    with pytest.raises(hf.HoldfastError, match="is not convex; MuJoCo takes its hull"):
        describe(hf.assemble(shipped_scene("tabletop")), None, 0.0)


@pytest.mark.parametrize("name", [*TABLE_II, *TABLE_III])
def test_poses_that_the_planner_returns_stay(name: str) -> None:
    pytest.importorskip("mujoco", reason="the drop test needs MuJoCo: pip install -e '.[bench]'")
    scene = {**TABLE_II, **TABLE_III}[name]()
    asked = planner(
        hf.assemble(scene.scene),
        scene.body,
        approach=scene.approach,
        engine="compliant",
        where=scene.where,
    )
    for seed in range(2):
        _, after = asked.search(seed=seed).found[0]
        fall = drop(after, "object")
        assert fall.stands, (seed, fall)
