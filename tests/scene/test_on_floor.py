"""on_floor: what was read is moved vertically, as one, onto the floor that there is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf
from holdfast.scene.formats.links import on_the_floor
from holdfast.scene.shipped.blocks import box, floor

URDF = """<robot name="thing"><link name="base"><inertial><mass value="1"/></inertial><collision><geometry>{}</geometry>
</collision></link></robot>"""
SHAPES = {
    '<box size="0.2 0.4 0.6"/>': 0.3,
    '<cylinder radius="0.1" length="0.2"/>': 0.1,
    '<sphere radius="0.1"/>': 0.1,
    '<capsule radius="0.1" length="0.2"/>': 0.2,
}


load = loading("thing.urdf", URDF.format, friction=0.5, floor=True)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("height", [0.0, 0.7, -3.0])
def test_the_lowest_point_comes_to_the_floor_from_anywhere(shape: str, height: float, load: Load) -> None:
    scene = load(shape, pose=hf.pose(0.3, 0.2, height), on_floor=True)
    body, half = scene.body("thing"), SHAPES[shape]
    np.testing.assert_allclose(body.pose, hf.pose(0.3, 0.2, half), atol=1e-9)
    way = f"raised by {half - height:.6g} m" if half > height else f"lowered by {height - half:.6g} m"
    assert f"on_floor: {way}, so that the lowest point is on the floor" in scene.notes
    verdict = hf.stability(scene)
    assert verdict.stable
    assert sum(np.linalg.norm(body.mass * scene.gravity) for body in scene.movable) == pytest.approx(9.81)


def test_a_turned_body_comes_to_the_floor_with_its_corner(load: Load) -> None:
    scene = load('<box size="0.2 0.2 0.2"/>', pose=hf.pose(roll=45), on_floor=True)
    assert scene.body("thing").pose[2, 3] == pytest.approx(0.1 * np.sqrt(2), rel=1e-12)


def test_all_of_a_file_moves_as_one_and_holds_with_it() -> None:
    low, high = box("low", (0.1, 0.1, 0.1), 1, (0, 0, 0)), box("high", (0.1, 0.1, 0.1), 1, (0, 0, 0.1))
    grip = hf.Grip("high", [(-0.05, 0, 0.1), (0.05, 0, 0.1)], [(1, 0, 0), (-1, 0, 0)], mu=0.5, force=20.0)
    scene = on_the_floor(hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), low, high], 0.5, holds=[grip]))
    assert [body.pose[2, 3] for body in scene.movable] == pytest.approx([0.05, 0.15])
    np.testing.assert_allclose(scene.holds[0].points[:, 2], 0.15)


def test_the_floor_is_the_highest_level_half_space_or_the_only_fixed_body() -> None:
    cube = box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0))
    ground = hf.Body("ground", hf.HalfSpace(), fixed=True, position=(0, 0, 1.5))
    wall = hf.Body("wall", hf.HalfSpace(), fixed=True, position=(-9, 0, 7), rpy_degrees=(0, 90, 0))
    scene = on_the_floor(hf.Scene([ground, wall, cube], 0.5))
    assert scene.body("cube").pose[2, 3] == pytest.approx(1.55)
    assert scene.body("ground") == ground
    shelf = hf.Body("shelf", hf.Box((1, 1, 0.02)), position=(0, 0, 0.8), fixed=True)
    scene = on_the_floor(hf.Scene([shelf, cube], 0.5))
    assert (scene.body("shelf"), scene.body("cube").pose[2, 3]) == (shelf, pytest.approx(0.86))
    tilted = on_the_floor(hf.Scene([floor(), cube], 0.5, gravity=(0, 9.81, 0)))
    assert tilted.body("cube").pose[1, 3] == pytest.approx(-0.55), "up is against gravity"


def test_without_a_floor_it_says_what_is_missing(tmp_path: Path) -> None:
    shelves = [replace(floor(), name=f"shelf{k}", pose=hf.pose(z=k)) for k in range(2)]
    with pytest.raises(
        hf.errors.SceneError, match=r"on_floor: of 2 fixed bodies none is a level half space; give floor="
    ):
        on_the_floor(hf.Scene([*shelves, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.5))
    (tmp_path / "thing.urdf").write_text(URDF.format('<sphere radius="0.1"/>'))
    with pytest.raises(hf.errors.SceneError, match="on_floor: is 'yes'"):
        hf.load_scene(tmp_path / "thing.urdf", friction=0.5, floor=True, on_floor="yes")
