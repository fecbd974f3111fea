"""The command ``disassemble``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.disassembly.order import BUDGET, disassembly_order
from holdfast.assembly.assembly import assemble
from holdfast.cli.common import (
    EXIT,
    Angle,
    AsJson,
    EngineName,
    Gap,
    Nodes,
    SceneArgument,
    check_suffix,
    engine_with,
    out,
    print_json,
    progress,
    scene_of,
)
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.disassembly import disassembly_report


def disassemble(
    scene: SceneArgument,
    goal: Annotated[list[str] | None, typer.Option(help="take this body out (may be repeated); else all")] = None,
    lift: Annotated[tuple[float, float, float], typer.Option(help="direction in which bodies leave: X Y Z")] = (
        0,
        0,
        1,
    ),
    engine: EngineName = DEFAULT_ENGINE,
    png: Annotated[Path | None, typer.Option(help="write the sequence as a picture here")] = None,
    budget: Annotated[int, typer.Option(help="answers by contact forces after which a search stops")] = BUDGET,
    gap: Gap = None,
    angle: Angle = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Say in which order the bodies of a scene can be taken out, one by one, while the rest stands."""
    check_suffix(png, ".png")
    method = engine_with(engine, nodes=nodes)
    assembly = assemble(scene_of(scene), gap=gap, angle=angle)
    with progress():
        result = disassembly_order(assembly, engine=method, lift=lift, goal=goal or None, budget=budget)
    if png is not None:
        result.save_png(png)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(disassembly_report(result))
        if png is not None:
            out.print(f"wrote {png}", highlight=False, soft_wrap=True)
    status = Status.STABLE if result.reached else Status.UNSTABLE if result.proven else Status.UNDECIDED
    raise typer.Exit(EXIT[status])
