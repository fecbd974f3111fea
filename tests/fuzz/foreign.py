"""Small valid scenes in the formats of other programs, to be mutated.

USD is left out: its files are read by a library that does not come with the tests.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor

DAE = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="decimetre" meter="0.1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="4"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3 3 3</vcount>
<p>0 2 1 0 1 3 1 2 3 0 3 2</p></polylist></mesh></geometry></library_geometries>
<library_nodes><node id="n"><rotate>0 0 1 30</rotate><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="e"><node><matrix>1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<scale>1 2 1</scale><instance_node url="#n"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#e"/></scene></COLLADA>"""
MJCF = """<mujoco model="scene">
<compiler angle="degree" meshdir="."/><option gravity="0 0 -9.81"/>
<default><geom friction="0.6 0.005 0.0001"/><default class="hard"><geom density="500"/></default></default>
<asset><mesh name="m" file="m.stl" scale="1 1 1"/></asset>
<worldbody><geom name="ground" type="plane" size="1 1 0.1"/>
<body name="a" pos="0 0 0.1" euler="0 0 30"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
<body name="b" pos="0 0 0.4"><joint type="free"/><geom class="hard" type="capsule" fromto="0 0 0 0 0 0.1" size="0.02"/>
<body name="c" pos="0 0 0.1"><geom type="mesh" mesh="m" mass="0.5"/></body></body></worldbody></mujoco>
"""
OBJECT = """<mujoco><asset><texture name="t" type="2d" file="no.png"/><material name="m" texture="t"/></asset>
<worldbody><body><body name="o"><geom type="box" size=".1 .1 .1" mass="1" material="m"/></body></body></worldbody>
</mujoco>
"""
URDF = """<?xml version="1.0"?>
<robot name="thing">
<link name="base"><contact><lateral_friction value="0.5"/></contact>
<inertial><origin xyz="0 0 0.1" rpy="0 0.1 0"/><mass value="2"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.15"/></inertial>
<collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
<collision><origin xyz="0 0 0.5"/><geometry><mesh filename="m.stl" scale="1 1 1"/></geometry></collision></link>
<link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><cylinder radius="0.1" length="0.3"/></geometry></collision></link>
<joint name="j" type="fixed"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.6" rpy="0 0 0"/></joint>
</robot>
"""
SDF = """<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity>
<model name="ground"><static>true</static><link name="link"><collision name="c"><geometry><plane>
<normal>0 0 1</normal><size>9 9</size></plane></geometry></collision></link></model>
<model name="m"><pose>0 0 0.3 0 0 0.1</pose><link name="link">
<inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.15</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.2 0.4 0.6</size></box></geometry>
<surface><friction><ode><mu>0.5</mu><mu2>0.5</mu2></ode></friction></surface></collision>
<collision name="d"><pose>0 0 0.5 0 0 0</pose><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
</link></model></world></sdf>
"""
API = '"PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysicsCollisionAPI"'
USD = f"""#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "w"
{{
    def Cube "a" (prepend apiSchemas = [{API}])
    {{
        double size = 0.2
        float physics:mass = 2
        double3 xformOp:translate = (0, 0, 0.1)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
    def Mesh "b" (prepend apiSchemas = [{API}])
    {{
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    }}
}}
"""
DRAKE = """directives:
- add_model_instance: {name: on}
- add_model: {name: board, file: part.sdf}
- add_frame: {name: seat, X_PF: {base_frame: world, translation: [0, 0, 0.3], rotation: !Rpy {deg: [0, 0, 90]}}}
- add_weld: {parent: seat, child: board::link, X_PC: {rotation: !AngleAxis {angle_deg: 10, axis: [0, 0, 1]}}}
- add_model: {name: low, file: part.sdf, default_free_body_pose: {link: {translation: [0, 0, 0.9]}}}
- add_collision_filter_group: {name: g, members: ["low::link"], ignored_collision_filter_groups: [g]}
"""
PART = SDF.partition('<model name="m">')[1] + SDF.partition('<model name="m">')[2].replace("</world>", "")
TABLE = "name,size_x,size_y,size_z,x,y,z,mass,yaw,fixed,material\n" + (
    "t,2,2,.1,0,0,-.05,,,true,oak\nc,.1,.2,.2,0,0,.1,4,30,no,\n"
)
OBJ = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
MOVEIT = "(noname)+\n* a\n0 0 0.5\n0 0 0 1\n1\nbox\n1 1 1\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n"
HABITAT = {
    "stage_instance": {"template_name": "m.stl"},
    "translation_origin": "COM",
    "object_instances": [
        {"template_name": "thing", "translation": [0.1, 0.9, 0.2], "rotation": [1, 0, 0, 0], "uniform_scale": 0.5}
    ],
}
THING = {"render_asset": "m.stl", "mass": 0.3, "COM": [0, 0, 0], "up": [0, 1, 0], "front": [0, 0, -1]}
PLAN = {
    "bins": [
        {"name": "b", "width": 9, "height": 9, "depth": 9, "unfitted_items": [], "items": [
            {"name": "a", "width": 1, "height": 2, "depth": "3.5", "weight": 4, "rotation_type": 2,
             "position": [0, 0, 0]}]}]}  # fmt: skip
