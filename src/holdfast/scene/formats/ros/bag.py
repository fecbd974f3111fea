"""Reads the planning scenes in a bag of ROS 1 or 2 through rosbags."""

from __future__ import annotations

from collections.abc import Collection

from numpy.typing import ArrayLike

from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import SceneError, message
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.moveit import Planned, scene_of_objects
from holdfast.scene.formats.named_meshes import Numbers
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.ros.planning_messages import World
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene

MARKS = {".bag": b"#ROSBAG V2", ".mcap": b"\x89MCAP0\r\n", ".db3": b"SQLite format 3\0"}
KINDS = ("PlanningScene", "PlanningSceneWorld", "CollisionObject")


def sniff(source: Source) -> bool:
    """Tell whether the file begins as a bag of its suffix does."""
    return source.suffix in MARKS and source.head.startswith(MARKS[source.suffix])


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the planning scene at the end of a bag.

    All messages of moveit_msgs/PlanningScene, PlanningSceneWorld and CollisionObject are applied in their order. The
    other options are those of ``from_planning_scene``. Raises SceneError if there is no such message, or if the bag
    lacks the definitions of messages.
    """
    from rosbags.highlevel import AnyReader

    where = str(source.path)
    world, topics, others, count = World(), dict[str, None](), dict[str, None](), 0
    folder = source.suffix != ".bag" and (source.path.parent / "metadata.yaml").is_file()
    bag = AnyReader([source.path.parent if folder else source.path])
    with foreign(where, remedy="needs a complete bag with its definitions"), bag as reader:
        wanted = [each for each in reader.connections if each.msgtype.rpartition("/")[2] in KINDS]
        others.update(dict.fromkeys(each.topic for each in reader.connections if each not in wanted))
        for connection, _, raw in reader.messages(connections=wanted) if wanted else ():
            world.apply(reader.deserialize(raw, connection.msgtype))
            topics[connection.topic] = None
            count += 1
    if not count:
        problem = f"holds no message of {listed(KINDS)}, but {listed(list(others))}" if others else "holds no message"
        raise SceneError(message(where, problem, "record /planning_scene or /monitored_planning_scene"))
    notes = [f"{count} messages of {listed([quoted(topic) for topic in topics])}", *world.notes()]
    options = Planned(friction, density, mass, fixed, floor, gravity)
    return scene_of_objects(where, world.objects, options, world.name or source.path.stem, notes)


BAG = Format("ROS bag", tuple(MARKS), sniff, read, extra="ros")
