"""The commands about a scene on a carrier that moves: transport and carry."""

from __future__ import annotations

import os
from functools import partial
from typing import Annotated, Any

import typer

from holdfast.applications.carrying import carry as carrying
from holdfast.applications.carrying.carry import Carried
from holdfast.applications.carrying.profile import STANDARDS, Profile
from holdfast.applications.strap import Strap
from holdfast.applications.transport import inertial_loads, transport_limits
from holdfast.assembly.assembly import Assembly
from holdfast.cli.assignments import option
from holdfast.cli.command import SAVE, CommandAnswer, EngineGiven, File, Several, Vector, check_suffix, question
from holdfast.cli.output import err
from holdfast.cli.scenes import AssemblyGiven
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.request import Load
from holdfast.queries.sets import sustainable_accelerations
from holdfast.report.carrier_report import carried_report, transport_report

PROFILE = f"CSV file (t, ax, ay, az, ...) or one of: {', '.join(STANDARDS)}"
Bounds = Annotated[bool, option("also compute upper bounds by engine limit", "--bounds")]
Tilt = Annotated[Vector | None, option("rotation vector of the carrier: X Y Z")]
Straps = Annotated[File, option("YAML or JSON file with straps, see docs/howto/straps.md")]


@question(transport_report)
def transport(
    scene: AssemblyGiven,
    engine: EngineGiven,
    count: Annotated[int, option("number of horizontal directions, beginning at +x")] = 100,
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
) -> CommandAnswer:
    """Compute how fast the carrier of a scene may accelerate before something moves on it."""
    check_suffix(png, ".png")
    methods = [engine.chosen(), *(EngineGiven(engine=name).chosen() for name in compare or ())]
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
    result, *others = (ask(engine=method, bounds=bounds and method is methods[0]) for method in methods)
    files: list[Any] = [(png, partial(result.save_png, others=others))]
    if set_file is not None and result.verdict.status is Status.STABLE:
        exists = result.claim is Claim.EXISTS  # what was asked of engine limit
        files.insert(0, (set_file, sustainable_accelerations(assembly, exists=exists, standing=loads).save))
    elif set_file is not None:
        err.say(f"no set written: the assembly is {result.verdict.status}")
    return CommandAnswer(result, files=files)


@question(carried_report, png="write a PNG of the motion and the used share to this file", save=SAVE)
def carry(
    scene: AssemblyGiven,
    profile: Annotated[str, typer.Option(help=PROFILE, show_default=False)],
    engine: EngineGiven,
    heading: Annotated[Vector, option("where the vehicle drives, for a profile by name: X Y Z")] = (1, 0, 0),
    pivot: Annotated[Vector, option("point whose acceleration is given, in m: X Y Z")] = (0, 0, 0),
    speed: Annotated[float, option("play the motion this many times as fast")] = 1.0,
    tilt_degrees: Tilt = None,
    straps: Straps = None,
    bounds: Bounds = False,
) -> Carried:
    """Decide whether a scene holds while its carrier moves, and what gives way first and when."""
    method, assembly = engine.chosen(), scene.assembled()
    up = assembly.scene.up  # before the tilt: the vehicle's own up direction
    if tilt_degrees is not None:
        assembly = assembly.tilted(tilt_degrees)
    if profile in STANDARDS:
        motion = Profile.named(profile, heading=heading, up=up)
    elif not os.path.lexists(profile):
        raise carrying.unknown_profile(profile)
    else:
        motion = Profile.from_file(profile, pivot=pivot)
    loads = strap_loads(straps, assembly)
    return carrying.carry(assembly, motion.at_speed(speed), standing=loads, engine=method, bounds=bounds)


def strap_loads(path: File, assembly: Assembly) -> tuple[Load, ...]:
    """Return the standing loads of all straps in the file on the bodies of an assembly; none without a file."""
    return () if path is None else tuple(load for strap in Strap.from_file(path) for load in strap.loads(assembly))
