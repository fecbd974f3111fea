"""MJCF and running MuJoCo models: what moves, which shapes, and MuJoCo's rules of contact and friction."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scene_content import read_scene

import holdfast as hf

mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")

FLOOR = '<geom name="floor" type="plane" size="1 1 1"/>'
CUBE = '<body name="{name}" pos="{pos}"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'


def text(world: str, rest: str = "") -> str:
    return f"<mujoco><worldbody>{world}</worldbody>{rest}</mujoco>"


def scene(world: str, rest: str = "", **options: Any) -> hf.Scene:
    return read_scene(text(world, rest).encode(), "scene.xml", **options)


def model(world: str, rest: str = "") -> tuple[Any, Any]:
    made = mujoco.MjModel.from_xml_string(text(world, rest))
    data = mujoco.MjData(made)
    mujoco.mj_forward(made, data)
    return made, data


def cube(name: str, pos: str = "0 0 .1") -> str:
    return CUBE.format(name=name, pos=pos)


def random_world(seed: int) -> tuple[str, str]:
    """Balls in one place, so that every two touch that may; classes of all kinds, pairs and exclusions among them."""
    rng = np.random.default_rng(seed)
    geoms, bodies = [], []
    for k in range(10):
        mu = rng.choice([0.1, 0.4, 0.9])
        geom = (
            f'<geom name="g{k}" type="sphere" size=".1" friction="{mu}" priority="{rng.integers(2)}" '
            f'condim="{rng.choice([1, 3, 4])}" contype="{rng.integers(4)}" conaffinity="{rng.integers(4)}"/>'
        )
        geoms.append(f"g{k}")
        place = f"{0.001 * k} 0 0"
        bodies.append(geom if k == 9 else f'<body name="b{k}" pos="{place}"><freejoint/>{geom}</body>')
    contact = ""
    for a, b in rng.choice(list(itertools.combinations(range(9), 2)), 4, replace=False):
        contact += f'<pair geom1="g{a}" geom2="g{b}" condim="{rng.choice([1, 3])}" friction="{rng.uniform():.3f}"/>'
    for a, b in rng.choice(list(itertools.combinations(range(9), 2)), 6, replace=False):
        contact += f'<exclude body1="b{a}" body2="b{b}"/>'
    contact += '<exclude body1="world" body2="b3"/>'
    return "".join(bodies), f"<contact>{contact}</contact>"


@pytest.mark.parametrize("seed", range(12))
def test_who_touches_whom_with_which_friction_is_what_mujoco_does(seed: int) -> None:
    made, data = model(*random_world(seed))
    read = hf.from_mujoco(made, data)
    theirs = {}
    for (g, h), dim, friction in zip(data.contact.geom, data.contact.dim, data.contact.friction[:, 0], strict=True):
        names = sorted(made.geom(int(k)).name.replace("g", "b").replace("b9", "g9") for k in (g, h))
        theirs[tuple(names)] = 0.0 if dim == 1 else friction
    known = {body.name for body in read.bodies}
    dropped = {f"b{k}" for k in range(9)} | {"g9"}
    dropped -= known
    assert not any(name in pair for name in dropped for pair in theirs)
    ours = set(itertools.combinations(sorted(known), 2)) - set(read.excluded)
    assert ours == set(theirs)
    assert {pair: read.mu(*pair) for pair in ours} == pytest.approx(theirs, abs=1e-12)


def test_an_override_counts_for_all() -> None:
    rest = '<option o_friction="0.3 0.3 0.01 0.01 0.01"><flag override="enable"/></option>'
    read = scene(FLOOR + cube("a"), rest)
    assert read.mu("floor", "a") == 0.3


def test_a_body_of_geoms_of_several_frictions_has_parts_of_several_materials() -> None:
    feet = "".join(
        f'<geom name="foot{k}" type="box" size=".1 .1 .1" pos="{k} 0 0" friction="{mu}"/>'
        for k, mu in enumerate((0.2, 0.2, 0.7))
    )
    body = f'<body name="table" pos="0 0 .1"><freejoint/>{feet}</body>'
    read = scene('<geom name="floor" type="plane" size="1 1 1" friction="0.5"/>' + body)
    table = read.body("table")
    assert isinstance(table.shape, hf.Compound)
    found = [read.friction.between("floor", "table", {**read.materials, "table": m}) for m in table.materials]
    assert found == [0.5, 0.5, 0.7]
    assert [part.material for part in table.shape.parts] == [None, None, "friction 0.7"]
    contacts = hf.assemble(read)
    assert sorted(contacts.mu) == [0.5, 0.7]


def test_every_shape_stands_where_mujoco_has_it() -> None:
    """Vertices of each shape in the world lie on the geom that MuJoCo measures distances to, and none is cut short."""
    geoms = {
        "box": ('type="box" size=".1 .2 .3"', 0.2 * 0.4 * 0.6),
        "ball": ('type="sphere" size=".2"', 4 / 3 * np.pi * 0.008),
        "can": ('type="cylinder" size=".2 .1"', np.pi * 0.04 * 0.2),
        "pill": ('type="capsule" size=".1 .2"', np.pi * 0.01 * 0.4 + 4 / 3 * np.pi * 0.001),
        "egg": ('type="ellipsoid" size=".1 .2 .3"', 4 / 3 * np.pi * 0.006),
        "wedge": ('type="mesh" mesh="wedge"', 1 / 6),
    }
    asset = '<asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1 .1 .1 .1"/></asset>'
    for name, (geom, volume) in geoms.items():
        body = '<body name="b" pos=".1 .2 3" euler="20 30 40"><freejoint/>'
        body += f'<geom {geom} pos=".3 0 0" euler="5 6 7"/></body>'
        probe = '<body name="probe" mocap="true"><geom type="sphere" size=".001"/></body>'
        made, data = model(body + probe, asset)
        solid = hf.from_mujoco(made, data).body("b")
        assert solid.shape.mass_properties.volume == pytest.approx(volume, rel=1e-6), name
        vertices = solid.surface_world.vertices
        for vertex in vertices[:: max(1, len(vertices) // 20)]:
            data.mocap_pos[0] = vertex
            mujoco.mj_kinematics(made, data)
            distance = mujoco.mj_geomDistance(made, data, 0, 1, 1.0, None)
            assert distance == pytest.approx(-0.001, abs=1e-4), name


def test_a_height_field_is_the_solid_below_it() -> None:
    heights = "0.1 0.9 0.3 0.7  0.5 0.2 1.0 0.0  0.6 0.4 0.8 0.25"
    asset = f'<asset><hfield name="h" nrow="3" ncol="4" size="1.5 1 0.7 0.2" elevation="{heights}"/></asset>'
    probe = '<body name="probe" pos="0 0 2"><freejoint/><geom type="sphere" size=".01"/></body>'
    made, data = model('<geom name="hill" type="hfield" hfield="h" pos=".1 .2 .3" euler="0 0 30"/>' + probe, asset)
    hill = hf.from_mujoco(made, data).body("hill")
    assert hill.fixed
    assert hill.shape.is_closed
    body = hill.surface_world
    up = np.flatnonzero(body.normals[:, 2] > 0.1)
    for face in up:
        centre = body.vertices[body.faces[face]].mean(0)
        data.qpos[:3] = centre + 0.0098 * body.normals[face]
        mujoco.mj_forward(made, data)
        assert data.contact.dist.min() == pytest.approx(-0.0002, abs=1e-6)


def test_planes_are_half_spaces_of_their_own() -> None:
    read = scene('<geom name="slope" type="plane" pos="1 2 3" euler="0 30 0" size="1 1 1"/>' + cube("a", "0 0 9"))
    slope = read.body("slope")
    assert isinstance(slope.shape, hf.HalfSpace)
    assert slope.fixed
    assert slope.pose[:3, 2] == pytest.approx([0.5, 0, np.sqrt(0.75)])
    assert slope.pose[:3, 3] == pytest.approx([1, 2, 3])


def test_welded_bodies_are_one_body_with_the_mass_of_all() -> None:
    inner = '<body name="lid" pos="0 0 .3" euler="0 0 45"><geom type="box" size=".1 .2 .05" mass="2"/></body>'
    outer = '<body name="jar" pos="1 0 1" euler="10 20 30"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/>'
    outer += f"{inner}</body>"
    made, data = model(FLOOR + outer)
    jar = hf.from_mujoco(made, data).body("jar")
    assert [len(jar.shape.parts), jar.mass] == [2, pytest.approx(5, abs=1e-12)]
    assert jar.com_world == pytest.approx(data.subtree_com[1], abs=1e-12)
    like = hf.Body("like", jar.shape, mass=5).inertia_com  # MuJoCo's masses are not of one density: another inertia
    assert not np.allclose(jar.inertia_com, like, rtol=1e-3)
    turn = jar.pose[:3, :3]
    whole = inertia_about(made, data, jar.com_world)
    assert turn @ jar.inertia_com @ turn.T == pytest.approx(whole, abs=1e-12)


def inertia_about(made: Any, data: Any, point: np.ndarray) -> np.ndarray:
    """The inertia of all bodies about a point, along the world's axes, from MuJoCo's own frames of inertia."""
    whole = np.zeros((3, 3))
    for b in range(1, made.nbody):
        turn, arm = data.ximat[b].reshape(3, 3), data.xipos[b] - point
        whole += turn @ np.diag(made.body_inertia[b]) @ turn.T
        whole += made.body_mass[b] * (np.eye(3) * (arm @ arm) - np.outer(arm, arm))
    return whole


ARM = (
    '<body name="link" pos="0 0 1"><joint name="hinge" axis="0 1 0"/>'
    '<geom type="capsule" size=".05" fromto="0 0 0 1 0 0"/>'
    '<body name="hand" pos="1 0 0"><joint name="wrist" axis="0 1 0"/><geom type="box" size=".1 .1 .1"/></body></body>'
)


def test_a_chain_on_the_world_is_fixed_where_it_is_one_body_a_link() -> None:
    motor = '<actuator><position joint="hinge"/><motor joint="wrist"/></actuator>'
    read = scene(FLOOR + ARM + cube("a"), motor, qpos=[0.5, 0.2, 0, 0, 0.1, 1, 0, 0, 0])
    assert [(b.name, b.fixed) for b in read.bodies] == [("floor", True), ("link", True), ("hand", True), ("a", False)]
    assert read.body("hand").pose[:3, 3] == pytest.approx([np.cos(0.5), 0, 1 - np.sin(0.5)])
    (note,) = [note for note in read.notes if "held fixed" in note]
    assert "link, hand" in note
    with pytest.raises(hf.errors.SceneError, match=r"joints that can move: joint 'wrist' of 'hand'; say rigid=True"):
        scene(FLOOR + ARM + cube("a"), motor.replace('<motor joint="wrist"/>', ""))


FINGERS = FLOOR + "".join(
    f'<body name="{name}" pos="{x} 0 1"><joint name="{name}" type="slide" axis="1 0 0"/><geom size=".1"/></body>'
    for x, name in enumerate(("left", "right"))
)
ON_TENDON = '<tendon><fixed name="both"><joint joint="left" coef="1"/><joint joint="right" coef="2"/></fixed></tendon>'
LEFT = '<actuator><motor joint="left"/></actuator>'
COUPLED = '<equality><joint joint1="left" joint2="right"/></equality>'
BAR = '<body name="{0}" pos="{1}"><joint name="{0}" axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 {2}"/>'
FOUR_BARS = FLOOR + (
    BAR.format("crank", "0 0 1", "0 0 .3")
    + BAR.format("rod", "0 0 .3", ".5 0 0")
    + "</body></body>"
    + BAR.format("rocker", ".5 0 1", "0 0 .3")
    + "</body>"
)
LOOP = '<equality><connect body1="rod" body2="rocker" anchor=".5 0 0"/></equality>'


@pytest.mark.parametrize(
    ("world", "rest", "loose"),
    [
        (FINGERS, COUPLED + LEFT, None),
        (FINGERS, COUPLED + ON_TENDON + '<actuator><motor tendon="both"/></actuator>', None),
        (FINGERS, ON_TENDON + '<actuator><motor tendon="both"/></actuator>', "left"),
        (FINGERS, COUPLED, "left"),
        (FINGERS, COUPLED + LEFT + '<option><flag actuation="disable"/></option>', "left"),
        (FINGERS, COUPLED + LEFT.replace("<motor", '<motor group="3"') + '<option actuatorgroupdisable="3"/>', "left"),
        (FINGERS, '<equality><joint joint1="left"/><joint joint1="right"/></equality>', None),
        (FINGERS, COUPLED.replace("<joint", '<joint active="false"') + LEFT, "right"),
        (FOUR_BARS, LOOP + '<actuator><motor joint="rocker"/></actuator>', None),
        (FOUR_BARS, '<actuator><motor joint="rocker"/></actuator>', "crank"),
    ],
)
def test_joints_that_follow_what_is_driven_are_held(world: str, rest: str, loose: str | None) -> None:
    """A finger that follows the other, both on one tendon, a linkage with one drive; dense and sparse Jacobians."""
    for jacobian in ("dense", "sparse"):
        option = f'<option jacobian="{jacobian}"/>'
        if loose is None:
            assert not scene(world, option + rest).movable
        else:
            with pytest.raises(hf.errors.SceneError, match=f"joints that can move: joint '{loose}' of '{loose}'"):
                scene(world, option + rest)


SHAPE = '<geom name="g" type="box" size=".1 .2 .3" mass="2"/>'
SLIDES = "".join(
    f'<joint name="s{k}" type="slide" axis="{axis}"/>' for k, axis in enumerate(("1 0 0", "0 1 1", "0 0 1"))
)
HINGES = "".join(
    f'<joint name="h{k}" axis="{axis}" pos="0 0 {k}"/>' for k, axis in enumerate(("1 0 0", "0 1 0", "0 0 1"))
)
BALL = '<joint name="turn" type="ball"/>'
LIGHT = '<inertial pos="0 0 0" mass="1e-8" diaginertia="1e-8 1e-8 1e-8"/>'
FREED = {
    "three slides and a ball": SLIDES + BALL + SHAPE,
    "three slides and three hinges": SLIDES + HINGES + SHAPE,
    "joints of weightless bodies": SLIDES + f'{LIGHT}<body name="b">{LIGHT}{BALL}<body name="c">{SHAPE}</body></body>',
}


@pytest.mark.parametrize("kind", FREED)
def test_bodies_on_joints_that_let_them_move_freely_are_movable(kind: str) -> None:
    """As in dm_control's and Adroit's objects: what they do is what a body with a free joint does, live too."""
    world = f'{FLOOR}<body name="can" pos="0 0 .5">{FREED[kind]}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    read = hf.from_mujoco(model, data)
    (body,) = read.movable
    assert body.mass == pytest.approx(2)
    assert body.pose[:3, 3] == pytest.approx([0, 0, 0.5])
    assert any("moves freely by its joints" in note for note in read.notes)
    assert hf.stability(read).status == hf.Status.UNSTABLE
    data.qpos[2] = -0.2  # along the third slide: now it stands on the floor
    mujoco.mj_forward(model, data)
    assert hf.stability(hf.from_mujoco(model, data)).status == hf.Status.STABLE


@pytest.mark.parametrize(
    ("joints", "rest"),
    [
        (SLIDES.replace('<joint name="s1" type="slide" axis="0 1 1"/>', '<joint name="s1" axis="0 1 0"/>'), ""),
        (SLIDES + HINGES.replace("0 1 0", "1 0 0"), ""),  # two axes are the same
        (SLIDES.replace("0 1 1", "1 0 0") + BALL, ""),
        (SLIDES + BALL, '<actuator><motor joint="s2"/></actuator>'),
        ('<joint name="s0"/>', ""),
    ],
)
def test_other_joints_that_nothing_drives_are_refused_by_name_or_held_on_request(joints: str, rest: str) -> None:
    world = FLOOR + f'<body name="can" pos="0 0 .3">{joints}{SHAPE}</body>'
    with pytest.raises(hf.errors.SceneError, match=r"joints that can move: joint 's0' of 'can'.*; say rigid=True"):
        scene(world, rest)
    held = scene(world, rest, rigid=True)
    assert not held.movable
    assert hf.stability(held).status == hf.Status.UNDECIDED
    assert "nothing here can move" in hf.stability(held).reason


def test_six_joints_that_actuators_drive_hold() -> None:
    drives = "".join(f'<motor joint="{name}"/>' for name in ("s0", "s1", "s2"))
    drives += '<motor joint="turn" gear="1 0 0"/>'
    read = scene(
        FLOOR + f'<body name="can" pos="0 0 .3">{SLIDES}{BALL}{SHAPE}</body>', f"<actuator>{drives}</actuator>"
    )
    assert not read.movable


def test_a_keyframe_and_positions_say_where_bodies_are() -> None:
    keys = '<keyframe><key name="up" qpos="0 0 5 1 0 0 0"/><key qpos="0 0 6 1 0 0 0"/></keyframe>'
    world = FLOOR + cube("a")
    heights = [scene(world, keys, **how).body("a").pose[2, 3] for how in ({}, {"key": "up"}, {"key": 1})]
    assert heights == [0.1, 5, 6]
    assert scene(world, keys, qpos=[0, 0, 7, 1, 0, 0, 0]).body("a").pose[2, 3] == 7
    for wrong, match in (
        ({"key": "upp"}, r"scene\.xml: keyframe 'upp': is unknown; did you mean 'up'\?"),
        ({"key": 2}, r"keyframe 2: the model has 2 keyframes; needs a name, or a number from 0"),
        ({"key": "up", "qpos": [0] * 7}, r"key and qpos: are both given"),
        ({"qpos": [0] * 6}, r"qpos: has shape \(6,\); needs shape \(7,\)"),
        ({"quos": [0] * 6}, r"option quos=: is unknown .*did you mean qpos="),
    ):
        with pytest.raises(hf.errors.SceneError, match=match):
            scene(world, keys, **wrong)


JOINTED = (
    '<body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/>'
    '<body name="lid" pos="0 0 .15"><joint name="hinge"/><geom type="box" size=".1 .1 .05" mass="1"/></body></body>'
)


def test_positions_outside_the_limits_of_a_joint_are_told_with_both_units() -> None:
    arm = (
        '<body name="arm" pos="0 0 1"><joint name="shoulder" type="hinge" axis="0 0 1" range="-90 90"/>'
        '<joint name="lift" type="slide" axis="0 0 1" range="0 0.3"/><geom size=".1 .1 .1" type="box" mass="1"/></body>'
    )
    assert scene(FLOOR + arm, qpos=[1.5, 0.3], rigid=True).body("arm").pose[2, 3] == pytest.approx(1.3)
    with pytest.raises(
        hf.errors.SceneError, match=r"qpos: joint 'shoulder': 45 rad .* -1.5708 to 1.5708 rad.*are 0.7854 rad"
    ):
        scene(FLOOR + arm, qpos=[45, 0.1])
    with pytest.raises(hf.errors.SceneError, match=r"qpos: joint 'lift': 100 m .* 0 to 0.3 m.*100 mm are 0.1 m"):
        scene(FLOOR + arm, qpos=[0, 100])


def test_a_joint_between_bodies_that_move_is_refused_by_name_or_held_on_request() -> None:
    match = r"joints that can move: joint 'hinge' of 'lid'; say rigid=True"
    with pytest.raises(hf.errors.SceneError, match=match):
        scene(FLOOR + JOINTED)
    read = scene(FLOOR + JOINTED, rigid=True)
    assert [b.name for b in read.movable] == ["box"]
    assert read.body("box").mass == pytest.approx(2)
    assert any("taken as rigid as it is now: joint 'hinge' of 'lid'" in note for note in read.notes)


@pytest.mark.parametrize(("kind", "told"), [("weld", "weld 'tie'"), ("connect", "connection 'tie'")])
def test_a_weld_between_bodies_is_refused_by_name_or_held_on_request(kind: str, told: str) -> None:
    anchor = ' anchor="0 0 0"' if kind == "connect" else ""
    tie = f'<equality><{kind} name="tie" body1="a" body2="b"{anchor}/></equality>'
    world = FLOOR + cube("a") + cube("b", "0 0 .3")
    with pytest.raises(hf.errors.SceneError, match=f"{told} of 'a' and 'b'"):
        scene(world, tie)
    read = scene(world, tie, rigid=True)
    assert [b.name for b in read.movable] == ["a"]
    assert len(read.body("a").shape.parts) == 2
    off = tie.replace('name="tie"', 'name="tie" active="false"')
    assert len(scene(world, off).movable) == 2
    held = scene(world, tie.replace('body1="a"', 'body1="world"'), rigid=True)
    assert [b.name for b in held.movable] == ["a"]
    assert held.body("b").fixed


def test_what_pulls_at_bodies_or_lifts_them_is_refused() -> None:
    site = '<body name="a" pos="0 0 .1"><freejoint/><site name="s"/><geom type="box" size=".1 .1 .1"/></body>'
    rope = '<tendon><spatial name="rope"><site site="s"/><site site="hook"/></spatial></tendon>'
    with pytest.raises(hf.errors.SceneError, match=r"tendon 'rope': pulls at a; leave it out"):
        scene(FLOOR + '<site name="hook" pos="0 0 2"/>' + site, rope)
    with pytest.raises(hf.errors.SceneError, match="gravcomp lifts a"):
        scene(FLOOR + cube("a").replace('name="a"', 'name="a" gravcomp="1"'))


def test_geoms_of_one_body_may_touch_different_ones() -> None:
    body = '<body name="a" pos="0 0 .1"><freejoint/><geom name="in" size=".1"/>'
    body += '<geom name="out" size=".1" pos="1 0 0" {}/></body>'
    other = '<worldbody><geom name="o" size="1" contype="2"/></worldbody>'
    read = scene(FLOOR + body.format('contype="2" conaffinity="2"'), other)
    assert read.excluded == ((("a", 1), "floor"),)
    assert isinstance(scene(FLOOR + body.format('contype="0" conaffinity="0"')).body("a").shape, hf.Sphere)


def test_what_is_left_out_is_told() -> None:
    ghost = '<body name="ghost"><freejoint/><geom size=".1" contype="0" conaffinity="0"/></body>'
    rough = cube("a").replace("size=", 'margin=".01" condim="6" size=')
    notes = "\n".join(scene(FLOOR + ghost + rough).notes)
    assert "no geom of theirs collides: ghost" in notes
    assert "ignored: margins" in notes
    assert "condim 4 and 6" in notes


def test_names_are_those_of_bodies_then_of_geoms_and_unique() -> None:
    world = (
        FLOOR + '<geom type="box" size=".1 .1 .1" pos="5 0 0"/><geom type="box" name="a" size=".1 .1 .1" pos="7 0 0"/>'
    )
    world += '<body pos="0 0 1"><freejoint/><geom name="ball" size=".1"/></body>' + cube("a", "0 0 2")
    world += '<body pos="0 0 3"><freejoint/><geom size=".1"/></body>'
    assert [b.name for b in scene(world).bodies] == ["floor", "box 1", "a", "ball", "a (2)", "body 3"]


def test_gravity_may_be_tilted_or_off() -> None:
    assert scene(FLOOR + cube("a"), '<option gravity="1 2 -9"/>').gravity.tolist() == [1, 2, -9]
    with pytest.raises(hf.errors.SceneError, match="gravity is zero"):
        scene(FLOOR + cube("a"), '<option><flag gravity="disable"/></option>')


def test_a_state_that_mujoco_has_not_worked_out_says_what_to_call() -> None:
    made = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    with pytest.raises(hf.errors.SceneError, match=r"no poses yet; call mujoco\.mj_forward\(model, data\)"):
        hf.from_mujoco(made, mujoco.MjData(made))


def test_what_is_no_model_is_refused() -> None:
    with pytest.raises(hf.errors.SceneError, match=r"from_mujoco: got a str and a NoneType; needs mujoco\.MjModel"):
        hf.from_mujoco("scene.xml", None)


ACTING = {
    "moving surfaces (surfacevel) of 'world'": (FLOOR.replace("/>", ' surfacevel="1 0 0 0 0 0"/>') + cube("a"), ""),
    "adhesion of 'a'": (FLOOR + cube("a"), '<actuator><adhesion body="a" ctrlrange="0 1" gain="3"/></actuator>'),
    "actuators that push of 'a'": (
        FLOOR + cube("a").replace("<freejoint/>", '<freejoint/><site name="s"/>'),
        '<actuator><general site="s" gear="1 0 0 0 0 0"/></actuator>',
    ),
    "springs of joints of 'a'": (
        FLOOR + cube("a").replace("<freejoint/>", SLIDES.replace("/>", ' stiffness="3"/>') + BALL),
        "",
    ),
    "wind": (FLOOR + cube("a"), '<option wind="1 0 0" density="1.2"/>'),
}


@pytest.mark.parametrize("what", ACTING)
def test_what_acts_in_mujoco_and_is_not_read_is_named(what: str) -> None:
    if "surfacevel" in what and not hasattr(mujoco.MjModel, "geom_surfacevel"):
        pytest.skip("this version of MuJoCo has no moving surfaces")
    assert f"ignored, though it acts: {what}" in scene(*ACTING[what]).notes
    assert not [note for note in scene(FLOOR + cube("a")).notes if "though it acts" in note]


def test_forces_that_are_applied_to_a_running_model_are_named() -> None:
    made, data = model(FLOOR + cube("a"))
    data.xfrc_applied[1, 0] = 3
    assert "ignored, though it acts: applied forces (xfrc_applied) of 'a'" in hf.from_mujoco(made, data).notes


def test_the_reason_of_a_fall_names_what_the_file_keeps_apart() -> None:
    read = scene(
        '<geom name="floor" type="plane" size="1 1 1" contype="2" conaffinity="2"/>'
        + cube("a")
        + FLOOR.replace('name="floor"', 'name="deep" pos="0 0 -3"')
    )
    found = hf.stability(read)
    assert found.status == hf.Status.UNSTABLE
    assert "a is 0 mm from floor, but the scene keeps these two apart (excluded)" in found.reason
