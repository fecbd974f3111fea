"""The command ``carry``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.carrying.carry import carry as carried
from holdfast.applications.carrying.carry import unknown_profile
from holdfast.applications.carrying.profile import Profile
from holdfast.applications.carrying.standards import STANDARDS
from holdfast.cli.common import EXIT, AsJson, EngineName, Nodes, SaveAnswer, check_suffix, engine_with
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import AssemblyGiven, takes_scene
from holdfast.cli.straps import Straps, strap_loads
from holdfast.cli.terminal import progress
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.carrier_report import carried_report

Vector = tuple[float, float, float]


@takes_scene
def carry(
    scene: AssemblyGiven,
    profile: Annotated[
        str, typer.Option(help=f"CSV file (t, ax, ay, az, ...) or one of: {', '.join(STANDARDS)}", show_default=False)
    ],
    heading: Annotated[Vector, typer.Option(help="where the vehicle drives, for a profile by name: X Y Z")] = (1, 0, 0),
    pivot: Annotated[Vector, typer.Option(help="point whose acceleration is given, in m: X Y Z")] = (0, 0, 0),
    speed: Annotated[float, typer.Option(help="play the motion this many times as fast")] = 1.0,
    tilt_degrees: Annotated[Vector | None, typer.Option(help="rotation vector of the carrier: X Y Z")] = None,
    straps: Straps = None,
    engine: EngineName = DEFAULT_ENGINE,
    bounds: Annotated[bool, typer.Option("--bounds", help="also compute upper bounds by engine limit")] = False,
    png: Annotated[Path | None, typer.Option(help="write a PNG of the motion and the used share to this file")] = None,
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
        result = carried(assembly, motion.at_speed(speed), standing=loads, engine=method, bounds=bounds)
    written = []
    if png is not None:
        result.save_png(png)
        written.append(png)
    if save is not None:
        result.save(save)
        written.append(save)
    if as_json:
        print_json(result.to_dict())
    else:
        out.print(carried_report(result))
        for path in written:
            out.say(f"wrote {path}")
    raise typer.Exit(EXIT[result.outcome])
