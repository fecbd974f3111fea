"""Robots read with ``hold_torques``: URDF and MJCF say the same, and what a file leaves out is asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.errors import SceneError

G, LIMIT = 9.81, hf.Limit()
pytest.importorskip("mujoco", reason="needs MuJoCo, of the extra mujoco")

LINK = """<link name="{0}"><inertial><origin xyz="{1} 0 0"/><mass value="{2}"/>
  <inertia ixx="0.001" iyy="0.01" izz="0.01"/></inertial>{3}</link>"""
BOX = """<collision><origin xyz="{0} 0 0"/><geometry><box size="{1} 0.05 0.04"/></geometry></collision>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4}"/><axis xyz="{5}"/>
  {6}</joint>"""
URDF = "\n".join(
    [
        '<robot name="arm">',
        LINK.format("base", 0, 5, BOX.format(0, 0.2)),
        LINK.format("upper", 0.2, 2, BOX.format(0.2, 0.4)),
        LINK.format("fore", 0.15, 1, BOX.format(0.15, 0.3)),
        LINK.format("tool", 0.05, 0.5, ""),
        JOINT.format("shoulder", "revolute", "base", "upper", "0 0 0.3", "0 1 0", '<limit effort="30"/>'),
        JOINT.format("elbow", "continuous", "upper", "fore", "0.4 0 0", "0 1 0", '<limit effort="8"/>'),
        JOINT.format("plunger", "prismatic", "fore", "tool", "0.3 0 0", "1 0 0", '<limit effort="{plunger}"/>'),
        "</robot>",
    ]
)
MJCF = """<mujoco model="arm"><worldbody><geom name="floor" type="plane" size="1 1 1" pos="0 0 -1"/>
<body name="base"><geom type="box" size="0.1 0.025 0.02"/>
<body name="upper" pos="0 0 0.3"><joint name="shoulder" axis="0 1 0"/>
<inertial pos="0.2 0 0" mass="2" diaginertia="0.001 0.01 0.01"/>
<geom type="box" pos="0.2 0 0" size="0.2 0.025 0.02"/>
<body name="fore" pos="0.4 0 0"><joint name="elbow" axis="0 1 0" {elbow}/>
<inertial pos="0.15 0 0" mass="1" diaginertia="0.001 0.01 0.01"/>
<geom type="box" pos="0.15 0 0" size="0.15 0.025 0.02"/>
<body name="tool" pos="0.3 0 0"><joint name="plunger" type="slide" axis="1 0 0"/>{more}
<inertial pos="0.05 0 0" mass="0.5" diaginertia="0.001 0.01 0.01"/></body></body></body></body></worldbody>
<actuator><motor joint="shoulder" ctrlrange="-1 1" ctrllimited="true" gear="30"/>
<position joint="elbow" kp="90" {range}/>
<general joint="plunger" gainprm="5" biasprm="0 -5" biastype="affine" forcerange="-20 20" gear="-3"/>
</actuator></mujoco>"""


def by_urdf(folder: Path, plunger: str = "60", **options: Any) -> hf.Scene:
    path = folder / "arm.urdf"
    path.write_text(URDF.replace("{plunger}", plunger))
    return hf.load_scene(path, **{"fixed": ["arm/base"], "friction": 0.5, "hold_torques": True} | options)


def by_mjcf(
    folder: Path, elbow: str = "", effort: str = 'forcerange="-8 8"', more: str = "", **options: Any
) -> hf.Scene:
    path = folder / "arm.xml"
    path.write_text(MJCF.format(elbow=elbow, range=effort, more=more))
    return hf.load_scene(path, **{"hold_torques": True} | options)


def pressing(scene: hf.Scene, body: str = "tool") -> float:
    (name,) = (each.name for each in scene.bodies if each.name.split("/")[-1] == body)
    load = hf.Load(name, scene.body(name).pose[:3, 3], (0, 0, -1))
    return float(hf.load_factor(scene, [load], engine=LIMIT))


@pytest.mark.parametrize("q", [(0.0, 0.0), (-0.7, 0.9), (0.4, -1.3)])
def test_both_formats_press_as_the_jacobian_says(tmp_path: Path, q: tuple[float, float]) -> None:
    a, b = q[0], sum(q)  # turning about y lowers what is in front
    elbow, end = 0.4 * np.cos(a), 0.4 * np.cos(a) + 0.3 * np.cos(b)
    tool = end + 0.05 * np.cos(b)
    weights = G * (2 * 0.2 * np.cos(a) + elbow + 0.15 * np.cos(b) + 0.5 * tool)
    motors = ((30, weights, end), (8, weights - G * 0.2 * 2 * np.cos(a) - G * 1.5 * elbow, end - elbow))
    most = min((torque - taken) / lever for torque, taken, lever in motors)
    most = min(most, (60 - 0.5 * G * np.sin(b)) / np.sin(b) if np.sin(b) > 0 else np.inf)
    first = by_urdf(tmp_path, joints={"shoulder": q[0], "elbow": q[1]})
    second = by_mjcf(tmp_path, qpos=[*q, 0.0])
    assert pressing(first) == pytest.approx(most, rel=1e-6)
    assert pressing(second) == pytest.approx(most, rel=1e-6)
    assert [hold.on for hold in first.holds] == ["arm/base", "arm/upper", "arm/fore"]
    assert [hold.on for hold in second.holds] == [None, "upper", "fore"]
    assert np.allclose(first.body("arm/tool").com_world, second.body("tool").com_world)
    assert any("no shape" in note for note in first.notes)


def test_links_of_one_arm_never_touch_however_many_joints_are_between_them(tmp_path: Path) -> None:
    """The arm folded back: its outer link lies in its base, which is no contact, and bears none of its weight."""
    folded = {"shoulder": 0.0, "elbow": np.pi}
    scene = by_urdf(tmp_path, joints=folded)
    links = ["base", "fore", "tool", "upper"]
    assert scene.excluded == tuple((f"arm/{a}", f"arm/{b}") for k, a in enumerate(links) for b in links[k + 1 :])
    named = by_mjcf(tmp_path, qpos=[*folded.values(), 0.0]).excluded
    assert {("fore", "upper"), ("fore", "tool"), ("tool", "upper")} <= set(named)


def test_torques_that_are_given_take_the_place_of_the_file(tmp_path: Path) -> None:
    plain, inf = pressing(by_urdf(tmp_path)), float("inf")
    for more in ({"elbow": 9.0}, {"elbow": inf}):
        first, second = by_urdf(tmp_path, hold_torques=more), by_mjcf(tmp_path, hold_torques=more)
        assert pressing(first) > 1.1 * plain
        assert pressing(second) == pytest.approx(pressing(first), rel=1e-6)


def test_joints_that_nothing_drives_turn_freely(tmp_path: Path) -> None:
    path = tmp_path / "door.xml"
    path.write_text(
        """<mujoco><worldbody><body name="door" pos="0 0 1"><joint name="hinge" axis="0 0 1"/>
        <geom type="box" pos="0.4 0 0" size="0.4 0.02 0.5" mass="9"/></body></worldbody></mujoco>"""
    )
    door = hf.load_scene(path, hold_torques=True, floor=True)
    assert float(hf.robustness(door, "door", (0.8, 0, 1), (-1, 0, 0), engine=LIMIT)) == np.inf
    assert float(hf.robustness(door, "door", (0.6, 0.02, 1), (0, -1, 0), engine=LIMIT)) == pytest.approx(0, abs=1e-9)


def test_a_finger_that_follows_another_one_is_asked_for(tmp_path: Path) -> None:
    fingers = [
        f"""<body name="{name}" pos="0 {y} 1"><joint name="{name} slide" type="slide" axis="0 1 0"/>
        <geom type="box" size="0.1 0.01 0.1" mass="0.1"/></body>"""
        for name, y in (("left", -0.1), ("right", 0.1))
    ]
    path = tmp_path / "hand.xml"
    path.write_text(
        f"""<mujoco><worldbody>{"".join(fingers)}</worldbody>
        <equality><joint joint1="left slide" joint2="right slide" polycoef="0 -1 0 0 0"/></equality>
        <actuator><motor joint="left slide" ctrlrange="-7 7" ctrllimited="true"/></actuator></mujoco>"""
    )
    with pytest.raises(SceneError, match="joint 'right slide': the file has no limit"):
        hf.load_scene(path, hold_torques=True, floor=True)
    hand = hf.load_scene(path, hold_torques={"right slide": 7.0}, floor=True)
    assert float(hf.robustness(hand, "left", (0, -0.11, 1), (0, 1, 0), engine=LIMIT)) == pytest.approx(7, rel=1e-6)


@pytest.mark.parametrize(
    ("elbow", "effort", "own"),
    [
        ('actuatorfrcrange="-5 6" actuatorfrclimited="true"', 'forcerange="-8 8"', (-5.0, 6.0)),
        ('actuatorfrcrange="-5 6" actuatorfrclimited="true"', "", (-5.0, 6.0)),
        ("", 'forcerange="-4 9"', (-4.0, 9.0)),
        ("", 'forcerange="-4 9" gear="-2"', (-18.0, 8.0)),
    ],
)
def test_ranges_of_mujoco(tmp_path: Path, elbow: str, effort: str, own: tuple[float, float]) -> None:
    moments = by_mjcf(tmp_path, elbow=elbow, effort=effort).holds[1].moments
    assert moments[2] == own


@pytest.mark.parametrize(
    ("actuators", "own"),
    [
        ('<motor {} ctrlrange="-1 2" gear="3" forcerange="-9 1.5"/>', (-3.0, 4.5)),
        ('<position {} kp="5" ctrlrange="-.5 .5" forcerange="-2 9"/>', (-2.0, 2.0)),  # at 0.1 rad
        ('<general {} dyntype="integrator" gainprm="4" actlimited="true" actrange="-1 1"/>', (-4.0, 4.0)),
        ('<motor {0} ctrlrange="-2 2"/><motor {0} ctrlrange="-7 7" group="3"/>', (-2.0, 2.0)),
        ('<muscle {} ctrlrange="0 1" lengthrange="0 1" force="9" forcerange="-9 9"/>', None),
    ],
)
def test_what_an_actuator_gives_is_what_its_control_allows(actuators: str, own: tuple[float, float] | None) -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option actuatorgroupdisable="3"/><worldbody><geom type="plane" size="1 1 1"/>
        <body pos="0 0 1"><joint name="j" axis="0 1 0"/><geom type="box" size=".1 .1 .1"/></body></worldbody>
        <actuator>{actuators.format('joint="j"')}</actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qpos[0] = 0.1
    mujoco.mj_forward(model, data)
    if own is None:
        with pytest.raises(SceneError, match="the file has no limit"):
            hf.from_mujoco(model, data, hold_torques=True)
    else:
        assert hf.from_mujoco(model, data, hold_torques=True).holds[0].moments[2] == pytest.approx(own)


def test_a_trunk_without_a_shape_is_held_by_its_legs_alone(tmp_path: Path) -> None:
    """It was left out, and its leg was held by the world."""
    path = tmp_path / "leg.xml"
    path.write_text(
        """<mujoco><worldbody><body name="trunk" pos="0 0 .5"><freejoint/>
        <inertial pos="0 0 0" mass="8" diaginertia=".1 .1 .1"/><body name="leg"><joint name="hip" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .3 0 -.48" size=".02"/></body></body></worldbody>
        <actuator><motor joint="hip" ctrlrange="-90 90"/></actuator></mujoco>"""
    )
    (tmp_path / "leg.urdf").write_text(
        '<robot name="leg">'
        + LINK.format("trunk", 0, 8, "")
        + LINK.format("leg", 0.2, 1, BOX.format(0.2, 0.4))
        + JOINT.format("hip", "revolute", "trunk", "leg", "0 0 1", "0 1 0", '<limit effort="90"/>')
        + "</robot>"
    )
    for name, more in (("leg.xml", {}), ("leg.urdf", {"friction": 0.5})):
        scene = hf.load_scene(tmp_path / name, hold_torques=True, floor=True, **more)
        assert [hold.on is None for hold in scene.holds] == [False]
        assert hf.stability(scene, engine=LIMIT).status is hf.Status.UNSTABLE


def test_a_link_that_is_the_only_body_of_a_urdf_file(tmp_path: Path) -> None:
    """A base with neither mass nor shape is fixed in the world, as in Bullet."""
    hinge = JOINT.format("j", "revolute", "base", "link", "0 0 1", "0 1 0", '<limit effort="3"/>')
    (tmp_path / "one.urdf").write_text(
        f'<robot name="one"><link name="base"/>{LINK.format("link", 0.2, 1, BOX.format(0.2, 0.4))}{hinge}</robot>'
    )
    scene = hf.load_scene(tmp_path / "one.urdf", hold_torques=True, friction=0.5, floor=True)
    assert [(hold.body, hold.on) for hold in scene.holds] == [("one", None)]
    assert pressing(scene, "one") == np.inf  # on its axis
    assert hf.stability(scene, engine=LIMIT).stable


def test_a_joint_that_mimics_another_one_has_no_motor_of_its_own(tmp_path: Path) -> None:
    text = URDF.replace("{plunger}", "9").replace('<limit effort="8"/>', '<limit effort="8"/><mimic joint="shoulder"/>')
    (tmp_path / "mimic.urdf").write_text(text)
    with pytest.raises(SceneError, match="joint 'elbow': the file has no limit"):
        hf.load_scene(tmp_path / "mimic.urdf", fixed=["arm/base"], friction=0.5, hold_torques=True)


def test_motors_bear_springs_and_applied_torques_too() -> None:
    """They were ignored, and an arm that its spring throws over was stable."""
    mujoco: Any = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body pos="0 0 1"><geom type="box" size=".1 .1 .1"/>
        <joint name="j" axis="0 1 0" stiffness="100" springref="57.29577951308232"/></body></worldbody>
        <tendon><fixed stiffness="10" springlength="3"><joint joint="j" coef="1"/></fixed></tendon>
        <actuator><motor joint="j" ctrlrange="-50 60"/></actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qfrc_applied[0] = 7
    mujoco.mj_forward(model, data)
    scene = hf.from_mujoco(model, data, hold_torques=True)
    assert scene.holds[0].moments[2] == pytest.approx((-50 + 137, 60 + 137))
    assert not any("acts" in note for note in scene.notes)
    assert hf.stability(scene, engine=LIMIT).status is hf.Status.UNSTABLE


@pytest.mark.parametrize("read", [by_urdf, by_mjcf])
def test_links_of_one_arm_never_touch_and_what_has_no_shape_touches_nothing(tmp_path: Path, read: Any) -> None:
    scene = read(tmp_path)
    assert hf.assemble(scene).interfaces == ()
    hf.save_scene(scene, tmp_path / "arm.yaml")
    assert hf.load_scene(tmp_path / "arm.yaml") == scene


def test_copies_hold_their_own_links(tmp_path: Path) -> None:
    two = by_urdf(tmp_path, poses={"a": np.eye(4), "b": hf.pose(0, 2, 0, yaw=90)}, fixed=["a/base", "b/base"])
    assert [(hold.body, hold.on) for hold in two.holds[::3]] == [("a/upper", "a/base"), ("b/upper", "b/base")]
    for name in ("a/tool", "b/tool"):
        load = hf.Load(name, two.body(name).pose[:3, 3], (0, 0, -1))
        assert float(hf.load_factor(two, [load], engine=LIMIT)) == pytest.approx(pressing(by_urdf(tmp_path)), rel=1e-6)


def test_what_a_file_leaves_out_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"joint 'plunger': the file has no limit.*hold_torques={'plunger'"):
        by_urdf(tmp_path, plunger="0")
    with pytest.raises(SceneError, match=r"joint 'elbow': the file has no limit.*hold_torques={'elbow'"):
        by_mjcf(tmp_path, effort="")
    for read in (by_urdf, by_mjcf):
        with pytest.raises(SceneError, match="hold_torques: 'elbov': is no joint; did you mean 'elbow'"):
            read(tmp_path, hold_torques={"elbov": 3.0})
        with pytest.raises(SceneError, match="hold_torques: is given with rigid=True"):
            read(tmp_path, rigid=True)
    with pytest.raises(SceneError, match="'tool' has the joints 'plunger', 'twist'; hold_torques takes one hinge"):
        by_mjcf(tmp_path, more='<joint name="twist" axis="1 0 0"/>')
    massless = URDF.replace('<mass value="1"/>', '<mass value="0"/>').replace("{plunger}", "5")
    (tmp_path / "light.urdf").write_text(massless)
    with pytest.raises(SceneError, match="has no mass, and moves by a joint of its own"):
        hf.load_scene(tmp_path / "light.urdf", hold_torques=True, friction=0.5, fixed=["arm/base"])


def test_a_real_arm_beside_the_dynamics_of_pybullet() -> None:
    """KUKA iiwa 7 at two poses: J and the torques of its weight are Bullet's."""
    bullet = pytest.importorskip("pybullet", reason="needs pybullet, of the extra bench")
    data = pytest.importorskip("pybullet_data", reason="needs pybullet, of the extra bench")
    path = f"{data.getDataPath()}/kuka_iiwa/model.urdf"
    client = bullet.connect(bullet.DIRECT)
    try:
        bullet.setGravity(0, 0, -G)
        robot = bullet.loadURDF(path, useFixedBase=True, flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        joints = [bullet.getJointInfo(robot, j) for j in range(bullet.getNumJoints(robot))]
        names, still = [joint[1].decode() for joint in joints], [0.0] * len(joints)
        for q in ([0.3, 0.5, -0.2, -1.2, 0.4, 0.9, 0.1], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]):
            for joint, angle in zip(joints, q, strict=True):
                bullet.resetJointState(robot, joint[0], angle)
            taken = np.array(bullet.calculateInverseDynamics(robot, q, still, still))
            J = np.array(bullet.calculateJacobian(robot, joints[-1][0], [0, 0, 0], q, still, still)[0])
            place = bullet.getLinkState(robot, joints[-1][0], computeForwardKinematics=True)[4]
            torques = dict(zip(names, (176.0, 176.0, 110.0, 110.0, 110.0, 40.0, 40.0), strict=True))
            options: dict[str, Any] = {"fixed": ["lbr_iiwa/lbr_iiwa_link_0"], "friction": 0.5}
            arm = hf.load_scene(path, joints=dict(zip(names, q, strict=True)), hold_torques=torques, **options)
            for way in (np.array([0, 0, -1.0]), np.array([0.6, 0, 0.8])):
                lever, most = J.T @ way, np.array([*torques.values()])
                bears = np.abs(lever) > 1e-9
                true = ((most + np.sign(lever) * taken) / np.abs(np.where(bears, lever, 1)))[bears].min(initial=np.inf)
                found = hf.load_factor(arm, [hf.Load("lbr_iiwa/lbr_iiwa_link_7", place, way)], engine=LIMIT)
                assert float(found) == pytest.approx(true, rel=1e-6)
    finally:
        bullet.disconnect(client)
