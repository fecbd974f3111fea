"""SDF: frames, included and nested models, joints, masses, friction and files, against closed forms and PyBullet."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scene_content import Load, loading

import holdfast as hf

GROUND = (
    '<model name="ground"><static>true</static><link name="link"><collision name="c"><geometry><plane>'
    "<normal>0 0 1</normal><size>9 9</size></plane></geometry></collision></link></model>"
)
BOX = "<box><size>0.2 0.4 0.6</size></box>"
INERTIAL = "<inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.15</izz></inertia></inertial>"


def world(content: str, version: str = "1.9") -> str:
    return f'<?xml version="1.0"?>\n<sdf version="{version}">\n<world name="w">{GROUND}\n{content}</world></sdf>'


def pose(xyz: str = "0 0 0", rpy: str = "0 0 0", rest: str = "") -> str:
    return f"<pose{rest}>{xyz} {rpy}</pose>"


def collision(shape: str = BOX, rest: str = "", name: str = "c") -> str:
    return f'<collision name="{name}">{rest}<geometry>{shape}</geometry></collision>'


def link(name: str = "link", rest: str = "", shapes: str | None = None, inertial: str = INERTIAL) -> str:
    return f'<link name="{name}">{rest}{inertial}{collision() if shapes is None else shapes}</link>'


def model(content: str, name: str = "m", rest: str = "") -> str:
    return f'<model name="{name}"{rest}>{content}</model>'


def joint(parent: str, child: str, kind: str = "fixed", name: str = "j", rest: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{rest}</joint>'


def ode(mu: str, more: str = "") -> str:
    return f"<surface><friction><ode><mu>{mu}</mu>{more}</ode></friction></surface>"


load = loading("scene.sdf")


def at(*xyz: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix(xyz)


def turned(angle: float, *axis: float) -> np.ndarray:
    return trimesh.transformations.rotation_matrix(angle, axis)


def test_a_pose_is_relative_to_a_frame_that_is_relative_to_another(load: Load) -> None:
    frames = (
        f'<frame name="a" attached_to="other">{pose("0 0 1", "0 0 0.5")}</frame>'
        '<frame name="b"><pose relative_to="a">1 0 0 0.3 0 0</pose></frame>'
    )
    content = frames + link("other", pose("0 2 0", "0 0.7 0")) + link("link", pose("0 0 3", rest=' relative_to="b"'))
    scene = load(world(model(content + pose("5 0 0", "0 0 1"))))
    expected = at(5, 0, 0) @ turned(1, 0, 0, 1) @ at(0, 2, 0) @ turned(0.7, 0, 1, 0)
    np.testing.assert_allclose(scene.body("m::other").pose, expected, atol=1e-14)
    expected = expected @ at(0, 0, 1) @ turned(0.5, 0, 0, 1) @ at(1, 0, 0) @ turned(0.3, 1, 0, 0) @ at(0, 0, 3)
    np.testing.assert_allclose(scene.body("m::link").pose, expected, atol=1e-14)


def test_degrees_quaternions_and_joints_as_frames(load: Load) -> None:
    content = link("a", pose("0 0 1", "90 0 0", ' degrees="true"'))
    content += link("b", '<pose rotation_format="quat_xyzw" relative_to="j">0 0 2  0 0 0.6 0.8</pose>')
    content += link("c") + joint("world", "a", rest=pose("0 0 5"))
    scene = load(world(model(content)))
    a = at(0, 0, 1) @ turned(np.pi / 2, 1, 0, 0)
    np.testing.assert_allclose(scene.body("m::a").pose, a, atol=1e-15)
    expected = a @ at(0, 0, 7) @ turned(2 * np.arctan2(0.6, 0.8), 0, 0, 1)
    np.testing.assert_allclose(scene.body("m::b").pose, expected, atol=1e-14)
    assert scene.body("m::a").fixed


def test_a_model_may_be_placed_by_a_frame_of_its_own(load: Load) -> None:
    content = pose("5 0 0") + f'<frame name="grip">{pose("0 0 2", "0 0 1")}</frame>' + link("link", pose("0 1 0"))
    scene = load(world(model(content, rest=' placement_frame="grip"')))
    expected = at(5, 0, 0) @ np.linalg.inv(at(0, 0, 2) @ turned(1, 0, 0, 1)) @ at(0, 1, 0)
    np.testing.assert_allclose(scene.body("m").pose, expected, atol=1e-14)


def test_nested_models_are_found_by_their_names(load: Load) -> None:
    inner = model(link(rest=pose("0 0 1")), "inner", "").replace("<link", pose("1 0 0") + "<link", 1)
    content = model(inner + link("top", pose("0 0 4", rest=' relative_to="inner::link"')) + pose("0 1 0"), "outer")
    scene = load(world(content))
    assert scene.body("outer").pose[:3, 3].tolist() == [1, 1, 5]
    assert scene.body("outer::inner").pose[:3, 3].tolist() == [1, 1, 1]


def test_fixed_joints_make_one_body(load: Load) -> None:
    content = link("a") + link("b", pose("0 0 1", "0 0.5 0")) + joint("a", "b")
    body = load(world(model(content))).body("m")
    own, arm, T = np.diag([0.1, 0.2, 0.15]), np.array([0, 0, 0.5]), at(0, 0, 1) @ turned(0.5, 0, 1, 0)
    expected = own + T[:3, :3] @ own @ T[:3, :3].T + 4 * (np.eye(3) * (arm @ arm) - np.outer(arm, arm))
    assert isinstance(body.shape, hf.Compound)
    assert body.mass == 4.0
    np.testing.assert_allclose(body.com_body, arm, atol=1e-15)
    np.testing.assert_allclose(body.inertia_com, expected, atol=1e-12)
    np.testing.assert_allclose(body.shape.parts[1].pose, T, atol=1e-15)


def test_models_joined_across_each_other_are_one_body(load: Load) -> None:
    scene = load(
        world(
            model(link(), "a")
            + model(link(), "b", "").replace("<link", pose("0 0 1") + "<link", 1)
            + joint("a", "b::link")
        )
    )
    assert [body.name for body in scene.movable] == ["a"]
    assert scene.body("a").mass == 4.0


def test_joints_that_move_are_named_or_welded(load: Load) -> None:
    content = world(model(link("a") + link("b", pose("0 0 1")) + joint("a", "b", "revolute", "hinge")))
    with pytest.raises(
        hf.errors.SceneError, match=r"sdf:4: <joint> 'hinge': can move; .* 'm::hinge' \(revolute\).*rigid=True"
    ):
        load(content)
    scene = load(content, rigid=True)
    assert scene.body("m").mass == 4.0
    assert "joints that hold as if welded: 'm::hinge' (revolute)" in scene.notes
    assert all(body.fixed for body in load(content, fixed=["m"]).bodies)


def test_friction_of_a_pair_is_the_least_of_both(load: Load) -> None:
    a = model(link(shapes=collision(rest=ode("0.6", "<mu2>0.4</mu2>"))), "a")
    b = model(link(shapes=collision(rest=ode("0.5"))) + pose("0 0 3"), "b")
    scene = load(world(a + b))
    assert (scene.mu("a", "b"), scene.mu("a", "ground"), scene.mu("b", "ground")) == (0.4, 0.4, 0.5)
    assert load(world(a + b), friction=0.1).mu("a", "ground") == 0.1


def test_friction_of_bullet_is_multiplied(load: Load) -> None:
    bullet = "<surface><friction><bullet><friction>0.5</friction></bullet></friction></surface>"
    both = ode("0.3").replace("</friction>", "<bullet><friction>0.5</friction></bullet></friction>")
    of_bullet, of_both = (
        "".join(model(link(shapes=collision(rest=rest)) + pose(f"0 0 {k}"), f"m{k}") for k in (1, 2))
        for rest in (bullet, both)
    )
    assert load(world(of_bullet)).mu("m1", "m2") == 0.25
    assert load(world(of_both)).mu("m1", "m2") == 0.3
    assert load(world(of_both), simulator="bullet").mu("m1", "m2") == 0.25
    assert load(world('<physics type="bullet"/>' + of_both)).mu("m1", "m2") == 0.25


def drake(mu: float, tag: str = "drake:mu_static") -> str:
    return f"<drake:proximity_properties><{tag}>{mu}</{tag}></drake:proximity_properties>"


def crates(*friction: str) -> str:
    """A crate for each, far from the others."""
    each = [model(link(shapes=collision(rest=rest)) + pose(f"{k} 0 0.3"), f"m{k}") for k, rest in enumerate(friction)]
    return world("".join(each)).replace("<sdf ", '<sdf xmlns:drake="http://drake.mit.edu" ')


def test_friction_of_drake_is_combined_as_drake_does(load: Load) -> None:
    scene = load(crates(drake(0.2), drake(0.6), ""))
    assert scene.mu("m0", "m1") == pytest.approx(2 * 0.2 * 0.6 / 0.8)
    assert scene.mu("m0", "m2") == pytest.approx(2 * 0.2 * 0.5 / 0.7)  # Drake's own where a file says none
    notes = "\n".join(scene.notes)
    assert "friction: tags of drake; of two surfaces it is their harmonic mean" in notes
    assert "friction 0.5, which Drake says where a file says none" in notes
    assert load(crates(drake(0.2), ""), friction=0.3).mu("m0", "m1") == pytest.approx(0.24)


def test_friction_of_drake_and_of_others_needs_a_choice(load: Load) -> None:
    content = crates(drake(0.2) + ode("0.4"), drake(0.6) + ode("0.8"))
    with pytest.raises(
        hf.errors.SceneError, match=r"friction for ode and drake, which combine it in different ways; give sim"
    ):
        load(content)
    assert load(content, simulator="drake").mu("m0", "m1") == pytest.approx(0.3)
    assert load(content, simulator="ode").mu("m0", "m1") == pytest.approx(0.4)


def test_a_collision_without_contact_touches_nothing(load: Load) -> None:
    ghost = "<surface><contact><collide_without_contact>true</collide_without_contact></contact></surface>"
    below = model(link(shapes=collision(rest=ghost)) + "<static>true</static>" + pose("0 0 0.3"), "ghost")
    on_it = model(link() + pose("0 0 0.9"), "crate")
    scene = load(world(below + on_it))
    assert "link ghost::link: touches nothing (collide_without_contact)" in scene.notes
    found = hf.stability(scene)
    assert found.status == hf.Status.UNSTABLE
    assert "the scene keeps these two apart" in found.reason
    assert (
        hf.stability(load(world(below.replace("true</collide", "false</collide") + on_it))).status == hf.Status.STABLE
    )


def test_tiny_spheres_are_points(load: Load) -> None:
    """As Drake's models of the YCB objects have them: four points carry a box that is a little smaller."""
    low = "".join(
        collision("<sphere><radius>1e-07</radius></sphere>", pose(f"{x} {y} -0.3"), f"p{x}{y}")
        for x in (-0.1, 0.1)
        for y in (-0.2, 0.2)
    )
    shapes = collision(BOX.replace("0.6", "0.59"), drake(0.4)) + low.replace("<geometry>", drake(0.4) + "<geometry>")
    scene = load(world(model(link(shapes=shapes) + pose("0 0 0.3"))), friction=0.4)
    assert any("spheres of radius 1e-07 m are taken as points (1e-06 m)" in note for note in scene.notes)
    answer = hf.robustness(scene, "m", (0.1, 0, 0.05), (-1, 0, 0), engine="limit")
    assert answer.force == pytest.approx(0.4 * 2 * 9.8, rel=1e-5)


