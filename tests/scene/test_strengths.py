"""Tension and cohesion of pairs: the table, files, sums of scenes, and what refuses them by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.friction import strength_between
from holdfast.sets import sensitivity

TABLE = hf.Friction(
    0.5,
    pairs={("brick", "plate"): 0.4},
    tension={("brick", "brick"): 9e3, ("brick", "plate"): 5e3},
    cohesion={("brick", "brick"): 4e3},
)
PAIR = {("one", "two"): 2e3}


def wall(table: hf.Friction = TABLE) -> hf.Scene:
    """Two bricks on a plate."""
    plate = hf.Body("base", hf.Box((0.2, 0.2, 0.01)), position=(0, 0, -0.005), fixed=True, material="plate")
    bricks = [
        hf.Body(name, hf.Box((0.04, 0.02, 0.01)), 0.01, position=(0, 0, 0.005 + 0.01 * k), material="brick")
        for k, name in enumerate(("one", "two"))
    ]
    return hf.Scene([plate, *bricks], table)


def test_strengths_are_looked_up_as_friction_is() -> None:
    materials = {"a": "brick", "b": "brick", "c": "plate"}
    assert strength_between(TABLE, "a", "b", materials, 0.5) == (8e3, 0.0)  # the cohesion closes the cone at 4000 / 0.5
    assert strength_between(TABLE, "a", "b", materials, 0.4) == pytest.approx((9e3, 400.0))
    assert strength_between(TABLE, "c", "a", materials, 0.4) == (5e3, 0.0)
    assert strength_between(TABLE, "c", "c", materials, 0.4) == (0.0, 0.0)
    assert TABLE.joins
    assert not hf.Friction(0.5, tension={("a", "b"): 0.0}).joins
    assert TABLE.among({"brick"}).tension == {("brick", "brick"): 9e3}
    for wrong in ({"tension": {("a", "b"): -1.0}}, {"cohesion": {"a": 1.0}}, {"tension": 3.0}):
        with pytest.raises(hf.HoldfastError, match=r"tension|cohesion"):
            hf.Friction(0.5, **wrong)
    with pytest.raises(hf.HoldfastError, match=r"tension of .*bric.*unknown name"):
        wall(hf.Friction(0.5, tension={("bric", "plate"): 1.0}))


@pytest.mark.parametrize("name", ["wall.yaml", "wall.json", "wall.glb"])
def test_files_hold_strengths(tmp_path: Path, name: str) -> None:
    hf.save_scene(wall(), tmp_path / name)
    assert hf.load_scene(tmp_path / name).friction == TABLE


def test_a_pair_in_a_file_says_something(tmp_path: Path) -> None:
    hf.save_scene(wall(), tmp_path / "wall.yaml")
    text = (tmp_path / "wall.yaml").read_text()
    assert "tension: 9000" in text
    (tmp_path / "wall.yaml").write_text(text.replace("cohesion: 4000.0", "").replace("tension: 9000.0", ""))
    with pytest.raises(hf.HoldfastError, match="needs mu, tension or cohesion"):
        hf.load_scene(tmp_path / "wall.yaml")


@pytest.mark.parametrize("name", ["wall.xml", "wall.usda"])
def test_other_formats_refuse_strengths(tmp_path: Path, name: str) -> None:
    if name == "wall.usda":
        pytest.importorskip("pxr", reason="usd-core is not installed")
    with pytest.raises(hf.HoldfastError, match=r"tension or a cohesion.*write .yaml"):
        hf.save_scene(wall(), tmp_path / name)
    assert not (tmp_path / name).exists()


def test_a_sum_of_scenes_keeps_both_tables_or_names_the_conflict() -> None:
    def tower(x: float, table: hf.Friction) -> hf.Scene:
        floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
        names = [f"{x:g} lower", f"{x:g} upper"]
        boxes = [
            hf.Body(name, hf.Box((0.1,) * 3), 1.0, position=(x, 0, 0.05 + 0.1 * k), material="box")
            for k, name in enumerate(names)
        ]
        return hf.Scene([floor, *boxes], table)

    glued = hf.Friction(0.5, tension={("0 lower", "0 upper"): 1e3})
    whole = tower(0, glued) + tower(1, hf.Friction(0.5))
    assert whole.friction.tension == glued.tension
    assert hf.stability(whole, engine="limit").stable
    with pytest.raises(hf.HoldfastError, match=r"the tension of .*box.*1000 in one scene and 0"):
        tower(0, hf.Friction(0.5, tension={("box", "box"): 1e3})) + tower(1, hf.Friction(0.5))


REFUSING: dict[str, Callable[[hf.Scene], object]] = {
    "engine graph": lambda scene: hf.stability(scene, engine="graph"),
    "settle": hf.settle,
    "removal": lambda scene: hf.can_remove(scene, "two"),
    "plan_placement": lambda scene: hf.plan_placement(scene, hf.Body("new", hf.Box((0.01,) * 3), 0.01)),
    "pose_sigma": lambda scene: hf.stability(hf.assemble(scene, pose_sigma=1e-4)),
    "imperfect faces": lambda scene: hf.robustness(
        scene, "two", (0, 0, 0.02), (0, 0, -1), imperfect=hf.Imperfect(1e-5, bed=1e10, samples=1)
    ),
}


@pytest.mark.parametrize("where", REFUSING)
def test_what_knows_nothing_of_strengths_says_so(where: str) -> None:
    with pytest.raises(hf.HoldfastError, match=f"{where}.*has a tension or a cohesion"):
        REFUSING[where](wall(hf.Friction(0.5, tension=PAIR)))
    REFUSING["engine graph"](wall(hf.Friction(0.5)))


def test_cohesion_beyond_friction_times_tension_is_refused() -> None:
    for engine in ("limit", "compliant"):
        with pytest.raises(hf.HoldfastError, match="cohesion is 1000 Pa above friction times tension"):
            hf.stability(wall(hf.Friction(0.5, tension=PAIR, cohesion={("one", "two"): 2e3})), engine=engine)
    closed = hf.Friction(0.5, tension=PAIR, cohesion={("one", "two"): 5e2})
    with pytest.raises(hf.HoldfastError, match="leave out cohesion"):
        sensitivity(wall(closed), "two", (0.02, 0, 0.015), (-1, 0, 0))


def test_a_pull_beyond_a_thousand_weights_is_refused() -> None:
    """There `limit` would find forces far above the truth: the weights are lost in the accuracy of its program."""
    for engine in ("limit", "compliant"):
        with pytest.raises(hf.HoldfastError, match="more than 1000 times the weight of all bodies; give at most"):
            hf.stability(wall(hf.Friction(0.5, tension={("one", "two"): 1e9})), engine=engine)


def test_a_margin_lowers_friction_where_a_cohesion_closes_the_cone() -> None:
    closed = hf.Friction(0.5, tension=PAIR, cohesion={("one", "two"): 5e2})
    assert 0 <= hf.stability(wall(closed)).margin <= 1


def test_parts_with_materials_of_their_own_have_no_strength() -> None:
    part = hf.Part(hf.Box((0.01,) * 3), np.eye(4), material="brick")
    other = hf.Part(hf.Box((0.01,) * 3), hf.pose(0.02, 0, 0), material="plate")
    bodies = [*wall().bodies, hf.Body("both", hf.Compound([part, other]), 0.01, position=(0, 0, 0.5))]
    with pytest.raises(hf.HoldfastError, match=r"'both'.*give it one material"):
        hf.Scene(bodies, TABLE)


def test_many_poses_a_monitor_and_certificates_know_strengths(tmp_path: Path) -> None:
    scene = wall(hf.Friction(0.5, tension=PAIR))
    assembly = hf.assemble(scene)
    poses = np.array([hf.pose(x, 0, 0.015) for x in (0, 0.01, 0.025)])
    for engine in ("limit", "compliant"):
        single = [hf.stability(assembly.moved({"two": pose}), engine=engine).status for pose in poses]
        assert hf.stability_of_poses(assembly, "two", poses, engine=engine).status.tolist() == single
    most = hf.transport_limits(assembly, [(1, 0, 0)], engine="limit").acceleration[0]
    for share in (0.5, 0.9):
        assert hf.Monitor(assembly).update(acceleration=(share * most, 0, 0)).margin <= 1 - share + 1e-9
    hf.stability(assembly, engine="limit").save_certificate(tmp_path / "certificate.json")
