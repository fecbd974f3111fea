"""The commands that ask how a scene stands and is pushed: assess, push and map."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from typing import Annotated

import numpy as np
import typer

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError
from holdfast.cli.assignments import option
from holdfast.cli.command import PNG, PROOF, CommandAnswer, EngineGiven, Several, Vector, question
from holdfast.cli.output import err
from holdfast.cli.scenes import AssemblyGiven
from holdfast.engines.answers import Claim
from holdfast.engines.contract import Engine
from holdfast.queries.map import RobustnessMap, expected_points, robustness_map
from holdfast.queries.push import Robustness, robustness
from holdfast.queries.stability import stability
from holdfast.report.contact_report import contact_details, map_report, push_report, stability_report
from holdfast.scene.scene import Scene

LARGE = 25  # number of bodies in a group from which load paths may cost several cone programs
SLOW = "compliant"  # the engine whose cost grows fastest with the number of bodies in a group
QUICK = "limit"  # the engine that solves one cone program for each push
Margin = Annotated[float, option("reduce all masses by this share, 0 to 1")]


@question(certificate=PROOF)
def assess(scene: AssemblyGiven, engine: EngineGiven, mass_margin: Margin = 0.0) -> CommandAnswer:
    """Decide whether a scene stands, explain why, and give the forces at its contacts."""
    method = engine.chosen(mass_margin=mass_margin)
    assembly = scene.assembled()
    report = partial(stability_report, assembly)
    return CommandAnswer(stability(assembly, engine=method), details=contact_details(assembly), report=report)


@question(push_report, certificate=PROOF)
def push(
    scene: AssemblyGiven,
    body: Annotated[str, typer.Argument(metavar="BODY", help="the name of the body that is pushed")],
    at: Annotated[Vector, option("point on the body in m", metavar="X Y Z")],
    along: Annotated[Vector, option("direction of the push; its length does not matter", metavar="X Y Z")],
    engine: EngineGiven,
    local: Annotated[bool, option("point and direction are in the body's own frame", "--local")] = False,
) -> Robustness:
    """Compute how hard a body can be pushed at a point in a direction before anything moves, and what moves then."""
    method, given = engine.chosen(), scene.read()
    point, direction = in_world(given, body, at, along) if local else (np.array(at), np.array(along))
    bounds = method.claim is not Claim.ESTIMATED
    return robustness(scene.assembled(given), body, point, direction, engine=method, bounds=bounds)


def in_world(scene: Scene, name: str, at: Vector, along: Vector) -> tuple[Float, Float]:
    """Return a point (3,) [m] and a direction (3,) of a body's own frame in the world frame.

    Raises SceneError for an unknown body.
    """
    body = scene.body(name)
    return body.placed(np.array([at]))[0], body.pose[:3, :3] @ np.array(along)


@question(
    map_report,
    png=PNG,
    html="write an interactive page to this file; it opens offline",
    glb="write glTF with colours and forces at its vertices",
    ply="write PLY with colours and forces at its vertices",
)
def map_surfaces(
    scene: AssemblyGiven,
    engine: EngineGiven,
    spacing: Annotated[float, option("distance between neighbouring points in m")] = 0.01,
    bodies: Annotated[Several, option("map this body only (may be repeated)")] = None,
    accuracy: Annotated[float, option("engine limit stops this close; 0: it solves every point")] = 0.01,
    immobile_above: Annotated[
        float | None, option("treat bodies heavier than this (kg) as immobile; optimistic")
    ] = None,
    mass_margin: Margin = 0.0,
    max_cuts: Annotated[int, option("refuse scenes with more feasible cuts than this")] = 20_000,
) -> RobustnessMap:
    """Compute the largest inward push at points of all exposed surfaces and name the weakest points."""
    method = engine.chosen(immobile_above=immobile_above, mass_margin=mass_margin, max_cuts=max_cuts)
    assembly = scene.assembled()
    print_cost_of_limit(assembly, bodies, spacing, method)
    return robustness_map(assembly, bodies, spacing=spacing, engine=method, accuracy=accuracy)


def print_cost_of_limit(assembly: Assembly, bodies: Sequence[str] | None, spacing: float, engine: Engine) -> None:
    """Print to stderr what a map would cost by engine ``limit``, if a group is large and the engine is ``compliant``.

    One push is solved twice; only the second time counts, because in a map the group is prepared only once.
    """
    mapped = [body.name for body in assembly.movable] if bodies is None else bodies
    grouped = [(len(group), name) for group in assembly.groups for name in mapped if name in group]
    size, name = max(grouped, default=(0, ""))
    if engine.name != SLOW or size < LARGE:
        return
    place = assembly.scene.body(name).surface_world.vertices[0]
    seconds = 0.0
    for _ in range(2):
        start = time.perf_counter()
        try:
            robustness(assembly, name, place, (1, 0, 0), engine=QUICK)
        except HoldfastError:  # the map may work without the estimate
            return
        seconds = time.perf_counter() - start
    known = [name for name in mapped if name in assembly.scene.names]
    points = expected_points(assembly, known, spacing)
    err.say(
        f"{size} bodies hold each other here: --engine {QUICK} takes about {1000 * seconds:.0f} ms a push, "
        f"{points * seconds:,.0f} s for all {points:,.0f} points, and proves its bounds"
    )