def test_what_is_not_read_and_may_matter_is_named(load: Load) -> None:
    odd = link(rest="<kinematic>true</kinematic>", shapes=collision(rest=ode("0.4", "<slip1>0.1</slip1>")))
    content = world(model(odd + "<plugin name='p' filename='f'/>") + "<population name='p'/><gui/>" + "<wind/>")
    scene = load(content)
    assert (
        "not read, though it may matter: <kinematic> in <link>, <population> in <world>, <slip1> in <ode>"
        in scene.notes
    )
    assert not [note for note in load(world(model(link()))).notes if "not read" in note]


def test_a_note_says_once_what_is_so_of_many_links(load: Load) -> None:
    scene = load(world("".join(model(link() + pose(f"{k} 0 0.3"), f"m{k}") for k in range(30))))
    (note,) = [note for note in scene.notes if "friction 1, which SDF says" in note]
    assert note.startswith("links ground::link, m0::link, m1::link")
    assert "and 25 more: friction 1" in note
    assert note in hf.stability(scene).notes
    assert note in hf.robustness(scene, "m0", (0.1, 0, 0), (-1, 0, 0)).notes


def test_parts_have_friction_of_their_own(load: Load) -> None:
    shapes = collision(rest=ode("0.3")) + collision(rest=pose("0 0 0.6") + ode("0.7"), name="d")
    scene = load(world(model(link(shapes=shapes))))
    assert [part.material for part in scene.body("m").shape.parts] == ["friction 0.3", "friction 0.7"]
    assert scene.friction.pairs["friction 0.3", "friction 0.7"] == 0.3
    assert scene.friction.pairs["friction 0.7", "friction 0.7"] == 0.7


