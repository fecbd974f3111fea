"""MJCF models of single objects: free joints, copies at poses and a floor, as files of benchmarks need them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from tests.cases.shared import FOLDER, needed

MUG = """<mujoco model="mug"><compiler texturedir="../textures"/>
<asset><texture name="t" type="2d" file="wood.png"/><material name="m" texture="t"/></asset>
<default><default class="seen"><geom material="m" contype="0" conaffinity="0" group="1"/></default></default>
<worldbody><body><body name="object">
<geom type="box" size=".1 .1 .1" mass="2" friction=".4 .1 .1" condim="4"/>
<geom class="seen" type="sphere" size=".1" mass="0"/>
</body><site name="top" pos="0 0 .1" material="m"/></body></worldbody>
<sensor><force site="top"/></sensor><keyframe><key name="home"/></keyframe></mujoco>"""
UP, BESIDE = hf.pose(z=0.1), hf.pose(x=1, z=0.1, yaw=30)


@pytest.fixture
def mug(tmp_path: Path) -> Path:
    pytest.importorskip("mujoco")
    (tmp_path / "mug.xml").write_text(MUG)
    return tmp_path / "mug.xml"


def test_an_object_on_a_floor_has_its_own_friction_there(mug: Path) -> None:
    scene = hf.load_scene(mug, free=True, pose=UP, floor=True)
    assert [body.name for body in scene.movable] == ["mug"]
    assert scene.mu("mug", "floor") == 0.4
    assert "free, as free= says: mug" in scene.notes
    assert not [note for note in scene.notes if "overlap" in note or "saved" in note]
    push = hf.robustness(scene, "mug", (-0.1, 0, 0.01), (1, 0, 0))
    assert push.force == pytest.approx(0.4 * 2 * 9.81, rel=1e-3)


def test_copies_have_names_and_poses(mug: Path) -> None:
    scene = hf.load_scene(mug, free=["object"], poses={"left": UP, "right": BESIDE}, floor=True)
    assert {body.name for body in scene.movable} == {"left", "right"}
    np.testing.assert_allclose(scene.body("right").pose, BESIDE, atol=1e-12)
    assert hf.stability(scene).stable


def test_a_model_with_a_pose_is_the_model_turned(mug: Path) -> None:
    turned = hf.load_scene(mug, free=True, pose=BESIDE, floor=True).body("mug")
    straight = hf.load_scene(mug, free=True, floor=True).body("mug")
    np.testing.assert_allclose(turned.pose, BESIDE @ straight.pose, atol=1e-12)
    np.testing.assert_allclose(turned.inertia, straight.inertia, atol=1e-12)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"free": ["objct"]}, r"mug.xml: free: no body is named 'objct'; did you mean 'object'"),
        ({"free": True}, r"none of its 1 bodies is fixed; mark .*; files of other programs take floor=True"),
        ({"free": True, "pose": UP, "poses": {"a": UP}}, r"poses: is .*and no pose="),
        ({"free": True, "floor": True, "key": "home"}, r"keyframe 'home': is unknown"),
    ],
)
def test_what_is_wrong_is_one_clear_error(options: dict[str, Any], match: str, mug: Path) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.load_scene(mug, **options)


def test_a_body_with_joints_is_not_freed(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    hinged = MUG.replace('<body><body name="object">', '<body name="door"><joint axis="0 0 1"/><body name="object">')
    (tmp_path / "door.xml").write_text(hinged)
    with pytest.raises(hf.errors.SceneError, match="body 'door' has joints of its own; name bodies without joints"):
        hf.load_scene(tmp_path / "door.xml", free=["object"], floor=True)


def test_motors_of_a_free_joint_are_told(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    content = MUG.replace('<body><body name="object">', '<body name="b"><freejoint name="j"/><body name="object">')
    content = content.replace("<sensor>", '<actuator><motor joint="j" gear="1 0 0 0 0 0"/></actuator><sensor>')
    (tmp_path / "m.xml").write_text(content.replace('<keyframe><key name="home"/></keyframe>', ""))
    notes = hf.load_scene(tmp_path / "m.xml", floor=True).notes
    assert any("ignored, though it acts: actuators of joints of" in note for note in notes)


@needed
@pytest.mark.parametrize("path", sorted((FOLDER / "robots" / "mjcf").glob("*.xml")), ids=lambda path: path.stem)
def test_a_model_at_the_identity_is_the_model(path: Path) -> None:
    pytest.importorskip("mujoco")
    plain, placed = hf.load_scene(path), hf.load_scene(path, pose=np.eye(4))
    assert [body.name for body in placed.bodies] == [body.name for body in plain.bodies]
    for a, b in zip(placed.bodies, plain.bodies, strict=True):
        np.testing.assert_allclose(a.pose, b.pose, atol=1e-12)
        assert (a.mass, a.fixed) == (b.mass, b.fixed)
    assert placed.friction == plain.friction
    assert placed.excluded == plain.excluded


# Fields of a compiled model that only show, that cannot change what holds at rest, or that follow from others
HARMLESS = re.compile(
    "(n[A-Za-z]|name|names|paths|bvh|oct|cam_|light_|mat_|tex_|skin_|sensor_|text_|numeric_|tuple_|vis$|stat$|key_"
    "|B_|D_|M_|mapM|mapD|efm|ten_J|tree_|signature|qpos_spring|qpos0|flg_"  # memory of the solver and derived numbers
    "|dof_|site_|wrap_|hfield_|mesh_|flexedge_|flex_"  # read through what refers to them; soft bodies are refused
    "|.*_(user|group|rgba|matid|sameframe|solimp|solref|solmix|solreffriction|treeid|pathadr|history)$"
    "|.*_historyadr$)"
)
OTHERS = [  # what they act through is read, refused or noted: actuators by joint, tendons whole, plugins by body
    "actuator_acc0", "actuator_actadr", "actuator_actearly", "actuator_actlimited", "actuator_actnum",
    "actuator_actrange", "actuator_armature", "actuator_biasprm", "actuator_biastype", "actuator_cranklength",
    "actuator_ctrladr", "actuator_ctrllimited", "actuator_ctrlnum", "actuator_ctrlrange", "actuator_ctrlspec",
    "actuator_damping", "actuator_dampingpoly", "actuator_delay", "actuator_dynprm", "actuator_dyntype",
    "actuator_forcelimited", "actuator_forcerange", "actuator_gainprm", "actuator_gaintype", "actuator_gear",
    "actuator_length0", "actuator_lengthrange", "actuator_outadr", "actuator_outnum", "actuator_plugin",
    "body_bvhadr", "body_bvhnum", "body_conaffinity", "body_contype", "body_dofadr", "body_dofnum", "body_geomadr",
    "body_invweight0", "body_margin", "body_mocapid", "body_pos", "body_quat", "body_rootid", "body_simple",
    "body_weldid", "eq_active0", "eq_data", "geom_aabb", "geom_castshadow", "geom_fluid", "geom_gap", "geom_plugin",
    "geom_rbound", "jnt_actfrclimited", "jnt_actfrcrange", "jnt_actgravcomp", "jnt_actuatorid", "jnt_axis",
    "jnt_margin", "jnt_plasticadr", "jnt_pos", "jnt_springyield", "pair_gap", "pair_margin", "pair_signature",
    "plugin", "plugin_attr", "plugin_attradr", "plugin_stateadr", "plugin_statenum",
]  # fmt: skip


def test_every_field_of_a_compiled_model_is_read_noted_or_known_to_be_harmless() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    folder = Path(hf.__file__).parent / "scene" / "formats" / "mjcf"
    source = "".join(path.read_text() for path in folder.glob("*.py"))
    fields = [each for each in dir(model) if not each.startswith("_") and not callable(getattr(model, each))]
    unknown = [each for each in fields if not HARMLESS.match(each) and each not in OTHERS and each not in source]
    unknown = [each for each in unknown if not each.startswith("tendon_")]  # a tendon at a moving body is refused
    assert unknown == []


def test_adhesion_of_a_pair_is_told(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    if not hasattr(mujoco.MjModel.from_xml_string("<mujoco/>"), "pair_adhesion"):
        pytest.skip("this version of MuJoCo has no adhesion of pairs")
    content = """<mujoco><worldbody><geom name="f" type="plane" size="1 1 1"/><body name="b" pos="0 0 .1"><freejoint/>
    <geom name="g" type="box" size=".1 .1 .1"/></body></worldbody>
    <contact><pair geom1="f" geom2="g" adhesion="1"/></contact></mujoco>"""
    (tmp_path / "p.xml").write_text(content)
    assert any("adhesion" in note for note in hf.load_scene(tmp_path / "p.xml").notes)
