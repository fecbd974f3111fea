"""The command ``push``."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer

from holdfast.base.arrays import Float
from holdfast.cli.common import (
    AsJson,
    EngineName,
    Nodes,
    Proof,
    certify,
    engine_with,
    exit_code,
)
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.terminal import progress
from holdfast.engines.answers import Claim
from holdfast.queries.push import robustness
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.contact_report import push_report
from holdfast.scene.scene import Scene

Vector = tuple[float, float, float]


@takes_scene
def push(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(metavar="BODY", help="the name of the body that is pushed")],
    at: Annotated[Vector, typer.Option(metavar="X Y Z", help="point on the body in m")],
    along: Annotated[Vector, typer.Option(metavar="X Y Z", help="direction of the push; its length does not matter")],
    local: Annotated[bool, typer.Option("--local", help="point and direction are in the body's own frame")] = False,
    engine: EngineName = DEFAULT_ENGINE,
    nodes: Nodes = None,
    certificate: Proof = None,
    as_json: AsJson = False,
) -> None:
    """Compute how hard a body can be pushed at a point in a direction before anything moves, and what moves then."""
    method = engine_with(engine, nodes=nodes)
    given = scene.read()
    point, direction = in_world(given, body, at, along) if local else (np.array(at), np.array(along))
    with progress():
        assembly = scene.assembled(given)
        result = robustness(assembly, body, point, direction, engine=method, bounds=method.claim is not Claim.ESTIMATED)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(push_report(result))
    certify(result.save_certificate, certificate, as_json=as_json)
    raise typer.Exit(exit_code(result.verdict.status, result.answers))


def in_world(scene: Scene, name: str, at: Vector, along: Vector) -> tuple[Float, Float]:
    """Return a point (3,) [m] and a direction (3,) of a body's own frame in the world frame.

    Raises SceneError for an unknown body.
    """
    body = scene.body(name)
    return body.placed(np.array([at]))[0], body.pose[:3, :3] @ np.array(along)
