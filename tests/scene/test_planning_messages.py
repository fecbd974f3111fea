"""MoveIt's planning scenes as messages of ROS: dictionaries, objects, and bags."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.errors import GeometryError, SceneError
from holdfast.readers import from_planning_scene

BOX, SPHERE, CYLINDER, CONE = 1, 2, 3, 4
ADD, REMOVE, APPEND, MOVE = range(4)
GIVEN: dict[str, Any] = {"friction": 0.5, "mass": 4, "floor": True}


def pose(x: float = 0, y: float = 0, z: float = 0, w: float = 1) -> dict[str, Any]:
    return {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": w}}


def primitive(kind: int, *sizes: float) -> dict[str, Any]:
    return {"type": kind, "dimensions": list(sizes)}


def thing(
    name: str, *shapes: Any, at: Any = None, operation: int = ADD, frame: str = "world", **more: Any
) -> dict[str, Any]:
    own = {"id": name, "pose": at or pose(), "operation": operation, "header": {"frame_id": frame}}
    return own | {"primitives": list(shapes), "primitive_poses": [pose()] * len(shapes)} | more


CRATE = thing("crate", primitive(BOX, 0.1, 0.2, 0.2), at=pose(z=0.1))


def as_objects(value: Any) -> Any:
    """The same message as objects with attributes."""
    if isinstance(value, dict):
        return SimpleNamespace(**{key: as_objects(each) for key, each in value.items()})
    return [as_objects(each) for each in value] if isinstance(value, list) else value


def planning(*objects: Any, **more: Any) -> dict[str, Any]:
    return {"name": "cell", "is_diff": False, "world": {"collision_objects": list(objects)}, **more}


@pytest.mark.parametrize("convert", [lambda msg: msg, as_objects], ids=["dictionary", "objects"])
@pytest.mark.parametrize("msg", [planning(CRATE), planning(CRATE)["world"], CRATE, [CRATE]])
def test_a_crate_on_the_floor(convert: Any, msg: Any) -> None:
    scene = from_planning_scene(convert(msg), **GIVEN)
    assert [(body.name, body.fixed) for body in scene.bodies] == [("crate", False), ("floor", True)]
    push = hf.robustness(scene, "crate", (-0.05, 0, 0.15), (1, 0, 0), engine="limit")
    assert float(push) == pytest.approx(4 * 9.81 * 0.05 / 0.15, rel=1e-6)


def test_every_shape() -> None:
    corners = [{"x": float(x), "y": float(y), "z": float(z)} for x, y, z in np.eye(4, 3)]
    triangles = [{"vertex_indices": each} for each in ([3, 1, 0], [3, 2, 1], [3, 0, 2], [0, 1, 2])]
    mesh = {"meshes": [{"vertices": corners, "triangles": triangles}], "mesh_poses": [pose()]}
    msg = planning(
        thing("ball", primitive(SPHERE, 0.1)), thing("can", primitive(CYLINDER, 0.3, 0.1)), thing("mesh", **mesh)
    )
    shapes = [body.shape for body in from_planning_scene(msg, **GIVEN).movable]
    assert shapes[:2] == [hf.Sphere(0.1), hf.Cylinder(0.1, 0.3)]
    assert shapes[2].mass_properties.volume == pytest.approx(1 / 6)


def test_poses_of_older_messages_and_those_that_were_never_set() -> None:
    older = {"id": "crate", "primitives": CRATE["primitives"], "primitive_poses": [pose(z=0.1, w=0.0)]}
    assert from_planning_scene(older, **GIVEN).body("crate").com_world == pytest.approx((0, 0, 0.1))


def test_an_orientation_is_a_quaternion_by_its_names() -> None:
    """By 90 degrees about z: the long side of the box lies along x; turned again within its object, along y."""
    half = 0.5**0.5
    turned = {"position": {}, "orientation": {"x": 0.0, "y": 0.0, "z": half, "w": half}}
    for poses, size in (([pose()], (0.2, 0.1, 0.2)), ([turned], (0.1, 0.2, 0.2))):
        msg = thing("crate", primitive(BOX, 0.1, 0.2, 0.2), at=turned, primitive_poses=poses)
        low, high = from_planning_scene(msg, **GIVEN).body("crate").box
        assert high - low == pytest.approx(size)


def test_operations_are_applied_in_order() -> None:
    other = thing("ball", primitive(SPHERE, 0.1), at=pose(1))
    more = thing("crate", primitive(BOX, 0.1, 0.1, 0.1), operation=APPEND)
    moved = {"id": "crate", "operation": bytes([MOVE]), "primitives": [], "pose": pose(z=0.5)}
    scene = from_planning_scene([planning(CRATE, other), more, moved, thing("ball", operation=REMOVE)], **GIVEN)
    assert [body.name for body in scene.bodies] == ["crate", "floor"]
    crate = scene.body("crate")
    assert crate.pose[2, 3] == 0.5
    assert len(crate.shape.parts) == 2  # type: ignore[union-attr]
    assert [b.name for b in from_planning_scene([planning(CRATE), planning(other)], **GIVEN).movable] == ["ball"]
    both = from_planning_scene([planning(CRATE), planning(other, is_diff=True)], **GIVEN)
    assert [body.name for body in both.movable] == ["crate", "ball"]


def test_what_is_left_out_is_said() -> None:
    held = {"attached_collision_objects": [{"object": thing("cup", primitive(SPHERE, 0.1))}]}
    msg = planning(CRATE, robot_state=held)
    msg["world"]["octomap"] = {"octomap": {"data": [1, 2]}}
    scene = from_planning_scene(msg, **GIVEN)
    assert scene.notes == ("left out, as the robot holds it: cup", "left out: the octomap")
    assert scene.name == "cell"


@pytest.mark.parametrize(
    ("msg", "error", "text"),
    [
        (1, SceneError, "planning scene: got 1; needs a PlanningScene, PlanningSceneWorld or CollisionObject"),
        (
            planning(CRATE, thing("b", primitive(BOX, 1, 1, 1), frame="tool")),
            SceneError,
            "frames tool, world; transform",
        ),
        (thing("b", primitive(CONE, 1, 1)), GeometryError, "object 'b': primitive: is a cone"),
        (thing("b", primitive(BOX, 1)), GeometryError, r"dimensions: are \[1.0\]; needs 3"),
        (thing("b"), SceneError, "object 'b': shapes: there are none"),
        (thing("b", operation=MOVE), SceneError, "is of an object that is not there; add it first"),
        (thing("b", planes=[{"coef": [0, 0, 1, 0]}]), GeometryError, "plane: has no end"),
        (thing("b", primitive(SPHERE, 1), primitive_poses=[pose()] * 2), SceneError, "1 primitive shapes and 2 poses"),
        (thing("", primitive(SPHERE, 1)), SceneError, "id of an object"),
    ],
)
def test_what_is_refused(msg: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        from_planning_scene(msg, **GIVEN)


def test_friction_and_masses_are_asked_for() -> None:
    with pytest.raises(SceneError, match="planning scene: says nothing of friction; give friction="):
        from_planning_scene(planning(CRATE), mass=1, floor=True)
    with pytest.raises(SceneError, match="has no mass"):
        from_planning_scene(planning(CRATE), friction=0.5, floor=True)


DEFINITIONS = {
    "moveit_msgs/msg/CollisionObject": "std_msgs/Header header\ngeometry_msgs/Pose pose\nstring id\n"
    "shape_msgs/SolidPrimitive[] primitives\ngeometry_msgs/Pose[] primitive_poses\nshape_msgs/Mesh[] meshes\n"
    "geometry_msgs/Pose[] mesh_poses\nbyte operation\n",
    "moveit_msgs/msg/PlanningSceneWorld": "moveit_msgs/CollisionObject[] collision_objects\n",
}


@pytest.mark.parametrize("kind", ["mcap", "sqlite3"])
def test_a_bag(kind: str, tmp_path: Path) -> None:
    writing = pytest.importorskip("rosbags.rosbag2", reason="needs rosbags: pip install 'holdfast-robotics[ros]'")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types: dict[str, Any] = {}
    for name, text in DEFINITIONS.items():
        types |= get_types_from_msg(text, name)
    store.register(types)
    t = store.types
    place = t["geometry_msgs/msg/Pose"](
        t["geometry_msgs/msg/Point"](0.0, 0.0, 0.1), t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    )
    none = t["geometry_msgs/msg/Pose"](
        t["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 0.0)
    )
    header = t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](0, 0), "world")
    polygon = t["geometry_msgs/msg/Polygon"]([])
    box = t["shape_msgs/msg/SolidPrimitive"](BOX, np.array([0.1, 0.2, 0.2]), polygon)
    crate = t["moveit_msgs/msg/CollisionObject"](header, place, "crate", [box], [none], [], [], 0)
    msg = t["moveit_msgs/msg/PlanningSceneWorld"]([crate])
    folder = tmp_path / "run"
    with writing.Writer(folder, version=9, storage_plugin=getattr(writing.StoragePlugin, kind.upper())) as writer:
        for topic, name in (("/world", "PlanningSceneWorld"), ("/other", None)):
            if name is None:
                writer.add_connection(topic, "std_msgs/msg/String", typestore=store)
                continue
            connection = writer.add_connection(topic, f"moveit_msgs/msg/{name}", typestore=store)
            writer.write(connection, 1, store.serialize_cdr(msg, connection.msgtype))
    (file,) = [path for path in folder.iterdir() if path.name != "metadata.yaml"]
    scene = hf.load_scene(file, **GIVEN)
    assert scene.notes == ("1 messages of '/world'",)
    push = hf.robustness(scene, "crate", (-0.05, 0, 0.15), (1, 0, 0), engine="limit")
    assert float(push) == pytest.approx(4 * 9.81 * 0.05 / 0.15, rel=1e-6)