def test_masses_are_worked_out_from_densities(load: Load) -> None:
    shapes = collision("<sphere><radius>0.5</radius></sphere>", "<density>10</density>")
    shapes += collision("<cone><radius>0.5</radius><length>2</length></cone>", pose("0 0 1.5"), "d")
    inertial = '<inertial auto="true"><density>30</density></inertial>'
    body = load(world(model(link(shapes=shapes, inertial=inertial)))).body("m")
    ball, cone = 10 * 4 / 3 * np.pi / 8, 30 * np.pi / 4 * 2 / 3
    assert body.mass == pytest.approx(ball + cone, rel=1e-12)
    assert body.com_body[2] == pytest.approx(cone * 1.0 / (ball + cone), rel=1e-12)  # a quarter of its height up
    across = ball * 0.4 / 4 + cone * (3 / 20 / 4 + 3 / 80 * 4) + ball * cone / (ball + cone)
    moments = np.array([across, across, ball * 0.1 + cone * 0.3 / 4])
    np.testing.assert_allclose(np.diag(body.inertia_com), moments, rtol=1e-12)
    given = inertial.replace("<density>", "<mass>5</mass><density>")
    scaled = load(world(model(link(shapes=shapes, inertial=given)))).body("m")
    assert scaled.mass == pytest.approx(5, rel=1e-12)
    np.testing.assert_allclose(np.diag(scaled.inertia_com), moments * 5 / (ball + cone), rtol=1e-12)
    usual = load(world(model(link(inertial='<inertial auto="true"/>')))).body("m")
    assert usual.mass == pytest.approx(48, rel=1e-12)  # 0.048 m³ of water, which SDF says where a file says none


