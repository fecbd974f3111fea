"""The command ``place``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from holdfast.applications.placement.plan import plan_placement
from holdfast.applications.placement.result import Placement
from holdfast.base.errors import HoldfastError, message
from holdfast.cli.common import (
    WRITTEN_SUFFIXES,
    AsJson,
    EngineName,
    check_suffix,
    engine_with,
    exit_code,
)
from holdfast.cli.output import out, print_json
from holdfast.cli.scenes import AssemblyGiven, scene_named, takes_scene
from holdfast.cli.terminal import progress
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.data import placement_data
from holdfast.report.placement import placement_report
from holdfast.scene.body import Body
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.meshes.read import SUFFIXES as MESH_SUFFIXES
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

CORNERS = "x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1"
Region = Annotated[str | None, typer.Option(help=f"low and high corner of a box in m: {CORNERS}")]
Saved = Annotated[Path | None, typer.Option(help=f"write the scene with the object to this file: {WRITTEN_SUFFIXES}")]


@takes_scene
def place(
    scene: AssemblyGiven,
    thing: Annotated[
        str,
        typer.Argument(
            metavar="OBJECT", help="a mesh file (with --mass), FILE:BODY of another scene, or a body of SCENE to move"
        ),
    ],
    mass: Annotated[float | None, typer.Option(help="mass of the mesh in kg")] = None,
    material: Annotated[str | None, typer.Option(help="material of the mesh, a name in the friction table")] = None,
    engine: EngineName = DEFAULT_ENGINE,
    region: Region = None,
    support: Annotated[list[str] | None, typer.Option(help="place it on this body only (may be repeated)")] = None,
    least_supports: Annotated[int, typer.Option(help="number of supports that it must touch")] = 1,
    avoid: Annotated[list[str] | None, typer.Option(help="it must not touch this body (may be repeated)")] = None,
    from_above: Annotated[bool, typer.Option("--from-above", help="the straight way down must be free")] = False,
    candidates: Annotated[int, typer.Option(help="return the best of this many stable poses")] = 1,
    attempts: Annotated[int, typer.Option(help="give up after this many attempts")] = 400,
    budget: Annotated[float | None, typer.Option(help="give up after this many seconds")] = None,
    seed: Annotated[int, typer.Option(help="the same seed gives the same pose")] = 0,
    spacing: Annotated[float, typer.Option(help="distance between points of the maps in m")] = 0.01,
    save: Saved = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    as_json: AsJson = False,
) -> None:
    """Find a pose for an object in which everything stands and resists pushes as well as possible."""
    check_suffix(png, ".png")
    whole = scene.read()
    rest, body = _taken(whole, thing, mass, material)
    method = engine_with(engine)
    with progress():
        result = plan_placement(
            scene.assembled(rest),
            body,
            engine=method,
            region=_corners(region),
            budget=budget,
            seed=seed,
            candidates=candidates,
            attempts=attempts,
            supports=support or None,
            least_supports=least_supports,
            avoid=avoid or (),
            approach=rest.gravity if from_above else None,
            spacing=spacing,
            friction=whole.friction,
        )
    written = _written(result, png, save)
    if as_json:
        print_json(placement_data(result))
    else:
        out.print(placement_report(result, rest.name or scene.scene, body.name), highlight=False)
        for path in written:
            out.say(f"wrote {path}")
    raise typer.Exit(exit_code(result.status, result.answers))


def _written(result: Placement, png: Path | None, save: Path | None) -> list[Path]:
    """The files that were written: none where no place was found."""
    if result.assembly is None:
        return []
    if png is not None:
        result.save_png(png)
    if save is not None:
        save_scene(result.assembly.scene, save)
    return [path for path in (png, save) if path is not None]


def _taken(scene: Scene, thing: str, mass: float | None, material: str | None) -> tuple[Scene, Body]:
    """Return the scene in which to place the object, and the object.

    If the object is a body of the scene, it is removed from the scene first.
    """
    path = Path(thing)
    if path.suffix.lower() in MESH_SUFFIXES:
        if mass is None:
            raise HoldfastError(message(thing, "has no mass", "say --mass in kg"))
        name = path.stem
        while any(name == body.name for body in scene.bodies):
            name += "_"
        return scene, Body(name, Mesh.from_file(path), mass=mass, material=material)
    if mass is not None or material is not None:
        raise HoldfastError(message("--mass and --material", f"given for {thing}", "they are for mesh files"))
    if ":" in thing:
        file, _, name = thing.rpartition(":")
        return scene, scene_named(file).body(name)
    return scene.without(thing), scene.body(thing)


def _corners(region: str | None) -> list[list[float]] | None:
    if region is None:
        return None
    try:
        values = [float(value) for value in region.split(",")]
    except ValueError:
        values = []
    if len(values) not in (4, 6):
        raise HoldfastError(message("--region", f"is {region!r}", f"needs 4 or 6 numbers: {CORNERS}"))
    half = len(values) // 2
    return [values[:half], values[half:]]
