"""What commands share: their options, engines with options, exit codes, and how an answer is told."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, cast

import typer

from holdfast.base.envelope import EXIT, enveloped, verdict_of
from holdfast.base.errors import PNG_INSTALL, PNG_NEEDS, HoldfastError, message
from holdfast.base.public import PublicValue
from holdfast.cli.output import out, print_json
from holdfast.engines.contract import Engine
from holdfast.engines.graph.engine import Graph
from holdfast.queries.request import ENGINES, engine_of

if TYPE_CHECKING:
    from holdfast.assembly.assembly import Assembly
    from holdfast.queries.request import Load
    from holdfast.report.description import Report


def option(text: str, *flags: str, metavar: str | None = None, panel: str | None = None) -> Any:  # noqa: ANN401
    """Return an option with this help; its flag is the name of the parameter, unless ``flags`` are given."""
    return typer.Option(*flags, help=text, metavar=metavar, rich_help_panel=panel)


Vector = tuple[float, float, float]
File = Path | None
Several = list[str] | None
Files = Sequence[tuple[File, Callable[[Path], object]]]
EngineName = Annotated[str, option(f"one of: {', '.join(ENGINES)}", "--engine")]
Nodes = Annotated[int | None, option("contact nodes: graph per interface, compliant per patch side")]
Immobile = Annotated[float | None, option("treat bodies heavier than this (kg) as immobile; optimistic")]
Margin = Annotated[float, option("reduce all masses by this share, 0 to 1")]
MaxCuts = Annotated[int, option("refuse scenes with more feasible cuts than this")]
Hands = Annotated[int, option("hands that may hold other bodies where they are")]
Bounds = Annotated[bool, option("also compute upper bounds by engine limit", "--bounds")]
Tilt = Annotated[Vector | None, option("rotation vector of the carrier: X Y Z")]
Straps = Annotated[File, option("YAML or JSON file with straps, see docs/howto/straps.md")]
SaveAnswer = Annotated[File, option("write the answer to this file (.json or .npz)", "--save")]
Proof = Annotated[File, option("also write a proof for others", "--certificate", metavar="FILE")]
Png = Annotated[File, option("write a PNG picture to this file")]


def engine_with(name: str, **options: Any) -> Engine:  # noqa: ANN401 - options of the engine
    """Return the engine with the given options. Raises HoldfastError if it lacks one that is not at its default."""
    choice: Any = engine_of(name)
    usual = {field.name: field.default for field in dataclasses.fields(Graph)} | {"nodes": None}
    changed = {key: value for key, value in options.items() if value != usual[key]}
    for key in [key for key in changed if key not in _fields(choice)]:
        having = [known for known, make in ENGINES.items() if key in _fields(make())]
        remedy = f"leave it out, or use --engine {' or '.join(having)}"
        raise HoldfastError(message("--" + key.replace("_", "-"), f"engine {name!r} has no such option", remedy))
    return cast(Engine, dataclasses.replace(choice, **changed))


def _fields(engine: Any) -> set[str]:  # noqa: ANN401 - a dataclass
    return {field.name for field in dataclasses.fields(engine)}


def strap_loads(path: File, assembly: Assembly) -> tuple[Load, ...]:
    """Return the standing loads of all straps in the file on the bodies of an assembly; none without a file."""
    from holdfast.applications.strap import Strap

    return () if path is None else tuple(load for strap in Strap.from_file(path) for load in strap.loads(assembly))


def check_suffix(path: File, suffix: str) -> None:
    """Raise HoldfastError if a file has the wrong suffix, or cannot be written because matplotlib is missing.

    To be called before anything is computed.
    """
    if path is None:
        return
    if path.suffix.lower() != suffix:
        raise HoldfastError(message(f"--{suffix[1:]}", f"{path} does not end in {suffix}", f"name a {suffix} file"))
    if suffix == ".png" and find_spec("matplotlib") is None:
        raise HoldfastError(message("--png", PNG_NEEDS, f"{PNG_INSTALL}, or leave it out"))


def tell(
    answer: PublicValue,
    report: Callable[[Any], Report],
    *,
    as_json: bool,
    details: dict[str, Any] | None = None,
    notes: Sequence[str] = (),
    files: Files = (),
    certificate: File = None,
) -> NoReturn:
    """Write the files of an answer that are named, print its envelope or its report, and exit with its verdict's code.

    ``notes``, such as those of the scene, are printed below the report, and come before those of the answer in JSON,
    as ``details`` come after its own. ``files`` are pairs of a path, or None, and a function that writes there.
    """
    written = [(path, write) for path, write in files if path is not None]
    for path, write in written:
        write(path)
    if as_json:
        print_json(enveloped(answer, details=details, notes=notes))
    else:
        out.print(report(answer))
        for note in notes:
            out.say(note, label="note:", style="yellow")
        for path, _ in written:
            out.say(f"wrote {path}")
    if certificate is not None:
        answer.save_certificate(certificate)  # type: ignore[attr-defined]
        if not as_json:
            out.say(f"wrote {certificate}")
    raise typer.Exit(EXIT[verdict_of(answer)])
