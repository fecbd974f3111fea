"""URDF: links, joints, masses, friction and files, against closed forms, and against PyBullet where it is installed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scene_content import Load, loading

import holdfast as hf

BOX = '<geometry><box size="0.2 0.4 0.6"/></geometry>'
INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.15"/></inertial>'
MU = '<contact><lateral_friction value="0.5"/></contact>'
LINK = f'<link name="base">{MU}{INERTIAL}<collision>{BOX}</collision></link>'


def robot(content: str) -> str:
    return f'<?xml version="1.0"?>\n<robot name="thing">\n{content}\n</robot>\n'


def link(name: str, content: str = "") -> str:
    return f'<link name="{name}">{content}</link>'


def solid(name: str, shape: str = BOX, inertial: str = INERTIAL, origin: str = "") -> str:
    return link(name, f"{MU}{inertial}<collision>{origin}{shape}</collision>")


def joint(name: str, parent: str, child: str, kind: str = "fixed", rest: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{rest}</joint>'


def origin(xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'


load = loading("thing.urdf", floor=True)


def turn(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Roll, pitch and yaw as three rotations one after the other, about the fixed axes."""
    rotations = [
        trimesh.transformations.rotation_matrix(angle, axis)
        for angle, axis in zip((roll, pitch, yaw), np.eye(3), strict=True)
    ]
    return rotations[2] @ rotations[1] @ rotations[0]


def test_a_link_is_a_body_with_its_mass_and_inertia(load: Load) -> None:
    scene = load(robot(LINK))
    body = scene.body("thing")
    assert (body.mass, body.shape, body.fixed) == (2.0, hf.Box((0.2, 0.4, 0.6)), False)
    assert body.com_body.tolist() == [0, 0, 0]
    assert body.inertia_com.tolist() == np.diag([0.1, 0.2, 0.15]).tolist()
    assert scene.gravity.tolist() == [0, 0, -9.81]
    assert isinstance(scene.body("floor").shape, hf.HalfSpace)


def test_an_inertial_frame_turns_and_shifts_the_inertia(load: Load) -> None:
    inertial = INERTIAL.replace("<inertial>", f"<inertial>{origin('0.1 0.2 0.3', '0.3 -0.4 0.5')}")
    body = load(robot(solid("base", inertial=inertial))).body("thing")
    R = turn(0.3, -0.4, 0.5)[:3, :3]
    np.testing.assert_allclose(body.com_body, [0.1, 0.2, 0.3], rtol=1e-12)
    np.testing.assert_allclose(body.inertia_com, R @ np.diag([0.1, 0.2, 0.15]) @ R.T, rtol=1e-12)


def test_fixed_joints_make_one_body(load: Load) -> None:
    joints = joint("weld", "base", "arm", rest=origin("0 0 1", "0 0.5 0")) + joint(
        "tip", "arm", "end", rest=origin("0.5 0 0")
    )
    body = load(robot(LINK + solid("arm") + link("end") + joints)).body("thing")
    T = turn(0, 0.5, 0)
    T[:3, 3] = (0, 0, 1)
    assert isinstance(body.shape, hf.Compound)
    assert len(body.shape.parts) == 2
    np.testing.assert_allclose(body.shape.parts[1].pose, T, atol=1e-15)
    own, arm = np.diag([0.1, 0.2, 0.15]), np.array([0, 0, 0.5])
    expected = own + T[:3, :3] @ own @ T[:3, :3].T + 2 * 2 * (np.eye(3) * (arm @ arm) - np.outer(arm, arm))
    assert body.mass == 4.0
    np.testing.assert_allclose(body.com_body, [0, 0, 0.5], atol=1e-15)
    np.testing.assert_allclose(body.inertia_com, expected, atol=1e-12)


