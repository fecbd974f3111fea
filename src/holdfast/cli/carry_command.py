"""The command ``carry``."""

from __future__ import annotations

import os
from typing import Annotated

import typer

from holdfast.applications.carrying.carry import carry as carry_load
from holdfast.applications.carrying.carry import unknown_profile
from holdfast.applications.carrying.profile import STANDARDS, Profile
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.shared_options import (
    Bounds,
    EngineName,
    File,
    Nodes,
    SaveAnswer,
    Straps,
    Tilt,
    Vector,
    check_suffix,
    engine_with,
    option,
    strap_loads,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.carrier_report import carried_report

PROFILE = f"CSV file (t, ax, ay, az, ...) or one of: {', '.join(STANDARDS)}"


@takes_scene
def carry(
    scene: AssemblyGiven,
    profile: Annotated[str, typer.Option(help=PROFILE, show_default=False)],
    heading: Annotated[Vector, option("where the vehicle drives, for a profile by name: X Y Z")] = (1, 0, 0),
    pivot: Annotated[Vector, option("point whose acceleration is given, in m: X Y Z")] = (0, 0, 0),
    speed: Annotated[float, option("play the motion this many times as fast")] = 1.0,
    tilt_degrees: Tilt = None,
    straps: Straps = None,
    engine: EngineName = DEFAULT_ENGINE,
    bounds: Bounds = False,
    png: Annotated[File, option("write a PNG of the motion and the used share to this file")] = None,
    save: SaveAnswer = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Decide whether a scene holds while its carrier moves, and what gives way first and when."""
    check_suffix(png, ".png")
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly = scene.assembled()
    up = assembly.scene.up  # before the tilt: the vehicle's own up direction
    if tilt_degrees is not None:
        assembly = assembly.tilted(tilt_degrees)
    if profile in STANDARDS:
        motion = Profile.named(profile, heading=heading, up=up)
    elif not os.path.lexists(profile):
        raise unknown_profile(profile)
    else:
        motion = Profile.from_file(profile, pivot=pivot)
    loads = strap_loads(straps, assembly)
    with progress():
        result = carry_load(assembly, motion.at_speed(speed), standing=loads, engine=method, bounds=bounds)
    files = [(png, result.save_png), (save, result.save)]
    tell(result, carried_report, as_json=as_json, files=files)
