"""Planning scenes of MoveIt: text files (.scene), messages, and bags of ROS 1 and 2; without masses or friction.

A message is an object of any of ROS's client libraries, or a dictionary with the same fields; ROS is not imported. Bags
are read through rosbags.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_name
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.ranges import PLACE
from holdfast.base.rigid import UNIT_LENGTH, pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Solid
from holdfast.scene.formats.links import BodyPiece, checked_fixed, filled, rigid_body, scene_of, with_floor
from holdfast.scene.formats.named_meshes import Numbers, Weights
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

MOST_SHAPES = 10_000  # largest number of shapes of one object
MOST_DIGITS = 20  # of a whole number; the time to read one grows with the square
BOX, SPHERE, CYLINDER = 1, 2, 3  # shape_msgs/SolidPrimitive
KINDS = {4: "cone", 5: "prism"}
ADD, REMOVE, APPEND, MOVE = range(4)  # moveit_msgs/CollisionObject
WHERE = "planning scene"
MARKS = {".bag": b"#ROSBAG V2", ".mcap": b"\x89MCAP0\r\n", ".db3": b"SQLite format 3\0"}
MESSAGES = ("PlanningScene", "PlanningSceneWorld", "CollisionObject")


def sniff_text(source: Source) -> bool:
    """Tell whether the file is a text whose second line begins an object, or which ends after the name."""
    if source.suffix != ".scene" or b"\0" in source.head:
        return False
    second = source.text.partition("\n")[2].lstrip()
    return second.startswith(("* ", "."))


def read_text(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a planning scene's text: one body for each object, named by its id.

    MoveIt files have neither friction nor masses: ``friction`` and ``density`` [kg/m³] or ``mass`` [kg] are needed,
    each one number or one for each name. ``fixed`` names the objects that never move, and ``floor`` adds the half space
    below z = 0. Colours and subframes are left out. Raises SceneError if the file is malformed, or if friction or
    masses are missing.
    """
    objects = dict(_Lines(source).objects())
    where, name = str(source.path), source.path.stem
    return scene_of_objects(where, objects, name, [], friction, density, mass, fixed, floor, gravity)


def scene_of_objects(
    where: str,
    objects: Mapping[str, tuple[Float, list[BodyPiece]]],
    name: str,
    notes: Sequence[str],
    friction: Friction | float | None,
    density: Numbers | None,
    mass: Numbers | None,
    fixed: Collection[str],
    floor: bool,
    gravity: ArrayLike,
) -> Scene:
    """Return the scene of objects, each with its pose (4, 4) and its shapes; ``where`` names them in errors."""
    if friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    weights = Weights(mass, density, list(objects))
    fixed_names = checked_fixed(fixed, objects, "object")
    bodies = []
    for each, (pose, pieces) in objects.items():
        with located(f"{where}: object {quoted(each)}"):
            inertial = None
            if each not in fixed_names:
                whole, dense = weights.of(each)
                if whole is None and dense is None:
                    remedy = "give mass= or density=, for it or for all"
                    raise SceneError(message(f"object {quoted(each)}", "has no mass", remedy))
                inertial = filled(pieces, 1.0 if dense is None else dense).weighing(whole)
            bodies.append(rigid_body(each, pieces, pose=pose, inertial=inertial, fixed=each in fixed_names))
    remedy = f"give fixed=[name] ({listed(objects)}), or floor=True for a floor at z = 0"
    return scene_of(with_floor(bodies, floor, where, remedy), friction, gravity, name, notes)


