"""Place several objects one after the other, in an order that is chosen, so that everything stands after each step.

A systematic search lists the level places of an object (``spots``); where there is none in which everything stands, the
random search of ``plan_placement`` is asked. Which place is taken, and in which order, is a way (``choices``). The two
simple rules come first, which are quick; then places are compared by what the object and what it rests on withstand, in
several orders and at several distances, while there is time. The best try is that which places most objects, then the
one whose weakest state is the strongest, and then the one with the most room.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import dropwhile, groupby, islice
from types import MappingProxyType
from typing import Any

import numpy as np

from holdfast.applications.placement.choices import COMPARING, RULED, Rule, Way
from holdfast.applications.placement.comparing import Compared, rated
from holdfast.applications.placement.level_places import Outline, Spot, frame_of, levels_of, spots_for, turns_of
from holdfast.applications.placement.place_search import Clock
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.rating import TOPPLED
from holdfast.applications.placement.result import Candidate
from holdfast.applications.placement.several_result import PlacedObject
from holdfast.applications.placement.standing_faces import Face
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.progress import OutOfTimeError, report, until
from holdfast.scene.body import Body

MOST_FACES = 3  # faces of an object on which places are looked at
MOST_REFUSED = 12  # places that are refused one after the other before a face is given up
WIDER: Mapping[float, float] = MappingProxyType({8.0: 0.25, 4.0: 0.45, 2.0: 0.65, 1.0: 1.0})
# distances that are tried, as multiples of the least one, each with the share of the time by which a rule has to end
SLACK = 1.5  # of the time of the longest try that has to be left for another one
POINTS = 40  # about the most points of the maps by which places are compared
RANDOM = 25  # attempts of the random search by default
_NONE = np.empty((0, 3))


def worth(place: Compared) -> tuple[float, ...]:
    """What decides between two places of one object: what the object and what it rests on withstand, upright doubly."""
    rating = place.rating
    return float(rating.own is not None), (rating.least or 0.0) * (1.0 if rating.upright else TOPPLED)


@dataclass(frozen=True, eq=False)
class Try:
    """What one way came to: the ``steps``, the ``assembly`` after them and the names of those ``left`` without a place.

    A try that could not become the best any more was ended: then some objects are neither placed nor left.
    """

    steps: tuple[PlacedObject, ...]
    assembly: Assembly
    left: tuple[str, ...]
    apart: float

    @property
    def key(self) -> tuple[Any, ...]:
        """What decides between two of them; the larger is the better.

        The number of objects comes first, then the least push of all steps, then the distance, because room is worth
        more than what a step withstands that is not the weakest. The other steps are last, the weakest of them first:
        an object that any push moves, such as a ball, does not make all tries equal.
        """
        leasts = sorted(_rounded(step) for step in self.steps)
        return len(leasts), leasts[:1], self.apart, leasts


def _rounded(step: PlacedObject) -> float:
    return float(f"{step.least or 0.0:.4g}")  # solvers differ in their last digits


@dataclass(eq=False)
class Placing:
    """Places several objects in one scene.

    ``planner_of`` makes a planner for an object in an assembly. ``grounds`` names the bodies to place objects on, which
    also stand on each other if ``stack`` is True. ``apart`` [m] is the least distance between them. ``solves`` are the
    attempts of the random search for an object that has no level place, with ``seed``.
    """

    planner_of: Callable[[Assembly, Body], Planner]
    grounds: tuple[str, ...]
    stack: bool
    apart: float
    seed: int
    solves: int = RANDOM
    _faces: dict[str, tuple[Face, ...]] = field(default_factory=dict)
    _outlines: dict[str, Outline] = field(default_factory=dict)

    def best(self, assembly: Assembly, objects: Sequence[Body], clock: Clock) -> tuple[Try, int]:
        """Return the best of all tries that there is time for, and their number.

        The rules at the least distance come first, which are quick: that is the baseline. Then the widest distance is
        sought at which a rule places everything; a try at a wide distance ends as soon as an object finds no place.
        There places are compared, and also at narrower distances where an order finds none for some object.
        """
        tries, spent = list[Try](), list[float]()

        def whole(way: Way, wider: float, deadline: float) -> bool:
            """Make a try, and tell whether there was time for it and no object was left without a place."""
            begun = clock.elapsed
            if tries and clock.seconds is not None and begun + SLACK * max(spent) > clock.seconds:
                return False
            beat = max((one.key for one in tries), default=None)
            one = self._tried(assembly, objects, way, wider * self.apart, deadline, wider == 1, beat)
            spent.append(clock.elapsed - begun)
            tries.extend([] if one is None else [one])
            return one is not None and not one.left

        def ruled(wider: float) -> bool:
            """Try the rules at a distance, and tell whether one of them placed everything."""
            deadline = clock.by("compare", WIDER[wider]) if wider > 1 else clock.by("end")
            return any([whole(way, wider, deadline) for way in RULED])  # noqa: C419 - both are tried

        ruled(1.0)
        distances = WIDER if self.apart > 0 and not self.stack else (1.0,)
        for wider in dropwhile(lambda wider: wider > 1 and not ruled(wider), distances):
            if all([whole(way, wider, clock.by("end")) for way in COMPARING]):  # noqa: C419 - every order is tried
                break
        return max(tries, key=lambda one: one.key), len(spent)

    def _tried(
        self,
        assembly: Assembly,
        objects: Sequence[Body],
        way: Way,
        apart: float,
        deadline: float,
        whole: bool,
        beat: tuple[Any, ...] | None,
    ) -> Try | None:
        """Place the objects in this way, as far as the key of another try can still be ``beat``.

        Where one finds no place or the time is over, the result is None, unless ``whole`` asks for what there is.
        """
        steps, left, after = list[PlacedObject](), list[str](), assembly
        begun = time.perf_counter()
        ordered = sorted(objects, key=way.order, reverse=True)
        for number, body in enumerate(ordered):
            report("objects placed", number, len(ordered))
            now = time.perf_counter()
            hurry = number > 0 and (now - begun) / number * (len(ordered) - number) > deadline - now
            try:
                with until(deadline):
                    found = self._placed(assembly, after, body, way.hurried() if hurry else way, apart, whole)
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

    def _placed(
        self, before: Assembly, assembly: Assembly, body: Body, way: Way, apart: float, whole: bool
    ) -> Compared | None:
        """Return the best of the places that a way looks at and in which everything stands, or None."""
        asked = self.planner_of(assembly, body)
        if body.name not in self._faces:
            self._faces[body.name] = asked.faces
        faces = self._faces[body.name]
        found = list[Compared]()
        spots = sorted(self.spots(before, assembly, body, faces, apart, asked), key=lambda spot: spot.face)
        for _, alike in islice(groupby(spots, key=lambda spot: spot.face), MOST_FACES):
            found += self._standing(list(alike), asked, faces, way.rules)
            if found and not way.compares:
                break
        if found:
            return max(found, key=worth)
        if not whole:
            return None
        search = asked.search(seed=self.seed, attempts=self.solves, mapped=False)
        for candidate, after in search.stable:
            return rated(asked.checks, faces, candidate, after, Clock.started(None), POINTS)
        return None

    def _standing(
        self, spots: Sequence[Spot], asked: Planner, faces: Sequence[Face], rules: Sequence[Rule]
    ) -> list[Compared]:
        """Return the first place by each rule in which everything stands, rated, each place once."""
        known, found = dict[int, Assembly | None](), dict[int, Assembly]()
        for rule in rules:
            ranked = sorted(range(len(spots)), key=lambda k: rule(spots[k]))
            asked_for = (k for k in ranked if not asked.checks.misplaced(asked.body.moved(spots[k].pose)))
            for k in islice(asked_for, MOST_REFUSED):
                if k not in known:
                    known[k] = asked.checks.fault(spots[k].pose)[1]
                after = known[k]
                if after is not None:
                    found[k] = after
                    break
        candidates = {k: Candidate(spots[k].pose, _NONE, _NONE, "") for k in found}
        return [
            rated(asked.checks, faces, candidates[k], after, Clock.started(None), POINTS) for k, after in found.items()
        ]

    def spots(
        self, before: Assembly, assembly: Assembly, body: Body, faces: Sequence[Face], apart: float, asked: Planner
    ) -> list[Spot]:
        """Return all level places of an object on what it may be placed on, ``apart`` [m] from all else."""
        up = assembly.scene.up
        first = [b for b in before.bodies if b.name in self.grounds]
        axes = frame_of(first, up)
        placed = [b for b in assembly.bodies if b.name not in before.index and not b.fixed]
        levels = levels_of(first + (placed if self.stack else []), up, axes)
        outlines = [self._outline(b, up, axes) for b in asked.checks.frozen]
        inset = 0.0 if self.stack else apart
        return spots_for(body, turns_of(faces, asked.options, up, axes), levels, outlines, apart, inset)

    def _outline(self, body: Body, up: Float, axes: Float) -> Outline:
        known = self._outlines.get(body.name)
        if known is None or (known.body.pose != body.pose).any():
            known = self._outlines[body.name] = Outline(body, up, axes)
        return known
