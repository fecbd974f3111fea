"""Place several objects one after the other, in the best order found, so that everything stands after each step.

A systematic search lists the level places of an object (``level_places``). If everything stands in none of them, the
random search of ``plan_placement`` is used. A strategy determines the order of the objects and the rules that choose
places by geometry alone, two of the packing literature: the place where most of the face is supported, or the lowest
one that is farthest in a corner. Each rule is tried alone first. Then, while there is time, the places that the rules
choose are compared by the pushes that the object and its supports withstand, for several faces, orders and distances.
The best attempt is the one that places most objects; among these, the one with the strongest weakest state, and then
the one with the most room.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import dropwhile, groupby, islice
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from holdfast.applications.placement.comparing import Clock, RatedPose, rated
from holdfast.applications.placement.conditions import Approach, Search, Where, friction_with, names_of
from holdfast.applications.placement.level_places import (
    LevelPlace,
    SeenFromAbove,
    frame_of,
    level_places_for,
    levels_of,
    turns_of,
)
from holdfast.applications.placement.planner import Planner, planner
from holdfast.applications.placement.result import TOPPLED, Candidate, PlacedObject, Placements
from holdfast.applications.resting_poses import Face
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_items
from holdfast.base.errors import SceneError, hinting, message
from holdfast.base.progress import OutOfTimeError, report, until
from holdfast.base.text import listed, quoted
from holdfast.engines.groups import prepared
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, checked_options, engine_of
from holdfast.scene.body import Body, materials_of
from holdfast.scene.friction import Friction
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

SEVERAL = "place_all"
APART = 0.005  # [m] the least distance between objects beside each other
Order = Callable[[Body], float]
Rule = Callable[[LevelPlace], tuple[float, ...]]
MOST_FACES = 3  # number of faces of an object on which it is placed
MOST_REFUSED = 12  # number of places that are checked by one rule before it gives up a face
# distances between objects, as multiples of ``apart``, with the share of the time by which a rule must end
WIDER: Mapping[float, float] = MappingProxyType({8.0: 0.25, 4.0: 0.45, 2.0: 0.65, 1.0: 1.0})
SLACK = 1.5  # another attempt begins if the time left is this multiple of the longest attempt
POINTS = 40  # approximate largest number of points of the maps by which places are compared
RANDOM = 25  # default number of attempts of the random search
_NONE = np.empty((0, 3))


def base_area(body: Body) -> float:
    """The product of the two longer sides of the body's own box [m²]."""
    sides = np.sort(np.ptp(body.shape.surface.vertices, axis=0))
    return float(sides[1] * sides[2])


def weight(body: Body) -> float:
    """The mass of the body [kg]."""
    return body.mass or 0.0


def bulk(body: Body) -> float:
    """The volume of the body's own box [m³]."""
    return float(np.prod(np.ptp(body.shape.surface.vertices, axis=0)))


def highest_support(place: LevelPlace) -> tuple[float, ...]:
    """Rank a place by the share of the face that is supported, the largest first, then by height, the lowest first."""
    return (-round(place.support, 2), round(place.height, 4), *np.round(place.corner, 6).tolist())


def bottom_left(place: LevelPlace) -> tuple[float, ...]:
    """Rank a place by its height, the lowest first, then by its closeness to one corner, then by support."""
    return (round(place.height, 4), *np.round(place.corner[::-1], 6).tolist(), -round(place.support, 2))


class Strategy(NamedTuple):
    """One strategy: objects come in decreasing ``order``, and the ``rules`` choose their places.

    With one rule, the first place where everything stands is taken. With several, the first place of each rule is
    compared, on each of several faces.
    """

    order: Order
    rules: tuple[Rule, ...]


RULES: Mapping[str, Rule] = MappingProxyType({"highest support": highest_support, "bottom-left": bottom_left})
RULED = tuple(Strategy(base_area, (rule,)) for rule in RULES.values())
COMPARING = tuple(Strategy(order, tuple(RULES.values())) for order in (base_area, weight, bulk))


def worth(place: RatedPose) -> tuple[float, ...]:
    """Return the sort key of the places of one object: the smallest push, halved if the object is not upright."""
    rating = place.rating
    return float(rating.own is not None), (rating.least or 0.0) * (1.0 if rating.upright else TOPPLED)