class _Lines:
    """A reader of the lines of a file, one after the other."""

    def __init__(self, source: Source) -> None:
        self.path = source.path
        self.lines = source.text.splitlines()
        self.at = 1  # the first line is the name of the scene

    def fail(self, problem: str, remedy: str) -> NoReturn:
        raise SceneError(message(f"{self.path}:{self.at}", problem, remedy))

    def line(self) -> str:
        """Return the next line."""
        if self.at >= len(self.lines):
            self.fail("ends within an object", "needs the whole text of a planning scene, with a line '.' at its end")
        self.at += 1
        return self.lines[self.at - 1].strip()

    def numbers(self, count: int) -> Float:
        """Return the finite numbers of the next line."""
        text = self.line()
        try:
            found = np.array([float(word) for word in text.split()])
        except ValueError:
            found = np.zeros(0)
        if len(found) != count or not np.isfinite(found).all():
            self.fail(f"holds {quoted(text)}", f"needs {count} finite numbers")
        return found

    def whole(self, most: int) -> int:
        """Return the whole number on the next line."""
        text = self.line()
        if not text.isdecimal() or len(text) > MOST_DIGITS or int(text) > most:
            self.fail(f"holds {quoted(text)}", f"needs a whole number of at most {most:,}")
        return int(text)

    def pose(self) -> Float:
        """Return a pose (4, 4) from two lines: a position, and a quaternion with its real part last."""
        place = self.numbers(3)
        x, y, z, w = self.numbers(4)
        if abs(np.linalg.norm((x, y, z, w)) - 1) > UNIT_LENGTH:
            self.fail("has a quaternion of another length than 1", "needs x, y, z, w")
        return pose_from(place, np.array([w, x, y, z]))

    def objects(self) -> Iterator[tuple[str, tuple[Float, list[BodyPiece]]]]:
        """Yield the name of each object with its pose and its shapes.

        In files of older versions the object has no pose: the number of its shapes follows its name.
        """
        seen: set[str] = set()
        while (begin := self.line()) != ".":
            name = begin.removeprefix("*").strip()
            if not begin.startswith("*") or not name or name in seen:
                self.fail(f"holds {quoted(begin)}", "needs '* ' and a name that no other object has, or '.' at the end")
            seen.add(name)
            newer = self.at < len(self.lines) and len(self.lines[self.at].split()) > 1
            pose = self.pose() if newer else np.eye(4)
            pieces = [self.piece() for _ in range(self.whole(MOST_SHAPES))]
            if newer:
                for _ in range(self.whole(MOST_SHAPES)):  # subframes
                    self.line()
                    self.pose()
            if not pieces:
                self.fail(f"ends the object {quoted(name)}, which has no shape", "needs one")
            yield name, (pose, pieces)

    def piece(self) -> BodyPiece:
        """Return a shape with its pose in the object; skip its colour."""
        shape = self.shape()
        pose = self.pose()
        self.numbers(4)
        return BodyPiece(shape, pose)

    def shape(self) -> Solid:
        """Return the next shape."""
        kind = self.line()
        with located(f"{self.path}:{self.at}"):
            match kind:
                case "box":
                    return Box(self.numbers(3))
                case "sphere":
                    return Sphere(float(self.numbers(1)[0]))
                case "cylinder":
                    radius, length = self.numbers(2)
                    return Cylinder(float(radius), float(length))
                case "mesh":
                    corners, triangles = (int(number) for number in self.numbers(2))
                    vertices = np.array([self.numbers(3) for _ in range(corners)])
                    return Mesh(vertices, np.array([self.numbers(3) for _ in range(triangles)]).astype(np.int64))
        return self.fail(f"holds {quoted(kind)}", "reads box, sphere, cylinder and mesh")


MOVEIT = Format("MoveIt", (".scene",), sniff_text, read_text)


def from_planning_scene(
    msg: Any,  # noqa: ANN401 - a message or a dictionary
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    name: str = "",
) -> Scene:
    """Return the scene of a message ``moveit_msgs/PlanningScene``, one body for each collision object, named by its id.

    ``msg`` may also be a ``PlanningSceneWorld``, a ``CollisionObject`` or a list of messages, which are applied one
    after the other: objects are added, removed, moved, and get more shapes, as their ``operation`` says. Messages have
    neither friction nor masses: ``friction`` and ``density`` [kg/m³] or ``mass`` [kg] are needed, each one number or
    one for each name. ``fixed`` names the objects that never move, and ``floor`` adds the half space below z = 0. The
    robot and what it holds are left out, with a note. Raises SceneError if a message is malformed, has objects in
    several frames, or if friction or masses are missing.
    """
    world = World()
    for each in msg if isinstance(msg, list | tuple) else [msg]:
        world.apply(each)
    name, notes = name or world.name, world.notes()
    return scene_of_objects(WHERE, world.objects, name, notes, friction, density, mass, fixed, floor, gravity)