def test_an_inertial_frame_turns_and_shifts_the_inertia(load: Load) -> None:
    inertial = INERTIAL.replace("<mass>", pose("0.1 0.2 0.3", "0.4 0 0") + "<mass>")
    body = load(world(model(link(inertial=inertial)))).body("m")
    R = turned(0.4, 1, 0, 0)[:3, :3]
    assert body.com_body.tolist() == [0.1, 0.2, 0.3]
    np.testing.assert_allclose(body.inertia_com, R @ np.diag([0.1, 0.2, 0.15]) @ R.T, atol=1e-15)


def test_links_of_one_model_do_not_touch_unless_it_says_so(load: Load) -> None:
    content = link("a") + link("b", pose("0 0 0.5"))
    assert load(world(model(content))).excluded == (("m::a", "m::b"),)
    assert load(world(model(content + "<self_collide>true</self_collide>"))).excluded == ()


def test_collisions_without_a_common_bit_do_not_touch(load: Load) -> None:
    def masked(name: str, mask: str) -> str:
        rest = f"<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface>"
        return model(link(shapes=collision(rest=rest)), name)

    scene = load(world(masked("a", "0x01") + masked("b", "6") + masked("c", "4")))
    assert scene.excluded == (("a", "b"), ("a", "c"))


def test_single_collisions_without_a_common_bit_do_not_touch(load: Load) -> None:
    def masked(name: str, mask: str) -> str:
        rest = f"<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface>"
        return collision(rest=pose("0 0 1") + rest, name=name)

    both = model(link(shapes=masked("c", "1") + masked("d", "2")), "a")
    scene = load(world(both + model(link(shapes=masked("c", "2")), "b") + model(link(shapes=masked("c", "3")), "c")))
    assert scene.excluded == ((("a", 0), "b"),)


