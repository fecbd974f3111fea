"""Place several objects with one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from numpy.typing import ArrayLike

from holdfast.applications.placement.friction import friction_with
from holdfast.applications.placement.options import names_of
from holdfast.applications.placement.plan import BUDGET, MASS_MARGIN, SPACING, planner
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.search import Clock
from holdfast.applications.placement.several import Placing
from holdfast.applications.placement.several_result import Placements
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_items, checked_number, checked_truth, checked_whole
from holdfast.base.errors import SceneError, message
from holdfast.base.progress import OutOfTimeError, until
from holdfast.base.ranges import LENGTH, MOST_SEED
from holdfast.base.text import listed, quoted
from holdfast.engines.groups import prepared
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body, materials_of
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene

APART = 0.005  # [m] the least distance between objects beside each other


def place_all(
    assembly: Assembly | Scene,
    objects: Sequence[Body],
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    supports: Sequence[str] | None = None,
    stack: bool = False,
    apart: float = APART,
    region: ArrayLike | None = None,
    keep_out: Sequence[ArrayLike] = (),
    avoid: Sequence[str] = (),
    orientations: ArrayLike | str | None = None,
    approach: ArrayLike | None = None,
    cone: float = 0.0,
    gripper: ArrayLike | None = None,
    budget: float | None = BUDGET,
    seed: int = 0,
    friction: Friction | float | None = None,
    mass_margin: float = MASS_MARGIN,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
) -> Placements:
    """Find places for ``objects``, to be put down one after the other, so that everything stands after each of them.

    The order is chosen: several are tried, the largest base, the heaviest and the bulkiest object first. Two simple
    rules say which places are looked at: where most of the object is supported, and what is lowest and farthest in a
    corner. Each of them is tried on its own first; then every object goes where the object and what it rests on
    withstand most, of what the rules choose. Everything stands in each of these places. The result is the try that
    places most objects, of these the one whose weakest state withstands the largest push, and then the one with the
    most room. The poses that the objects already have are ignored.

    - ``supports``: names of the bodies to place objects on; all bodies of the scene by default. With ``stack`` the
      objects are also put on each other, the lowest places first: layer by layer.
    - ``apart`` [m]: the least distance between objects, and from whatever else is beside them. Without ``stack`` it is
      also that from edges, and eight, four and two times as much are tried too. With 0 objects may touch.
    - ``budget`` [s]: the longest time, but for what is compiled on first use; what has found no place by then is told.
      With None, which takes as long as it takes, the same call gives the same answer.
    - ``region``, ``keep_out``, ``avoid``, ``orientations``, ``approach``, ``cone``, ``gripper``, ``friction``,
      ``mass_margin``, ``spacing`` and ``confirm`` are those of ``plan_placement`` and hold for every object.
      ``seed`` is that of the random search for objects without a level place.

    Raises SceneError if there are no objects, or if they or an option are invalid.
    """
    assembly = checked_assembly(assembly)
    where = "place_all"
    bodies = checked_items(objects, f"{where}: objects", "bodies")
    _check_objects(assembly, bodies)
    grounds = tuple(b.name for b in assembly.bodies) if supports is None else names_of(assembly, supports, "supports")
    piled = checked_truth(stack, f"{where}: stack")
    least = checked_number(apart, f"{where}: apart", minimum=0, within=LENGTH)
    clock = Clock.started(None if budget is None else checked_number(budget, f"{where}: budget", above=0))

    table = Scene([*assembly.bodies, *bodies], friction_with(assembly, bodies, friction, grounds)).friction

    def planner_of(now: Assembly, body: Body) -> Planner:
        placed = [other.name for other in now.bodies[len(assembly.bodies) :]]
        known = {other.name for other in (*now.bodies, body)} | materials_of([*now.bodies, body])
        return planner(
            now, body, engine=engine, region=region, supports=[*grounds, *placed] if piled else grounds, avoid=avoid,
            keep_out=keep_out, orientations=orientations, approach=approach, cone=cone, gripper=gripper,
            friction=table.among(known), mass_margin=mass_margin, spacing=spacing, confirm=confirm,
        )  # fmt: skip

    for body in bodies:
        planner_of(assembly, body)  # which refuses what is invalid before anything is searched
    placing = Placing(planner_of, grounds, piled, least, checked_whole(seed, f"{where}: seed", 0, MOST_SEED))
    return _answered(assembly, bodies, placing, engine, clock)


def _answered(
    assembly: Assembly, bodies: Sequence[Body], placing: Placing, engine: EngineChoice, clock: Clock
) -> Placements:
    method = engine_of(engine)
    names = tuple(body.name for body in bodies)
    assembly = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))  # engines may be told of the bodies
    try:
        with until(clock.by("search")):
            verdict = prepared(method, assembly).verdict()
    except OutOfTimeError:
        verdict = undecided("the time was spent before it was known")
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
        if clock.budget is not None and clock.elapsed > 0.9 * clock.budget:
            reason += ", the time was spent"
    return Placements(
        assembly=best.assembly, status=Status.UNDECIDED if best.left else Status.STABLE, reason=reason,
        steps=best.steps, left=best.left, apart=best.apart, tries=tries, elapsed=clock.elapsed,
        engine=method.name, claim=method.claim,
    )  # fmt: skip


def _check_objects(assembly: Assembly, bodies: Sequence[object]) -> None:
    """Raise SceneError unless there are objects, all of them bodies, with names of their own."""
    where = "place_all: objects"
    if not bodies:
        raise SceneError(message(where, "is empty", "needs a list of holdfast.Body"))
    seen = {body.name for body in assembly.bodies}
    for body in bodies:
        if not isinstance(body, Body):
            raise SceneError(message(where, f"hold a {type(body).__name__}", "needs a list of holdfast.Body"))
        if body.name in seen:
            raise SceneError(message(where, f"two bodies are named {quoted(body.name)}", "give each another name"))
        seen.add(body.name)
