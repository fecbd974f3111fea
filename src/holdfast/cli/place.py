"""The command ``place``."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.applications.placement.friction import with_own
from holdfast.applications.placement.place_all import APART, place_all
from holdfast.applications.placement.plan import BUDGET, plan_placement
from holdfast.applications.placement.planner import CANDIDATES, MOST_ATTEMPTS
from holdfast.applications.placement.result import Placement
from holdfast.applications.placement.several_result import Placements
from holdfast.assembly.assembly import Assembly
from holdfast.base.errors import HoldfastError, message
from holdfast.cli.assignments import of_all_and_each
from holdfast.cli.common import (
    EXIT,
    WRITTEN_SUFFIXES,
    AsJson,
    EngineName,
    check_suffix,
    engine_with,
    exit_code,
)
from holdfast.cli.output import noted, out, print_json, tell_notes
from holdfast.cli.scenes import PAIR, AssemblyGiven, paired, scene_named, takes_scene
from holdfast.cli.terminal import progress
from holdfast.engines.contract import Engine
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report.data import placement_data
from holdfast.report.placement import placement_report
from holdfast.report.placements import placements_report
from holdfast.scene.body import Body
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.read import SUFFIXES as MESH_SUFFIXES
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shapes import Mesh

CORNERS = "x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1"
BOX = "x0,y0,z0,x1,y1,z1"
Region = Annotated[str | None, typer.Option(help=f"low and high corner of a box in m: {CORNERS}")]
Saved = Annotated[Path | None, typer.Option(help=f"write the scene with the object to this file: {WRITTEN_SUFFIXES}")]


class Orientation(StrEnum):
    """Which way up an object may stand."""

    UPRIGHT = "upright"
    ANY = "any"


KeepOut = Annotated[list[str] | None, typer.Option(help=f"keep out of this box: {CORNERS} (may be repeated)")]
WayUp = Annotated[Orientation | None, typer.Option(help="as it was modelled, or any; by default upright counts double")]
Hand = Annotated[str | None, typer.Option(help=f"room for a gripper about the middle of the top, third axis up: {BOX}")]
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
    mass: Annotated[float | None, typer.Option(help="mass of the mesh in kg")] = None,
    material: Annotated[str | None, typer.Option(help="material of the mesh, a name in the friction table")] = None,
    object_friction: Rub = None,
    engine: EngineName = DEFAULT_ENGINE,
    region: Region = None,
    keep_out: KeepOut = None,
    support: Annotated[list[str] | None, typer.Option(help="place it on this body only (may be repeated)")] = None,
    least_supports: Annotated[int | None, typer.Option(help="number of supports that it must touch [1]")] = None,
    next_to: Annotated[str | None, typer.Option(help="place it beside this body")] = None,
    avoid: Annotated[list[str] | None, typer.Option(help="it must not touch this body (may be repeated)")] = None,
    orientation: WayUp = None,
    from_above: Annotated[bool, typer.Option("--from-above", help="the straight way down must be free")] = False,
    cone: Annotated[float, typer.Option(help="the way in may lean by so many degrees")] = 0.0,
    gripper: Hand = None,
    stack: Annotated[bool, typer.Option("--stack", help="place several objects on each other too")] = False,
    apart: Annotated[float | None, typer.Option(help=f"least distance between several objects in m [{APART}]")] = None,
    candidates: Annotated[int | None, typer.Option(help=f"compare this many stable poses [{CANDIDATES}]")] = None,
    attempts: Annotated[int | None, typer.Option(help=f"give up after this many attempts [{MOST_ATTEMPTS}]")] = None,
    budget: Annotated[float, typer.Option(help="the longest time in s")] = BUDGET,
    seed: Annotated[int, typer.Option(help="the same seed gives the same pose, if the time suffices")] = 0,
    spacing: Annotated[float, typer.Option(help="distance between points of the maps in m")] = 0.01,
    save: Saved = None,
    png: Annotated[Path | None, typer.Option(help="write a PNG picture to this file")] = None,
    as_json: AsJson = False,
) -> None:
    """Put objects down where everything stands, and where they and what they rest on resist pushes well."""
    check_suffix(png, ".png")
    whole = scene.read()
    rest, bodies = _taken(whole, things, mass, material)
    asked: dict[str, Any] = {
        "region": _corners(region, "--region"),
        "keep_out": [_corners(box, "--keep-out") for box in keep_out or ()],
        "supports": support or None,
        "avoid": avoid or (),
        "orientations": None if orientation is None else orientation.value,
        "approach": rest.gravity if from_above or cone > 0 else None,
        "cone": cone,
        "gripper": _corners(gripper, "--gripper", flat=False),
        "budget": budget,
        "seed": seed,
        "spacing": spacing,
        "friction": _friction(rest, bodies, whole.friction, object_friction or ()),
    }
    rest = with_notes(rest, [f"--cone: the way in may lean by {cone:g}°"] if cone else [])
    for_one = {"least_supports": least_supports, "next_to": next_to, "candidates": candidates, "attempts": attempts}
    for_many = {"stack": stack or None, "apart": apart}
    result = _placed(scene.assembled(rest), bodies, engine_with(engine), asked, for_one, for_many)
    _tell(result, _written(result, png, save), rest, rest.name or scene.scene, as_json)


def _friction(rest: Scene, bodies: list[Body], known: Friction, given: Sequence[str]) -> Friction:
    """Return the friction table of the scene with the objects, in which what the command line says comes first."""
    mu, pairs = of_all_and_each("--object-friction", given, PAIR)
    whole = paired(Scene([*rest.bodies, *bodies], known), pairs, "--object-friction")
    return whole.friction if mu is None else with_own(whole.friction, whole.bodies, bodies, mu)


def _placed(
    assembly: Assembly,
    bodies: list[Body],
    engine: Engine,
    asked: dict[str, Any],
    for_one: dict[str, Any],
    for_many: dict[str, Any],
) -> Placement | Placements:
    """Ask for a place for one body or for several; ``for_one`` and ``for_many`` are options of one of these alone."""
    if len(bodies) == 1:
        asked |= _only(for_many, for_one, "one object")
        with progress():
            return plan_placement(assembly, bodies[0], engine=engine, **asked)
    asked |= _only(for_one, for_many, "several objects")
    with progress():
        return place_all(assembly, bodies, engine=engine, **asked)


def _only(others: dict[str, Any], own: dict[str, Any], what: str) -> dict[str, Any]:
    """Return the options of ``own`` that were given; raises HoldfastError if one of ``others`` was given."""
    wrong = [f"--{name.replace('_', '-')}" for name, value in others.items() if value is not None]
    if wrong:
        raise HoldfastError(message("place", f"{' and '.join(wrong)} given for {what}", "leave it out"))
    return {name: value for name, value in own.items() if value is not None}


def _tell(result: Placement | Placements, written: list[Path], scene: Scene, name: str, as_json: bool) -> None:
    """Print the result, and exit with its code."""
    if as_json:
        data = placement_data(result) if isinstance(result, Placement) else result.to_dict()
        print_json(noted(data, scene.notes))
    else:
        told = placement_report(result, name, result.name) if isinstance(result, Placement) else None
        out.print(told or placements_report(result, name), highlight=False)  # type: ignore[arg-type]
        tell_notes(scene.notes)
        for path in written:
            out.say(f"wrote {path}")
    if isinstance(result, Placement):
        raise typer.Exit(exit_code(result.status, result.answers))
    raise typer.Exit(EXIT[result.status])


def _written(result: Placement | Placements, png: Path | None, save: Path | None) -> list[Path]:
    """The files that were written: none where no place was found."""
    if result.assembly is None or (isinstance(result, Placements) and not result.steps):
        return []
    if png is not None:
        result.save_png(png)
    if save is not None:
        save_scene(result.assembly.scene, save)
    return [path for path in (png, save) if path is not None]


def _taken(scene: Scene, things: Sequence[str], mass: float | None, material: str | None) -> tuple[Scene, list[Body]]:
    """Return the scene in which to place the objects, and these.

    Objects that are bodies of the scene are removed from it first.
    """
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
            bodies.append(scene_named(file).body(name))
        else:
            bodies.append(scene.body(thing))
    moved = [thing for thing in things if Path(thing) not in meshes and ":" not in thing]
    return scene.without(moved) if moved else scene, bodies


def _corners(text: str | None, option: str, flat: bool = True) -> list[list[float]] | None:
    if text is None:
        return None
    try:
        values = [float(value) for value in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in ((4, 6) if flat else (6,)):
        needs = f"4 or 6 numbers: {CORNERS}" if flat else f"6 numbers: {BOX}"
        raise HoldfastError(message(option, f"is {text!r}", f"needs {needs}"))
    half = len(values) // 2
    return [values[:half], values[half:]]