class World:
    """The objects of planning scenes that are applied one after the other."""

    def __init__(self) -> None:
        self.objects: dict[str, tuple[Float, list[BodyPiece]]] = {}
        self.name = ""
        self.frames: dict[str, str] = {}  # of objects, by their names
        self.held: dict[str, None] = {}
        self.voxels = False

    def apply(self, msg: Any) -> None:  # noqa: ANN401
        """Apply a message. A planning scene that is no difference replaces what there was."""
        if _has(msg, "world"):
            if not _field(msg, "is_diff", False):
                self.objects.clear()
                self.frames.clear()
                self.held.clear()
            self.name = str(_field(msg, "name", "") or self.name)
            attached = _field(_field(msg, "robot_state", {}), "attached_collision_objects", [])
            self.held.update(dict.fromkeys(str(_field(_field(each, "object", {}), "id", "")) for each in attached))
            msg = _field(msg, "world")
        if _has(msg, "collision_objects"):
            data = _field(_field(_field(msg, "octomap", {}), "octomap", {}), "data", [])
            self.voxels |= len(data) > 0
            for each in _field(msg, "collision_objects"):
                self._change(each)
        elif _has(msg, "primitives") or _has(msg, "meshes"):
            self._change(msg)
        else:
            remedy = "needs a PlanningScene, PlanningSceneWorld or CollisionObject, as a message or a dictionary"
            raise SceneError(message(WHERE, f"got {quoted(msg, 80)}", remedy))

    def notes(self) -> list[str]:
        """Return notes on what was left out."""
        if len(set(self.frames.values())) > 1:
            problem = f"its objects are in the frames {listed(sorted(set(self.frames.values())))}"
            raise SceneError(message(WHERE, problem, "transform them to one frame first"))
        found = []
        if self.held:
            found.append(f"left out, as the robot holds it: {listed(list(self.held))}")
        if self.voxels:
            found.append("left out: the octomap")
        return found

    def _change(self, msg: Any) -> None:  # noqa: ANN401
        """Add, remove, extend or move an object."""
        name = checked_name(_field(msg, "id", ""), f"{WHERE}: id of an object")
        operation = _field(msg, "operation", ADD)
        operation = operation[0] if isinstance(operation, bytes) else int(operation)
        if operation == REMOVE:
            self.objects.pop(name, None)
            self.frames.pop(name, None)
            return
        with located(f"{WHERE}: object {quoted(name)}"):
            pose = _pose(_field(msg, "pose", {}))
            pieces = list(_pieces(msg))
            if operation in (APPEND, MOVE) and name not in self.objects:
                raise SceneError(message("operation", "is of an object that is not there", "add it first"))
            if operation == MOVE:
                before = self.objects[name][1]
                places = [place for key in ("primitive_poses", "mesh_poses") for place in _field(msg, key, [])]
                moved = len(places) == len(before)
                pieces = (
                    [old._replace(pose=_pose(p)) for old, p in zip(before, places, strict=True)] if moved else before
                )
            elif operation == APPEND:
                pose, before = self.objects[name]
                pieces = before + pieces
            if not pieces:
                raise SceneError(message("shapes", "there are none", "needs primitives or meshes"))
            self.frames[name] = str(_field(_field(msg, "header", {}), "frame_id", ""))
        self.objects[name] = (pose, pieces)


def _has(msg: Any, key: str) -> bool:  # noqa: ANN401
    return key in msg if isinstance(msg, Mapping) else hasattr(msg, key)


def _field(msg: Any, key: str, *default: Any) -> Any:  # noqa: ANN401
    """Return a field of a message or dictionary; messages of older versions lack some."""
    if not _has(msg, key) and default:
        return default[0]
    return msg[key] if isinstance(msg, Mapping) else getattr(msg, key)