@dataclass(frozen=True, eq=False)
class Try:
    """The result of one strategy: its ``steps``, the ``assembly`` after them, and the objects ``left`` without a place.

    An attempt ends early when it can no longer be the best; some objects are then neither placed nor left.
    """

    steps: tuple[PlacedObject, ...]
    assembly: Assembly
    left: tuple[str, ...]
    apart: float

    @property
    def key(self) -> tuple[Any, ...]:
        """The sort key of attempts; the best has the largest.

        The number of objects comes first, then the smallest push of all steps, then the distance between objects, and
        last the pushes of the other steps, the smallest first. These decide if an object that any push moves, such as a
        ball, makes the smallest push 0 in all attempts.
        """
        leasts = sorted(_rounded(step) for step in self.steps)
        return len(leasts), leasts[:1], self.apart, leasts


def _rounded(step: PlacedObject) -> float:
    return float(f"{step.least or 0.0:.4g}")  # solvers differ in their last digits


@dataclass(eq=False)
class Placing:
    """Places several objects in one scene.

    ``planner_of`` makes a planner for an object in an assembly; the first is ``before``. ``grounds`` names the bodies
    on which objects may be placed; with ``stack``, they may also be placed on each other. ``apart`` [m] is the smallest
    distance between them. ``solves`` limits the random search, with ``seed``, for an object that has no level place.
    """

    planner_of: Callable[[Assembly, Body], Planner]
    before: Assembly
    grounds: tuple[str, ...]
    stack: bool
    apart: float
    seed: int
    solves: int = RANDOM
    _faces: dict[str, tuple[Face, ...]] = field(default_factory=dict)
    _outlines: dict[str, SeenFromAbove] = field(default_factory=dict)

    def planner(self, assembly: Assembly, body: Body) -> Planner:
        """Return the planner of an object; its faces are found once."""
        planner = self.planner_of(assembly, body)
        if body.name in self._faces:
            vars(planner)["faces"] = self._faces[body.name]  # fills the cached property
        self._faces[body.name] = planner.faces
        return planner

    def best(self, objects: Sequence[Body], clock: Clock) -> tuple[Try, int]:
        """Return the best of all attempts that there is time for, and their number.

        The baseline is each rule at the smallest distance. Then the widest distance is sought at which a rule places
        everything; an attempt at a wider distance ends as soon as an object has no place. There, places are compared,
        and also at narrower distances until every order places everything.
        """
        tries, spent = list[Try](), list[float]()

        def whole(strategy: Strategy, wider: float, deadline: float) -> bool:
            """Make an attempt, and return whether there was time for it and every object has a place."""
            begun = clock.elapsed
            if tries and clock.seconds is not None and begun + SLACK * max(spent) > clock.seconds:
                return False
            beat = max((one.key for one in tries), default=None)
            one = self._tried(objects, strategy, wider * self.apart, deadline, wider == 1, beat)
            spent.append(clock.elapsed - begun)
            tries.extend([] if one is None else [one])
            return one is not None and not one.left

        def ruled(wider: float) -> bool:
            """Try each rule at a distance, and return whether one of them placed everything."""
            deadline = clock.by("compare", WIDER[wider]) if wider > 1 else clock.by("end")
            return any([whole(strategy, wider, deadline) for strategy in RULED])  # noqa: C419 - both are tried

        ruled(1.0)
        distances = WIDER if self.apart > 0 and not self.stack else (1.0,)
        for wider in dropwhile(lambda wider: wider > 1 and not ruled(wider), distances):
            if all([whole(strategy, wider, clock.by("end")) for strategy in COMPARING]):  # noqa: C419 - every order is tried
                break
        return max(tries, key=lambda one: one.key), len(spent)

    def _tried(
        self,
        objects: Sequence[Body],
        strategy: Strategy,
        apart: float,
        deadline: float,
        whole: bool,
        beat: tuple[Any, ...] | None,
    ) -> Try | None:
        """Place the objects by a strategy, until the key of another attempt, ``beat``, can no longer be exceeded.

        If an object has no place or the time is up, the result is None, or with ``whole`` the attempt without it.
        """
        steps, left, after = list[PlacedObject](), list[str](), self.before
        begun = time.perf_counter()
        ordered = sorted(objects, key=strategy.order, reverse=True)
        for number, body in enumerate(ordered):
            report("objects placed", number, len(ordered))
            now = time.perf_counter()
            hurry = number > 0 and (now - begun) / number * (len(ordered) - number) > deadline - now
            try:
                with until(deadline):
                    rules = strategy.rules[:1] if hurry else strategy.rules
                    found = self._placed(self.planner(after, body), rules, apart, whole)
            except OutOfTimeError:
                if not whole:
                    return None
                left += [other.name for other in ordered[number:]]
                break
            if found is None and not whole:
                return None
            if found is None:
                left.append(body.name)
                continue
            after = found.after
            steps.append(
                PlacedObject(body.name, found.candidate.pose, found.rating.own, found.rating.beneath, found.beneath)
            )
            bound = len(objects) - len(left), [min(map(_rounded, steps))], apart
            if beat is not None and bound < beat[:3]:
                break
        return Try(tuple(steps), after, tuple(left), apart)

    def _placed(self, planner: Planner, rules: Sequence[Rule], apart: float, whole: bool) -> RatedPose | None:
        """Return the best place that the rules choose where everything stands, or None."""
        found = list[RatedPose]()
        places = sorted(self.places(planner, apart), key=lambda place: place.face)
        for _, alike in islice(groupby(places, key=lambda place: place.face), MOST_FACES):
            found += self._standing(list(alike), planner, rules)
            if found and len(rules) == 1:
                break
        if found:
            return max(found, key=worth)
        if not whole:
            return None
        search = planner.search(seed=self.seed, attempts=self.solves, mapped=False)
        for candidate, after in search.stable:
            return rated(planner.checks, planner.faces, candidate, after, Clock.started(None), POINTS)
        return None

    def _standing(self, places: Sequence[LevelPlace], planner: Planner, rules: Sequence[Rule]) -> list[RatedPose]:
        """Return the first place of each rule where everything stands, rated and without duplicates."""
        checks = planner.checks
        known, found = dict[int, Assembly | None](), dict[int, Assembly]()
        for rule in rules:
            ranked = sorted(range(len(places)), key=lambda k: rule(places[k]))
            allowed = (k for k in ranked if not checks.misplaced(checks.body.moved(places[k].pose)))
            for k in islice(allowed, MOST_REFUSED):
                if k not in known:
                    known[k] = checks.fault(places[k].pose)[1]
                after = known[k]
                if after is not None:
                    found[k] = after
                    break
        candidates = {k: Candidate(places[k].pose, _NONE, _NONE, "") for k in found}
        return [
            rated(checks, planner.faces, candidates[k], after, Clock.started(None), POINTS)
            for k, after in found.items()
        ]

    def places(self, planner: Planner, apart: float) -> list[LevelPlace]:
        """Return all level places of an object on its possible supports, ``apart`` [m] from other bodies."""
        checks, up = planner.checks, planner.checks.up
        first = [b for b in self.before.bodies if b.name in self.grounds]
        axes = frame_of(first, up)
        placed = [b for b in checks.assembly.bodies if b.name not in self.before.index and not b.fixed]
        levels = levels_of(first + (placed if self.stack else []), up, axes)
        for b in checks.frozen:
            known = self._outlines.get(b.name)
            if known is None or (known.body.pose != b.pose).any():
                self._outlines[b.name] = SeenFromAbove(b, up, axes)
        outlines = [self._outlines[b.name] for b in checks.frozen]
        inset = 0.0 if self.stack else apart
        turns = turns_of(planner.faces, checks.approach, up, axes)
        return level_places_for(checks.body, turns, levels, outlines, apart, inset)


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
    names = {body.name for body in bodies}  # an engine may have options that name them
    before = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))
    solves = RANDOM if how.solves is None else how.solves
    apart = APART if place.apart is None else place.apart
    return _answered(Placing(planner_of, before, grounds, place.stack, apart, how.seed, solves), bodies, engine, clock)


def _answered(placing: Placing, bodies: Sequence[Body], engine: EngineChoice, clock: Clock) -> Placements:
    """Put the bodies down as well as time allows, if the scene stands before; those without a place are left."""
    method = engine_of(engine)
    try:
        with until(clock.by("search")):
            verdict = prepared(method, placing.before).verdict()
    except OutOfTimeError:
        verdict = undecided("the time was used up before it was known")
    status: Status = verdict.status
    if status is not Status.STABLE:
        words = "does not stand" if status is Status.UNSTABLE else "is undecided"
        reason = f"the scene {words} before anything is put down: {verdict.reason}"
        best, tries = Try((), placing.before, tuple(body.name for body in bodies), placing.apart), 0
    else:
        best, tries = placing.best(bodies, clock)
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