def test_a_plane_is_a_half_space_along_its_normal(load: Load) -> None:
    plane = collision("<plane><normal>0 -1 0</normal></plane>", pose("0 2 0"))
    wall = model("<static>1</static>" + link(shapes=plane + collision(name="d")) + pose("0 0 1"), "wall")
    scene = load(world(wall))
    body = scene.body("wall::plane")
    assert isinstance(body.shape, hf.HalfSpace)
    np.testing.assert_allclose(body.pose[:3, 2], [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(body.pose[:3, 3], [0, 2, 1], atol=1e-15)
    assert scene.body("wall").fixed


def test_name_pose_and_static_of_an_include_come_first(load: Load, tmp_path: Path) -> None:
    folder = tmp_path / "models" / "crate"
    folder.mkdir(parents=True)
    trimesh.creation.box((1, 1, 1)).export(folder / "crate.stl")
    shape = collision("<mesh><uri>model://crate/crate.stl</uri><scale>0.1 0.2 0.3</scale></mesh>")
    (folder / "v2.sdf").write_text(f'<sdf version="1.9">{model(link(rest=pose("0 0 1"), shapes=shape), "crate")}</sdf>')
    (folder / "model.config").write_text('<model><sdf version="1.9">v2.sdf</sdf></model>')
    include = "<include><uri>model://crate</uri>{}</include>"
    content = (
        include.format("")
        + include.format(f"<name>b</name>{pose('0 0 2')}")
        + include.format("<name>c</name><static>1</static>")
    )
    scene = load(world(content), package={"crate": folder})
    assert {body.name: body.pose[2, 3] for body in scene.bodies} == {"ground": 0, "crate": 1, "b": 3, "c": 1}
    assert [body.name for body in scene.movable] == ["crate", "b"]
    np.testing.assert_allclose(scene.body("b").box[1], [0.05, 0.1, 3.15], atol=1e-12)
    with pytest.raises(hf.errors.SceneError, match=r"<uri>: names the package 'crate'.*give package="):
        load(world(content))


def merging(content: str = "", at: str = "") -> str:
    return f'<include merge="true"><uri>part.sdf</uri>{at}</include>{content}'


PART = (
    pose("0 0 9")
    + link("a", pose("0.5 0 0"))
    + f'<frame name="f" attached_to="a">{pose("0 0.3 0", "0.2 0 0")}</frame>'
    + link("b", pose("0 0 1", rest=' relative_to="f"'))
    + link("lone", pose("0 0 7", rest=' relative_to="__model__"'))
    + joint("a", "b")
)


@pytest.mark.parametrize("own", ["", "<self_collide>true</self_collide>"])
@pytest.mark.parametrize("held", [(), ("m",)])
def test_a_model_merged_into_another_is_that_with_its_links_written_out(
    own: str, held: tuple[str, ...], load: Load, tmp_path: Path
) -> None:
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9">{model(PART, "part")}</sdf>')
    rest = (
        own
        + link("c", pose("0 0 2", rest=' relative_to="b"'))
        + joint("c", "lone", name="k")
        + link("d", pose("0 0 20"))
    )
    where = pose("5 0 0", "0 0 1")
    place = pose("0 2 0", "0 0.7 0")
    written = (
        f'<frame name="part">{place}</frame>'
        + link("a", pose("0.5 0 0", rest=' relative_to="part"'))
        + f'<frame name="f" attached_to="a">{pose("0 0.3 0", "0.2 0 0")}</frame>'
        + link("b", pose("0 0 1", rest=' relative_to="f"'))
        + link("lone", pose("0 0 7", rest=' relative_to="part"'))
        + joint("a", "b")
    )
    merged, expected = (
        load(world(model(content + rest + where)), fixed=held) for content in (merging(at=place), written)
    )
    assert {body.name for body in merged.bodies} == {"ground", "m::a", "m::c", "m::d"}
    for body in expected.bodies:
        twin = next(each for each in merged.bodies if np.allclose(each.box, body.box, atol=1e-12))
        assert (twin.fixed, twin.mass) == (body.fixed, pytest.approx(body.mass))
        if not body.fixed:
            centers = [each.pose[:3, :3] @ each.com + each.pose[:3, 3] for each in (twin, body)]
            np.testing.assert_allclose(*centers, atol=1e-12)
    assert len(merged.excluded) == len(expected.excluded) == (0 if own or held else 3)


def test_names_of_merged_models_are_those_of_the_model_around_them(load: Load, tmp_path: Path) -> None:
    (tmp_path / "part.sdf").write_text(f'<sdf version="1.9">{model(PART, "part")}</sdf>')
    for more, match in ((link("a"), "'a'|second of this name"), (joint("a", "part::b", name="k"), "no model 'part'")):
        with pytest.raises(hf.errors.SceneError, match=match):
            load(world(model(merging(more))))
        with pytest.raises(hf.errors.SceneError, match=match):
            load(world(model(more + merging())))


@pytest.mark.parametrize(
    "what", ['<light name="sun"/>', '<light name="sun"/><actor name="walker"/>', '<actor name="a"/>']
)
def test_lights_and_actors_are_included_as_nothing(what: str, load: Load, tmp_path: Path) -> None:
    (tmp_path / "sun").mkdir()
    (tmp_path / "sun" / "model.sdf").write_text(f'<sdf version="1.6">{what}</sdf>')
    include = "<include><uri>model://sun</uri></include>"
    assert load(world(model(link()) + include), package={"sun": tmp_path / "sun"}) == load(world(model(link())))


FUEL = "https://fuel.gazebosim.org/1.0/OpenRobotics/models/"


@pytest.mark.parametrize(
    ("sun", "plane"), [("model://sun", "model://ground_plane"), (FUEL + "Sun", FUEL + "Ground Plane")]
)
def test_the_models_of_every_classic_world_need_no_folder(sun: str, plane: str, load: Load, tmp_path: Path) -> None:
    """A light is nothing; the plane has friction 50, and the least of two counts: pushed low, 2 kg slide at mu m g."""
    crate = model(link(shapes=collision(rest=ode("0.3"))) + pose("0 0 0.3"))
    around = (
        f'<sdf version="1.6"><world name="w"><include><uri>{sun}</uri></include><include><uri>{plane}</uri></include>'
    )
    scene = load(f"{around}{crate}</world></sdf>")
    assert [body.name for body in scene.bodies] == ["ground_plane", "m"]
    assert "ground_plane is in no folder: Gazebo's is taken, a plane with a friction of 50" in scene.notes
    push = hf.robustness(scene, "m", (-0.1, 0, 0.01), (1, 0, 0), engine="limit")
    assert push.force == pytest.approx(0.3 * 2 * 9.8, rel=1e-4)
    own = tmp_path / "models" / "ground_plane"
    own.mkdir(parents=True)
    (own / "model.sdf").write_text(f'<sdf version="1.6">{GROUND}</sdf>')
    if plane.startswith("model"):
        mine = load(f"{around}{crate}</world></sdf>", model_path=[tmp_path / "models"])
        assert [body.name for body in mine.bodies] == ["ground", "m"]
    with pytest.raises(hf.errors.SceneError, match="names the package 'moon', whose folder is unknown"):
        load(world("<include><uri>model://moon</uri></include>"))


def test_the_address_of_a_file_of_models_follows_the_model_path(load: Load, tmp_path: Path) -> None:
    (tmp_path / "elsewhere" / "crate" / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.2, 0.4, 0.6)).export(tmp_path / "elsewhere" / "crate" / "meshes" / "c.stl")
    mesh = "<mesh><uri>file://models/crate/meshes/c.stl</uri></mesh>"
    content = world(model(link(shapes=collision(mesh))))
    body = load(content, model_path=[tmp_path / "elsewhere"]).body("m")
    np.testing.assert_allclose(np.ptp(body.box, axis=0), (0.2, 0.4, 0.6), atol=1e-6)
    with pytest.raises(hf.errors.SceneError, match=r"the package 'crate', whose folder is unknown.*model_path="):
        load(content)
    for way in ("file://models/crate/../../secret.stl", "file://models/../../secret.stl"):
        with pytest.raises(hf.errors.SceneError, match=r"outside of the folder|whose folder is unknown"):
            load(content.replace("file://models/crate/meshes/c.stl", way), model_path=[tmp_path / "elsewhere"])


@pytest.mark.parametrize("comment", ["<!-- sim --iterations 100 -->", "<!----\n\n a -- b --->", "<!---->"])
def test_comments_may_hold_hyphens(comment: str, load: Load) -> None:
    assert load(world(comment + model(link()))) == load(world(model(link())))
    line = 5 + comment.count("\n")
    with pytest.raises(hf.errors.SceneError, match=rf"scene.sdf:{line}: <collision> 'c': has no <geometry>"):
        load(world(comment + "\n" + model(link(shapes='<collision name="c"/>'))))


def test_text_that_looks_like_a_comment_is_kept(load: Load) -> None:
    (body,) = load(world(model(link("l", pose("0 0 3").replace("0 0 3", "<![CDATA[0 0 3]]>"))))).movable
    assert body.pose[2, 3] == 3
    with pytest.raises(hf.errors.SceneError, match="<!-- 3 -->"):
        load(world(model(link("l", "<pose><![CDATA[<!-- 3 -->]]></pose>"))))


def test_shapes_and_masses_may_be_placed_relative_to_their_own_link(load: Load) -> None:
    def scene(rest: str) -> hf.Scene:
        shapes = collision(rest=pose("0.1 0 0.2", "0 0 0.3", rest))
        inertial = INERTIAL.replace("<inertial>", "<inertial>" + pose("0 0.1 0", "0.2 0 0", rest))
        return load(world(model(link(shapes=shapes, inertial=inertial))))

    assert scene(' relative_to="link"') == scene("")


def test_a_lone_model_needs_a_floor(load: Load) -> None:
    content = f'<sdf version="1.9">{model(link(shapes=collision(rest=ode("0.3"))))}</sdf>'
    with pytest.raises(hf.errors.SceneError, match=r"has nothing that is static; give floor=True"):
        load(content)
    assert load(content, floor=True).mu("m", "floor") == 0.3


def test_gravity_and_one_of_several_worlds(load: Load) -> None:
    worlds = "".join(f'<world name="w{k}"><gravity>0 {k} -1</gravity>{GROUND}</world>' for k in (1, 2))
    content = f'<sdf version="1.9">{worlds}</sdf>'
    assert load(content, world="w2").gravity.tolist() == [0, 2, -1]
    with pytest.raises(hf.errors.SceneError, match=r"<sdf>: has 2 worlds and 0 models; name one with world="):
        load(content)


def test_pybullet_reads_the_same(load: Load, tmp_path: Path) -> None:
    bullet = pytest.importorskip("pybullet", reason="needs pybullet, of the extra bench")
    inertial = INERTIAL.replace("<mass>", pose("0.1 0.2 0.3", "0.4 0.1 0") + "<mass>").replace(
        "<iyy>", "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz><iyy>"
    )
    content = "".join(model(pose(f"0 {k} {k}", "0.1 0.2 0.3") + link(inertial=inertial), f"m{k}") for k in (1, 2))
    scene = load(world(content, "1.6"))
    client = bullet.connect(bullet.DIRECT)
    try:
        found = bullet.loadSDF(str(tmp_path / "scene.sdf"))
        named = {bullet.getBodyInfo(body)[1].decode(): body for body in found}
        for name in ("m1", "m2"):
            position, _ = bullet.getBasePositionAndOrientation(named[name])
            np.testing.assert_allclose(scene.body(name).com_world, position, atol=1e-9)
            assert scene.body(name).mass == bullet.getDynamicsInfo(named[name], -1)[0]
    finally:
        bullet.disconnect(client)


def meshed(uri: str) -> str:
    return world(model(link(shapes=collision(f"<mesh><uri>{uri}</uri></mesh>"))))


def relative(name: str) -> str:
    return pose(rest=f' relative_to="{name}"')


def attached(names: Sequence[str]) -> str:
    """Frames, each of which is attached to the next."""
    return "".join(f'<frame name="{a}" attached_to="{b}"/>' for a, b in pairwise(names))


WRONG: dict[str, tuple[str, str]] = {
    "no world": ('<sdf version="1.9"/>', "<sdf>: has 0 worlds and 0 models; needs one"),
    "nothing": ('<sdf><world name="w"/></sdf>', "<world> 'w': has no link with a shape"),
    "second name": (world(model(link() + link())), "<link> 'link': is the second of this name"),
    "second model": (world(model(link()) * 2), "<model> 'm': is the second of this name"),
    "kept name": (world(model(link(), "a::b")), "<model> 'a::b': has a name that SDF keeps for itself"),
    "unknown frame": (world(model(link(rest=relative("lnk")))), "names 'lnk', which is not there; did you mean 'link'"),
    "unknown model": (world(model(link(rest=relative("n::a")))), "names 'n::a': no model 'n'"),
    "frame circle": (
        world(model(attached("aba") + link(rest=relative("a")))),
        "<frame> 'a': has a pose that is relative to itself",
    ),
    "own frame": (world(model(link(rest=relative("link")))), "<link> 'link': has a pose that is relative to itself"),
    "long chain": (
        world(model(attached([f"f{k}" for k in range(400)]) + '<frame name="f399"/>' + link(rest=relative("f0")))),
        "has a pose behind too many frames; the limit is 200",
    ),
    "placed by itself": (
        world(model(link() + f'<frame name="a">{relative("a")}</frame>', rest=' placement_frame="a"')),
        "<frame> 'a': has a pose that is relative to itself",
    ),
    "attached in a circle": (
        world(model(link() + attached("aba") + joint("a", "link"))),
        "attached to itself",
    ),
    "joint to nothing": (world(model(link() + joint("lnk", "link"))), "<parent>: names 'lnk'"),
    "no child": (
        world(model(link() + '<joint name="j" type="fixed"><parent>link</parent></joint>')),
        "<joint> 'j': has no <child>",
    ),
    "no child, and a parent that is not there": (
        world(model(link() + '<joint name="j" type="fixed"><parent>lnk</parent></joint>')),
        "<parent>: names 'lnk'",
    ),
    "pose of five": (world(model(link(rest="<pose>0 0 0 0 0</pose>"))), "<pose>: holds '0 0 0 0 0'; needs 6 finite"),
    "pose of nan": (world(model(link(rest="<pose>0 0 0 0 0 nan</pose>"))), "needs 6 finite numbers"),
    "no unit quaternion": (
        world(model(link(rest='<pose rotation_format="quat_xyzw">0 0 0 0 0 0 2</pose>'))),
        "quaternion of length 2",
    ),
    "negative size": (
        world(model(link(shapes=collision("<sphere><radius>-1</radius></sphere>")))),
        "<sphere>: Sphere: radius: is -1",
    ),
    "negative cone": (
        world(model(link(shapes=collision("<cone><radius>1</radius><length>-1</length></cone>")))),
        "<cone>: length: is -1",
    ),
    "negative mass": (world(model(link(inertial=INERTIAL.replace("2</mass>", "-2</mass>")))), "<mass>: is -2"),
    "impossible inertia": (world(model(link(inertial=INERTIAL.replace("0.1<", "-0.1<")))), "negative principal moment"),
    "negative friction": (world(model(link(shapes=collision(rest=ode("-1"))))), "friction: is -1"),
    "heightmap": (world(model(link(shapes=collision("<heightmap/>")))), "<heightmap>: is not read; reads box"),
    "submesh": (
        world(model(link(shapes=collision("<mesh><uri>a.stl</uri><submesh><name>x</name></submesh></mesh>")))),
        "takes one of several meshes",
    ),
    "mirrored": (
        world(model(link(shapes=collision("<mesh><uri>a.stl</uri><scale>1 1 -1</scale></mesh>")))),
        "scale = 1 1 -1 mirrors the mesh",
    ),
    "two shapes": (world(model(link(shapes=collision(BOX * 2)))), "<geometry>: has 2 shapes"),
    "zero normal": (
        world(model("<static>1</static>" + link(shapes=collision("<plane><normal>0 0 0</normal></plane>")))),
        "zero normal",
    ),
    "plane that moves": (world(model(link(shapes=collision("<plane/>")))), "<link> 'link': has a <plane> and can move"),
    "weightless": (world(model(link(rest="<gravity>0</gravity>"))), "<link> 'link': has no weight"),
    "no truth": (world(model("<static>yes</static>" + link())), "<static>: is 'yes'; needs true or false"),
    "mask": (
        world(
            model(
                link(
                    shapes=collision(rest="<surface><contact><collide_bitmask>x</collide_bitmask></contact></surface>")
                )
            )
        ),
        "<collide_bitmask>: is 'x'",
    ),
    "escape": (meshed("../../a.stl"), "<uri>: names '../../a.stl', outside of the folder"),
    "web": (meshed("https://fuel.gazebosim.org/1.0/a.stl"), "needs a path, file://"),
    "include of the web": (
        world("<include><uri>https://fuel.gazebosim.org/a</uri></include>"),
        "needs a path, file://",
    ),
    "include out of it": (world("<include><uri>../../etc</uri></include>"), "outside of the folder"),
    "include of nothing": (world("<include><uri>none.sdf</uri></include>"), "none.sdf: no such model file"),
    "include of itself": (
        world("<include><uri>scene.sdf</uri></include>"),
        "<include>: includes '.*scene.sdf', in which it lies",
    ),
    "merge": (world('<include merge="true"><uri>a.sdf</uri></include>'), "merges a model into the world"),
    "no uri": (world("<include/>"), "<include>: has no <uri>"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_clear_error(name: str, load: Load) -> None:
    content, match = WRONG[name]
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content)
    assert "scene.sdf" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_includes_in_a_circle_are_refused(load: Load, tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        text = model(f"<include><uri>{other}.sdf</uri></include>", name)
        (tmp_path / f"{name}.sdf").write_text(f"<sdf>{text}</sdf>")
    with pytest.raises(hf.errors.SceneError, match=r"b.sdf:1: <include>: includes '.*a.sdf', in which it lies"):
        load(world("<include><uri>a.sdf</uri></include>"))


def test_includes_that_multiply_are_refused(load: Load, tmp_path: Path) -> None:
    for level in range(12):
        inner = "".join(f"<include><uri>m{level + 1}.sdf</uri><name>n{k}</name></include>" for k in range(3))
        (tmp_path / f"m{level}.sdf").write_text(f"<sdf>{model(inner, f'm{level}')}</sdf>")
    (tmp_path / "m12.sdf").write_text(f"<sdf>{model(link(), 'm12')}</sdf>")
    with pytest.raises(hf.errors.SceneError, match=r"<include>: is one too many; the limit is 2,000"):
        load(world("<include><uri>m0.sdf</uri></include>"))


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"fixed": ["n"]}, "fixed: no model is named 'n'"),
        ({"fixed": True}, "fixed: is True; needs a list"),
        ({"world": "x"}, "has no world 'x'"),
        ({"simulator": "dart"}, "simulator: is 'dart'"),
        ({"density": 0}, "density: is 0"),
        ({"friction": -1}, "friction: is -1"),
    ],
)
def test_options_are_checked(options: dict[str, object], match: str, load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        load(world(model(link())), **options)