def _numbers(msg: Any, keys: Iterable[str], where: str) -> Float:  # noqa: ANN401
    values = [_field(msg, key, 0.0) for key in keys]
    return checked(values, (None,), where, within=PLACE)


def _pose(msg: Any) -> Float:  # noqa: ANN401
    """Return a geometry_msgs/Pose as (4, 4); an orientation that was never set, all zero, is none, as in MoveIt."""
    place = _numbers(_field(msg, "position", {}), "xyz", "position")
    turn = _numbers(_field(msg, "orientation", {}), "wxyz", "orientation")
    return pose_from(place, turn if turn.any() else np.array([1.0, 0.0, 0.0, 0.0]))


def _pieces(msg: Any) -> Iterator[BodyPiece]:  # noqa: ANN401
    """Yield the shapes of an object with their poses in its frame."""
    if len(_field(msg, "planes", [])):
        raise GeometryError(message("plane", "has no end", "leave it out, and say floor=True or add a body"))
    for what, make in (("primitive", _primitive), ("mesh", _mesh)):
        shapes = _field(msg, {"primitive": "primitives", "mesh": "meshes"}[what], [])
        poses = _field(msg, f"{what}_poses", [])
        if len(poses) not in (0, len(shapes)):
            problem = f"has {len(shapes)} {what} shapes and {len(poses)} poses"
            raise SceneError(message(f"{what}_poses", problem, "needs one for each"))
        for k, shape in enumerate(shapes):
            yield BodyPiece(make(shape), _pose(poses[k]) if len(poses) else np.eye(4))


def _primitive(msg: Any) -> Solid:  # noqa: ANN401
    kind, sizes = int(_field(msg, "type")), [float(size) for size in _field(msg, "dimensions")]
    needed = {BOX: 3, SPHERE: 1, CYLINDER: 2}
    if len(sizes) < needed.get(kind, 0):
        raise GeometryError(message("dimensions", f"are {sizes}", f"needs {needed[kind]}"))
    match kind:
        case 1:
            return Box(sizes[:3])
        case 2:
            return Sphere(sizes[0])
        case 3:
            return Cylinder(sizes[1], sizes[0])
    problem = f"is a {KINDS[kind]}" if kind in KINDS else f"is of type {kind}"
    raise GeometryError(message("primitive", problem, "needs a box, sphere or cylinder, or a mesh of it"))


def _mesh(msg: Any) -> Solid:  # noqa: ANN401
    vertices = np.array([_numbers(corner, "xyz", "vertex") for corner in _field(msg, "vertices")]).reshape(-1, 3)
    faces = [[int(k) for k in _field(each, "vertex_indices")] for each in _field(msg, "triangles")]
    return Mesh(vertices, np.array(faces, dtype=np.int64).reshape(-1, 3))


def sniff_bag(source: Source) -> bool:
    """Tell whether the file begins as a bag of its suffix does."""
    return source.suffix in MARKS and source.head.startswith(MARKS[source.suffix])


def read_bag(
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
        wanted = [each for each in reader.connections if each.msgtype.rpartition("/")[2] in MESSAGES]
        others.update(dict.fromkeys(each.topic for each in reader.connections if each not in wanted))
        for connection, _, raw in reader.messages(connections=wanted) if wanted else ():
            world.apply(reader.deserialize(raw, connection.msgtype))
            topics[connection.topic] = None
            count += 1
    if not count:
        problem = "holds no message" + (f" of {listed(MESSAGES)}, but {listed(list(others))}" if others else "")
        raise SceneError(message(where, problem, "record /planning_scene or /monitored_planning_scene"))
    notes = [f"{count} messages of {listed([quoted(topic) for topic in topics])}", *world.notes()]
    name = world.name or source.path.stem
    return scene_of_objects(where, world.objects, name, notes, friction, density, mass, fixed, floor, gravity)


BAG = Format("ROS bag", tuple(MARKS), sniff_bag, read_bag, extra="ros")
