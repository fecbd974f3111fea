"""Shared parts of the commands: arguments, reading of scenes and engines, printing and progress bars."""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import listening
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.engines.verdict import Status
from holdfast.queries.request import ENGINES, engine_of
from holdfast.scene.formats.registry import load_scene, writable
from holdfast.scene.scene import Scene
from holdfast.scene.shipped import shipped_scene, shipped_scenes

out, err = Console(), Console(stderr=True)

EXIT = {Status.STABLE: 0, Status.UNSTABLE: 1, Status.UNDECIDED: 3}  # exit code of each status

WRITTEN_SUFFIXES = ", ".join(dict.fromkeys(suffix for each in writable() for suffix in each.suffixes))

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="a scene file, or the name of a shipped scene")]
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

    Raises HoldfastError if there is neither.
    """
    if Path(name).exists() or name not in shipped_scenes():
        if not Path(name).suffix and not Path(name).exists():
            raise HoldfastError(
                message(name, "is neither a file nor a shipped scene", f"shipped: {', '.join(shipped_scenes())}")
            )
        return load_scene(name)
    return shipped_scene(name)


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


def print_json(data: Any, *, indent: int | None = None) -> None:  # noqa: ANN401 - any JSON value
    """Print strict JSON: it has no NaN, and infinity is a text."""
    sys.stdout.write(json.dumps(data, allow_nan=False, indent=indent) + "\n")


@contextmanager
def progress() -> Iterator[None]:
    """Show a progress bar for each stage that reports its progress, if the output is a terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bars:
        tasks: dict[str, Any] = {}

        def listener(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        with listening(listener):
            yield
