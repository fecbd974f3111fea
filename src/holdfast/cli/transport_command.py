"""The command ``transport``."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from holdfast.applications.transport import inertial_loads, transport_limits
from holdfast.cli.output import AsJson, err, progress
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.shared_options import (
    Bounds,
    EngineName,
    File,
    Nodes,
    Several,
    Straps,
    Tilt,
    Vector,
    check_suffix,
    engine_with,
    option,
    strap_loads,
    tell,
)
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.queries.sets import sustainable_accelerations
from holdfast.report.carrier_report import transport_report


@takes_scene
def transport(
    scene: AssemblyGiven,
    count: Annotated[int, option("number of horizontal directions, beginning at +x")] = 100,
    engine: EngineName = DEFAULT_ENGINE,
    compare: Annotated[Several, option("draw this engine too (may be repeated)")] = None,
    tilt_degrees: Tilt = None,
    angular_acceleration: Annotated[Vector | None, option("of the carrier in rad/s²: X Y Z")] = None,
    angular_velocity: Annotated[Vector | None, option("of the carrier in rad/s: X Y Z")] = None,
    pivot: Annotated[Vector, option("point about which it rotates in m: X Y Z")] = (0.0, 0.0, 0.0),
    jolt: Annotated[float, option("vertical acceleration in m/s² that acts throughout, upwards > 0")] = 0.0,
    bodies: Annotated[
        Several, option("only what this body and those in contact with it allow (may be repeated); default: all")
    ] = None,
    straps: Straps = None,
    bounds: Bounds = False,
    png: Annotated[File, option("write a PNG polar plot to this file")] = None,
    set_file: Annotated[
        File, option("write the set of sustainable accelerations here (.json or .npz)", "--set")
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
    ask = partial(transport_limits, assembly, ways, standing=loads, bodies=bodies)
    with progress():
        results = [ask(engine=method, bounds=bounds and method is methods[0]) for method in methods]
        result = results[0]
        save_set = None
        if set_file is not None and result.verdict.status is Status.STABLE:
            exists = result.claim is Claim.EXISTS  # what was asked of engine limit
            save_set = sustainable_accelerations(assembly, exists=exists, standing=loads).save
    if set_file is not None and save_set is None:
        err.say(f"no set written: the assembly is {result.verdict.status}")
    files = [] if save_set is None else [(set_file, save_set)]
    files.append((png, partial(result.save_png, others=results[1:])))
    tell(result, transport_report, as_json=as_json, files=files)
