"""Poses: what is rigid and what is not; where bodies are in the world."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.rigid import pose_from, rotation_about, shift_twist, tangents, wrench_at

TURN = np.eye(4)
TURN[:3, :3] = Rotation.from_euler("zyx", [0.3, -0.4, 1.1]).as_matrix()
TURN[:3, 3] = [1, 2, 3]


def bad(row: int, column: int, value: float) -> np.ndarray:
    pose = np.eye(4)
    pose[row, column] = value
    return pose


@pytest.mark.parametrize(
    ("pose", "match"),
    [
        (np.diag([2.0, 2, 2, 1]), r"is not rigid: .* = 3; needs a rotation and a translation, scale belongs"),
        (np.diag([-1.0, 1, 1, 1]), r"is a reflection: det R = -1; needs a proper rotation"),
        (bad(0, 1, 0.1), r"is not rigid: .* = 0\.1; needs"),
        (bad(0, 0, 1.0001), r"is not rigid"),
        (bad(1, 3, np.nan), r"contains nan at index \(1, 3\); needs finite"),
        (bad(2, 2, np.inf), r"contains inf at index \(2, 2\); needs finite"),
        (bad(3, 0, 1.0), r"last row is \[1.*; needs \(0, 0, 0, 1\)"),
        (np.eye(3), r"has shape \(3, 3\); needs shape \(4, 4\)"),
        ("here", r"got 'here'; needs numbers of shape \(4, 4\)"),
    ],
)
def test_a_pose_that_is_not_rigid_is_refused(pose: object, match: str) -> None:
    with pytest.raises(hf.errors.GeometryError, match=rf"body 'b': pose:? ?{match}"):
        hf.Body("b", hf.Box((1, 1, 1)), mass=1, pose=pose)


def test_a_pose_takes_the_body_frame_to_the_world() -> None:
    body = hf.Body("b", hf.Box((0.2, 0.4, 0.6)), mass=1, com=(0.1, 0, 0), pose=TURN)
    np.testing.assert_allclose(body.com_world, TURN[:3, 3] + 0.1 * TURN[:3, 0], rtol=1e-12)
    corners = body.shape.surface.vertices @ TURN[:3, :3].T + TURN[:3, 3]
    np.testing.assert_allclose(body.surface_world.vertices, corners, rtol=1e-12)


def test_quaternions_are_w_first() -> None:
    x, y, z, w = Rotation.from_matrix(TURN[:3, :3]).as_quat()
    np.testing.assert_allclose(pose_from(np.array([1.0, 2, 3]), np.array([w, x, y, z])), TURN, atol=1e-15)


def test_power_does_not_depend_on_the_reference_point() -> None:
    rng = np.random.default_rng(0)
    force, point, p, q, twist = rng.normal(size=(5, 3))[0], *rng.normal(size=(3, 3)), rng.normal(size=6)
    at_q = wrench_at(force, point, q) @ shift_twist(twist, p, q)
    assert wrench_at(force, point, p) @ twist == pytest.approx(at_q, rel=1e-12)


def test_a_rotation_about_a_line_leaves_the_line_at_rest() -> None:
    rng = np.random.default_rng(1)
    axis, origin, reference = rng.normal(size=(3, 3))
    axis /= np.linalg.norm(axis)
    twist = rotation_about(axis, origin, reference)
    np.testing.assert_allclose(shift_twist(twist, reference, origin + 0.7 * axis)[:3], 0, atol=1e-14)


def test_tangents_are_right_handed_for_every_normal() -> None:
    normals = np.vstack([np.eye(3), -np.eye(3), np.random.default_rng(2).normal(size=(50, 3))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    t1, t2 = tangents(normals)
    np.testing.assert_allclose(np.cross(t1, t2), normals, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(t1, axis=1), 1)