def test_a_ball_that_is_not_at_the_origin_leaves_the_frame_of_its_link(load: Load) -> None:
    content = robot(solid("base", '<geometry><sphere radius="0.1"/></geometry>', origin=origin("0 0.3 0", "1 0 0")))
    body = load(content).body("thing")
    assert isinstance(body.shape, hf.Compound)
    (part,) = body.shape.parts
    assert part.shape == hf.Sphere(0.1)
    np.testing.assert_allclose(part.pose[:3, 3], [0, 0.3, 0], atol=1e-15)
    np.testing.assert_allclose(part.pose[:3, :3], turn(1, 0, 0)[:3, :3], atol=1e-15)
    np.testing.assert_allclose(body.pose, np.eye(4), atol=1e-15)
    np.testing.assert_allclose(body.com_world, [0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(body.inertia_com, np.diag([0.1, 0.2, 0.15]), atol=1e-15)


def test_a_movable_joint_is_named_and_refused(load: Load) -> None:
    content = robot(LINK + solid("door") + joint("hinge", "base", "door", "revolute"))
    with pytest.raises(
        hf.errors.SceneError,
        match=r"thing.urdf:2: <robot> 'thing': has joints that can move: 'hinge' \(revolute\).*rigid=True",
    ):
        load(content)


@pytest.mark.parametrize(("kind", "position"), [("revolute", 0.7), ("continuous", -2.0), ("prismatic", 0.3)])
def test_joints_hold_at_their_positions_on_request(kind: str, position: float, load: Load) -> None:
    rest = origin("0 0 1", "0.2 0 0") + '<axis xyz="0 2 0"/>'
    content = robot(LINK + solid("door") + joint("hinge", "base", "door", kind, rest))
    body = load(content, rigid=True, joints={"hinge": position}).body("thing")
    moved = np.eye(4)
    if kind == "prismatic":
        moved[1, 3] = position
    else:
        moved = turn(0, position, 0)
    at = turn(0.2, 0, 0)
    at[2, 3] = 1
    np.testing.assert_allclose(body.shape.parts[1].pose, at @ moved, atol=1e-15)


@pytest.mark.parametrize(
    ("kind", "limit", "position", "told"),
    [
        (
            "revolute",
            'lower="-2" upper="2"',
            120,
            "120 rad is outside its limits -2 to 2 rad.* 120 degrees are 2.094 rad",
        ),
        ("revolute", 'lower="-2" upper="2"', -2.1, "-2.1 rad is outside"),
        ("prismatic", 'upper="0.2"', 100, "100 m is outside its limits 0 to 0.2 m; .* 100 mm are 0.1 m"),
        ("revolute", 'lower="-2" upper="1.57"', np.pi / 2, ""),
        ("revolute", 'effort="1"', 1.0, ""),
        ("continuous", 'lower="-2" upper="2"', 6.0, ""),
    ],
)
def test_a_position_outside_the_limits_of_a_joint_is_told_with_both_units(
    kind: str, limit: str, position: float, told: str, load: Load
) -> None:
    content = robot(LINK + solid("arm") + joint("a", "base", "arm", kind, f'<axis xyz="0 0 1"/><limit {limit}/>'))
    if told:
        with pytest.raises(hf.errors.SceneError, match=f"joints: 'a': {told}"):
            load(content, fixed=True, joints={"a": position})
    else:
        assert load(content, fixed=True, joints={"a": position}).notes


@pytest.mark.parametrize(("kind", "expected"), [("prismatic", [0.3, 0, 0]), ("revolute", [0, 0, 0])])
def test_a_joint_without_an_axis_has_the_x_axis(kind: str, expected: list[float], load: Load) -> None:
    content = robot(LINK + solid("door") + joint("hinge", "base", "door", kind))
    pose = load(content, rigid=True, joints={"hinge": 0.3}).body("thing").shape.parts[1].pose
    np.testing.assert_allclose(pose[:3, 3], expected, atol=1e-15)
    np.testing.assert_allclose(pose[:3, 0], [1, 0, 0], atol=1e-15)


def test_a_joint_that_mimics_follows(load: Load) -> None:
    mimic = '<axis xyz="1 0 0"/><mimic joint="a" multiplier="-2" offset="0.1"/>'
    joints = joint("a", "base", "left", "prismatic", '<axis xyz="1 0 0"/>') + joint(
        "b", "base", "right", "prismatic", mimic
    )
    body = load(robot(LINK + solid("left") + solid("right") + joints), rigid=True, joints={"a": 0.3}).body("thing")
    assert sorted(part.pose[0, 3] for part in body.shape.parts) == pytest.approx([-0.5, 0, 0.3])


def test_a_floating_joint_joins_nothing(load: Load) -> None:
    joints = joint("a", "world", "base") + joint("b", "base", "loose", "floating", origin("0 0 1"))
    scene = load(robot(link("world") + LINK + solid("loose") + joints), floor=False)
    assert {body.name: body.fixed for body in scene.bodies} == {"thing/world": True, "thing/loose": False}
    assert scene.body("thing/loose").pose[2, 3] == 1.0


def test_copies_have_names_and_poses(load: Load) -> None:
    high = np.eye(4)
    high[2, 3] = 3.0
    scene = load(robot(LINK), poses={"low": np.eye(4), "high": high})
    assert [body.name for body in scene.bodies] == ["low", "high", "floor"]
    assert scene.body("high").com_world[2] == 3.0
    assert scene.mu("low", "high") == 0.25  # Bullet multiplies
    assert scene.mu("low", "floor") == 0.5


@pytest.mark.parametrize("inertial", ["", "<inertial/>"])
def test_a_density_stands_for_a_missing_mass(inertial: str, load: Load) -> None:
    content = robot(solid("base", inertial=inertial))
    body = load(content, density=100).body("thing")
    assert body.mass == pytest.approx(100 * 0.2 * 0.4 * 0.6, rel=1e-12)
    np.testing.assert_allclose(np.diag(body.inertia_com), body.mass / 12 * np.array([0.52, 0.40, 0.20]), rtol=1e-12)
    with pytest.raises(hf.errors.SceneError, match=r"<link> 'base': has no mass; give density=, or fixed=True"):
        load(content)
    assert "link 'base': mass from density 100 kg/m³" in load(content, density=100).notes
    assert load(content, fixed=True).body("thing").fixed


@pytest.mark.parametrize("option", [None, 100])
@pytest.mark.parametrize("density", ['<density value="500"/>', f'<density value="500"/>{origin()}'])
def test_a_density_in_the_file_comes_before_the_option(density: str, option: float | None, load: Load) -> None:
    body = load(robot(solid("base", inertial=f"<inertial>{density}</inertial>")), density=option).body("thing")
    assert body.mass == pytest.approx(500 * 0.2 * 0.4 * 0.6, rel=1e-12)
    np.testing.assert_allclose(np.diag(body.inertia_com), body.mass / 12 * np.array([0.52, 0.40, 0.20]), rtol=1e-12)
    both = INERTIAL.replace("<mass", '<density value="500"/><mass')
    assert load(robot(solid("base", inertial=both)), density=option).body("thing").mass == 2.0


def test_an_inertia_that_is_missing_is_that_of_the_shape(load: Load) -> None:
    inertial = f'<inertial>{origin("0 0 0.1")}<mass value="3"/></inertial>'
    body = load(robot(solid("base", inertial=inertial))).body("thing")
    like = hf.Body("like", hf.Box((0.2, 0.4, 0.6)), mass=3, com=(0, 0, 0.1))
    np.testing.assert_allclose(body.inertia_com, like.inertia_com, rtol=1e-12)


def test_what_is_seen_stands_for_what_collides(load: Load) -> None:
    scene = load(robot(link("base", f"{MU}{INERTIAL}<visual>{BOX}</visual>")))
    assert scene.body("thing").shape == hf.Box((0.2, 0.4, 0.6))
    assert "link 'base': no <collision>, its <visual> is taken" in scene.notes


DRAKE = "<drake:proximity_properties><drake:mu_static value='{}'/></drake:proximity_properties>"


@pytest.mark.parametrize(
    ("tags", "pair"),
    [
        ("bullet", 0.8 * 0.2),
        ("drake", 2 * 0.8 * 0.2 / (0.8 + 0.2)),
        ("gazebo", 0.2),
    ],
)
def test_friction_is_combined_as_its_simulator_does(tags: str, pair: float, load: Load) -> None:
    links, more = [], ""
    for name, mu in (("a", 0.8), ("b", 0.2)):
        own = {"bullet": f'<contact><lateral_friction value="{mu}"/></contact>'}.get(tags, "")
        inside = DRAKE.format(mu) if tags == "drake" else ""
        links.append(link(name, f"{own}{INERTIAL}<collision>{BOX}{inside}</collision>"))
        more += f'<gazebo reference="{name}"><mu1>{mu}</mu1><mu2 value="{mu}"/></gazebo>' if tags == "gazebo" else ""
    scene = load(robot("".join(links) + joint("apart", "a", "b", "floating", origin("0 0 2")) + more))
    assert scene.mu("thing/a", "thing/b") == pytest.approx(pair, rel=1e-15)
    assert [scene.mu(f"thing/{name}", "floor") for name in "ab"] == [0.8, 0.2]


def test_friction_is_never_guessed(load: Load) -> None:
    content = robot(LINK.replace(MU, ""))
    with pytest.raises(hf.errors.SceneError, match=r"<link> 'base': has no friction; give friction="):
        load(content)
    assert load(content, friction=0.3).mu("thing", "floor") == 0.3


def test_friction_of_two_kinds_needs_a_choice(load: Load) -> None:
    content = robot(LINK + '<gazebo reference="base"><mu1>0.9</mu1><mu2>0.7</mu2></gazebo>')
    with pytest.raises(
        hf.errors.SceneError, match=r"has friction for bullet and gazebo, .*; give simulator='bullet', or another"
    ):
        load(content)
    assert load(content, simulator="bullet").mu("thing", "floor") == 0.5
    assert load(content, simulator="gazebo").mu("thing", "floor") == 0.7


def test_a_thing_alone_needs_something_below(load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"nothing carries; give floor=True .* fixed=True"):
        load(robot(LINK), floor=False)


def test_what_is_not_read_and_may_matter_is_named(load: Load) -> None:
    odd = robot(LINK + '<gazebo reference="base"><static>true</static><kp>1</kp></gazebo><tether/>')
    note = "not read, though it may matter: <static> in <gazebo>, <tether> in <robot>"
    assert note in load(odd, friction=0.5).notes
    assert not [note for note in load(robot(LINK), friction=0.5).notes if "not read" in note]


def test_tiny_spheres_are_points(load: Load) -> None:
    scene = load(robot(solid("base", '<geometry><sphere radius="1e-7"/></geometry>')), friction=0.5)
    assert "link 'base': spheres of radius 1e-07 m are taken as points (1e-06 m)" in scene.notes
    assert scene.movable[0].shape == hf.Sphere(1e-6)


def test_a_box_without_size_is_a_point(load: Load) -> None:
    """As Bullet takes it: it stands for a link of which nothing is to be seen."""
    scene = load(robot(solid("base", '<geometry><box size="0 0 0"/></geometry>')), friction=0.5)
    assert scene.movable[0].shape == hf.Sphere(1e-6)
    with pytest.raises(hf.HoldfastError, match=r"<box>: Box: size: is \[0.1, 0.0, 0.1\]"):
        load(robot(solid("base", '<geometry><box size="0.1 0 0.1"/></geometry>')), friction=0.5)


def test_a_broken_declaration_is_overlooked(load: Load) -> None:
    assert load(robot(LINK).replace('"1.0"', '"0.0"')).body("thing").mass == 2.0


def mesh(name: str, scale: str = "1 1 1") -> str:
    return robot(solid("base", f'<geometry><mesh filename="{name}" scale="{scale}"/></geometry>'))


def test_meshes_are_found_in_the_folder_of_meshes_beside(tmp_path: Path) -> None:
    """As packages of ROS have it, without the name of the package; nothing else outside, and no link to elsewhere."""
    (tmp_path / "urdf").mkdir()
    for folder in ("meshes", "secret"):
        (tmp_path / folder / "visual").mkdir(parents=True)
        for name in ("cube.stl", "visual/cube.stl"):
            trimesh.creation.box((1, 1, 1)).export(tmp_path / folder / name)
    path = tmp_path / "urdf" / "thing.urdf"
    for name in ("../meshes/cube.stl", "../meshes/visual/cube.stl"):
        path.write_text(mesh(name, "0.1 0.2 0.3"))
        np.testing.assert_allclose(np.ptp(hf.load_scene(path, floor=True).body("thing").box, axis=0), (0.1, 0.2, 0.3))
    (tmp_path / "mesh").symlink_to(tmp_path / "secret")
    for name in ("../secret/cube.stl", "../meshes/../secret/cube.stl", "../mesh/cube.stl", "../../meshes/cube.stl"):
        path.write_text(mesh(name))
        with pytest.raises(hf.errors.SceneError, match="outside of the folder of the file"):
            hf.load_scene(path, floor=True)


def test_meshes_are_scaled_and_found_in_packages(load: Load, tmp_path: Path) -> None:
    (tmp_path / "elsewhere" / "meshes").mkdir(parents=True)
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "elsewhere" / "meshes" / "cube.stl")
    content = mesh("package://parts/meshes/cube.stl", "0.1 0.2 0.3")
    for package in ({"parts": tmp_path / "elsewhere"}, lambda name: tmp_path / "elsewhere"):
        body = load(content, package=package).body("thing")
        assert body.box[1].tolist() == pytest.approx([0.05, 0.1, 0.15])
    (tmp_path / "elsewhere" / "package.xml").write_text("<package/>")
    (tmp_path / "elsewhere").rename(tmp_path / "parts")
    (tmp_path / "parts" / "urdf").mkdir()
    (tmp_path / "parts" / "urdf" / "thing.urdf").write_text(content)
    assert hf.load_scene(tmp_path / "parts" / "urdf" / "thing.urdf", floor=True).body("thing").mass == 2.0


def test_a_package_has_the_name_that_its_manifest_says(load: Load, tmp_path: Path) -> None:
    """As in ROS, whatever the folder of a checkout is called."""
    folder, broken = tmp_path / "checkout", tmp_path / "another"
    (folder / "meshes").mkdir(parents=True)
    broken.mkdir()
    (broken / "package.xml").write_text("<package><name>parts")
    trimesh.creation.box((1, 1, 1)).export(folder / "meshes" / "cube.stl")
    (folder / "package.xml").write_text("<package format='3'><name>parts</name></package>")
    content = mesh("package://parts/meshes/cube.stl")
    beside = load(content)
    (folder / "thing.urdf").write_text(content)
    assert hf.load_scene(folder / "thing.urdf", floor=True) == beside
    (folder / "package.xml").write_text("<package format='3'><name>other</name></package>")
    with pytest.raises(hf.errors.SceneError, match="the package 'parts', whose folder is unknown"):
        load(content)


def test_a_link_of_the_file_system_does_not_lead_out(load: Load, tmp_path: Path) -> None:
    outside = tmp_path.parent / f"{tmp_path.name}_outside"
    outside.mkdir()
    trimesh.creation.box((1, 1, 1)).export(outside / "cube.stl")
    (tmp_path / "cube.stl").symlink_to(outside / "cube.stl")
    with pytest.raises(hf.errors.SceneError, match=r"<mesh>: names 'cube.stl', outside of the folder"):
        load(mesh("cube.stl"))
    assert load(mesh("cube.stl"), package={"any": outside}).body("thing").mass == 2.0


WRONG: dict[str, tuple[str, str]] = {
    "no links": (robot(""), "<robot> 'thing': has no links; needs at least one"),
    "no shape": (robot(link("base", INERTIAL)), "has no link with a shape"),
    "nothing": (robot(link("base")), "has no link with a shape"),
    "link twice": (robot(LINK + LINK), "<link> 'base': stands twice"),
    "joint twice": (robot(LINK + solid("b") + joint("j", "base", "b") * 2), "<joint> 'j': stands twice"),
    "two parents": (
        robot(LINK + solid("b") + joint("j", "base", "b") + joint("k", "base", "b")),
        "<joint> 'k': is a second joint to the link 'b'",
    ),
    "circle": (robot(LINK + solid("b") + joint("j", "base", "b") + joint("k", "b", "base")), "has joints in a circle"),
    "circle beside a root": (
        robot(LINK + solid("b") + solid("c") + joint("j", "c", "b") + joint("k", "b", "c")),
        "has joints in a circle",
    ),
    "own parent": (robot(LINK + joint("j", "base", "base")), "has joints in a circle"),
    "two roots": (robot(LINK + solid("b")), r"has 2 links that no joint carries \(base, b\)"),
    "unknown link": (robot(LINK + joint("j", "base", "bse")), "<joint> 'j': names the link 'bse'; did you mean 'base'"),
    "unknown kind": (robot(LINK + solid("b") + joint("j", "base", "b", "rope")), "type = 'rope'; needs one of fixed"),
    "negative mass": (robot(LINK.replace('mass value="2"', 'mass value="-2"')), "<mass>: value: is -2"),
    "no number": (robot(LINK.replace('mass value="2"', 'mass value="nan"')), "<mass>: value = 'nan'; needs a finite"),
    "infinite": (robot(LINK.replace('ixx="0.1"', 'ixx="1e999"')), "<inertia>: ixx = '1e999'; needs a finite"),
    "negative size": (robot(LINK.replace("0.2 0.4", "-0.2 0.4")), r"urdf:3: <box>: Box: size: is \[-0.2, 0.4, 0.6\]"),
    "two numbers": (robot(LINK.replace("0.2 0.4 0.6", "0.2 0.4")), "<box>: size = '0.2 0.4'; needs 3 finite"),
    "impossible inertia": (robot(LINK.replace('ixx="0.1"', 'ixx="-0.1"')), "has a negative principal moment"),
    "unknown shape": (robot(LINK.replace("<box", "<cone")), "<cone>: is unknown; reads box"),
    "two shapes": (robot(LINK.replace("</geometry>", '<sphere radius="1"/></geometry>')), "has 2 shapes; needs one"),
    "negative friction": (robot(LINK.replace('value="0.5"', 'value="-0.5"')), "'base': friction: is -0.5"),
    "mirrored": (mesh("cube.stl", "1 -1 1"), "scale = 1 -1 1 mirrors the mesh"),
    "no file": (mesh("cube.stl"), "cube.stl: no such mesh file"),
    "other suffix": (mesh("cube.dae"), "cube.dae: no such mesh file"),
    "escape": (mesh("../../secret.stl"), r"<mesh>: names '../../secret.stl', outside of the folder"),
    "absolute": (mesh("/etc/passwd"), "<mesh>: names '/etc/passwd', outside of the folder"),
    "file scheme": (mesh("file:///etc/passwd"), "outside of the folder"),
    "web": (mesh("https://example.org/a.stl"), "needs a path, file://"),
    "unknown package": (mesh("package://parts/a.stl"), r"the package 'parts', .*; give package=\{'parts': folder\}"),
    "zero byte": (mesh("a&#10;b.stl"), "no such mesh file"),
    "macro": (robot('<xacro:include filename="a.xacro"/>'), "<xacro:include>: is a macro; expand"),
    "mimics itself": (
        robot(LINK + solid("b") + joint("j", "base", "b", "revolute", '<mimic joint="j"/>')),
        "<joint> 'j': mimics itself",
    ),
    "not closed": ("<robot name='a'><link>", ":1: is not XML: no element found; check"),
    "unknown entity": (robot("&lol;"), ":3: is not XML: undefined entity; check"),
    "entity bomb": (
        '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><robot>&b;</robot>',
        r":1: has a document type \(<!DOCTYPE>\); remove it",
    ),
    "outside entity": (
        '<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="a">&a;</robot>',
        r":1: has a document type",
    ),
    "deep": ("<robot>" + "<a>" * 500 + "</a>" * 500 + "</robot>", ":1: is nested too deeply"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_clear_error(name: str, load: Load) -> None:
    content, match = WRONG[name]
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content)
    assert "thing.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"joints": {"hnge": 1.0}}, "joints: 'hnge': is no joint; did you mean 'hinge'"),
        ({"joints": {"hinge": float("nan")}}, "joints: 'hinge': is nan"),
        ({"joints": {"weld": 1.0}}, "'weld': is fixed and has the position 1"),
        ({"poses": {}}, "poses: is {}; needs a dict"),
        ({"pose": 2 * np.eye(4)}, r"pose: last row is \[0.0, 0.0, 0.0, 2.0\]"),
        ({"density": -1.0}, "density: is -1"),
        ({"friction": -1.0}, "friction: is -1"),
        ({"simulator": "ode"}, "simulator: is 'ode'; needs one of bullet, drake, gazebo"),
    ],
)
def test_options_are_checked(options: dict[str, object], match: str, load: Load) -> None:
    joints = joint("hinge", "base", "door", "revolute") + joint("weld", "base", "b")
    content = robot(LINK + solid("door", inertial="") + solid("b") + joints)
    with pytest.raises(hf.HoldfastError, match=match):
        load(content, **{"rigid": True, **options})


