"""No reader drops an attribute that it does not know without a word: a note or an error names it.

Each format has a small scene in which ``@`` marks the places where an attribute may stand; one at a time gets one.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

import pytest

import holdfast as hf
from holdfast.scene.formats import FORMATS

KEY = '"stickiness": 3, '
XML = ' stickiness="3"'
FREE = {"friction": 0.5, "density": 500.0}
VERTICES = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
COMPAS_MESH = json.dumps(
    {
        "vertex": {str(k): dict(zip("xyz", v, strict=True)) for k, v in enumerate(VERTICES)},
        "face": {str(k): face for k, face in enumerate(FACES)},
    }
)[1:]


@dataclass(frozen=True)
class Sample:
    """A file of a format: its name, its text with marks, what stands for a mark, options, and the files beside it."""

    file: str
    text: str
    mark: str
    options: Mapping[str, object] = field(default_factory=dict)
    beside: Mapping[str, str] = field(default_factory=dict)
    needs: str = "json"


SAMPLES = {
    "holdfast scene": Sample(
        "s.json",
        '{@"format": "holdfast-scene/1", "friction": 0.5, "bodies": [{@"name": "a", "fixed": true,'
        ' "shape": {@"type": "box", "size": [1, 1, 1]}}]}',
        KEY,
    ),
    "block assembly": Sample(
        "s.json",
        f'{{@"friction": 0.5, "gravity": [0, 0, -9.81], "blocks": [{{@"name": "a", "vertices": {VERTICES},'
        f' "faces": {FACES}, "mass": 1, "fixed": true}}]}}',
        KEY,
    ),
    "settled scene": Sample(
        "s.json",
        '{@"format": "settled-scene/1", "units": {@"gravity": [0, 0, -9.81]}, "objects": [{@"name": "a", "fixed": true,'
        ' "mesh": "m.obj", "scale": 1, "pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],'
        ' "friction": 0.5}]}',
        KEY,
        beside={"m.obj": "".join(f"v {x} {y} {z}\n" for x, y, z in VERTICES) + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"},
    ),
    "MJCF": Sample(
        "s.xml",
        "<mujoco@><option@/><worldbody@><geom@ type='plane' size='1 1 1'/><body@ pos='0 0 1'><freejoint@/>"
        "<inertial@ pos='0 0 0' mass='1' diaginertia='1 1 1'/><geom size='1'/></body></worldbody></mujoco>",
        XML,
        needs="mujoco",
    ),
    "URDF": Sample(
        "s.urdf",
        '<robot@ name="r"><link@ name="a"><inertial@><origin@/><mass@ value="1"/><inertia@ ixx="1" iyy="1" izz="1"/>'
        '</inertial><collision@><origin@/><geometry@><box@ size="1 1 1"/></geometry></collision></link><link name="b"/>'
        '<joint@ name="j" type="fixed"><parent@ link="a"/><child@ link="b"/></joint></robot>',
        XML,
        {**FREE, "floor": True},
    ),
    "SDF": Sample(
        "s.sdf",
        "<sdf@ version='1.9'><world@ name='w'><gravity@>0 0 -9.8</gravity><model@ name='m'><static@>1</static><pose@/>"
        "<link@ name='l'><inertial@><mass@>1</mass></inertial><collision@ name='c'><pose@>0 0 0 0 0 0</pose><geometry@>"
        "<box@><size@>1 1 1</size></box></geometry><surface@><friction@><ode@><mu@>1</mu></ode></friction></surface>"
        "</collision></link></model></world></sdf>",
        XML,
    ),
    "glTF": Sample(
        "s.gltf",
        '{@"asset": {@"version": "2.0"}, "scene": 0, "scenes": [{@"nodes": [0]}], "nodes": [{@"mesh": 0, "name": "a"}],'
        ' "meshes": [{@"primitives": [{@"attributes": {"POSITION": 0}, "indices": 1}]}],'
        ' "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],'
        ' "max": [1, 1, 1]}, {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],'
        ' "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],'
        ' "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,'
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA"
        '"}]}',
        KEY,
        {**FREE, "floor": True},
    ),
    "COMPAS assembly": Sample(
        "s.json",
        '{"dtype": "compas_assembly.datastructures/Assembly", "data": {@"graph": {@"edge": {}, "node": {"0": {@"block":'
        f' {{"dtype": "compas_assembly.datastructures/Block", "data": {{@{COMPAS_MESH}}}}}}}}}}}}}',
        KEY,
        {**FREE, "floor": True},
    ),
    "USD": Sample(
        "s.usda",
        '#usda 1.0\ndef Cube "a" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI",'
        ' "MaterialBindingAPI"])\n{\n@\nrel material:binding:physics = </m>\n}\n'
        'def Material "m" (prepend apiSchemas = ["PhysicsMaterialAPI"])\n'
        '{\n@\nfloat physics:staticFriction = 1\n}\ndef PhysicsScene "s"\n{\n@\n}\n'
        'def PhysicsFixedJoint "j"\n{\n@\nrel physics:body0 = </a>\n}\ndef Xform "x"\n{\n@\n}\n',
        "float stickiness = 3",
        {"floor": True},
        needs="pxr",
    ),
    "MoveIt": Sample(
        "s.scene",
        "s+\n* a\n@0 0 0\n0 0 0 1\n1\n@box\n@1 1 1\n0 0 0\n0 0 0 1\n0 0 0 0\n@0\n.\n",
        "stickiness 3\n",
        {**FREE, "floor": True},
    ),
    "Drake directives": Sample(
        "s.dmd.yaml",
        "directives:\n- add_model: {@name: a, file: 'package://p/a.sdf'}\n"
        "- add_frame: {@name: f, X_PF: {@base_frame: world}}\n"
        "- add_weld: {@parent: world, child: 'a::l'}\n",
        "stickiness: 3, ",
        {"package": {"p": "."}},
        {
            "a.sdf": "<sdf version='1.7'><model name='a'><link name='l'><collision name='c'><geometry><box><size>1 1 1"
            "</size></box></geometry></collision></link></model></sdf>"
        },
    ),
    "Habitat scene": Sample(
        "s.scene_instance.json",
        '{@"stage_instance": {@"template_name": "room"}, "object_instances": [{@"template_name": "mug"}]}',
        KEY,
        beside={
            "k.scene_dataset_config.json": "{}",
            "room.stage_config.json": '{@"render_asset": "m.obj", "friction_coefficient": 1}',
            "mug.object_config.json": '{@"render_asset": "m.obj", "friction_coefficient": 1, "mass": 1}',
            "m.obj": "".join(f"v {x} {y} {z}\n" for x, y, z in VERTICES) + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
        },
    ),
    "table of boxes": Sample(
        "s.csv",
        "name,size_x,size_y,size_z,x,y,z,mass,fixed@\na,1,1,1,0,0,0,1,true,5\n",
        ",stickiness",
        {"friction": 0.5},
    ),
}
WITHOUT = {
    "mesh file": "has corners and faces alone",
    "LDraw model": "each line has numbers at fixed places, and other lines are comments",
    "packing plan": "each packer dumps what it keeps of its own beside sizes and places",
    "ROS bag": "holds messages, not text: test_planning_messages.py",
}


def places() -> list[tuple[str, str, int]]:
    """Every marked place: the format, the file that has it, and its number there."""
    found = []
    for name, sample in SAMPLES.items():
        for file, text in {sample.file: sample.text, **sample.beside}.items():
            found += [(name, file, k) for k in range(text.count("@"))]
    return found


def loaded(sample: Sample, folder: Path, file: str = "", place: int = -1) -> hf.Scene:
    """The sample with an attribute at one of the marks of a file, or at none."""
    pytest.importorskip(sample.needs)
    for each, text in {sample.file: sample.text, **sample.beside}.items():
        parts = (text if file else text.replace(",true,5", ",true")).split("@")  # a table has as many values as columns
        marks = [sample.mark if each == file and k == place else "" for k in range(len(parts) - 1)]
        (folder / each).write_text("".join(a + b for a, b in zip(parts, [*marks, ""], strict=True)))
    options = {key: {"p": folder} if key == "package" else value for key, value in sample.options.items()}
    return hf.load_scene(folder / sample.file, **options)


def test_every_format_has_a_sample_or_a_reason() -> None:
    own = [getattr(import_module(f"holdfast.scene.formats.{module}"), name) for module, name in FORMATS]
    assert {each.name for each in own if each.read is not None} == {*SAMPLES, *WITHOUT}


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize(("name", "file", "place"), places())
def test_an_attribute_that_is_not_known_is_named(name: str, file: str, place: int, tmp_path: Path) -> None:
    try:
        said = " ".join(loaded(SAMPLES[name], tmp_path, file, place).notes)
    except hf.HoldfastError as error:
        said = str(error)
    assert re.search("stickiness", said), said


@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
@pytest.mark.parametrize("name", SAMPLES)
def test_the_samples_themselves_load(name: str, tmp_path: Path) -> None:
    scene = loaded(SAMPLES[name], tmp_path)
    assert not any("may matter" in note or "not read" in note for note in scene.notes), scene.notes
