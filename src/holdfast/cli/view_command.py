"""The command ``view``."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.cli.output import out
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.shared_options import EngineName, Nodes, engine_with, option
from holdfast.live.start import PORT
from holdfast.live.start import view as opened
from holdfast.queries.request import DEFAULT_ENGINE


@takes_scene
def view(
    scene: AssemblyGiven,
    engine: EngineName = DEFAULT_ENGINE,
    nodes: Nodes = None,
    spacing: Annotated[float | None, option("distance between neighbouring points of the map in m")] = None,
    port: Annotated[int, typer.Option(min=1, max=65535, help="port that is tried first")] = PORT,
    browser: Annotated[bool, option("open the browser")] = True,
) -> None:
    """Open a live view: the map on the bodies, clicked pushes, what moves, edits. Ctrl-C closes it."""
    method = engine_with(engine, nodes=nodes)
    with opened(scene.assembled(), engine=method, spacing=spacing, port=port, browser=browser) as live:
        out.say(f"{live.url} shows it, on this machine alone; Ctrl-C closes it")
        live.wait()
