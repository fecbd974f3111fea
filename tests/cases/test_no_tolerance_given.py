"""Rough scenes without a tolerance: what may rest is undecided, with what to do about it (findings R1, R3, R7)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shared import FOLDER, needed

import holdfast as hf
from holdfast.scene.shipped.blocks import at, box, floor

pytestmark = pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")

HELD = {  # what is said of each scene that was settled with convex parts, so that its meshes hover by up to 2.3 mm
    "jenga12": (),
    "masonry_wall": (),
    "masonry_crossvault": (),
    "lack_table": ("mug is 0.43 mm above 'top'",),
    "beam_frame": ("b6 is 0.84 mm above 'table'", "b0 is 0.82 mm above 'b6'", "b1 is 1.2 mm above 'b6'"),
    "leaning": ("cracker is 0.67 mm from 'wood'", "table and hammer overlap by 0.701 mm"),
    "kitchen_place": ("plate is 1.1 mm above 'table'", "bowl is 2 mm above 'plate'", "apple is 2.2 mm above 'bowl'"),
    "dishes": ("p1 is 2.5 mm above 'p0'", "p2 is 0.62 mm above 'p1'", "b1 is 2.1 mm from 'b0'"),
}
LONG = ("kitchen_place", "dishes")  # where faces are many


@needed
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in HELD]
)
def test_a_millimetre_gap_is_not_a_fall(name: str) -> None:
    """R1: each needed another gap, found by trial; at a smaller one it was unstable."""
    found = hf.stability(hf.load_scene(FOLDER / "settled" / f"{name}.json"), engine="limit")
    assert found.status is (hf.Status.UNDECIDED if HELD[name] else hf.Status.STABLE)
    assert all(group.verdict.status is not hf.Status.UNSTABLE for group in found.groups)
    for text in HELD[name]:
        assert text in found.reason
    assert found.reason.count("settle, or") == sum(g.verdict.status is hf.Status.UNDECIDED for g in found.groups)


def noisy(scene: hf.Scene, seed: int, metres: float, degrees: float) -> hf.Scene:
    rng, poses = np.random.default_rng(seed), {}
    for body in scene.movable:
        pose, turn = np.array(body.pose), Rotation.from_rotvec(np.radians(degrees) * rng.standard_normal(3)).as_matrix()
        pose[:3, :3] = turn @ pose[:3, :3]
        pose[:3, 3] = body.com_world + metres * rng.standard_normal(3) + turn @ (pose[:3, 3] - body.com_world)
        poses[body.name] = pose
    return scene.moved(poses)


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2"])
@pytest.mark.parametrize("seed", range(5))
def test_noisy_poses_are_told_to_settle(name: str, seed: int) -> None:
    """R7: with 1 mm and 0.3 degrees of noise no body of a scene at rest is said to fall."""
    found = hf.stability(noisy(hf.shipped_scene(name), seed, 1e-3, 0.3), engine="limit")
    told = {g.bodies: g.verdict for g in found.groups}
    assert all(verdict.status is not hf.Status.UNSTABLE for verdict in told.values()), found.reason
    assert all("settle" in v.reason for v in told.values() if v.status is hf.Status.UNDECIDED)


def test_noise_on_what_truly_falls_hides_no_fall() -> None:
    """A tower of three, 20 mm over the edge of its base: it falls whatever the noise is."""
    tower = [box(f"{k}", (0.1, 0.1, 0.1), 1, (0.07, 0, 0.15 + 0.1 * k)) for k in range(3)]
    scene = hf.Scene([floor(), hf.Body("base", hf.Box((0.1, 0.1, 0.1)), pose=at(0, 0, 0.05), fixed=True), *tower], 0.5)
    for seed in range(5):
        found = hf.stability(noisy(scene, seed, 1e-3, 0.3), engine="limit")
        assert found.status is not hf.Status.STABLE
