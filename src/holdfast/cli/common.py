"""Shared parts of the commands: arguments, reading of scenes and engines, printing and progress bars."""

from __future__ import annotations

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from holdfast.base.errors import HoldfastError, message
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.engines.verdict import Status
from holdfast.queries.request import ENGINES, engine_of
from holdfast.scene.formats.registry import load_scene, read_scene, writable
from holdfast.scene.formats.source import MAX_BYTES
from holdfast.scene.scene import Scene
from holdfast.scene.shipped import shipped_scene, shipped_scenes

EXIT = {Status.STABLE: 0, Status.UNSTABLE: 1, Status.UNDECIDED: 3}  # exit code of each status

WRITTEN_SUFFIXES = ", ".join(dict.fromkeys(suffix for each in writable() for suffix in each.suffixes))

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="a scene file, - for standard input, or the name of a shipped scene")
]
STREAM = "-"  # in place of a file: standard input or output
AllowLarge = Annotated[
    bool, typer.Option("--allow-large", help="sizes are in metres, though every movable body is larger than a house")
]
Gap = Annotated[float | None, typer.Option(help="contact tolerance in m; default: 1/1000 of the usual body size")]
Angle = Annotated[float | None, typer.Option(help="largest angle between touching faces in degrees; default: 1")]
EngineName = Annotated[str, typer.Option("--engine", help=f"one of: {', '.join(ENGINES)}")]
Nodes = Annotated[int | None, typer.Option(help="contact nodes: graph per interface, compliant per patch side")]
Immobile = Annotated[float | None, typer.Option(help="treat bodies heavier than this (kg) as immobile; optimistic")]
Margin = Annotated[float, typer.Option(help="reduce all masses by this share, 0 to 1")]
MaxCuts = Annotated[int, typer.Option(help="refuse scenes with more feasible cuts than this")]
AsJson = Annotated[bool, typer.Option("--json", help="print JSON; infinity is the text inf")]


def scene_of(name: str) -> Scene:
    """Return the scene from the file with this name or, if there is no such file, the shipped scene.

    The name ``-`` stands for standard input. Raises HoldfastError if there is neither.
    """
    if name == STREAM:
        return read_scene(_standard_input(), STREAM)
    there = os.path.lexists(name)  # False, too, for what is no path at all
    if not there and name in shipped_scenes():
        return shipped_scene(name)
    if not there and not Path(name).suffix:
        remedy = f"shipped: {', '.join(shipped_scenes())}"
        raise HoldfastError(message(name, "is neither a file nor a shipped scene", remedy))
    return load_scene(name)


def _standard_input() -> bytes:
    """Return what stands in standard input, up to the largest file that is read."""
    if sys.stdin is None:
        raise HoldfastError(message(STREAM, "standard input is closed", "name a scene file"))
    content = sys.stdin.buffer.read(MAX_BYTES + 1)
    if not content:
        problem = "standard input is empty, or was read before"
        raise HoldfastError(message(STREAM, problem, "give one scene, as in `holdfast assess - < scene.yaml`"))
    return content


def engine_with(name: str, **options: Any) -> Engine:  # noqa: ANN401 - options of the engine
    """Return the engine with the options that differ from their defaults.

    Raises HoldfastError if the engine does not have one of these options.
    """
    choice: Any = engine_of(name)
    own = {field.name for field in dataclasses.fields(choice)}
    usual = {field.name: field.default for field in dataclasses.fields(Graph)} | {"nodes": None}
    changed = {key: value for key, value in options.items() if value != usual[key]}
    for key in changed:
        if key not in own:
            having = [
                known
                for known, make in ENGINES.items()
                if key in {f.name for f in dataclasses.fields(cast(Any, make()))}
            ]
            remedy = f"leave it out, or use --engine {' or '.join(having)}"
            raise HoldfastError(message("--" + key.replace("_", "-"), f"engine {name!r} has no such option", remedy))
    return cast(Engine, dataclasses.replace(choice, **changed))


def exit_code(status: Status, answers: Answers) -> int:
    """Return the exit code of an answer with this status.

    It is that of "undecided" also where the assembly stands but no row of the table is decided.
    """
    nothing = len(answers) > 0 and not answers.decided.any()
    return EXIT[Status.UNDECIDED if nothing and status is Status.STABLE else status]


def check_suffix(path: Path | None, suffix: str) -> None:
    """Raise HoldfastError if the name of the file does not end in the suffix of its format."""
    if path is not None and path.suffix.lower() != suffix:
        raise HoldfastError(message(f"--{suffix[1:]}", f"{path} does not end in {suffix}", f"name a {suffix} file"))
