"""The command ``rest``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.resting_poses import resting_poses
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import listed
from holdfast.base.values import altered
from holdfast.cli.common import AsJson, check_suffix
from holdfast.cli.output import noted, out, print_json, print_notes
from holdfast.cli.scenes import SceneGiven, takes_scene
from holdfast.report.pose_report import resting_report
from holdfast.scene.formats.mesh_file import SUFFIXES

FRICTION = 0.5  # of --mu where the scene has none for all pairs


@takes_scene
def rest(
    scene: SceneGiven,
    body: Annotated[str | None, typer.Argument(help="one of several bodies")] = None,
    mass: Annotated[float | None, typer.Option(help="mass in kg; default: as in the file, or 1 kg of a mesh")] = None,
    mu: Annotated[float | None, typer.Option(help="friction with the plane; default: the scene's, or 0.5")] = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG of all poses to this file")] = None,
    as_json: AsJson = False,
) -> None:
    """List all poses in which one body rests on a level plane, with how firm each is."""
    check_suffix(png, ".png")
    if Path(scene.scene).suffix.lower() in SUFFIXES:  # which say nothing of friction, of mass and of what is below
        mass = (None if scene.density else 1.0) if mass is None else mass
        scene = replace(
            scene, friction=scene.friction or [str(FRICTION)], density=scene.density or ["1000"], floor=True
        )
    known = scene.read()
    names = [each.name for each in known.movable]
    if body is None and len(names) != 1:
        problem = f"has {len(names)} bodies that can move"
        raise HoldfastError(message(scene.scene, problem, f"name one: {listed(names)}"))
    chosen = known.body(names[0] if body is None else body)
    mass = (chosen.mass or 1.0) if mass is None else mass
    usual = known.friction.default
    mu = (FRICTION if usual is None else usual) if mu is None else mu
    found = resting_poses(chosen.shape, mass, mu, chosen.com_body)
    result = altered(found, body=altered(found.body, name=chosen.name))
    if png is not None:
        result.save_png(png)
    if as_json:
        print_json(noted(result.to_dict(), known.notes))
    else:
        out.print(resting_report(result, chosen.name))
        print_notes(known.notes)
        if png is not None:
            out.say(f"wrote {png}")
