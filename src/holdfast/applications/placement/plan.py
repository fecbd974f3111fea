"""Place one object, or several, with one call: check the arguments and make the planners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.applications.placement.comparing import Clock
from holdfast.applications.placement.conditions import (
    ATTEMPTS,
    Approach,
    Options,
    Search,
    Where,
    checked_keep_out,
    checked_orientations,
    checked_region,
    friction_with,
    names_of,
)
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.result import Placement, Placements
from holdfast.applications.placement.several import RANDOM, Placing, Try
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_items
from holdfast.base.errors import SceneError, hinting, message
from holdfast.base.progress import OutOfTimeError, until
from holdfast.base.text import listed, quoted
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status
from holdfast.queries.lower_bounds import covering
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, checked_options, engine_of
from holdfast.scene.body import Body, materials_of
from holdfast.scene.friction import Friction
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

NAME = "plan_placement"
SEVERAL = "place_all"
APART = 0.005  # [m] the least distance between objects beside each other


@hinting(where=Where, approach=Approach, search=Search)
def plan_placement(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Placement:
    """Find a good pose for ``obj`` in which everything stands; the pose that it already has is ignored.

    Several stable poses are compared: by the smallest push that moves the object or its supports, and by the room to
    edges and neighbours (``Placement.rating``). Poses on flat faces rank before poses on a facet of a round side, from
    which a round body would roll.

    - ``where``, ``approach`` and ``search`` say where the object may be placed, how it gets there, and how long to
      search: see Where, Approach and Search. By default any place, orientation and way in is allowed, and the search
      takes at most 60 s.
    - ``friction``: the coefficient of the object with all bodies with which the scene's table does not pair it, or
      the whole table of the scene with the object. By default it is the scene's own table.
    - ``imperfect``: imperfect faces, as in ``robustness``. Stable poses are then compared by ``lower``, which holds on
      the samples, as does ``lower`` of the result; forces remain those of ideal faces. With 32 samples, a comparison
      takes about as long as 30 maps.

    If no place is found, the result says why. Raises SceneError if ``obj`` is fixed, is not a Body or has the name of
    another body, and HoldfastError if an option is invalid or ``imperfect`` is given for an engine other than
    ``compliant``.
    """
    place, how = (
        checked_options(where, Where, f"{NAME}: where", "holdfast"),
        checked_options(search, Search, f"{NAME}: search", "holdfast"),
    )
    if place.apart is not None:
        raise SceneError(message(f"{NAME}: where", "has apart", "it is the distance between several: ask place_all"))
    asked = planner(assembly, obj, place, approach, how, engine=engine, friction=friction, imperfect=imperfect)
    attempts = ATTEMPTS if how.solves is None else how.solves
    return asked.plan(seed=how.seed, seconds=how.limit, candidates=how.candidates, attempts=attempts)


def planner(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Planner:
    """Return a planner that can be used with many seeds; the arguments are those of ``plan_placement``."""
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, "plan_placement", "place into the scene without them")
    place = checked_options(where, Where, f"{NAME}: where", "holdfast")
    way = checked_options(approach, Approach, f"{NAME}: approach", "holdfast")
    how = checked_options(search, Search, f"{NAME}: search", "holdfast")
    if not isinstance(obj, Body):
        raise SceneError(message(NAME, f"obj is a {type(obj).__name__}", "needs a holdfast.Body with a mass"))
    if obj.fixed:
        raise SceneError(message(NAME, f"body {quoted(obj.name)} is fixed", "needs one that can be moved"))
    if any(other.name == obj.name for other in assembly.bodies):
        problem = f"the scene has a body named {quoted(obj.name)}"
        raise SceneError(message(NAME, problem, "give the object another name"))
    method = engine_of(engine)
    second = None if how.confirm is None else engine_of(how.confirm)
    up = assembly.scene.up
    supports = names_of(assembly, place.supports, "supports")
    options = Options(
        box=checked_region(place.box, up),
        supports=supports,
        least_supports=place.least_supports,
        avoid=names_of(assembly, place.avoid, "avoid"),
        orientations=checked_orientations(way.orientations, up),
        free_yaw=way.free_yaw,
        lean_degrees=way.lean_degrees,
        approach=way.way,
        prefer_upright=way.orientations is None,
        keep_out=checked_keep_out(place.keep_out, up),
        next_to=None if place.next_to is None else names_of(assembly, [place.next_to], "next_to")[0],
        cone=float(np.radians(way.cone_degrees)),
        gripper=way.hand,
        weights=how.weights,
        friction=friction_with(assembly, [obj], friction, supports),
        mass_margin=how.mass_margin,
        spacing=how.spacing,
        imperfect=imperfect,
    )
    covering(imperfect, method, assembly)  # raises an error if the engine does not take imperfect faces
    if options.least_supports > len(options.supports):
        problem = f"least_supports is {options.least_supports}, supports are {listed(options.supports)}"
        raise SceneError(message("Where", problem, "ask for no more than there are"))
    names = {obj.name} if obj.material is None else {obj.name, obj.material}
    # an engine may have options that name the new body
    assembly = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))
    return Planner(assembly, obj, method, None if second == method else second, options)


@hinting(where=Where, approach=Approach, search=Search)
def place_all(
    assembly: Assembly | Scene,
    objects: Sequence[Body],
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
) -> Placements:
    """Find places for ``objects``, to be put down one after the other, so that everything stands after each of them.

    Several orders are tried: the object with the largest base, the heaviest and the bulkiest first. Two rules propose
    places: the one where most of the object is supported, and the lowest one that is farthest in a corner. Each rule is
    first used alone. Then each object takes the better of the proposed places, by the pushes that the object and its
    supports withstand. The result is the attempt that places most objects; among these, the one whose weakest state
    withstands the largest push, and then the one with the most room. The poses that the objects already have are
    ignored.

    - ``where`` and ``approach`` hold for every object, see Where and Approach.
    - ``search`` limits the whole call, see Search; the result names the objects without a place. Its ``seed`` and
      ``solves`` are those of the random search for objects without a level place. ``candidates`` and ``weights`` must
      not be given.
    - ``friction`` has the same meaning as in ``plan_placement``.

    Raises SceneError if there are no objects, or if they or an option are invalid.
    """
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, "place_all", "place into the scene without them")
    bodies = checked_items(objects, f"{SEVERAL}: objects", "bodies")
    _check_several(assembly, bodies)
    place = checked_options(where, Where, f"{SEVERAL}: where", "holdfast")
    way = checked_options(approach, Approach, f"{SEVERAL}: approach", "holdfast")
    how = checked_options(search, Search, f"{SEVERAL}: search", "holdfast")
    usual = Search()
    of_one = [name for name in ("candidates", "weights") if getattr(how, name) != getattr(usual, name)]
    if of_one:
        problem = f"has {' and '.join(of_one)}, which are for one object"
        raise SceneError(message(f"{SEVERAL}: search", problem, "leave them out, or ask plan_placement"))
    grounds = names_of(assembly, place.supports, "supports")
    clock = Clock.started(how.limit)
    table = Scene([*assembly.bodies, *bodies], friction_with(assembly, bodies, friction, grounds)).friction

    def planner_of(now: Assembly, body: Body) -> Planner:
        placed = [other.name for other in now.bodies[len(assembly.bodies) :]]
        known = {other.name for other in (*now.bodies, body)} | materials_of([*now.bodies, body])
        there = replace(place, supports=[*grounds, *placed] if place.stack else grounds)
        return planner(now, body, there, way, how, engine=engine, friction=table.among(known))

    for body in bodies:
        planner_of(assembly, body)  # raises an error for invalid arguments before the search begins
    solves = RANDOM if how.solves is None else how.solves
    apart = APART if place.apart is None else place.apart
    placing = Placing(planner_of, grounds, place.stack, apart, how.seed, solves)
    return _answered(assembly, bodies, placing, engine, clock)


def _answered(
    assembly: Assembly, bodies: Sequence[Body], placing: Placing, engine: EngineChoice, clock: Clock
) -> Placements:
    method = engine_of(engine)
    names = tuple(body.name for body in bodies)
    # an engine may have options that name the new bodies
    assembly = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))
    try:
        with until(clock.by("search")):
            verdict = prepared(method, assembly).verdict()
    except OutOfTimeError:
        verdict = undecided("the time was used up before it was known")
    status: Status = verdict.status
    if status is not Status.STABLE:
        words = "does not stand" if status is Status.UNSTABLE else "is undecided"
        reason = f"the scene {words} before anything is put down: {verdict.reason}"
        best, tries = Try((), assembly, names, placing.apart), 0
    else:
        best, tries = placing.best(assembly, bodies, clock)
        status = Status.UNDECIDED if best.left else Status.STABLE
        reason = f"everything stands after each step, {1e3 * best.apart:.3g} mm apart"
        if best.left:
            reason = f"no place found for {listed(best.left)}"
            if clock.seconds is not None and clock.elapsed > 0.9 * clock.seconds:
                reason += ", the time was used up"
    return Placements(
        assembly=best.assembly, status=status, reason=reason,
        steps=best.steps, left=best.left, apart=best.apart, tries=tries, elapsed=clock.elapsed,
        engine=method.name, claim=method.claim,
    )  # fmt: skip


def _check_several(assembly: Assembly, bodies: Sequence[object]) -> None:
    """Raise SceneError unless there are objects, all of them bodies, with names of their own."""
    where = f"{SEVERAL}: objects"
    if not bodies:
        raise SceneError(message(where, "is empty", "needs a list of holdfast.Body"))
    seen = {body.name for body in assembly.bodies}
    for body in bodies:
        if not isinstance(body, Body):
            raise SceneError(message(where, f"hold a {type(body).__name__}", "needs a list of holdfast.Body"))
        if body.name in seen:
            raise SceneError(message(where, f"two bodies are named {quoted(body.name)}", "give each another name"))
        seen.add(body.name)
