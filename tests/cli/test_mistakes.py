"""What newcomers write wrongly is told with what to write instead."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh
from calling import Call, called, column

from holdfast.scene.formats.registry import readable

HEAD = "format: holdfast-scene/1\n"
BODIES = """bodies:
- {{name: floor, shape: {{type: box, size: [1, 1, 0.2]}}, fixed: true, position: [0, 0, -0.1]}}
- {{name: a, shape: {{type: box, size: [0.2, 0.2, 0.2]}}, mass: 1, {more}}}
"""
URDF = """<robot name="arm">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry>{shape}</geometry></collision>
  </link>
</robot>
"""


def scene(folder: Path, more: str, friction: str = "friction: 0.5\n") -> str:
    path = folder / "scene.yaml"
    path.write_text(HEAD + friction + BODIES.format(more=more))
    return str(path)


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """What a command that is refused says, in one line."""

    def told(*arguments: str) -> str:
        code, out, err = called(monkeypatch, capsys, *arguments)
        assert (code, out) == (2, "")
        return " ".join(err.split())

    return told


def test_a_scene_without_friction(said: Callable[..., str], tmp_path: Path) -> None:
    path = scene(tmp_path, "position: [0, 0, 0.1]", friction="")
    assert (
        "friction: is not given; write `friction: 0.5` for all pairs, or "
        "`friction: {pairs: [{between: [cup, table], mu: 0.4}]}`" in said("assess", path)
    )


def test_angles_as_orientation(said: Callable[..., str], tmp_path: Path) -> None:
    path = scene(tmp_path, "position: [0, 0, 0.1], orientation: [0, 0, 90]")
    assert "needs four numbers, a unit quaternion w, x, y, z; write angles as rpy_degrees: [0, 0, 90]" in said(
        "assess", path
    )
    path = scene(tmp_path, "position: [0, 0, 0.1], rpy: [0, 0, 90]")
    assert "bodies[1].rpy (body 'a'): unknown key; did you mean 'rpy_degrees'?" in said("assess", path)
    path = scene(tmp_path, "rpy_degrees: [0, 0, 90], orientation: [1, 0, 0, 0]")
    assert "needs either rpy_degrees or orientation" in said("assess", path)


def test_an_overlap_of_half_a_body(call: Call, tmp_path: Path) -> None:
    code, out, err = call("assess", scene(tmp_path, "position: [0, 0, 0]"))
    assert code == 3
    for text in (out, err):
        words = " ".join(text.split())
        assert words.count("overlap") == 1
        assert "is the origin of a shape in its middle, and not at its foot?" in words
        assert "settle" not in words


@pytest.mark.parametrize(
    ("shape", "options", "place"),
    [
        ('<sphere radius="0.1"/>', (), "arm.urdf:2: <link> 'base': has no friction; give --friction,"),
        ("<box/>", ("--friction", "0.5"), "arm.urdf:4: <box>: has no attribute 'size'; add it"),
        ('<box size="1 1"/>', ("--friction", "0.5"), "arm.urdf:4: <box>: size = '1 1'; needs 3 finite numbers"),
    ],
)
def test_a_urdf_line_is_named_once(
    said: Callable[..., str], tmp_path: Path, shape: str, options: tuple[str, ...], place: str
) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.format(shape=shape))
    text = said("assess", str(path), *options)
    assert text.count("arm.urdf") == 1
    assert place in text


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply"])
def test_a_mesh_as_a_scene(said: Callable[..., str], tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"cup{suffix}"
    trimesh.creation.box((0.1, 0.1, 0.1)).export(path)
    text = said("assess", str(path))
    assert "is a mesh, which says nothing of friction, of mass and of what it lies on" in text
    assert "give --friction, --density or --mass, and --floor or --fixed" in text
    assert "b'" not in text


def test_a_misspelt_command(said: Callable[..., str]) -> None:
    assert said("asses", "table") == "error: command: 'asses' is unknown; did you mean 'assess'?"


def test_numbers_with_commas_are_those_with_spaces(call: Call) -> None:
    answers = {
        call("push", "cube", "cube", "--engine", "limit", *given)
        for given in (
            ("--at", "-0.05", "0", "0.05", "--along", "1", "0", "0"),
            ("--at", "-0.05,0,0.05", "--along", "1,0,0"),
            ("--at=-0.05,0,0.05", "--along=1,0,0"),
        )
    }
    assert len(answers) == 1
    assert next(iter(answers))[0] == 0


def test_several_values_after_an_option_for_one(said: Callable[..., str]) -> None:
    assert "say --bodies before each: --bodies A --bodies B" in said("map", "table", "--bodies", "slab", "leg_0")


def test_what_is_only_balanced_hides_no_other_answer(call: Call, tmp_path: Path) -> None:
    ball = "- {name: an orange, shape: {type: sphere, radius: 0.04}, mass: 0.2, position: [0.4, 0, 0.04]}\n"
    path = Path(scene(tmp_path, "position: [0, 0, 0.1]"))
    path.write_text(path.read_text() + ball)
    code, out, _ = call("transport", path)
    words = "the least is 0 because an orange is only balanced: --without 'an orange' asks about the rest"
    assert (code, words in " ".join(out.split())) == (0, True)


def test_an_overlap_is_told_once_to_each_stream(call: Call, tmp_path: Path) -> None:
    _, out, err = call("map", scene(tmp_path, "position: [0, 0, 0.09]"), "--spacing", "0.1")
    assert (" ".join(out.split()).count("overlap by 10 mm"), " ".join(err.split()).count("by 10 mm")) == (1, 1)


def test_a_body_is_left_out(call: Call) -> None:
    code, out, _ = call("assess", "stack", "--without", "cube3", "--engine", "limit", "--json")
    answer = json.loads(out)
    assert code == 0
    assert "cube3" not in {name for pair in answer["details"]["interfaces"] for name in pair["bodies"]}
    assert "--without cube3" in answer["notes"]
    code, _, err = call("transport", "stack", "--without", "cub3")
    assert code == 2
    assert "has no body named 'cub3'; did you mean 'cube3'?" in err


def test_friction_for_a_file_that_says_its_own(said: Callable[..., str], tmp_path: Path) -> None:
    path = scene(tmp_path, "position: [0, 0, 0.1]")
    text = said("assess", path, "--friction", "0.3")
    assert "it has none: write `friction: 0.3` into the file, or say --friction A:B=0.3 for a pair" in text
    assert "(in Python hf.Scene(scene.bodies, 0.3))" in text
    assert "write `density: 700` or `mass: 0.3` at the body" in said("assess", path, "--density", "700")
    assert "add `{name: floor, shape: {type: halfspace}, fixed: true}` to the bodies" in said("assess", path, "--floor")


def test_the_remedy_for_friction_does_what_it_says(call: Call, tmp_path: Path) -> None:
    path = scene(tmp_path, "position: [0, 0, 0.1]")
    push = ("a", "--at", "-0.1", "0", "0.01", "--along", "1", "0", "0", "--engine", "limit", "--json")
    for given in (("--friction", "a:floor=0.3"), ()):
        if not given:
            path = scene(tmp_path, "position: [0, 0, 0.1]", friction="friction: 0.3\n")
        _, out, _ = call("push", path, *push, *given)
        assert column(out, "force")[0] == pytest.approx(0.3 * 9.81, rel=1e-4)


ALONG = ("--along", "1", "0", "0")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (("--at", "-0.1", "0", *ALONG), "Invalid value for '--at': is '-0.1 0'; needs 3 numbers: --at X Y Z"),
        (("--at=-0.1,0", *ALONG), "Invalid value for '--at': is '-0.1,0'; needs 3 numbers: --at X Y Z"),
        (("--at", "-0.1", "0", "x", *ALONG), "Invalid value for '--at': is '-0.1 0 x'; needs 3 numbers: --at X Y Z"),
        ((*ALONG, "--at", "-0.1", "0"), "Invalid value for '--at': is '-0.1 0'; needs 3 numbers: --at X Y Z"),
        (ALONG, "Missing option '--at'. Give 3 numbers: --at X Y Z"),
    ],
)
def test_a_point_of_two_numbers(said: Callable[..., str], tmp_path: Path, given: tuple[str, ...], told: str) -> None:
    assert told in said("push", scene(tmp_path, "position: [0, 0, 0.1]"), "a", *given)


def test_a_point_in_millimetres(said: Callable[..., str], tmp_path: Path) -> None:
    path = scene(tmp_path, "position: [0, 0, 0.1]")
    text = said("push", path, "a", "--at", "-100", "0", "50", "--along", "1", "0", "0")
    assert "from the surface; are these millimetres? needs points on the body (tolerance" in text
    text = said("push", path, "a", "--at", "-0.1", "0", "0.5", "--along", "1", "0", "0")
    assert "from the surface; needs points on the body (tolerance" in text


def test_a_profile_that_is_neither_a_file_nor_a_name(said: Callable[..., str]) -> None:
    assert "no such file, and no standard profile of this name; did you mean 'road'?" in said(
        "carry", "cube", "--profile", "raod"
    )
    assert "no standard profile of this name; known: eumos40509_0.5g" in said("carry", "cube", "--profile", "drive.csv")


@pytest.mark.parametrize("shape", ["cylinder, height: 0.2", "sphere", "capsule, length: 0.1"])
def test_a_diameter_for_a_radius(said: Callable[..., str], tmp_path: Path, shape: str) -> None:
    path = Path(scene(tmp_path, "position: [0, 0, 0.1]"))
    path.write_text(path.read_text().replace("type: box, size: [0.2, 0.2, 0.2]", f"type: {shape}, diameter: 0.2"))
    assert "bodies[1].shape.diameter (body 'a'): unknown key" in (text := said("assess", str(path)))
    assert "write half of it as 'radius'" in text


@pytest.mark.parametrize(
    ("thing", "options", "remedy"),
    [
        ("open.glb", (), "says nothing of friction; give --friction, or write it to"),
        (
            "open.glb",
            ("--friction", "0.5"),
            "has no mass; give --mass or --density, for it or for all, or --fixed name",
        ),
        ("open.glb", ("--friction", "0.5", "--mass", "1"), "a closed mesh or, where a file is read, --collision hull"),
        ("open.glb", ("--friction", "0.5", "--fixed", "geometry_0", "--world", "w"), "option --world: is unknown"),
        ("open.stl", ("--friction", "0.5"), "give --density or --mass, for it or for all, or --fixed name"),
        ("open.stl", ("--friction", "0.5", "--mass", "1", "--collision", "hull"), "give --floor for a floor at z = 0"),
        ("open.stl", ("--friction", "1", "--mass", "1", "--objects"), "read it as one body, or export it as OBJ"),
        (
            "two.urdf",
            ("--friction", "0.5"),
            "give --rigid for one rigid body (at --joints name=position), --fixed BODY",
        ),
        ("two.urdf", ("--friction", "1", "--rigid"), "--package parts=folder, or --model-path the folder in which"),
        ("mm.yaml", (), "or say --allow-large"),
    ],
)
def test_an_error_of_a_command_names_its_flags(
    said: Callable[..., str], tmp_path: Path, thing: str, options: tuple[str, ...], remedy: str
) -> None:
    """Options as Python takes them, such as floor=True, are of no use to who types a command."""
    mesh = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh.update_faces(range(10))
    for name in ("open.glb", "open.stl"):
        mesh.export(tmp_path / name)
    part = '<mesh filename="package://parts/a.stl"/>'
    joint = '<joint name="j" type="prismatic"><parent link="base"/><child link="b"/></joint>'
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    body = f'<link name="b">{inertial}<collision><geometry><sphere radius="1"/></geometry></collision></link>{joint}'
    (tmp_path / "two.urdf").write_text(URDF.format(shape=part).replace("</robot>", f"{body}</robot>"))
    large = BODIES.replace("0.2, 0.2, 0.2", "200, 200, 200").format(more="position: [0, 0, 100]")
    (tmp_path / "mm.yaml").write_text(f"{HEAD}friction: 0.5\n{large}")
    text = said("assess", str(tmp_path / thing), *options)
    assert remedy in text
    names = {name for each in readable() for name in each.options} - {"material", "gravity"}  # they have no flags
    assert not any(f" {name}=" in text for name in (*names, "allow_large"))
