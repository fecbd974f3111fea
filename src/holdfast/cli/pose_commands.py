"""The commands about where bodies are: rest, settle, firmer, place, and safe, which says where they may be pushed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from holdfast.applications.placement.conditions import Approach, Search, Where, with_own
from holdfast.applications.placement.planner import plan_placement
from holdfast.applications.placement.several import place_all
from holdfast.applications.pushing.firmer import firmer as make_firmer
from holdfast.applications.pushing.freedom import Moves
from holdfast.applications.pushing.safe_pushes import DOUBT, Tool, safe_pushes
from holdfast.applications.resting_poses import resting_poses
from holdfast.applications.settled import settle as settle_scene
from holdfast.assembly.caution import doubts
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import listed
from holdfast.base.values import altered
from holdfast.cli.assignments import of_all_and_each, option
from holdfast.cli.command import (
    PNG,
    SAVE,
    CommandAnswer,
    EngineGiven,
    EngineName,
    Several,
    Vector,
    check_suffix,
    question,
)
from holdfast.cli.file_commands import WRITTEN_SUFFIXES
from holdfast.cli.scenes import PAIR, AssemblyGiven, SceneGiven, paired
from holdfast.queries.request import DEFAULT_ENGINE
from holdfast.report import order_report, pose_report
from holdfast.report.contact_report import placement_details
from holdfast.scene.body import Body
from holdfast.scene.formats.named_meshes import SUFFIXES
from holdfast.scene.formats.registry import save_scene
from holdfast.scene.meshes.read import SUFFIXES as MESH_SUFFIXES
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shapes import Mesh

FRICTION = 0.5  # of --mu where the scene has none for all pairs
TURN = 15.0  # [deg] default of --turn-degrees of settle
THINGS = (
    "a mesh file (with --mass), FILE:BODY of another scene, or a body of SCENE to move; if there are several, their "
    "order is chosen"
)
RUB = "coefficient of the objects with all that the scene's table does not pair them with; or of a pair"


@question(png="write a PNG of all poses to this file")
def rest(
    scene: SceneGiven,
    body: Annotated[str | None, typer.Argument(help="one of several bodies")] = None,
    mass: Annotated[float | None, option("mass in kg; default: as in the file, or 1 kg of a mesh")] = None,
    mu: Annotated[float | None, option("friction with the plane; default: the scene's, or 0.5")] = None,
) -> CommandAnswer:
    """List all poses in which one body rests on a level plane, with how firm each is."""
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
    return CommandAnswer(result, known.notes, report=partial(pose_report.resting_report, name=chosen.name))


@question(order_report.pushes_report, save=SAVE)
def safe(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(help="the body that is to be pushed")],
    force: Annotated[float, typer.Option(help="the most that the tool pushes with, in N", show_default=False)],
    engine: EngineGiven,
    direction: Annotated[Vector | None, option("push along X Y Z only; default: inwards everywhere")] = None,
    radius: Annotated[float, option("radius of the tool, in m")] = Tool.radius,
    spacing: Annotated[float | None, option("distance between points, in m; default: about 100")] = None,
    travel: Annotated[float, option("how far the body is pushed, in m")] = Tool.travel,
    doubt: Annotated[float, option("share by which friction may be off")] = DOUBT,
) -> CommandAnswer:
    """Find where a body can be pushed so that nothing moves, or so that it moves alone."""
    result = safe_pushes(
        scene.assembled(),
        body,
        force,
        directions=direction,
        spacing=spacing,
        tool=Tool(radius, travel),
        doubt=doubt,
        engine=engine.chosen(),
    )
    return CommandAnswer(result, result.notes)


@question(png=PNG)
def settle(
    scene: SceneGiven,
    output: Annotated[
        Path | None, option(f"write the scene at rest to this file: {WRITTEN_SUFFIXES}", "--output", "-o")
    ] = None,
    travel: Annotated[float, option("a body that goes farther than this in m falls")] = 0.03,
    turn_degrees: Annotated[float, option("a body that turns by more than this in degrees falls")] = TURN,
    known: Annotated[Several, option("a body whose pose is exact (may be repeated)")] = None,
    upright: Annotated[Several, option("a body that stands upright (may be repeated)")] = None,
    pose_sigma: Annotated[float | None, option("standard deviation of the positions in m")] = None,
    engine: EngineName = DEFAULT_ENGINE,
    gap: Annotated[float | None, option("contact tolerance of the verdict in m; default: by pair")] = None,
) -> CommandAnswer:
    """Bring a perceived or authored scene to rest near its poses, and say what moved and what falls."""
    method = EngineGiven(engine=engine).chosen()
    remarks = [f"--turn-degrees: what turns by more than {turn_degrees:g}° falls"] if turn_degrees != TURN else []
    result = settle_scene(
        with_notes(scene.read(), remarks),
        travel=travel,
        turn_degrees=turn_degrees,
        known=known or (),
        upright=upright or (),
        pose_sigma=pose_sigma,
        gap=gap,
        engine=method,
    )
    report = partial(pose_report.settled_report, scene=result.given.name or scene.scene)
    return CommandAnswer(result, files=[(output, partial(save_scene, result.scene))], report=report)


@question(pose_report.firmer_report, png="write a PNG of the scene before and after to this file", save=SAVE)
def firmer(
    scene: AssemblyGiven,
    bodies: Annotated[list[str], typer.Argument(help="the bodies that may be moved")],
    engine: EngineGiven,
    slide: Annotated[float, option("how far each may slide on what it stands on, in m")] = Moves.slide,
    turn_degrees: Annotated[float, option("how far each may be turned, in degrees")] = Moves.turn_degrees,
    apart: Annotated[float, option("distance to keep from others, in m")] = Moves.apart,
    nearer_edges: Annotated[bool, option("they may come nearer to edges", "--nearer-edges")] = False,
    profile: Annotated[str | None, option("a motion, as for carry, in place of pushes")] = None,
    seconds: Annotated[float | None, option("longest time of the search, in s")] = None,
    scene_out: Annotated[
        Path | None, option(f"write the firmer scene to this file ({WRITTEN_SUFFIXES})", "--scene-out")
    ] = None,
) -> CommandAnswer:
    """Move bodies a little, to where the least push that moves something is larger."""
    moves = Moves(slide=slide, turn_degrees=turn_degrees, apart=apart, nearer_edges=nearer_edges)
    method, assembly = engine.chosen(), scene.assembled()
    result = make_firmer(assembly, bodies, moves=moves, motion=profile, engine=method, seconds=seconds)
    return CommandAnswer(result, result.notes, files=[(scene_out, partial(save_scene, result.assembly.scene))])


@question()
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
    save: Annotated[Path | None, option(f"write the scene with the object to this file: {WRITTEN_SUFFIXES}")] = None,
    png: Annotated[Path | None, option(PNG)] = None,
) -> CommandAnswer:
    """Find places for objects where everything stands, and where they and their supports withstand large pushes."""
    check_suffix(png, ".png")
    whole = scene.read()
    rest, bodies = _taken(whole, things, mass, material)
    if approach.direction is None and (from_above or approach.cone_degrees > 0):
        approach = replace(approach, direction=rest.gravity)
    mu, pairs = of_all_and_each("--object-friction", object_friction or (), PAIR)
    mixed = paired(Scene([*rest.bodies, *bodies], whole.friction), pairs, "--object-friction")
    arguments: dict[str, Any] = {
        "where": where,
        "approach": approach,
        "search": search,
        "engine": EngineGiven(engine=engine).chosen(),
        "friction": mixed.friction if mu is None else with_own(mixed.friction, mixed.bodies, bodies, mu),
    }
    cone = approach.cone_degrees
    rest = with_notes(rest, [f"--cone-degrees: the way in may lean by {cone:g}°"] if cone else [])
    assembly = scene.assembled(with_notes(rest, doubts(bodies)))
    name, several, details = rest.name or scene.scene, len(bodies) > 1, {}
    result: Any = (
        place_all(assembly, bodies, **arguments) if several else plan_placement(assembly, bodies[0], **arguments)
    )
    if several:
        report, placed = partial(order_report.placements_report, scene=name), bool(result.steps)
    else:
        report = partial(pose_report.placement_report, scene=name, body=result.name)
        placed, details = result.assembly is not None, placement_details(result)
    files = [(png, result.save_png), (save, partial(save_scene, result.assembly.scene))] if placed else []
    return CommandAnswer(result, assembly.scene.notes, details, files, report)


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
            bodies.append(Body(_free_name(path.stem, scene), Mesh.from_file(path), mass=mass, material=material))
        elif ":" in thing:
            file, _, name = thing.rpartition(":")
            bodies.append(replace(SceneGiven(scene=file).read().body(name), name=_free_name(name, scene)))
        else:
            bodies.append(scene.body(thing))
    moved = [thing for thing in things if Path(thing) not in meshes and ":" not in thing]
    return scene.without(moved) if moved else scene, bodies


def _free_name(name: str, scene: Scene) -> str:
    """Return the name, with underscores if a body of the scene has it."""
    while any(name == body.name for body in scene.bodies):
        name += "_"
    return name
