"""The commands ``assess`` and ``map``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.assembly.assembly import Assembly, assemble
from holdfast.cli.common import (
    EXIT,
    Angle,
    AsJson,
    EngineName,
    Gap,
    Immobile,
    Margin,
    MaxCuts,
    Nodes,
    SceneArgument,
    check_suffix,
    engine_with,
    exit_code,
    out,
    print_json,
    progress,
    scene_of,
)
from holdfast.queries.map import robustness_map
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.queries.stability import stability
from holdfast.report.data import stability_data
from holdfast.report.tables import map_report, stability_report


def assess(
    scene: SceneArgument,
    engine: EngineName = DEFAULT_ENGINE,
    gap: Gap = None,
    angle: Angle = None,
    nodes: Nodes = None,
    mass_margin: Margin = 0.0,
    as_json: AsJson = False,
) -> None:
    """Decide whether a scene stands, explain why, and give the forces at its contacts."""
    assembly = assemble(scene_of(scene), gap=gap, angle=angle)
    result = stability(assembly, engine=engine_with(engine, nodes=nodes, mass_margin=mass_margin))
    if as_json:
        print_json(stability_data(assembly, result))
    else:
        out.print(stability_report(assembly, result))
    raise typer.Exit(EXIT[result.status])


def map_surfaces(
    scene: SceneArgument,
    engine: EngineName = DEFAULT_ENGINE,
    spacing: Annotated[float, typer.Option(help="distance between neighbouring points in m")] = 0.01,
    body: Annotated[list[str] | None, typer.Option(help="map this body only (may be repeated)")] = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    html: Annotated[Path | None, typer.Option(help="write an interactive page to this file; it opens offline")] = None,
    gap: Gap = None,
    angle: Angle = None,
    nodes: Nodes = None,
    immobile_above: Immobile = None,
    mass_margin: Margin = 0.0,
    max_cuts: MaxCuts = 20_000,
    as_json: AsJson = False,
) -> None:
    """Compute the largest inward push at points of all exposed surfaces and name the weakest points."""
    check_suffix(png, ".png")
    check_suffix(html, ".html")
    method = engine_with(engine, nodes=nodes, immobile_above=immobile_above, mass_margin=mass_margin, max_cuts=max_cuts)
    assembly: Assembly = assemble(scene_of(scene), gap=gap, angle=angle)
    with progress():
        result = robustness_map(assembly, body, spacing=spacing, engine=method)
    if png is not None:
        result.save_png(png)
    if html is not None:
        result.save_html(html)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(map_report(result))
        for path in (png, html):
            if path is not None:
                out.print(f"wrote {path}", highlight=False, soft_wrap=True)
    raise typer.Exit(exit_code(result.verdict.status, result.answers))