def test_pybullet_reads_the_same(load: Load, tmp_path: Path) -> None:
    """A chain of links at joint positions, with turned inertial frames. PyBullet rounds to 2e-8 m."""
    bullet = pytest.importorskip("pybullet", reason="needs pybullet, of the extra bench")
    inertial = INERTIAL.replace("<inertial>", f"<inertial>{origin('0.1 0.2 0.3', '0.3 -0.4 0.5')}")
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    joints = joint("a", "base", "arm", "revolute", origin("0.3 0 1", "0.1 0.2 0.3") + '<axis xyz="1 2 -1"/>' + limit)
    joints += joint("b", "arm", "hand", "prismatic", origin("0 1 0", "-1 0.5 2") + '<axis xyz="0 0.6 0.8"/>' + limit)
    content = robot(LINK + solid("arm", inertial=inertial) + solid("hand") + joints)
    scene = load(content, fixed=True, joints={"a": 0.4, "b": -0.2})
    client = bullet.connect(bullet.DIRECT)
    try:
        robot_id = bullet.loadURDF(str(tmp_path / "thing.urdf"), flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        bullet.resetJointState(robot_id, 0, 0.4)
        bullet.resetJointState(robot_id, 1, -0.2)
        states = [bullet.getLinkState(robot_id, k, computeForwardKinematics=True) for k in range(2)]
        masses = [bullet.getDynamicsInfo(robot_id, k)[0] for k in (-1, 0, 1)]
    finally:
        bullet.disconnect(client)
    body = scene.body("thing")
    for part, state in zip(body.shape.parts[1:], states, strict=True):
        np.testing.assert_allclose(part.pose[:3, 3], state[4], atol=1e-7)
        rotation = np.array(bullet.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        np.testing.assert_allclose(part.pose[:3, :3], rotation, atol=1e-7)
    coms = [np.zeros(3), *(np.array(state[0]) for state in states)]
    assert body.mass == pytest.approx(sum(masses), rel=1e-12)
    expected = sum(mass * com for mass, com in zip(masses, coms, strict=True)) / sum(masses)
    np.testing.assert_allclose(body.com_world, expected, atol=1e-7)


@pytest.mark.parametrize("links", ["one", "many"])
def test_a_long_file_is_read_or_refused_in_time(links: str, load: Load) -> None:
    """What is read for every shape is looked up, not searched: twenty thousand times twenty thousand would not end."""
    many = 20_000
    if links == "many":
        content = "".join(link(f"l{k}") for k in range(many))
        content += "".join(joint(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(many - 1))
        with pytest.raises(hf.errors.SceneError, match="has no link with a shape"):
            load(robot(content))
    else:
        tags = '<contact><inertia_scaling value="3"/></contact>' * many
        with pytest.raises(hf.errors.SceneError, match="has no friction"):
            load(robot(link("base", f"{INERTIAL}{tags}" + f"<collision>{BOX}</collision>" * many)))
