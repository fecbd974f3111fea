"""The command ``holdfast``.

Exit codes: 0 stable, 1 not stable, 2 bad input, 3 undecided, 4 internal error.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from holdfast import __version__
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.engines.contract import Engine, Status
from holdfast.engines.graph.engine import Graph
from holdfast.errors import HoldfastError, HoldfastWarning, SolverError, message
from holdfast.progress import listening
from holdfast.report import save_html, save_png
from holdfast.report.data import map_data, stability_data
from holdfast.report.tables import map_report, stability_report
from holdfast.robustness.map import robustness_map
from holdfast.robustness.request import DEFAULT_ENGINE, ENGINES, engine_of
from holdfast.robustness.stability import stability
from holdfast.scene.formats.files import load_scene, save_scene
from holdfast.scene.formats.native import schema as scene_schema
from holdfast.scene.scene import Scene
from holdfast.shipped import SHIPPED, shipped_scene

app = typer.Typer(
    name="holdfast",
    help="How hard can you push here before something moves?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
out, err = Console(), Console(stderr=True)

EXIT = {Status.STABLE: 0, Status.UNSTABLE: 1, Status.UNDECIDED: 3}
BAD_INPUT, INTERNAL, STOPPED = 2, 4, 130

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="a scene file, or the name of a shipped scene")]
Gap = Annotated[float | None, typer.Option(help="contact tolerance in m; default: 1/1000 of the usual body size")]
Angle = Annotated[float | None, typer.Option(help="largest angle between touching faces in degrees; default: 1")]
EngineName = Annotated[str, typer.Option("--engine", help=f"one of: {', '.join(ENGINES)}")]
Nodes = Annotated[int | None, typer.Option(help="graph: contact nodes an interface; compliant: along a patch's side")]
Immobile = Annotated[float | None, typer.Option(help="bodies heavier than this (in kg) count as immobile (optimistic)")]
Margin = Annotated[float, typer.Option(help="take all masses smaller by this share, 0 to 1")]
MaxCuts = Annotated[int, typer.Option(help="refuse scenes with more feasible cuts than this")]
AsJson = Annotated[bool, typer.Option("--json", help="print JSON; infinity is the text inf")]


@app.command()
def assess(
    scene: SceneArgument,
    engine: EngineName = DEFAULT_ENGINE,
    gap: Gap = None,
    angle: Angle = None,
    nodes: Nodes = None,
    mass_margin: Margin = 0.0,
    as_json: AsJson = False,
) -> None:
    """Say whether a scene stands, why, and which forces its contacts carry."""
    assembly = assemble(_scene(scene), gap=gap, angle=angle)
    result = stability(assembly, engine=_engine(engine, nodes=nodes, mass_margin=mass_margin))
    if as_json:
        _print_json(stability_data(assembly, result))
    else:
        out.print(stability_report(assembly, result))
    raise typer.Exit(EXIT[result.status])


@app.command("map")
def map_(
    scene: SceneArgument,
    engine: EngineName = DEFAULT_ENGINE,
    spacing: Annotated[float, typer.Option(help="distance of neighbouring points in m")] = 0.01,
    body: Annotated[list[str] | None, typer.Option(help="map this body only (may be repeated)")] = None,
    png: Annotated[Path | None, typer.Option(help="write a picture here")] = None,
    html: Annotated[Path | None, typer.Option(help="write an interactive page here (opens offline)")] = None,
    gap: Gap = None,
    angle: Angle = None,
    nodes: Nodes = None,
    immobile_above: Immobile = None,
    mass_margin: Margin = 0.0,
    max_cuts: MaxCuts = 20_000,
    as_json: AsJson = False,
) -> None:
    """Map the largest inward push over all exposed surfaces and name the weakest points."""
    _check_suffix(png, ".png")
    _check_suffix(html, ".html")
    method = _engine(engine, nodes=nodes, immobile_above=immobile_above, mass_margin=mass_margin, max_cuts=max_cuts)
    assembly: Assembly = assemble(_scene(scene), gap=gap, angle=angle)
    with _progress():
        result = robustness_map(assembly, body, spacing, engine=method)
    if png is not None:
        save_png(result, png)
    if html is not None:
        save_html(result, html)
    if as_json:
        _print_json(map_data(result))
    else:
        out.print(map_report(result))
        for path in (png, html):
            if path is not None:
                out.print(f"wrote {path}", highlight=False, soft_wrap=True)
    raise typer.Exit(EXIT[result.verdict.status])


@app.command()
def convert(
    source: SceneArgument,
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="native scene file to write (.yaml or .json)")],
    as_json: AsJson = False,
) -> None:
    """Write a scene in the native format, from any format that can be read."""
    scene = _scene(source)
    save_scene(scene, target)
    counts = {"written": str(target), "bodies": len(scene.bodies), "movable": len(scene.movable)}
    if as_json:
        _print_json(counts)
    else:
        text = f"wrote {target}: {counts['bodies']} bodies, {counts['movable']} movable"
        out.print(text, highlight=False, soft_wrap=True)


@app.command()
def schema() -> None:
    """Print the JSON schema of the native scene file."""
    _print_json(scene_schema(), indent=2)


def _version(value: bool) -> None:
    if value:
        out.print(f"holdfast {__version__}", highlight=False)
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    pass


def run() -> None:
    """Entry point: turns errors into one line and an exit code."""
    warnings.showwarning = _show_warning  # type: ignore[assignment]
    warnings.simplefilter("always", HoldfastWarning)
    try:
        sys.exit(app(standalone_mode=False) or 0)
    except SolverError as error:
        _complain("no answer", str(error))
        sys.exit(EXIT[Status.UNDECIDED])
    except HoldfastError as error:
        _complain("error", str(error))
        sys.exit(BAD_INPUT)
    except (typer.Abort, KeyboardInterrupt):
        _complain("stopped", "by the user")
        sys.exit(STOPPED)
    except Exception as error:
        if isinstance(getattr(error, "exit_code", None), int):  # typer's own word on wrong usage
            error.show()  # type: ignore[attr-defined]
            sys.exit(BAD_INPUT)
        traceback.print_exc()
        _complain("internal error", "this is a defect in holdfast: please report it with the lines above")
        sys.exit(INTERNAL)


def _scene(name: str) -> Scene:
    if Path(name).exists() or name not in SHIPPED:
        if not Path(name).suffix and not Path(name).exists():
            raise HoldfastError(
                message(name, "is neither a file nor a shipped scene", f"shipped: {', '.join(SHIPPED)}")
            )
        return load_scene(name)
    return shipped_scene(name)


def _engine(name: str, **options: Any) -> Engine:  # noqa: ANN401 - options of the engine
    """The engine with the options that were changed; an option that it does not have is an error."""
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


def _check_suffix(path: Path | None, suffix: str) -> None:
    if path is not None and path.suffix.lower() != suffix:
        raise HoldfastError(message(f"--{suffix[1:]}", f"{path} does not end in {suffix}", f"name a {suffix} file"))


def _print_json(data: Any, *, indent: int | None = None) -> None:  # noqa: ANN401
    sys.stdout.write(json.dumps(data, allow_nan=False, indent=indent) + "\n")


def _complain(kind: str, text: str) -> None:
    err.print(f"[bold red]{kind}:[/] ", end="")
    err.print(text, markup=False, highlight=False, soft_wrap=True)


def _show_warning(text: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    if issubclass(category, HoldfastWarning):
        err.print("[yellow]warning:[/] ", end="")
        err.print(str(text), markup=False, highlight=False, soft_wrap=True)


@contextmanager
def _progress() -> Iterator[None]:
    """Draw a bar for each stage that reports, where somebody watches."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bars:
        tasks: dict[str, Any] = {}

        def listener(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        with listening(listener):
            yield


if __name__ == "__main__":
    run()
