"""The own frame of a group of bodies: it moves with them, and what is written in it does not see the world's axes."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.scenes.random_assemblies import FAMILIES, standing
from holdfast.assembly.axes import contact_axes, own_frame
from holdfast.assembly.one_group import part_of
from holdfast.base.rigid import WORLD, snapped
from holdfast.native import core


def moved(scene: hf.Scene, seed: int) -> hf.Scene:
    motion = np.eye(4)
    motion[:3, :3] = R = Rotation.random(random_state=seed).as_matrix()
    motion[:3, 3] = np.random.default_rng(seed).uniform(-2, 2, 3)
    return hf.Scene([body.moved(motion @ body.pose) for body in scene.bodies], scene.friction, R @ scene.gravity)


def test_of_no_bodies_it_is_the_frame_of_the_world() -> None:
    assert own_frame((), np.array([0.0, 0, 1])) is WORLD


def test_it_is_that_of_the_heaviest_body_then_of_the_lowest() -> None:
    def body(name: str, mass: float, height: float, turn: float) -> hf.Body:
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("z", turn).as_matrix()
        pose[2, 3] = height
        return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), mass=mass, pose=pose)

    bodies = [body("high", 2.0, 0.3, 0.1), body("low", 2.0, 0.1, 0.2), body("light", 1.0, 0.0, 0.3)]
    for order in ((0, 1, 2), (2, 1, 0)):
        frame = own_frame([bodies[k] for k in order], np.array([0.0, 0, 1]))
        assert np.allclose(frame.origin, (0, 0, 0.1))
        assert np.allclose(frame.axes, bodies[1].pose[:3, :3].T)


def test_seen_and_world_undo_each_other() -> None:
    frame = own_frame([hf.Body("b", hf.Box((1, 2, 3)), mass=1, pose=moved_pose())], np.array([0.0, 0, 1]))
    points = np.random.default_rng(3).normal(size=(5, 3))
    assert np.allclose(frame.world(frame.seen(points)), points)
    assert np.allclose(frame.seen(frame.origin + 2 * frame.axes[1]), (0, 2, 0))


def moved_pose() -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=4).as_matrix()
    pose[:3, 3] = (1, 2, 3)
    return pose


@pytest.mark.parametrize("family", ["table", "row", "hull"])
def test_a_part_is_written_alike_wherever_its_scene_lies(family: str) -> None:
    assembly = standing(FAMILIES[family], np.random.default_rng(6))
    other = hf.assemble(moved(assembly.scene, 7))
    for group in assembly.groups:
        one, two = (part_of(a, group).assembly for a in (assembly, other))
        assert one.size == pytest.approx(two.size, rel=1e-9)
        assert [b.name for b in one.movable] == [b.name for b in two.movable]
        frames = [own_frame(a.movable, a.scene.up) for a in (one, two)]
        for mine, yours in zip(one.interfaces, two.interfaces, strict=True):
            assert mine.bodies == yours.bodies
            for a, b in zip(mine.patches, yours.patches, strict=True):
                assert np.allclose(frames[0].seen(a.polygon), frames[1].seen(b.polygon), atol=1e-9)
                assert np.allclose(a.normal @ frames[0].axes.T, b.normal @ frames[1].axes.T, atol=1e-9)


def test_rounding_is_to_binary_digits_of_the_size_and_symmetric() -> None:
    values = np.random.default_rng(1).uniform(-1, 1, 100)
    rounded = snapped(values, 1.0, 20)
    assert np.abs(rounded - values).max() <= 2.0**-20
    assert np.abs(rounded - values).max() > 2.0**-23
    assert (snapped(-values, 1.0, 20) == -rounded).all()
    assert (snapped(values * (1 + 1e-15), 1.0, 20) == rounded).all()
    assert (snapped(rounded, 1.0, 20) == rounded).all()
    assert not snapped(np.zeros(3), 0.0, 20).any()
    assert [core.snapped_number(value, 1.0, 20) for value in values.tolist()] == rounded.tolist()
    assert (snapped(np.array([0.49, 0.51, 1.49]) * 2.0**-20, 1.0, 20) == np.array([0, 1, 1]) * 2.0**-20).all()


def test_the_step_of_nothing_is_a_normal_number() -> None:
    """Genesis makes the processor take denormal numbers for zero, and values are divided by this step."""
    step = core.snapped_number(1e-281, 0.0, 53)
    assert step == 0 or step > sys.float_info.min
    assert core.snapped_number(0.0, 0.0, 53) == 0
    assert snapped(np.zeros(2), 0.0, 53).tolist() == [0, 0]


def test_axes_of_contacts_are_right_handed_with_the_normal_first() -> None:
    normals = np.random.default_rng(3).standard_normal((50, 3))
    normals = np.vstack([normals / np.linalg.norm(normals, axis=1)[:, None], np.eye(3), -np.eye(3)])
    axes = contact_axes(np.eye(3), normals)
    np.testing.assert_array_equal(axes[:, 0], normals)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.broadcast_to(np.eye(3), axes.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, atol=1e-12)
