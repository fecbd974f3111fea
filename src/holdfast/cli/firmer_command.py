"""The command ``firmer``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.firmer.firmer import firmer as make_firmer
from holdfast.applications.firmer.freedom import Moves
from holdfast.cli.common import AsJson, EngineName, Nodes, SaveAnswer, check_suffix, engine_with, exit_code
from holdfast.cli.output import out, print_json, print_notes
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.cli.written import WRITTEN_SUFFIXES
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.pose_report import firmer_report
from holdfast.scene.formats.registry import save_scene


@takes_scene
def firmer(
    scene: AssemblyGiven,
    bodies: Annotated[list[str], typer.Argument(help="the bodies that may be moved")],
    slide: Annotated[float, typer.Option(help="how far each may slide on what it stands on, in m")] = Moves.slide,
    turn_degrees: Annotated[float, typer.Option(help="how far each may be turned, in degrees")] = Moves.turn_degrees,
    apart: Annotated[float, typer.Option(help="distance to keep from others, in m")] = Moves.apart,
    nearer_edges: Annotated[bool, typer.Option("--nearer-edges", help="they may come nearer to edges")] = False,
    profile: Annotated[str | None, typer.Option(help="a motion, as for carry, in place of pushes")] = None,
    seconds: Annotated[float | None, typer.Option(help="longest time of the search, in s")] = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG of the scene before and after to this file")] = None,
    scene_out: Annotated[
        Path | None, typer.Option("--scene-out", help=f"write the firmer scene to this file ({WRITTEN_SUFFIXES})")
    ] = None,
    engine: EngineName = DEFAULT_ENGINE,
    save: SaveAnswer = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Move bodies a little, to where the least push that moves something is larger."""
    check_suffix(png, ".png")
    moves = Moves(slide=slide, turn_degrees=turn_degrees, apart=apart, nearer_edges=nearer_edges)
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = make_firmer(assembly, bodies, moves=moves, motion=profile, engine=method, seconds=seconds)
    written = [path for path in (png, scene_out, save) if path is not None]
    if png is not None:
        result.save_png(png)
    if scene_out is not None:
        save_scene(result.assembly.scene, scene_out)
    if save is not None:
        result.save(save)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(firmer_report(result))
        print_notes(result.notes)
        for path in written:
            out.say(f"wrote {path}")
    raise typer.Exit(exit_code(result.verdict.status, result.answers))
