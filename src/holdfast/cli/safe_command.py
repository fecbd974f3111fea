"""The command ``safe``."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.applications.pushing.result import Effect
from holdfast.applications.pushing.safe import DOUBT, safe_pushes
from holdfast.applications.pushing.tool import Tool
from holdfast.cli.common import EXIT, AsJson, EngineName, Nodes, SaveAnswer, engine_with
from holdfast.cli.output import out, print_json, print_notes
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.order_report import pushes_report


@takes_scene
def safe(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be pushed")],
    force: Annotated[float, typer.Option(help="the most that the tool pushes with, in N", show_default=False)],
    direction: Annotated[
        tuple[float, float, float] | None, typer.Option(help="push along X Y Z only; default: inwards everywhere")
    ] = None,
    radius: Annotated[float, typer.Option(help="radius of the tool, in m")] = Tool.radius,
    spacing: Annotated[float | None, typer.Option(help="distance between points, in m; default: about 100")] = None,
    travel: Annotated[float, typer.Option(help="how far the body is pushed, in m")] = Tool.travel,
    doubt: Annotated[float, typer.Option(help="share by which friction may be off")] = DOUBT,
    engine: EngineName = DEFAULT_ENGINE,
    save: SaveAnswer = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Find where a body can be pushed so that nothing moves, or so that it moves alone."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = safe_pushes(
            assembly,
            body,
            force,
            directions=direction,
            spacing=spacing,
            tool=Tool(radius, travel),
            doubt=doubt,
            engine=method,
        )
    if save is not None:
        result.save(save)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(pushes_report(result))
        print_notes(result.notes)
        if save is not None:
            out.say(f"wrote {save}")
    known = bool((result.nothing | result.alone | result.are(Effect.OTHERS)).any())
    raise typer.Exit(EXIT[Status.STABLE if known else Status.UNDECIDED])
