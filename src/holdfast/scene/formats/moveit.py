"""Reads MoveIt planning scenes from text files (.scene): objects of several shapes, without masses or friction."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, located, message
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


def sniff(source: Source) -> bool:
    """Tell whether the file is a text whose second line begins an object, or which ends after the name."""
    if source.suffix != ".scene" or b"\0" in source.head:
        return False
    second = source.text.partition("\n")[2].lstrip()
    return second.startswith(("* ", "."))


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
    """Return the scene of a planning scene's text: one body for each object, named by its id.

    MoveIt files have neither friction nor masses: ``friction`` and ``density`` [kg/m³] or ``mass`` [kg] are needed,
    each one number or one for each name. ``fixed`` names the objects that never move, and ``floor`` adds the half space
    below z = 0. Colours and subframes are left out. Raises SceneError if the file is malformed, or if friction or
    masses are missing.
    """
    objects = dict(_Lines(source).objects())
    options = Planned(friction, density, mass, fixed, floor, gravity)
    return scene_of_objects(str(source.path), objects, options, source.path.stem, [])


class Planned(NamedTuple):
    """What planning scenes do not say: see the options of ``read``."""

    friction: Friction | float | None
    density: Numbers | None
    mass: Numbers | None
    fixed: Collection[str]
    floor: bool
    gravity: ArrayLike


def scene_of_objects(
    where: str, objects: Mapping[str, tuple[Float, list[BodyPiece]]], given: Planned, name: str, notes: Sequence[str]
) -> Scene:
    """Return the scene of objects, each with its pose (4, 4) and its shapes; ``where`` names them in errors."""
    if given.friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    weights = Weights(given.mass, given.density, list(objects))
    held = checked_fixed(given.fixed, objects, "object")
    bodies = []
    for each, (pose, pieces) in objects.items():
        with located(f"{where}: object {quoted(each)}"):
            inertial = None
            if each not in held:
                mass, density = weights.of(each)
                if mass is None and density is None:
                    remedy = "give mass= or density=, for it or for all"
                    raise SceneError(message(f"object {quoted(each)}", "has no mass", remedy))
                inertial = filled(pieces, 1.0 if density is None else density).weighing(mass)
            bodies.append(rigid_body(each, pieces, pose=pose, inertial=inertial, fixed=each in held))
    remedy = f"give fixed=[name] ({listed(objects)}), or floor=True for a floor at z = 0"
    return scene_of(with_floor(bodies, given.floor, where, remedy), given.friction, given.gravity, name, notes)


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


MOVEIT = Format("MoveIt", (".scene",), sniff, read)