VISUALIZED = {"containers": [{"name": "c", "dx": 3, "stack": {"placements": [
    {"x": 0, "y": 1, "z": 0, "stackable": {"id": "A", "dx": 1, "dy": 1, "dz": 1, "weight": 2}}]}}]}  # fmt: skip
ORDERS = {"7": [{"item": {"article": "a", "length/mm": 300, "width/mm": 200, "height/mm": 100, "weight/kg": 2},
                 "flb_coordinates": [0, 0, 0], "orientation": 1}]}  # fmt: skip
TURN = "1 0 0 0 1 0 0 0 1"
LDRAW = f"""0 FILE main.ldr
1 2 0 0 0 {TURN} 3867.dat
1 4 40 -24 20 {TURN} two.ldr
0 FILE two.ldr
1 4 0 0 0 {TURN} 3001.dat
1 4 20 -8 0 0 0 1 0 1 0 -1 0 0 3020.dat
"""
BESIDE = {  # files to which some of them refer
    "part.sdf": f'<sdf version="1.9">{PART}'.encode(),
    "thing.object_config.json": json.dumps(THING).encode(),
}
FILLED = {"friction": 0.5, "density": 500.0, "floor": True}  # what formats without contacts do not say
Foreign = tuple[str, bytes, dict[str, Any]]  # suffix, content and options


def scenes(folder: Path) -> list[Foreign]:
    """All of them; they may refer to ``m.stl`` beside them."""
    hf.save_scene(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5), folder / "s.xml")
    parts = trimesh.Scene([trimesh.creation.box((1, 1, 0.1)), trimesh.creation.icosphere(1, 0.05)])
    return [
        (".xml", (folder / "s.xml").read_bytes(), {}),
        (".xml", MJCF.encode(), {}),
        (".urdf", URDF.encode(), FILLED),
        (".sdf", SDF.encode(), {}),
        (".json", json.dumps(compas()).encode(), FILLED),
        (".glb", parts.export(file_type="glb"), FILLED),
        (".yaml", DRAKE.encode(), {}),
        (".csv", TABLE.encode(), {"friction": 0.5}),
        (".obj", OBJ.encode(), FILLED | {"bodies": "objects"}),
        (".scene", MOVEIT.encode(), FILLED),
        (".json", json.dumps(HABITAT).encode(), {"friction": 0.5, "floor": True}),
        (".json", json.dumps(PLAN).encode(), {"friction": 0.5, "scale": 0.1}),
        (".json", json.dumps(VISUALIZED).encode(), {"friction": 0.5}),
        (".json", json.dumps(ORDERS).encode(), {"friction": 0.5}),
        (".mpd", LDRAW.encode(), {}),
        (".xml", OBJECT.encode(), {"free": True, "pose": hf.pose(z=0.5).tolist(), "floor": True}),
        *usd(folder),
    ]


def usd(folder: Path) -> list[Foreign]:
    """A stage as text, as a crate and as a package; none where usd-core is not installed."""
    try:
        from pxr import Usd, UsdUtils
    except ImportError:
        return []
    options = {"friction": 0.5, "floor": True}
    (folder / "u.usda").write_text(USD)
    Usd.Stage.Open(str(folder / "u.usda")).Export(str(folder / "u.usdc"))
    UsdUtils.CreateNewUsdzPackage(str(folder / "u.usdc"), str(folder / "u.usdz"))
    return [(f".{each}", (folder / f"u.{each}").read_bytes(), options) for each in ("usda", "usdc", "usdz")]


def compas() -> dict[str, Any]:
    """Two cubes, the lower one a support, as compas_assembly writes them."""
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

    def block(height: float) -> dict[str, Any]:
        vertex = {str(k): {"x": x, "y": y, "z": z + height} for k, (x, y, z) in enumerate(corners.tolist())}
        face = {str(k): quad for k, quad in enumerate(quads)}
        inner = {"attributes": {}, "vertex": vertex, "face": face, "facedata": {}, "max_vertex": 7, "max_face": 5}
        return {"dtype": "compas_assembly.datastructures/Block", "data": inner, "name": "Box", "guid": "g"}

    nodes = {"0": {"block": block(0.0), "is_support": True}, "1": {"block": block(1.0)}}
    graph = {"dtype": "compas.datastructures/Graph", "data": {"node": nodes, "edge": {"0": {"1": {}}}}}
    return {"dtype": "compas_assembly.datastructures/Assembly", "data": {"attributes": {}, "graph": graph}}
