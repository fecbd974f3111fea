"""The command ``disassemble``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.disassembly.order import SOLVES, disassembly_order
from holdfast.cli.common import (
    AsJson,
    EngineName,
    Hands,
    Nodes,
    Proof,
    certify,
    check_suffix,
    engine_with,
    order_exit_code,
)
from holdfast.cli.output import noted, out, print_json, print_notes
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.order_report import disassembly_report


@takes_scene
def disassemble(
    scene: AssemblyGiven,
    goal: Annotated[list[str] | None, typer.Option(help="take out this body (may be repeated); default: all")] = None,
    lift: Annotated[tuple[float, float, float], typer.Option(help="direction in which bodies leave: X Y Z")] = (
        0,
        0,
        1,
    ),
    engine: EngineName = DEFAULT_ENGINE,
    png: Annotated[Path | None, typer.Option(help="write a PNG of the sequence to this file")] = None,
    solves: Annotated[int, typer.Option(help="stop after this many checks by contact forces")] = SOLVES,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Find an order in which the bodies of a scene can be taken out, one by one, while the others stand."""
    check_suffix(png, ".png")
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = disassembly_order(assembly, engine=method, lift=lift, goal=goal or None, solves=solves, hands=hands)
    if png is not None:
        result.save_png(png)
    if as_json:
        print_json(noted(result.to_dict(), assembly.scene.notes))
    else:
        out.print(disassembly_report(result))
        print_notes(assembly.scene.notes)
        if png is not None:
            out.say(f"wrote {png}")
    certify(result.save_certificate, certificate, as_json=as_json)
    raise typer.Exit(order_exit_code(reached=result.reached, proven=result.proven))
