"""The scene argument of commands, with one common set of options that say how it is read."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.errors import HoldfastError, SceneError, located, message, nearest_of
from holdfast.base.text import quoted
from holdfast.cli.assignments import (
    POSE,
    assigned,
    number,
    numbers,
    of_all_and_each,
    option,
    poses,
    turns,
)
from holdfast.cli.command import OptionSet, Several
from holdfast.scene.formats.links import on_the_floor
from holdfast.scene.formats.registry import format_of, read_as
from holdfast.scene.formats.source import MAX_BYTES, Source
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shipped import shipped_scene, shipped_scenes

STREAM = "-"  # in place of a file: standard input or output
READING, TOUCHING = "How the scene is read", "Where bodies touch"  # headings in the help of a command
PAIR = "MU, or A:B=MU for a pair of bodies or materials"
Text = str | None
Number = float | None


def _reading(text: str, metavar: str | None = None, *flags: str) -> Any:  # noqa: ANN401 - typer's own type
    return option(text, *flags, metavar=metavar, panel=READING)


def _touching(text: str, metavar: str | None = None, *flags: str) -> Any:  # noqa: ANN401 - typer's own type
    return option(text, *flags, metavar=metavar, panel=TOUCHING)


@dataclass(frozen=True, kw_only=True)
class SceneGiven(OptionSet):
    """A scene by name, and the options with which it is read. The fields are the options of the command line."""

    scene: Annotated[
        str,
        typer.Argument(metavar="SCENE", help="a scene file, - for standard input, or the name of a shipped scene"),
    ]
    pose: Annotated[Several, _reading("put a body there: m, and degrees; of URDF, or with --free, a copy", POSE)] = None
    fixed: Annotated[Several, _reading("this body never moves; of SDF, this model", "BODY")] = None
    friction: Annotated[Several, _reading("coefficient where the file has none; or of a pair", PAIR)] = None
    density: Annotated[Several, _reading("kg/m³ where the file has no mass; or of a body", "RHO or BODY=RHO")] = None
    mass: Annotated[Several, _reading("kg where the file has none; or of a body", "M or BODY=M")] = None
    without: Annotated[Several, _reading("leave this body out of the scene", "BODY")] = None
    free: Annotated[Several, _reading("this body of a model of single objects moves freely", "BODY")] = None
    floor: Annotated[bool, _reading("add a floor: all that is below z = 0", None, "--floor")] = False
    on_floor: Annotated[
        bool, _reading("lift or lower all, so that the lowest point is on the floor", None, "--on-floor")
    ] = False
    rigid: Annotated[bool, _reading("joints between bodies that move hold", None, "--rigid")] = False
    joints: Annotated[Several, _reading("position of a joint that holds: rad or m", "NAME=VALUE")] = None
    hold_torques: Annotated[
        Several, _reading("links are held by motors: N m of a joint, or all by the file", "NAME=MAX")
    ] = None
    key: Annotated[Text, _reading("name or number of a keyframe", "KEY")] = None
    qpos: Annotated[Text, _reading("positions of a model, nq numbers", "Q,Q,...")] = None
    world: Annotated[Text, _reading("one of several worlds of a file", "NAME")] = None
    simulator: Annotated[str | None, _reading("whose friction counts: bullet, drake, gazebo or ode", "NAME")] = None
    combine: Annotated[
        str | None, _reading("how two coefficients make that of a pair: least, mean, product ...", "RULE")
    ] = None
    package: Annotated[Several, _reading("folder of package://NAME", "NAME=FOLDER")] = None
    objects: Annotated[bool, _reading("each object of a mesh file is a body", None, "--objects")] = False
    model_path: Annotated[Several, _reading("a folder of models and packages", "FOLDER")] = None
    collision: Annotated[
        Several, _reading("mesh, or hull: meshes are their hulls; of all or of a body", "BODY=HOW")
    ] = None
    up_axis: Annotated[Text, _reading("axis that points up in mesh files and packing plans: y or z", "AXIS")] = None
    scale: Annotated[Number, _reading("unit of a packing plan, in m: 0.001 for mm", "M")] = None
    stud: Annotated[Number, _reading("force that pulls a stud out of a brick, in N", "N")] = None
    within: Annotated[Text, _reading("folder in which the files lie that a model names", "FOLDER")] = None

    def read(self) -> Scene:
        """Return the scene from the file with this name or, if there is no such file, the shipped scene.

        The name ``-`` stands for standard input. Raises HoldfastError if there is neither, or if the format of the file
        has no such option.
        """
        there = os.path.lexists(self.scene)  # also False for a name that is no valid path
        if not there and self.scene in shipped_scenes():
            options, after = self._options(())
            if options:
                from holdfast.scene.formats.native import NATIVE  # has none either, and tells which formats have them

                NATIVE.check_options(options)
            return after(shipped_scene(self.scene))
        if self.scene != STREAM and not there and not Path(self.scene).suffix:
            remedy = f"shipped: {', '.join(shipped_scenes())}"
            raise HoldfastError(message(self.scene, "is neither a file nor a shipped scene", remedy))
        with located(self.scene):
            source = Source(Path(self.scene), _standard_input() if self.scene == STREAM else None)
            chosen = format_of(source)
            options, after = self._options(chosen.options)
            return after(read_as(chosen, source, options))

    def _options(self, known: Collection[str]) -> tuple[dict[str, Any], Callable[[Scene], Scene]]:
        """Return the options for a reader with the ``known`` ones, and what applies the others to the scene."""
        friction, pairs = of_all_and_each("--friction", self.friction or (), PAIR)
        joints = assigned("--joints", self.joints or (), "NAME=VALUE").items()
        key = int(self.key) if self.key is not None and self.key.isdecimal() else self.key
        ways = list(self.collision or ())
        of_all = len(ways) == 1 and "=" not in ways[0]
        torques = self.hold_torques or ()
        each = assigned("--hold-torques", [text for text in torques if text != "all"], "all, or NAME=MAX")
        limits = {name: number("--hold-torques", text, "NAME=MAX") for name, text in each.items()}
        given: dict[str, Any] = {
            "friction": friction,
            "density": _of_all_or_each("--density", self.density or (), "RHO, or BODY=RHO"),
            "mass": _of_all_or_each("--mass", self.mass or (), "M, or BODY=M"),
            "free": self.free or None,
            "floor": self.floor or None,
            "rigid": self.rigid or None,
            "joints": {name: number("--joints", value, "NAME=VALUE") for name, value in joints} or None,
            "hold_torques": limits or bool(torques) or None,
            "key": key,
            "qpos": None if self.qpos is None else numbers("--qpos", self.qpos, "numbers with commas between them"),
            "world": self.world,
            "simulator": self.simulator,
            "combine": self.combine,
            "package": assigned("--package", self.package or (), "NAME=FOLDER", last=False) or None,
            "bodies": "objects" if self.objects else None,
            "model_path": self.model_path or None,
            "collision": ways[0] if of_all else assigned("--collision", ways, "HOW, or BODY=HOW") or None,
            "up_axis": self.up_axis,
            "scale": self.scale,
            "stud": self.stud,
            "within": self.within,
        }
        options = {name: value for name, value in given.items() if value is not None}
        turned = [f"--pose turns {text}" for text in turns(self.pose or ())]
        moved, fixed = poses(self.pose or ()), self.fixed or []
        if "poses" in known and moved and (self.free or "free" not in known):
            options["poses"], moved = moved, {}
        if "fixed" in known and fixed:
            options["fixed"], fixed = fixed, []
        gone = self.without or []

        def after(scene: Scene) -> Scene:
            chosen = scene.checked_names(*fixed)
            bodies = tuple(replace(body, fixed=body.fixed or body.name in chosen) for body in scene.bodies)
            given = paired(replace(scene, bodies=bodies).moved(moved), pairs, "--friction")
            left = with_notes(
                given.without(gone) if gone else given, [*turned, *(f"--without {name}" for name in gone)]
            )
            return on_the_floor(left) if self.on_floor else left

        return options, after


@dataclass(frozen=True, kw_only=True)
class AssemblyGiven(SceneGiven):
    """A scene like SceneGiven, with the tolerances of contact detection."""

    gap: Annotated[
        float | None,
        _touching(
            "surfaces touch if they are this near, or overlap no deeper, in m; default: 1/1000 of the bodies' size"
        ),
    ] = None
    angle_degrees: Annotated[Number, _touching("largest angle between touching faces in degrees; default: 1")] = None
    pose_sigma: Annotated[
        tuple[float, float] | None,
        _touching("standard deviations of the poses: m and degrees; without gap and angle", "M DEG"),
    ] = None
    allow_large: Annotated[
        bool, _touching("sizes are in metres, though every movable body is larger than a house", None, "--allow-large")
    ] = False

    def assembled(self, scene: Scene | None = None) -> Assembly:
        """Return the assembly of the scene, or of ``scene`` in its place."""
        remarks = []
        if self.angle_degrees is not None:
            remarks.append(f"--angle-degrees: faces touch at up to {self.angle_degrees:g}°")
        if self.pose_sigma is not None:
            remarks.append("--pose-sigma: {:g} m and {:g}°".format(*self.pose_sigma))
        given = with_notes(self.read() if scene is None else scene, remarks)
        return assemble(
            given,
            gap=self.gap,
            angle_degrees=self.angle_degrees,
            pose_sigma=self.pose_sigma,
            allow_large=self.allow_large,
        )


def _of_all_or_each(option: str, given: Sequence[str], form: str) -> float | dict[str, float] | None:
    """Return the number that is given for all, or the number for each name."""
    of_all, each = of_all_and_each(option, given, form)
    if of_all is not None and each:
        raise HoldfastError(message(option, "is given for all and for some", "give one or the other"))
    return each or of_all


def paired(scene: Scene, given: dict[str, float], option: str) -> Scene:
    """Return the scene with friction coefficients for pairs ``A:B`` of bodies or materials from an ``option``."""
    if not given:
        return scene
    old = scene.friction
    pairs = dict(old.pairs)
    for text, mu in given.items():
        pairs[_pair(text, scene, option)] = mu
    return replace(scene, friction=replace(old, pairs=pairs))


def _pair(text: str, scene: Scene, option: str) -> tuple[str, str]:
    """Return the two names of ``A:B``, in alphabetical order; they may hold colons themselves."""
    ends = [k for k, character in enumerate(text) if character == ":"]
    possible = {(text[:k], text[k + 1 :]) for k in ends if {text[:k], text[k + 1 :]} <= scene.names}
    if len(possible) == 1:
        a, b = sorted(possible.pop())
        return a, b
    if possible:
        raise SceneError(message(option, f"{quoted(text)} may be several pairs", "write it in the scene file"))
    unknown = next((name for name in (text.partition(":")[::2]) if name not in scene.names), text)
    remedy = nearest_of(unknown, sorted(scene.names)) if ends else f"needs {PAIR}"
    raise SceneError(message(option, f"{quoted(text)} names no pair of bodies or materials", remedy))


def _standard_input() -> bytes:
    """Return the content of standard input, up to the largest size of a scene file."""
    if sys.stdin is None:
        raise HoldfastError(message(STREAM, "standard input is closed", "name a scene file"))
    content = sys.stdin.buffer.read(MAX_BYTES + 1)
    if not content:
        problem = "standard input is empty, or was read before"
        raise HoldfastError(message(STREAM, problem, "give one scene, as in `holdfast assess - < scene.yaml`"))
    return content
