"""The command ``view``."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.cli.assignments import option
from holdfast.cli.command import EngineGiven, takes_scene
from holdfast.cli.output import out
from holdfast.cli.scenes import AssemblyGiven
from holdfast.live.start import PORT
from holdfast.live.start import view as opened


@takes_scene
def view(
    scene: AssemblyGiven,
    engine: EngineGiven,
    spacing: Annotated[float | None, option("distance between neighbouring points of the map in m")] = None,
    port: Annotated[int, typer.Option(min=1, max=65535, help="port that is tried first")] = PORT,
    browser: Annotated[bool, option("open the browser")] = True,
) -> None:
    """Open a live view: the map on the bodies, clicked pushes, what moves, edits. Ctrl-C closes it."""
    method = engine.chosen()
    with opened(scene.assembled(), engine=method, spacing=spacing, port=port, browser=browser) as live:
        out.say(f"{live.url} shows it, on this machine alone; Ctrl-C closes it")
        live.wait()
