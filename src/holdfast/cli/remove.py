"""The command ``remove``."""

from __future__ import annotations

from typing import Annotated

import typer

from holdfast.applications.disassembly.removal import Answer
from holdfast.applications.disassembly.removal_check import can_remove
from holdfast.cli.common import EXIT, AsJson, EngineName, Hands, Nodes, Proof, certify, engine_with
from holdfast.cli.output import noted, out, print_json, print_notes
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.order_report import removal_report

STATUS = {Answer.SAFE: Status.STABLE, Answer.UNSAFE: Status.UNSTABLE, Answer.UNDECIDED: Status.UNDECIDED}


@takes_scene
def remove(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be taken out")],
    lift: Annotated[tuple[float, float, float], typer.Option(help="direction in which it leaves: X Y Z")] = (0, 0, 1),
    engine: EngineName = DEFAULT_ENGINE,
    hands: Hands = 0,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Decide whether one body may be taken out of a scene now, and say who would move if not."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
        result = can_remove(assembly, body, lift=lift, engine=method, hands=hands)
    if as_json:
        print_json(noted(result.to_dict(), assembly.scene.notes))
    else:
        out.print(removal_report(result))
        print_notes(assembly.scene.notes)
    certify(result.save_certificate, certificate, as_json=as_json)
    raise typer.Exit(EXIT[STATUS[result.answer]])
