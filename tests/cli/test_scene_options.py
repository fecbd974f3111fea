"""One set of options for reading scenes, on every command that reads one."""

from __future__ import annotations

import io
import json
import re
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
import trimesh
import typer
from calling import Call, column

import holdfast as hf
from holdfast.cli.main import COMMANDS, app
from holdfast.cli.scenes import AssemblyGiven, SceneGiven
from holdfast.scene.formats.registry import readable
from holdfast.scene.shipped.blocks import box, floor

READING = ("convert", "settle", "rest")
ASSEMBLING = (
    "assess",
    "push",
    "map",
    "place",
    "transport",
    "carry",
    "disassemble",
    "remove",
    "build",
    "safe",
    "firmer",
    "view",
    "calibrate",
)
BLOCK = """<robot name="block"><link name="base"><inertial><mass value="2"/></inertial>
<collision><geometry><box size="0.2 0.1 0.06"/></geometry></collision></link></robot>"""
ARM = """<robot name="arm"><link name="a"><collision><geometry><mesh filename="package://parts/a.stl"/></geometry></collision>
</link><link name="b"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""
MODEL = """<mujoco><worldbody><geom type="plane" size="0 0 1"/><body name="crate" pos="0 0 0.05"><freejoint/>
<geom type="box" size="0.05 0.05 0.05" mass="1"/></body></worldbody>
<keyframe><key name="up" qpos="0 0 0.2 1 0 0 0"/></keyframe></mujoco>"""


@pytest.fixture
def converted(call: Call, tmp_path: Path) -> Callable[..., hf.Scene]:
    """The scene that ``convert`` makes of a file, or of the text of one, with these options."""

    def scene(source: object, *options: object, name: str = "") -> hf.Scene:
        path = tmp_path / name if name else source
        if name:
            (tmp_path / name).write_text(str(source))
        code, _, err = call("convert", path, tmp_path / "out.json", *options)
        assert code == 0, err
        return hf.load_scene(tmp_path / "out.json")

    return scene


def parameters(name: str) -> set[str]:
    command: Any = typer.main.get_command(app)
    return {each.name for each in command.resolve_command(SimpleNamespace(), [name])[1].params}


def test_every_command_that_reads_a_scene_has_all_options() -> None:
    reading, touching = ({each.name for each in fields(kind)} for kind in (SceneGiven, AssemblyGiven))
    for name in COMMANDS:
        found = parameters(name)
        wanted = touching if name in ASSEMBLING else reading if name in READING else set()
        assert wanted <= found, name
        assert bool(wanted) == ("scene" in found), name


def test_every_option_is_one_of_a_reader_or_works_for_all() -> None:
    known = {option for each in readable() for option in each.options}
    assert known - {each.name for each in fields(SceneGiven)} == {"poses", "bodies", "material", "gravity"}
    general = {"scene", "pose", "fixed", "friction", "without", "on_floor", "objects"}  # --objects is bodies="objects"
    for each in fields(SceneGiven):
        assert each.name in known | general


def test_a_body_is_put_where_the_command_says(converted: Callable[..., hf.Scene]) -> None:
    moved = converted("table", "--pose", "slab=1,2,3", "--pose", "leg_left=0,0,1,0,0,90")
    assert moved.body("slab").pose.tolist() == [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(moved.body("leg_left").pose[:3, :3] @ (1, 0, 0), (0, 1, 0), atol=1e-15)
    rolled = converted("table", "--pose", "slab=0,0,0,90,0,90").body("slab").pose[:3, :3]
    np.testing.assert_allclose(rolled @ (0, 1, 0), (0, 0, 1), atol=1e-15)  # rolled first, so it does not follow the yaw
    np.testing.assert_allclose(rolled @ (1, 0, 0), (0, 1, 0), atol=1e-15)
    assert converted("table").body("leg_right") == moved.body("leg_right")


def test_copies_of_a_thing_make_a_tower(call: Call, tmp_path: Path) -> None:
    (tmp_path / "block.urdf").write_text(BLOCK)
    tower = [tmp_path / "block.urdf", "--floor", "--friction", "0.5", "--friction", "low:high=0.25"]
    tower += ["--pose", "low=0,0,0.03", "--pose", "high=0,0,0.09,0,0,90"]
    code, text, _ = call(
        "push", *tower, "high", "--at", -0.05, 0, 0.07, "--along", 1, 0, 0, "--engine", "limit", "--json"
    )
    assert code == 0
    assert column(text, "force") == pytest.approx([0.25 * 2 * 9.81], rel=1e-6)  # slides, low on its side
    code, text, _ = call("assess", *tower, "--fixed", "low", "--engine", "limit", "--json")
    assert code == 0
    assert "low" not in str(json.loads(text)["rows"])


@pytest.mark.parametrize("suffix", [".yaml", ".glb", ".urdf", ".xml"])
def test_a_body_is_held_in_every_format(suffix: str, converted: Callable[..., hf.Scene], tmp_path: Path) -> None:
    if suffix == ".xml":
        pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    path = tmp_path / f"block{suffix}"
    if suffix == ".urdf":
        path.write_text(BLOCK)
    else:
        hf.save_scene(hf.Scene([floor(), box("block", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5), path)
    more = ("--friction", "0.5") if suffix == ".urdf" else ()
    assert converted(path, "--fixed", "block", *more).body("block").fixed


def test_friction_of_a_pair_by_names_that_hold_colons(call: Call, tmp_path: Path) -> None:
    bodies = [box(name, (0.1, 0.1, 0.1), 1, (k, 0, 0.05)) for k, name in enumerate(["a", "b::c", "a:b", ":c", "x=y"])]
    hf.save_scene(hf.Scene([floor(), *bodies], hf.Friction(0.5, {("floor", "a:b"): 0.9})), tmp_path / "s.yaml")
    given = ("convert", tmp_path / "s.yaml", tmp_path / "t.yaml", "--friction")
    assert call(*given, "floor:b::c=0.1", "--friction", "x=y:a=0.2", "--friction", "floor:a:b=0")[0] == 0
    scene = hf.load_scene(tmp_path / "t.yaml")
    assert [scene.mu("floor", name) for name in ("b::c", "a:b", "a")] == [0.1, 0, 0.5]
    assert scene.mu("a", "x=y") == 0.2
    code, _, err = call(*given, "a:b::c=0.1")
    assert code == 2
    assert "--friction: 'a:b::c' may be several pairs" in err


def test_what_a_file_leaves_out_comes_from_the_command(converted: Callable[..., hf.Scene]) -> None:
    no_mass = BLOCK.replace('<inertial><mass value="2"/></inertial>', "")
    scene = converted(no_mass, "--density", 1000, "--friction", 0.4, "--floor", name="block.urdf")
    assert scene.body("block").mass == pytest.approx(1.2, rel=1e-12)
    assert scene.mu("block", "floor") == 0.4


def test_packages_and_joints(converted: Callable[..., hf.Scene], tmp_path: Path) -> None:
    (tmp_path / "else=where").mkdir()
    (tmp_path / "else=where" / "a.stl").write_bytes(_stl())
    package = ("--package", f"parts={tmp_path / 'else=where'}")
    scene = converted(ARM, *package, "--fixed", "arm", "--joints", "lift=0.25", "--friction", 0.5, name="arm.urdf")
    assert scene.body("arm").box[1][2] == 0.75  # the upper cube, lifted by its joint


def _stl() -> bytes:
    import trimesh

    content: bytes = trimesh.creation.box((1, 1, 1)).export(file_type="stl")
    return content


@pytest.mark.parametrize(
    ("options", "height"),
    [((), 0.05), (("--key", "up"), 0.2), (("--key", "0"), 0.2), (("--qpos", "0,0,0.3,1,0,0,0"), 0.3)],
)
def test_positions_of_a_model(options: tuple[str, ...], height: float, converted: Callable[..., hf.Scene]) -> None:
    pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    assert converted(MODEL, *options, name="m.xml").body("crate").pose[2, 3] == pytest.approx(height)


def test_tolerances_reach_the_search(call: Call, tmp_path: Path) -> None:
    hf.save_scene(hf.Scene([floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.052))], 0.5), tmp_path / "s.yaml")
    assert call("assess", tmp_path / "s.yaml", "--engine", "limit")[0] == 3
    assert call("assess", tmp_path / "s.yaml", "--engine", "limit", "--gap", 0.003)[0] == 0


def test_a_stream_takes_options(call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(BLOCK.encode())))
    assert call("convert", "-", tmp_path / "t.json", "--floor", "--friction", "0.3", "--pose", "it=0,0,1")[0] == 0
    assert hf.load_scene(tmp_path / "t.json").body("it").pose[2, 3] == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--key", "up"), "option --key: is unknown to the format 'holdfast scene'; it has none; .* --key: MJCF"),
        (("--density", "5"), "option --density: is unknown .* --density: URDF, SDF, glTF, COMPAS assembly, USD"),
        (("--friction", "0.4"), "option --friction: is unknown to the format"),
        (("--floor",), "option --floor: is unknown to the format"),
        (("--pose", "slab=0,0"), "--pose: is 'slab=0,0'; needs BODY=X,Y,Z or BODY=X,Y,Z,ROLL,PITCH,YAW"),
        (("--pose", "slab=0,0,x"), "--pose: is '0,0,x'; needs BODY=X,Y,Z"),
        (("--pose", "slab=0,0,inf"), "--pose: is 'slab=0,0,inf'"),
        (("--pose", "=0,0,0"), "--pose: is '=0,0,0'"),
        (("--pose", "slab"), "--pose: is 'slab'"),
        (("--pose", "slb=0,0,0"), "no body named 'slb'; did you mean 'slab'"),
        (("--pose", "slab=0,0,0", "--pose", "slab=0,0,1"), "--pose: is given twice for 'slab'"),
        (("--fixed", "slb"), "no body named 'slb'; did you mean 'slab'"),
        (("--friction", "slab=0.3"), "--friction: 'slab' names no pair .* needs MU, or A:B=MU"),
        (("--friction", "slab:lg=0.3"), "--friction: 'slab:lg' names no pair of bodies or materials; known: floor"),
        (("--friction", "slab:floor=x"), "--friction: is 'x'; needs MU"),
        (("--friction", "slab:floor=-1"), "friction of .*: is -1"),
        (("--friction", "1", "--friction", "2"), "--friction: is given 2 times for all"),
        (("--friction", "1,2"), "--friction: is '1,2'"),
        (("--density", "1", "--density", "slab=2"), "--density: is given for all and for some"),
        (("--mass", "1", "--mass", "slab=2"), "--mass: is given for all and for some"),
        (("--mass", "slab=x"), "--mass: is 'x'; needs M, or BODY=M"),
        (("--qpos", "a"), "--qpos: is 'a'; needs numbers with commas between them"),
        (("--joints", "a"), "--joints: is 'a'; needs NAME=VALUE"),
        (("--package", "a"), "--package: is 'a'; needs NAME=FOLDER"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_in_one_line(options: tuple[str, ...], said: str, call: Call, tmp_path: Path) -> None:
    code, out, err = call("convert", "table", tmp_path / "t.yaml", *options)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert re.search(said, err), err
    assert not any(tmp_path.iterdir())


def test_a_map_is_written_to_files_of_other_programs(call: Call, tmp_path: Path) -> None:
    files = {suffix: tmp_path / f"m{suffix}" for suffix in (".glb", ".ply")}
    options = [item for suffix, path in files.items() for item in (f"--{suffix[1:]}", path)]
    code, out, _ = call("map", "cube", "--spacing", 0.05, "--engine", "limit", *options)
    assert code == 0
    assert [path.read_bytes()[:3] for path in files.values()] == [b"glT", b"ply"]
    assert all(f"wrote {path}" in out.replace("\n", "") for path in files.values())
    code, _, err = call("map", "cube", "--glb", tmp_path / "m.ply")
    assert code == 2
    assert "--glb: " in err


def test_a_file_is_put_on_the_floor_after_its_poses(
    converted: Callable[..., hf.Scene], call: Call, tmp_path: Path
) -> None:
    """--pose comes first, whether the reader applies it or the command."""
    given = ("--floor", "--friction", "0.5", "--pose", "block=0,0,0,90,0,0", "--on-floor")
    scene = converted(BLOCK, *given, name="block.urdf")
    assert scene.body("block").pose[2, 3] == pytest.approx(0.05)
    sunk = hf.Scene([floor(), box("block", (0.2, 0.1, 0.06), 1, (0, 0, 0))], 0.5)
    hf.save_scene(sunk, tmp_path / "sunk.yaml")
    scene = converted(tmp_path / "sunk.yaml", "--pose", "block=0,0,-2", "--on-floor")
    assert scene.body("block").pose[2, 3] == pytest.approx(0.03)
    code, out, _ = call("assess", tmp_path / "sunk.yaml", "--on-floor", "--engine", "limit")
    assert code == 0
    assert "note: on_floor: raised by 0.03 m, so that the lowest point is on the floor" in " ".join(out.split())


def test_open_meshes_of_gltf_are_their_hulls_if_a_command_says_so(
    call: Call, converted: Callable[..., hf.Scene], tmp_path: Path
) -> None:
    """A truck as modellers leave it: a box without a side, and wheels without some of their triangles."""
    body, wheel = trimesh.creation.box((2, 1, 1)), trimesh.creation.icosphere(2, 0.25)
    body.update_faces(range(2, 12))
    wheel.update_faces(range(2, len(wheel.faces)))
    truck = trimesh.Scene()
    for name, mesh, at in (("body", body, (0, 1, 0)), ("wheel", wheel, (3, 0.25, 0))):
        truck.add_geometry(mesh, node_name=name, transform=trimesh.transformations.translation_matrix(at))
    truck.export(tmp_path / "truck.glb")
    rest = ("--floor", "--friction", "0.5")
    code, _, err = call("assess", tmp_path / "truck.glb", *rest, "--density", "10")
    assert (code, "is not watertight" in err) == (2, True)
    scene = converted(tmp_path / "truck.glb", *rest, "--density", "10", "--collision", "hull")
    assert scene.body("body").mass == pytest.approx(10 * 2 * 1 * 1)  # ρ V of the whole box
    assert scene.body("body").pose[:3, 3].tolist() == pytest.approx([0, 0, 1])
    assert len(scene.body("body").shape.surface.vertices) == 8
    with pytest.raises(AssertionError, match="node 'wheel': is not watertight"):
        converted(tmp_path / "truck.glb", *rest, "--density", "10", "--collision", "body=hull")
    named = converted(tmp_path / "truck.glb", *rest, "--mass", "body=20", "--mass", "wheel=3", "--collision", "hull")
    assert (named.body("body").mass, named.body("wheel").mass) == (20, 3)


def test_the_hull_of_what_holdfast_wrote_is_that_of_its_mesh(tmp_path: Path) -> None:
    """Its shape in the file is not the body any more, and what is not named stays as it was."""
    outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
    bent = trimesh.creation.extrude_polygon(shapely.Polygon(outline), 1.0)
    mesh = hf.Mesh(bent.vertices, bent.faces)
    things = [hf.Body("bent", mesh, density=1.0), hf.Body("ball", hf.Sphere(0.5), mass=1, position=(5, 0, 0.5))]
    hf.save_scene(hf.Scene([floor(), *things], 0.5), tmp_path / "things.glb")
    scene = hf.load_scene(tmp_path / "things.glb", collision={"bent": "hull"})
    assert scene.body("bent").shape.mass_properties.volume == pytest.approx(3.5)  # 3 m³, and the corner of 1/2
    assert scene.body("ball").shape == hf.Sphere(0.5)
    with pytest.raises(hf.errors.SceneError, match="no body is named 'bant'; did you mean 'bent'"):
        hf.load_scene(tmp_path / "things.glb", collision={"bant": "hull"})
