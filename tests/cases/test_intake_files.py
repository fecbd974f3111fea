"""Small files that were once refused or misread: each does what the README beside them says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from tests.cases.shared import FOLDER, needed

pytestmark = needed
INTAKE = FOLDER / "intake"


def test_lights_in_includes_are_passed_over(tmp_path: Path) -> None:
    text = (INTAKE / "conveyor_pose.sdf").read_text()
    sun = '<world name="w"><include><uri>model://sun</uri></include>'
    (tmp_path / "w.sdf").write_text(text.replace('<world name="w">', sun))
    assert hf.stability(hf.load_scene(tmp_path / "w.sdf", model_path=[INTAKE / "models"])).stable


def test_directives_of_drake_by_hand() -> None:
    scene = hf.load_scene(INTAKE / "drake_scene.dmd.yaml")
    np.testing.assert_allclose(scene.body("board").pose, hf.pose(z=0.5, yaw=90), atol=1e-12)
    np.testing.assert_allclose(scene.body("low").pose, hf.pose(z=0.56, yaw=30), atol=1e-12)
    high = hf.pose(z=0.56, yaw=30) @ hf.pose(0.02, 0, 0.1)
    np.testing.assert_allclose(scene.body("high").pose, high, atol=1e-12)
    assert [body.name for body in scene.movable] == ["low", "high"]
    assert scene.mu("low", "board") == pytest.approx(0.4)
