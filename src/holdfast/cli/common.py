"""Shared parts of the commands: options, engines and exit codes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from holdfast.base.distribution import PNG_INSTALL, PNG_NEEDS
from holdfast.base.errors import HoldfastError, message
from holdfast.cli.output import out
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.engines.verdict import Status
from holdfast.queries.request import ENGINES, engine_of

EXIT = {Status.STABLE: 0, Status.UNSTABLE: 1, Status.UNDECIDED: 3}  # exit code of each status

EngineName = Annotated[str, typer.Option("--engine", help=f"one of: {', '.join(ENGINES)}")]
Nodes = Annotated[int | None, typer.Option(help="contact nodes: graph per interface, compliant per patch side")]
Immobile = Annotated[float | None, typer.Option(help="treat bodies heavier than this (kg) as immobile; optimistic")]
Margin = Annotated[float, typer.Option(help="reduce all masses by this share, 0 to 1")]
MaxCuts = Annotated[int, typer.Option(help="refuse scenes with more feasible cuts than this")]
SaveAnswer = Annotated[Path | None, typer.Option("--save", help="write the answer to this file (.json or .npz)")]
Proof = Annotated[Path | None, typer.Option("--certificate", metavar="FILE", help="also write a proof for others")]
Hands = Annotated[int, typer.Option(help="hands that may hold other bodies where they are")]
AsJson = Annotated[bool, typer.Option("--json", help="print JSON; infinity is the text inf")]


def engine_with(name: str, **options: Any) -> Engine:  # noqa: ANN401 - options of the engine
    """Return the engine with the given options. Raises HoldfastError if it lacks one that is not at its default."""
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


def certify(save: Callable[[Path], None], path: Path | None, *, as_json: bool) -> None:
    """Write the certificate of an answer that was printed, if one is asked for."""
    if path is not None:
        save(path)
        if not as_json:
            out.say(f"wrote {path}")


def exit_code(status: Status, answers: Answers) -> int:
    """Return the exit code of an answer: that of its status, unless it stands and no row is decided, or one gives way.

    A row gives way without any load where a body is crushed at rest.
    """
    if status is not Status.STABLE or not len(answers):
        return EXIT[status]
    nothing, crushed = not answers.decided.any(), Status.UNSTABLE in answers.status
    return EXIT[Status.UNSTABLE if crushed else Status.UNDECIDED if nothing else status]


def order_exit_code(*, reached: bool, proven: bool) -> int:
    """Return the exit code of a search for an order: found, proved not to exist, or undecided."""
    return EXIT[Status.STABLE if reached else Status.UNSTABLE if proven else Status.UNDECIDED]


def check_suffix(path: Path | None, suffix: str) -> None:
    """Raise HoldfastError if a file has the wrong suffix, or cannot be written because matplotlib is missing.

    To be called before anything is computed.
    """
    if path is None:
        return
    if path.suffix.lower() != suffix:
        raise HoldfastError(message(f"--{suffix[1:]}", f"{path} does not end in {suffix}", f"name a {suffix} file"))
    if suffix == ".png" and find_spec("matplotlib") is None:
        raise HoldfastError(message("--png", PNG_NEEDS, f"{PNG_INSTALL}, or leave it out"))
