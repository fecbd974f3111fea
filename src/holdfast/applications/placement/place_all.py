"""Place several objects with one call: check the arguments and build the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from holdfast.applications.placement.conditions import Approach, Search, Where, checked_value
from holdfast.applications.placement.options import names_of
from holdfast.applications.placement.place_search import Clock
from holdfast.applications.placement.placed_friction import friction_with
from holdfast.applications.placement.plan import planner
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.several import RANDOM, Placing
from holdfast.applications.placement.several_result import Placements
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_items
from holdfast.base.errors import SceneError, hinting, message
from holdfast.base.progress import OutOfTimeError, until
from holdfast.base.text import listed, quoted
from holdfast.engines.groups import prepared
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body, materials_of
from holdfast.scene.friction import Friction
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

NAME = "place_all"
APART = 0.005  # [m] the least distance between objects beside each other


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
    bodies = checked_items(objects, f"{NAME}: objects", "bodies")
    _check_objects(assembly, bodies)
    place = checked_value(where, Where, f"{NAME}: where")
    way = checked_value(approach, Approach, f"{NAME}: approach")
    how = checked_value(search, Search, f"{NAME}: search")
    _check_search(how)
    every = tuple(b.name for b in assembly.bodies)
    grounds = every if place.supports is None else names_of(assembly, place.supports, "supports")
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


def _check_search(search: Search) -> None:
    """Raise SceneError for options that only ``plan_placement`` takes."""
    usual = Search()
    given = [name for name in ("candidates", "weights") if getattr(search, name) != getattr(usual, name)]
    if given:
        problem = f"has {' and '.join(given)}, which are for one object"
        raise SceneError(message(f"{NAME}: search", problem, "leave them out, or ask plan_placement"))


def _answered(
    assembly: Assembly, bodies: Sequence[Body], placing: Placing, engine: EngineChoice, clock: Clock
) -> Placements:
    method = engine_of(engine)
    names = tuple(body.name for body in bodies)
    assembly = replace(
        assembly, absent=tuple(sorted({*assembly.absent, *names}))
    )  # an engine may have options that name the new bodies
    try:
        with until(clock.by("search")):
            verdict = prepared(method, assembly).verdict()
    except OutOfTimeError:
        verdict = undecided("the time was used up before it was known")
    if verdict.status is not Status.STABLE:
        words = "does not stand" if verdict.status is Status.UNSTABLE else "is undecided"
        reason = f"the scene {words} before anything is put down: {verdict.reason}"
        return Placements(
            assembly=assembly, status=verdict.status, steps=(), left=names, apart=placing.apart, tries=0,
            reason=reason, elapsed=clock.elapsed, engine=method.name, claim=method.claim,
        )  # fmt: skip
    best, tries = placing.best(assembly, bodies, clock)
    reason = f"everything stands after each step, {1e3 * best.apart:.3g} mm apart"
    if best.left:
        reason = f"no place found for {listed(best.left)}"
        if clock.seconds is not None and clock.elapsed > 0.9 * clock.seconds:
            reason += ", the time was used up"
    return Placements(
        assembly=best.assembly, status=Status.UNDECIDED if best.left else Status.STABLE, reason=reason,
        steps=best.steps, left=best.left, apart=best.apart, tries=tries, elapsed=clock.elapsed,
        engine=method.name, claim=method.claim,
    )  # fmt: skip


def _check_objects(assembly: Assembly, bodies: Sequence[object]) -> None:
    """Raise SceneError unless there are objects, all of them bodies, with names of their own."""
    where = f"{NAME}: objects"
    if not bodies:
        raise SceneError(message(where, "is empty", "needs a list of holdfast.Body"))
    seen = {body.name for body in assembly.bodies}
    for body in bodies:
        if not isinstance(body, Body):
            raise SceneError(message(where, f"hold a {type(body).__name__}", "needs a list of holdfast.Body"))
        if body.name in seen:
            raise SceneError(message(where, f"two bodies are named {quoted(body.name)}", "give each another name"))
        seen.add(body.name)
