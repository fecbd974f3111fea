"""The command ``firmer``."""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from holdfast.applications.firmer.firmer import firmer as make_firmer
from holdfast.applications.firmer.freedom import Moves
from holdfast.cli.file_commands import WRITTEN_SUFFIXES
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.shared_options import (
    EngineName,
    File,
    Files,
    Nodes,
    SaveAnswer,
    check_suffix,
    engine_with,
    option,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.pose_report import firmer_report
from holdfast.scene.formats.registry import save_scene


@takes_scene
def firmer(
    scene: AssemblyGiven,
    bodies: Annotated[list[str], typer.Argument(help="the bodies that may be moved")],
    slide: Annotated[float, option("how far each may slide on what it stands on, in m")] = Moves.slide,
    turn_degrees: Annotated[float, option("how far each may be turned, in degrees")] = Moves.turn_degrees,
    apart: Annotated[float, option("distance to keep from others, in m")] = Moves.apart,
    nearer_edges: Annotated[bool, option("they may come nearer to edges", "--nearer-edges")] = False,
    profile: Annotated[str | None, option("a motion, as for carry, in place of pushes")] = None,
    seconds: Annotated[float | None, option("longest time of the search, in s")] = None,
    png: Annotated[File, option("write a PNG of the scene before and after to this file")] = None,
    scene_out: Annotated[
        File, option(f"write the firmer scene to this file ({WRITTEN_SUFFIXES})", "--scene-out")
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
    files: Files = [
        (png, result.save_png),
        (scene_out, partial(save_scene, result.assembly.scene)),
        (save, result.save),
    ]
    tell(result, firmer_report, as_json=as_json, notes=result.notes, files=files)
