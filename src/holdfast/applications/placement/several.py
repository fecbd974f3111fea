"""Place several objects one after the other, in an order that is chosen, so that everything stands after each step.

Every object goes where a systematic search for level places (``spots``) finds one in which everything stands; of the
first few of these, where the object and what it rests on withstand most. Where there is none, the random search of
``plan_placement`` is asked. Several orders and distances are tried while there is time. The best is that which places
most objects, then the one whose weakest state is the strongest, and then the one with the most room.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby, islice
from types import MappingProxyType
from typing import Any

import numpy as np

from holdfast.applications.placement.comparing import Compared, rated
from holdfast.applications.placement.faces import Face
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.rating import TOPPLED
from holdfast.applications.placement.result import Candidate
from holdfast.applications.placement.search import Clock
from holdfast.applications.placement.several_result import PlacedObject
from holdfast.applications.placement.spots import Outline, Spot, frame_of, levels_of, spots_for, turns_of
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.progress import OutOfTimeError, report, until
from holdfast.scene.body import Body

COMPARED = 2  # places in which everything stands that are compared for each object and face
MOST_FACES = 3  # faces of an object that are compared
MOST_REFUSED = 12  # places that are refused one after the other before an object is given up
WIDER: Mapping[float, float] = MappingProxyType({8.0: 0.25, 4.0: 0.45, 2.0: 0.65, 1.0: 1.0})
# distances that are tried, as multiples of the least one, each with the share of the time by which it has to end
SLACK = 1.5  # of the time of the longest try that has to be left for another one
POINTS = 40  # about the most points of the maps by which places are compared
RANDOM = 25  # attempts of the random search for an object that has no level place
_NONE = np.empty((0, 3))

Order = Callable[[Body], float]


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


ORDERS: tuple[Order, ...] = (base_area, weight, bulk)  # the largest first


def worth(place: Compared) -> tuple[float, ...]:
    """What decides between two places of one object: what the object and what it rests on withstand, upright doubly."""
    rating = place.rating
    return float(rating.own is not None), (rating.least or 0.0) * (1.0 if rating.upright else TOPPLED)


@dataclass(frozen=True, eq=False)
class Try:
    """What one order came to: the ``steps``, the ``assembly`` after them and the names of those ``left``."""

    steps: tuple[PlacedObject, ...]
    assembly: Assembly
    left: tuple[str, ...]
    apart: float

    @property
    def key(self) -> tuple[Any, ...]:
        """What decides between two of them; the larger is the better.

        The number of objects comes first, then the least pushes of the steps, the weakest first, so that an object that
        any push moves, such as a ball, does not make all tries equal; then the distance.
        """
        return len(self.steps), sorted(round(step.least or 0.0, 6) for step in self.steps), self.apart


@dataclass(eq=False)
class Placing:
    """Places several objects in one scene.

    ``planner_of`` makes a planner for an object in an assembly. ``grounds`` names the bodies to place objects on, which
    also stand on each other if ``stack`` is True. ``apart`` [m] is the least distance between them.
    """

    planner_of: Callable[[Assembly, Body], Planner]
    grounds: tuple[str, ...]
    stack: bool
    apart: float
    seed: int
    _faces: dict[str, tuple[Face, ...]] = field(default_factory=dict)
    _outlines: dict[str, Outline] = field(default_factory=dict)

    def best(self, assembly: Assembly, objects: Sequence[Body], clock: Clock) -> tuple[Try, int]:
        """Return the best of all tries that there is time for, and their number.

        Wide distances come first; a try at one of these ends as soon as an object finds no place. Where everything has
        found its place, all orders are compared, and narrower distances are not looked at.
        """
        best, count, longest = None, 0, 0.0
        for wider, share in WIDER.items() if self.apart > 0 and not self.stack else ((1.0, 1.0),):
            least = wider == 1.0
            for order in ORDERS:
                begun = clock.elapsed
                if best is not None and begun + SLACK * longest > (clock.budget or np.inf):
                    return best, count
                deadline = clock.by("end" if least else "compare", share)
                one = self._tried(
                    assembly, sorted(objects, key=order, reverse=True), wider * self.apart, deadline, least
                )
                count += 1
                if one is None:
                    break
                longest = max(longest, clock.elapsed - begun)
                best = one if best is None or one.key > best.key else best
            if best is not None and not best.left:
                break
        assert best is not None
        return best, count

    def _tried(
        self, assembly: Assembly, objects: Sequence[Body], apart: float, deadline: float, whole: bool
    ) -> Try | None:
        """Place the objects in this order.

        Where one finds no place or the time is over, the result is None, unless ``whole`` asks for what there is.
        """
        steps, left, after = list[PlacedObject](), list[str](), assembly
        begun = time.perf_counter()
        for number, body in enumerate(objects):
            report("objects placed", number, len(objects))
            now = time.perf_counter()
            hurry = number > 0 and (now - begun) / number * (len(objects) - number) > deadline - now
            try:
                with until(deadline):
                    found = self._placed(assembly, after, body, apart, whole, hurry)
            except OutOfTimeError:
                if not whole:
                    return None
                left += [other.name for other in objects[number:]]
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
        return Try(tuple(steps), after, tuple(left), apart)

    def _placed(
        self, before: Assembly, assembly: Assembly, body: Body, apart: float, whole: bool, hurry: bool
    ) -> Compared | None:
        """Return the best of the first places in which everything stands, or None; in a ``hurry`` the very first."""
        asked = self.planner_of(assembly, body)
        if body.name not in self._faces:
            self._faces[body.name] = asked.faces
        faces = self._faces[body.name]
        found = list[Compared]()
        by_face = groupby(self.spots(before, assembly, body, faces, apart, asked), key=lambda spot: spot.face)
        for _, alike in islice(by_face, MOST_FACES):
            found += self._standing(alike, asked, faces, 1 if hurry else COMPARED)
            if found and hurry:
                break
        if found:
            return max(found, key=worth)
        if not whole:
            return None
        search = asked.search(seed=self.seed, attempts=RANDOM, mapped=False)
        for candidate, after in search.stable:
            return rated(asked.checks, faces, candidate, after, Clock.started(None), POINTS)
        return None

    def _standing(self, spots: Iterable[Spot], asked: Planner, faces: Sequence[Face], most: int) -> list[Compared]:
        """Return the first places in which everything stands, ``most`` of them, rated."""
        found, refused = list[Compared](), 0
        for spot in spots:
            fault, after = asked.checks.fault(spot.pose)
            refused += bool(fault)
            if after is not None:
                candidate = Candidate(spot.pose, _NONE, _NONE, "")
                found.append(rated(asked.checks, faces, candidate, after, Clock.started(None), POINTS))
            if len(found) == most or refused == MOST_REFUSED:
                break
        return found

    def spots(
        self, before: Assembly, assembly: Assembly, body: Body, faces: Sequence[Face], apart: float, asked: Planner
    ) -> list[Spot]:
        """Return all level places of an object, in the order in which they are looked at.

        The preferred face comes first, then what is low, what is wholly supported, and what is in a corner.
        """
        up = assembly.scene.up
        first = [b for b in before.bodies if b.name in self.grounds]
        axes = frame_of(first, up)
        placed = [b for b in assembly.bodies if b.name not in before.index and not b.fixed]
        levels = levels_of(first + (placed if self.stack else []), up, axes)
        outlines = [self._outline(b, up, axes) for b in asked.checks.frozen]
        inset = 0.0 if self.stack else apart
        found = spots_for(body, turns_of(faces, asked.options, up, axes), levels, outlines, apart, inset)
        return sorted(
            found,
            key=lambda s: (s.face, round(s.height, 4), -round(s.support, 1), *np.round(s.corner[::-1], 6).tolist()),
        )

    def _outline(self, body: Body, up: Float, axes: Float) -> Outline:
        known = self._outlines.get(body.name)
        if known is None or (known.body.pose != body.pose).any():
            known = self._outlines[body.name] = Outline(body, up, axes)
        return known
