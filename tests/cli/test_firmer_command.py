"""The command ``firmer``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from calling import command

import holdfast as hf

firmer = command("firmer")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    post = hf.Body("post", hf.Box((0.1, 0.1, 0.3)), position=(0, 0, 0.15), fixed=True)
    cube = hf.Body("cube", hf.Box((0.08, 0.08, 0.08)), mass=1.0, position=(0.04, 0, 0.34))
    hf.save_scene(hf.Scene([post, cube], 1.0, name="post"), tmp_path / "post.yaml")
    return tmp_path / "post.yaml"


def test_it_moves_a_body_and_writes_the_scene(firmer: Any, scene: Path, tmp_path: Path) -> None:
    files = ["--scene-out", tmp_path / "better.yaml", "--png", tmp_path / "both.png"]
    code, out, err = firmer(scene, "cube", "--engine", "limit", "--turn-degrees", 0, *files)
    assert (code, err) == (0, "")
    assert "moved cube by" in " ".join(out.split())
    assert abs(hf.load_scene(tmp_path / "better.yaml").body("cube").pose[0, 3]) < 0.015
    assert (tmp_path / "both.png").stat().st_size > 5_000


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_an_undecided_scene_is_told_and_is_3(firmer: Any, scene: Path) -> None:
    beside = hf.Body("beside", hf.Box((0.08, 0.08, 0.08)), mass=1.0, position=(-0.037, 0, 0.34))
    hf.save_scene(hf.load_scene(scene).with_body(beside), scene)
    code, out, _ = firmer(scene, "cube", "--engine", "limit")
    assert code == 3
    assert "undecided" in out
    assert "0 N" not in out
    assert json.loads(firmer(scene, "cube", "--engine", "limit", "--json")[1])["rows"][0]["undecided"]


def test_limits_and_a_motion(firmer: Any, scene: Path) -> None:
    motion = scene.with_name("brake.csv")
    motion.write_text("t,ax,ay,az\n0,-1,0,0\n1,-1,0,0\n")
    asked = ["cube", "--engine", "limit", "--slide", 0.01, "--turn-degrees", 0, "--profile", motion, "--json"]
    code, out, _ = firmer(scene, *asked)
    found = json.loads(out)
    assert code == 0
    assert found["details"]["after"] > found["details"]["before"] > 0
    x = [step["poses"]["cube"][0][3] for step in found["rows"]]
    assert 0 < abs(x[-1] - x[0]) < 0.01 + 1e-6
