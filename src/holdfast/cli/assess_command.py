"""The command ``assess``."""

from __future__ import annotations

import typer

from holdfast.cli.common import EXIT, AsJson, EngineName, Margin, Nodes, Proof, certify, engine_with
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.queries.stability import stability
from holdfast.report.contact_report import stability_data, stability_report


@takes_scene
def assess(
    scene: AssemblyGiven,
    engine: EngineName = DEFAULT_ENGINE,
    nodes: Nodes = None,
    mass_margin: Margin = 0.0,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Decide whether a scene stands, explain why, and give the forces at its contacts."""
    method = engine_with(engine, nodes=nodes, mass_margin=mass_margin)
    with progress():
        assembly = scene.assembled()
        result = stability(assembly, engine=method)
    if as_json:
        print_json(stability_data(assembly, result))
    else:
        out.print(stability_report(assembly, result))
    certify(result.save_certificate, certificate, as_json=as_json)
    raise typer.Exit(EXIT[Status.UNSTABLE if result.crushed else result.status])
