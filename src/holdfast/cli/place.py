"""The command ``place``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.applications.placement.conditions import Approach, Search, Where
from holdfast.applications.placement.place_all import place_all
from holdfast.applications.placement.placed_friction import with_own
from holdfast.applications.placement.plan import plan_placement
from holdfast.applications.placement.result import Placement
from holdfast.applications.placement.several_result import Placements
from holdfast.assembly.caution import doubts
from holdfast.base.errors import HoldfastError, message
from holdfast.cli.assignments import of_all_and_each
from holdfast.cli.common import (
    EXIT,
    AsJson,
    EngineName,
    check_suffix,
    engine_with,
    exit_code,
)
from holdfast.cli.output import noted, out, print_json, print_notes
from holdfast.cli.scenes import PAIR, AssemblyGiven, SceneGiven, paired, takes_scene
from holdfast.cli.terminal import progress
from holdfast.cli.written import WRITTEN_SUFFIXES
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.contact_report import placement_data
from holdfast.report.order_report import placements_report
from holdfast.report.pose_report import placement_report
from holdfast.scene.body import Body
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.read import SUFFIXES as MESH_SUFFIXES
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shapes import Mesh

Saved = Annotated[Path | None, typer.Option(help=f"write the scene with the object to this file: {WRITTEN_SUFFIXES}")]
Rub = Annotated[
    list[str] | None,
    typer.Option(
        "--object-friction",
        metavar=PAIR,
        help="coefficient of the objects with all that the scene's table does not pair them with; or of a pair",
    ),
]
Things = Annotated[
    list[str],
    typer.Argument(
        metavar="OBJECT...",
        help="a mesh file (with --mass), FILE:BODY of another scene, or a body of SCENE to move; if there are "
        "several, their order is chosen",
    ),
]


@takes_scene
def place(
    scene: AssemblyGiven,
    things: Things,
    where: Where,
    approach: Approach,
    search: Search,
    mass: Annotated[float | None, typer.Option(help="mass of the mesh in kg")] = None,
    material: Annotated[str | None, typer.Option(help="material of the mesh, a name in the friction table")] = None,
    object_friction: Rub = None,
    engine: EngineName = DEFAULT_ENGINE,
    from_above: Annotated[bool, typer.Option("--from-above", help="the straight way down must be free")] = False,
    save: Saved = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    as_json: AsJson = False,
) -> None:
    """Find places for objects where everything stands, and where they and their supports withstand large pushes."""
    check_suffix(png, ".png")
    whole = scene.read()
    rest, bodies = _taken(whole, things, mass, material)
    if approach.direction is None and (from_above or approach.cone_degrees > 0):
        approach = replace(approach, direction=rest.gravity)
    asked: dict[str, Any] = {
        "where": where,
        "approach": approach,
        "search": search,
        "engine": engine_with(engine),
        "friction": _friction(rest, bodies, whole.friction, object_friction or ()),
    }
    cone = approach.cone_degrees
    rest = with_notes(rest, [f"--cone-degrees: the way in may lean by {cone:g}°"] if cone else [])
    assembly = scene.assembled(with_notes(rest, doubts(bodies)))
    with progress():
        result: Placement | Placements
        if len(bodies) == 1:
            result = plan_placement(assembly, bodies[0], **asked)
        else:
            result = place_all(assembly, bodies, **asked)
    _tell(result, _written(result, png, save), assembly.scene, rest.name or scene.scene, as_json)


def _friction(rest: Scene, bodies: list[Body], known: Friction, given: Sequence[str]) -> Friction:
    """Return the friction table of the scene with the objects; options of the command line take precedence."""
    mu, pairs = of_all_and_each("--object-friction", given, PAIR)
    whole = paired(Scene([*rest.bodies, *bodies], known), pairs, "--object-friction")
    return whole.friction if mu is None else with_own(whole.friction, whole.bodies, bodies, mu)


def _tell(result: Placement | Placements, written: list[Path], scene: Scene, name: str, as_json: bool) -> None:
    """Print the result, and exit with its code."""
    if as_json:
        data = placement_data(result) if isinstance(result, Placement) else result.to_dict()
        print_json(noted(data, scene.notes))
    else:
        report = placement_report(result, name, result.name) if isinstance(result, Placement) else None
        out.print(report or placements_report(result, name), highlight=False)  # type: ignore[arg-type]
        print_notes(scene.notes)
        for path in written:
            out.say(f"wrote {path}")
    if isinstance(result, Placement):
        raise typer.Exit(exit_code(result.status, result.answers))
    raise typer.Exit(EXIT[result.status])


def _written(result: Placement | Placements, png: Path | None, save: Path | None) -> list[Path]:
    """Write the requested files if a place was found, and return their paths."""
    if result.assembly is None or (isinstance(result, Placements) and not result.steps):
        return []
    if png is not None:
        result.save_png(png)
    if save is not None:
        save_scene(result.assembly.scene, save)
    return [path for path in (png, save) if path is not None]


def _taken(scene: Scene, things: Sequence[str], mass: float | None, material: str | None) -> tuple[Scene, list[Body]]:
    """Return the scene without the objects that are bodies of it, and the objects."""
    meshes = [Path(thing) for thing in things if Path(thing).suffix.lower() in MESH_SUFFIXES]
    if len(meshes) > 1:
        raise HoldfastError(message("place", f"{len(meshes)} mesh files", "give all but one as FILE:BODY of a scene"))
    if meshes and mass is None:
        raise HoldfastError(message(str(meshes[0]), "has no mass", "say --mass in kg"))
    if not meshes and (mass is not None or material is not None):
        raise HoldfastError(message("--mass and --material", f"given for {things[0]}", "they are for mesh files"))
    bodies = []
    for thing in things:
        path = Path(thing)
        if path in meshes:
            name = path.stem
            while any(name == body.name for body in scene.bodies):
                name += "_"
            bodies.append(Body(name, Mesh.from_file(path), mass=mass, material=material))
        elif ":" in thing:
            file, _, name = thing.rpartition(":")
            bodies.append(SceneGiven(scene=file).read().body(name))
        else:
            bodies.append(scene.body(thing))
    moved = [thing for thing in things if Path(thing) not in meshes and ":" not in thing]
    return scene.without(moved) if moved else scene, bodies
