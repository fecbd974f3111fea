"""The command ``settle``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.settled import settle as settled
from holdfast.cli.common import (
    EXIT,
    AsJson,
    EngineName,
    check_suffix,
    engine_with,
)
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import SceneGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.cli.written import WRITTEN_SUFFIXES
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.pose_report import settled_report
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.scene import with_notes

TURN = 15.0  # [deg] default of --turn-degrees


@takes_scene
def settle(
    scene: SceneGiven,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help=f"write the scene at rest to this file: {WRITTEN_SUFFIXES}")
    ] = None,
    travel: Annotated[float, typer.Option(help="a body that goes farther than this in m falls")] = 0.03,
    turn_degrees: Annotated[float, typer.Option(help="a body that turns by more than this in degrees falls")] = TURN,
    known: Annotated[list[str] | None, typer.Option(help="a body whose pose is exact (may be repeated)")] = None,
    upright: Annotated[list[str] | None, typer.Option(help="a body that stands upright (may be repeated)")] = None,
    pose_sigma: Annotated[float | None, typer.Option(help="standard deviation of the positions in m")] = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    engine: EngineName = DEFAULT_ENGINE,
    gap: Annotated[float | None, typer.Option(help="contact tolerance of the verdict in m; default: by pair")] = None,
    as_json: AsJson = False,
) -> None:
    """Bring a perceived or authored scene to rest near its poses, and say what moved and what falls."""
    check_suffix(png, ".png")
    method = engine_with(engine)
    remarks = [f"--turn-degrees: what turns by more than {turn_degrees:g}° falls"] if turn_degrees != TURN else []
    with progress():
        result = settled(
            with_notes(scene.read(), remarks),
            travel=travel,
            turn_degrees=turn_degrees,
            known=known or (),
            upright=upright or (),
            pose_sigma=pose_sigma,
            gap=gap,
            engine=method,
        )
    if png is not None:
        result.save_png(png)
    if output is not None:
        save_scene(result.scene, output)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(settled_report(result, result.given.name or scene.scene), highlight=False)
        for path in (png, output):
            if path is not None:
                out.say(f"wrote {path}")
    raise typer.Exit(EXIT[result.status])
