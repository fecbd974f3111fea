"""The command ``build``."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.applications.disassembly.build import PUSHES, build_order
from holdfast.applications.disassembly.order import SOLVES
from holdfast.cli.common import (
    AsJson,
    EngineName,
    Hands,
    Nodes,
    Proof,
    SaveAnswer,
    certify,
    engine_with,
    order_exit_code,
)
from holdfast.cli.output import noted, out, print_json, print_notes
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.order_report import build_report


@takes_scene
def build(
    scene: AssemblyGiven,
    lift: Annotated[tuple[float, float, float], typer.Option(help="direction that bodies come from: X Y Z")] = (
        0,
        0,
        1,
    ),
    pushes: Annotated[int, typer.Option(help="approximate number of pushes on each state; 0: none")] = PUSHES,
    solves: Annotated[int, typer.Option(help="stop after this many checks by contact forces")] = SOLVES,
    engine: EngineName = DEFAULT_ENGINE,
    save: SaveAnswer = None,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Find an order in which a scene can be built, so that everything stands after each step."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = build_order(assembly, lift=lift, pushes=pushes, solves=solves, engine=method, hands=hands)
    if save is not None:
        result.save(save)
    if as_json:
        print_json(noted(result.to_dict(), assembly.scene.notes))
    else:
        out.print(build_report(result))
        print_notes(assembly.scene.notes)
        if save is not None:
            out.say(f"wrote {save}")
    certify(result.save_certificate, certificate, as_json=as_json)
    raise typer.Exit(order_exit_code(reached=result.reached, proven=result.proven))
