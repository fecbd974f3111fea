"""The command ``map``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.cli.common import (
    AsJson,
    EngineName,
    Immobile,
    Margin,
    MaxCuts,
    Nodes,
    check_suffix,
    engine_with,
    exit_code,
)
from holdfast.cli.estimates import print_cost_of_limit
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.queries.map import robustness_map
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.contact_report import map_report


@takes_scene
def map_surfaces(
    scene: AssemblyGiven,
    engine: EngineName = DEFAULT_ENGINE,
    spacing: Annotated[float, typer.Option(help="distance between neighbouring points in m")] = 0.01,
    bodies: Annotated[list[str] | None, typer.Option(help="map this body only (may be repeated)")] = None,
    accuracy: Annotated[float, typer.Option(help="engine limit stops this close; 0: it solves every point")] = 0.01,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    html: Annotated[Path | None, typer.Option(help="write an interactive page to this file; it opens offline")] = None,
    glb: Annotated[Path | None, typer.Option(help="write glTF with colours and forces at its vertices")] = None,
    ply: Annotated[Path | None, typer.Option(help="write PLY with colours and forces at its vertices")] = None,
    nodes: Nodes = None,
    immobile_above: Immobile = None,
    mass_margin: Margin = 0.0,
    max_cuts: MaxCuts = 20_000,
    as_json: AsJson = False,
) -> None:
    """Compute the largest inward push at points of all exposed surfaces and name the weakest points."""
    files = {".png": png, ".html": html, ".glb": glb, ".ply": ply}
    for suffix, path in files.items():
        check_suffix(path, suffix)
    method = engine_with(engine, nodes=nodes, immobile_above=immobile_above, mass_margin=mass_margin, max_cuts=max_cuts)
    with progress():
        assembly = scene.assembled()
        print_cost_of_limit(assembly, bodies, spacing, method)
        result = robustness_map(assembly, bodies, spacing=spacing, engine=method, accuracy=accuracy)
        savers = (result.save_png, result.save_html, result.save_glb, result.save_ply)
        for save, path in zip(savers, files.values(), strict=True):
            if path is not None:
                save(path)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(map_report(result))
        for path in files.values():
            if path is not None:
                out.say(f"wrote {path}")
    raise typer.Exit(exit_code(result.verdict.status, result.answers))
