"""The commands about one body: how it rests, and where it can be pushed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.pushing.safe import DOUBT, Tool, safe_pushes
from holdfast.applications.resting_poses import resting_poses
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import listed
from holdfast.base.values import altered
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import AssemblyGiven, SceneGiven, takes_scene
from holdfast.cli.shared_options import (
    EngineName,
    File,
    Nodes,
    SaveAnswer,
    Vector,
    check_suffix,
    engine_with,
    option,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.order_report import pushes_report
from holdfast.report.pose_report import resting_report
from holdfast.scene.formats.named_meshes import SUFFIXES

FRICTION = 0.5  # of --mu where the scene has none for all pairs


@takes_scene
def rest(
    scene: SceneGiven,
    body: Annotated[str | None, typer.Argument(help="one of several bodies")] = None,
    mass: Annotated[float | None, option("mass in kg; default: as in the file, or 1 kg of a mesh")] = None,
    mu: Annotated[float | None, option("friction with the plane; default: the scene's, or 0.5")] = None,
    png: Annotated[File, option("write a PNG of all poses to this file")] = None,
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
    poses = resting_poses(chosen.shape, mass, mu, chosen.com_body)
    result = altered(poses, body=altered(poses.body, name=chosen.name))
    report = partial(resting_report, name=chosen.name)
    tell(result, report, as_json=as_json, notes=known.notes, files=[(png, result.save_png)])


@takes_scene
def safe(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be pushed")],
    force: Annotated[float, typer.Option(help="the most that the tool pushes with, in N", show_default=False)],
    direction: Annotated[Vector | None, option("push along X Y Z only; default: inwards everywhere")] = None,
    radius: Annotated[float, option("radius of the tool, in m")] = Tool.radius,
    spacing: Annotated[float | None, option("distance between points, in m; default: about 100")] = None,
    travel: Annotated[float, option("how far the body is pushed, in m")] = Tool.travel,
    doubt: Annotated[float, option("share by which friction may be off")] = DOUBT,
    engine: EngineName = DEFAULT_ENGINE,
    save: SaveAnswer = None,
    nodes: Nodes = None,
    as_json: AsJson = False,
) -> None:
    """Find where a body can be pushed so that nothing moves, or so that it moves alone."""
    method = engine_with(engine, nodes=nodes)
    with progress():
        assembly, tool = scene.assembled(), Tool(radius, travel)
        result = safe_pushes(
            assembly, body, force, directions=direction, spacing=spacing, tool=tool, doubt=doubt, engine=method
        )
    tell(result, pushes_report, as_json=as_json, notes=result.notes, files=[(save, result.save)])
