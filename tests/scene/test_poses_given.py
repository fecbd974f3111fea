"""Poses from position and angles: one meaning in ``pose``, in ``Body`` and in scene files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import holdfast as hf

BOX = hf.Box((0.1, 0.1, 0.1))
DEGREES = st.floats(-720, 720)


@given(DEGREES, DEGREES, DEGREES)
def test_a_pose_turns_about_the_axes_of_the_world_in_order(roll: float, pitch: float, yaw: float) -> None:
    pose = hf.pose(1, 2, 3, roll=roll, pitch=pitch, yaw=yaw)
    expected = Rotation.from_euler("xyz", (roll, pitch, yaw), degrees=True).as_matrix()
    assert pose[:3, :3] == pytest.approx(expected, abs=1e-12)
    assert pose[:, 3].tolist() == [1, 2, 3, 1]


def test_right_angles_are_exact() -> None:
    turned = hf.pose(yaw=90)
    assert turned.tolist() == [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert hf.pose().tolist() == np.eye(4).tolist()
    assert hf.pose(roll=-180).tolist() == np.diag([1.0, -1, -1, 1]).tolist()
    assert not np.signbit(hf.pose(roll=180, pitch=90, yaw=-270)[hf.pose(roll=180, pitch=90, yaw=-270) == 0]).any()


def test_a_body_takes_position_and_angles() -> None:
    body = hf.Body("cup", BOX, mass=1, position=(0.1, 0, 0.05), rpy_degrees=(0, 0, 30))
    assert body == hf.Body("cup", BOX, mass=1, pose=hf.pose(0.1, 0, 0.05, yaw=30))
    assert hf.Body("cup", BOX, mass=1, position=(1, 2, 3)).pose.tolist() == hf.pose(1, 2, 3).tolist()
    assert hf.Body("cup", BOX, mass=1, rpy_degrees=(0, 90, 0)).pose.tolist() == hf.pose(pitch=90).tolist()


def test_a_scene_file_gives_the_same_pose(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(
        "format: holdfast-scene/1\nfriction: 0.5\nbodies:\n"
        "- {name: cup, shape: {type: box, size: [.1, .1, .1]}, fixed: true, position: [1, 2, 3], "
        "rpy_degrees: [10, 20, 30]}\n"
    )
    assert hf.load_scene(path).body("cup").pose.tobytes() == hf.pose(1, 2, 3, roll=10, pitch=20, yaw=30).tobytes()


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"pose": np.eye(4), "position": (0, 0, 1)}, "'cup': pose: is given twice, by pose and by position or rpy_deg"),
        ({"pose": (0, 0, 0.05)}, r"pose: got \(0, 0, 0.05\); needs a \(4, 4\) array; .* is written position=\(x, y, z"),
        ({"position": (0, 0)}, r"position: has shape \(2,\); needs shape \(3,\)"),
        ({"position": "here"}, "position: got 'here'"),
        ({"rpy_degrees": 30}, r"rpy_degrees: has shape \(\); needs shape \(3,\)"),
        ({"rpy_degrees": (0, 0, float("nan"))}, "rpy_degrees: contains nan"),
        ({"density": (0, 0, 0.05), "mass": None}, r"density: got \(0, 0, 0.05\); .* written position=\(x, y, z\)"),
        ({"mass": (0, 0, 0.05)}, r"mass: got \(0, 0, 0.05\); .* written position=\(x, y, z\)"),
    ],
)
def test_a_mistake_in_where_a_body_is_says_what_to_write(arguments: dict[str, object], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.Body("cup", BOX, **{"mass": 1, **arguments})


def test_positional_mistakes_say_what_to_write() -> None:
    with pytest.raises(hf.HoldfastError, match=r"density: got \(0, 0, 0.05\); needs a number; where the body is"):
        hf.Body("n", BOX, 1, (0, 0, 0.05))
    with pytest.raises(hf.errors.GeometryError, match=r"give the three .*together: Box\(\(0.1, 0.2, 0.2\)\)"):
        hf.Box(0.1, 0.2, 0.2)
    with pytest.raises(hf.errors.GeometryError, match=r"Box: got 0.1; give the three .* together: Box\(\(x, y, z\)\)"):
        hf.Box(0.1)
    with pytest.raises(hf.errors.SceneError, match=r"scene: friction: is \{.*write Friction\(pairs="):
        hf.Scene([], {("a", "b"): 0.5})
    with pytest.raises(hf.errors.GeometryError, match=r"Box: size: has shape \(2,\)"):
        hf.Box((0.1, 0.2))
