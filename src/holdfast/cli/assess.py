"""The commands ``assess`` and ``map``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.assembly.assembly import assemble
from holdfast.cli.common import (
    EXIT,
    AllowLarge,
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
    scene_of,
)
from holdfast.cli.output import out, print_json
from holdfast.cli.terminal import progress
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
    allow_large: AllowLarge = False,
    as_json: AsJson = False,
) -> None:
    """Decide whether a scene stands, explain why, and give the forces at its contacts."""
    method = engine_with(engine, nodes=nodes, mass_margin=mass_margin)
    with progress():
        assembly = assemble(scene_of(scene), gap=gap, angle=angle, allow_large=allow_large)
        result = stability(assembly, engine=method)
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
    allow_large: AllowLarge = False,
    as_json: AsJson = False,
) -> None:
    """Compute the largest inward push at points of all exposed surfaces and name the weakest points."""
    check_suffix(png, ".png")
    check_suffix(html, ".html")
    method = engine_with(engine, nodes=nodes, immobile_above=immobile_above, mass_margin=mass_margin, max_cuts=max_cuts)
    with progress():
        assembly = assemble(scene_of(scene), gap=gap, angle=angle, allow_large=allow_large)
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
                out.say(f"wrote {path}")
    raise typer.Exit(exit_code(result.verdict.status, result.answers))
