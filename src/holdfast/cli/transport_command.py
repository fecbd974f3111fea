"""The command ``transport``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.inertia import inertial_loads
from holdfast.applications.transport import transport_limits
from holdfast.cli.common import (
    AsJson,
    EngineName,
    Nodes,
    check_suffix,
    engine_with,
    exit_code,
)
from holdfast.cli.output import err, out, print_json
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.straps import Straps, strap_loads
from holdfast.cli.terminal import progress
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.queries.sets import sustainable_accelerations
from holdfast.report.carrier_report import transport_report

Vector = tuple[float, float, float]
Bodies = Annotated[
    list[str] | None,
    typer.Option(help="only what this body and those in contact with it allow (may be repeated); default: all"),
]


@takes_scene
def transport(
    scene: AssemblyGiven,
    count: Annotated[int, typer.Option(help="number of horizontal directions, beginning at +x")] = 100,
    engine: EngineName = DEFAULT_ENGINE,
    compare: Annotated[list[str] | None, typer.Option(help="draw this engine too (may be repeated)")] = None,
    tilt_degrees: Annotated[Vector | None, typer.Option(help="rotation vector of the carrier: X Y Z")] = None,
    angular_acceleration: Annotated[Vector | None, typer.Option(help="of the carrier in rad/s²: X Y Z")] = None,
    angular_velocity: Annotated[Vector | None, typer.Option(help="of the carrier in rad/s: X Y Z")] = None,
    pivot: Annotated[Vector, typer.Option(help="point about which it rotates in m: X Y Z")] = (0.0, 0.0, 0.0),
    jolt: Annotated[float, typer.Option(help="vertical acceleration in m/s² that acts throughout, upwards > 0")] = 0.0,
    bodies: Bodies = None,
    straps: Straps = None,
    bounds: Annotated[bool, typer.Option("--bounds", help="also compute upper bounds by engine limit")] = False,
    png: Annotated[Path | None, typer.Option(help="write a PNG polar plot to this file")] = None,
    set_file: Annotated[
        Path | None, typer.Option("--set", help="write the set of sustainable accelerations here (.json or .npz)")
    ] = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Compute how fast the carrier of a scene may accelerate before something moves on it."""
    check_suffix(png, ".png")
    methods = [engine_with(engine, nodes=nodes), *(engine_with(name) for name in compare or ())]
    with progress():
        assembly = scene.assembled()
    if tilt_degrees is not None:
        assembly = assembly.tilted(tilt_degrees)
    loads = inertial_loads(
        assembly,
        acceleration=jolt * assembly.scene.up,
        angular_acceleration=angular_acceleration,
        angular_velocity=angular_velocity,
        pivot=pivot,
    )
    loads += strap_loads(straps, assembly)
    ways = assembly.scene.horizontal_directions(count)
    written = []
    ask = partial(transport_limits, assembly, ways, standing=loads, bodies=bodies)
    with progress():
        results = [ask(engine=method, bounds=bounds and method is methods[0]) for method in methods]
        result = results[0]
        if set_file is not None and result.verdict.status is Status.STABLE:
            exists = result.claim is Claim.EXISTS  # what was asked of engine limit
            sustainable_accelerations(assembly, exists=exists, standing=loads).save(set_file)
            written.append(set_file)
    if set_file is not None and set_file not in written:
        err.say(f"no set written: the assembly is {result.verdict.status}")
    if png is not None:
        result.save_png(png, others=results[1:])
        written.append(png)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(transport_report(result))
        for path in written:
            out.say(f"wrote {path}")
    raise typer.Exit(exit_code(result.verdict.status, result.answers))
