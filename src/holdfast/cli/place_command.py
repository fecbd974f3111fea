"""The command ``place``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.applications.placement.conditions import Approach, Search, Where, with_own
from holdfast.applications.placement.plan import place_all, plan_placement
from holdfast.assembly.caution import doubts
from holdfast.base.errors import HoldfastError, message
from holdfast.cli.assignments import of_all_and_each
from holdfast.cli.file_commands import WRITTEN_SUFFIXES
from holdfast.cli.output import AsJson, progress
from holdfast.cli.scenes import PAIR, AssemblyGiven, SceneGiven, paired, takes_scene
from holdfast.cli.shared_options import (
    EngineName,
    File,
    Files,
    Png,
    Several,
    check_suffix,
    engine_with,
    option,
    tell,
)
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.contact_report import placement_details
from holdfast.report.order_report import placements_report
from holdfast.report.pose_report import placement_report
from holdfast.scene.body import Body
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.meshes.read import SUFFIXES as MESH_SUFFIXES
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shapes import Mesh

THINGS = (
    "a mesh file (with --mass), FILE:BODY of another scene, or a body of SCENE to move; if there are several, their "
    "order is chosen"
)
RUB = "coefficient of the objects with all that the scene's table does not pair them with; or of a pair"


@takes_scene
def place(
    scene: AssemblyGiven,
    things: Annotated[list[str], typer.Argument(metavar="OBJECT...", help=THINGS)],
    where: Where,
    approach: Approach,
    search: Search,
    mass: Annotated[float | None, option("mass of the mesh in kg")] = None,
    material: Annotated[str | None, option("material of the mesh, a name in the friction table")] = None,
    object_friction: Annotated[Several, option(RUB, "--object-friction", metavar=PAIR)] = None,
    engine: EngineName = DEFAULT_ENGINE,
    from_above: Annotated[bool, option("the straight way down must be free", "--from-above")] = False,
    save: Annotated[File, option(f"write the scene with the object to this file: {WRITTEN_SUFFIXES}")] = None,
    png: Png = None,
    as_json: AsJson = False,
) -> None:
    """Find places for objects where everything stands, and where they and their supports withstand large pushes."""
    check_suffix(png, ".png")
    whole = scene.read()
    rest, bodies = _taken(whole, things, mass, material)
    if approach.direction is None and (from_above or approach.cone_degrees > 0):
        approach = replace(approach, direction=rest.gravity)
    mu, pairs = of_all_and_each("--object-friction", object_friction or (), PAIR)
    mixed = paired(Scene([*rest.bodies, *bodies], whole.friction), pairs, "--object-friction")
    question: dict[str, Any] = {
        "where": where,
        "approach": approach,
        "search": search,
        "engine": engine_with(engine),
        "friction": mixed.friction if mu is None else with_own(mixed.friction, mixed.bodies, bodies, mu),
    }
    cone = approach.cone_degrees
    rest = with_notes(rest, [f"--cone-degrees: the way in may lean by {cone:g}°"] if cone else [])
    assembly = scene.assembled(with_notes(rest, doubts(bodies)))
    name, notes = rest.name or scene.scene, assembly.scene.notes
    files: Files = []
    if len(bodies) > 1:
        with progress():
            several = place_all(assembly, bodies, **question)
        if several.steps:
            files = [(png, several.save_png), (save, partial(save_scene, several.assembly.scene))]
        report = partial(placements_report, scene=name)
        tell(several, report, as_json=as_json, notes=notes, files=files)
    with progress():
        result = plan_placement(assembly, bodies[0], **question)
    if result.assembly is not None:
        files = [(png, result.save_png), (save, partial(save_scene, result.assembly.scene))]
    one = partial(placement_report, scene=name, body=result.name)
    tell(result, one, as_json=as_json, details=placement_details(result), notes=notes, files=files)


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
