"""The result of placement planning."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Literal

import numpy as np

from holdfast.applications.placement.margins import contacts_of
from holdfast.applications.placement.support import SupportPoints
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, frozen
from holdfast.base.painters import paint
from holdfast.base.public import Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.contacts.interface import Interface
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.result import Result, gives_way, vector_text
from holdfast.scene.body import Body

NARROW = 0.25  # score of a pose without any room around it, relative to one with unlimited room
USUAL = 0.25  # room, as a share of the object's size, at which the factor is midway between NARROW and 1
LEAST_ROOM = 1e-6  # [m] less than this counts as no room
TOPPLED = 0.5  # factor on the score of a pose in which the object is not upright


class Rating(Record):
    """What makes a stable pose good or bad.

    ``own`` [N] is the smallest push on the object that moves something, and ``beneath`` [N] the smallest push on the
    movable bodies that it touches or rests on, down to the ground, but for those that were only balanced before; inf if
    there are none. Both are from the decided points of a coarse map, and None if no point is decided. ``edge`` [m] is
    the distance of the object from the edges of its supports, and ``clearance`` [m] that from the nearest body that
    does not support it, at most the object's size; ``room`` [m] is the smaller of both. ``rolls`` is True if the object
    balances on one facet of a round side, and ``upright`` if its own third axis points up. ``size`` [m] is the size of
    the object. ``score`` [N] combines all of these.
    """

    own: float | None
    beneath: float | None
    edge: float
    clearance: float
    rolls: bool
    upright: bool
    size: float

    @property
    def least(self) -> float | None:
        """The smaller of ``own`` and ``beneath`` [N], or None if neither is known."""
        known = [force for force in (self.own, self.beneath) if force is not None]
        return min(known, default=None)

    @property
    def room(self) -> float:
        """The smaller of ``edge`` and ``clearance`` [m]: the object could be shifted that far in any direction."""
        return min(self.edge, self.clearance)

    @property
    def score(self) -> float:
        """The smallest push [N], reduced for little room and for an object that is not upright.

        With the room d and w = USUAL * size, the factor for room is (NARROW w + d) / (w + d).
        """
        wide = USUAL * self.size
        worth = (NARROW * wide + self.room) / (wide + self.room)
        least = 0.0 if self.least is None else min(self.least, 1e300)
        return least * worth * (1.0 if self.upright else TOPPLED)

    def facts(self, name: str, beneath: Sequence[str]) -> list[tuple[str, str]]:
        """Return the rating in words for an object ``name`` on the bodies ``beneath``."""
        facts = [(f"least push on {name}", _newtons(self.own))]
        if self.beneath is None or np.isfinite(self.beneath):
            facts.append(("on what it rests on", f"{_newtons(self.beneath)} ({listed(beneath)})"))
        facts.append(("room", f"{_room(self.edge)} to the edges, {_room(self.clearance)} to the next body"))
        return facts

    @property
    def key(self) -> tuple[float, ...]:
        """The sort key of poses; the best pose has the largest.

        Poses rank lowest if ``own``, the smallest push on the object that moves something, is not known, and next
        lowest if the object would roll. The others rank by score, and then by ``own``.
        """
        own = -1.0 if self.own is None else self.own
        return float(self.own is not None), float(not self.rolls), round(self.score, 9), own


def _newtons(force: float | None) -> str:
    return "not known" if force is None else number(force, "N")


def _room(distance: float) -> str:
    return f"{1e3 * distance if distance > LEAST_ROOM else 0.0:.3g} mm"


class Candidate(Record):
    """A pose (4, 4), body frame to world, that was tried.

    ``fault`` says in words why it was rejected; it is empty for a stable pose. ``robustness`` [N] of a stable pose is
    the smallest push on the object and its supports that moves something, from the decided points of coarse maps, or
    None if no point is decided. ``lower`` [N] is the smallest lower bound there if faces are imperfect, else None.
    ``rating`` says what makes a stable pose good or bad. ``points`` (k, 3) [m] are the support points on which the pose
    was built, with outward ``normals`` (k, 3), world frame; the pose may have been shifted afterwards.
    """

    pose: Float = column("4 4")
    points: Float = column("k 3")
    normals: Float = column("k 3")
    fault: str
    robustness: float | None = None
    lower: float | None = None
    rating: Rating | None = None


class Placement(Result, ask=".stable, which says whether a place was found, or .status"):
    """Where an object can be put down.

    ``status`` is one of three. STABLE: a pose was found in which everything stands. UNSTABLE: the scene does not stand
    before anything is put down. UNDECIDED: no place was found, which does not prove that there is none, or the verdict
    on the scene is undecided. ``reason`` explains the status.

    If the status is STABLE, ``pose`` (4, 4), body frame to world, is the pose with the best ``rating``: by the pushes
    that the object and the bodies ``beneath`` it withstand, and by the room around it, whatever the rest of the scene
    withstands. ``assembly`` is the assembly with the object in place, ``body`` is the object, and ``contacts`` are its
    interfaces. ``map`` is the robustness map of that assembly, and ``robustness`` [N] is its smallest inward push over
    all decided points of movable bodies, at ``weakest``. If no point is decided, the status of ``weakest`` is
    UNDECIDED, and the 0 is no answer. The pose was built on ``points`` (k, 3) [m] with outward ``normals`` (k, 3),
    chosen from ``support``.

    Otherwise ``pose``, ``map`` and the values that follow from them are None, ``robustness`` is 0, and ``best`` is the
    attempt that passed the most checks.

    ``candidates`` are all stable poses found, the returned one first. ``attempts`` counts all attempts, and ``faults``
    counts the failed ones by their fault. ``time_to_stable`` [s] is the time until the first stable pose, and
    ``elapsed`` [s] the total time. ``answers`` are those of ``map``; without a map they are empty, and ``verdict`` is
    that of the scene.
    """

    name: str
    status: Status
    reason: str
    map: RobustnessMap | None = None
    candidates: tuple[Candidate, ...] = ()
    best: Candidate | None = None
    beneath: tuple[str, ...] = ()
    attempts: int
    faults: Table[str, int]
    support: SupportPoints | None = None
    time_to_stable: float | None = None
    elapsed: float

    plain = (
        "name status reason pose robustness lower weakest attempts faults rating "
        "beneath candidates best points normals time_to_stable elapsed"
    )

    @property
    def stable(self) -> bool:
        """Whether a pose was found in which everything certainly stands."""
        return self.status is Status.STABLE

    @property
    def assembly(self) -> Assembly | None:
        """The assembly with the object in place, or None without a place."""
        return None if self.map is None else self.map.assembly

    @property
    def body(self) -> Body | None:
        """The object in place, or None if no place was found."""
        return None if self.assembly is None else self.assembly.scene.body(self.name)

    @property
    def pose(self) -> Float | None:
        """The pose (4, 4) of the object, body frame to world, or None without a place."""
        return self.candidates[0].pose if self.candidates else None

    @property
    def rating(self) -> Rating | None:
        """What makes the pose good, or None without a place."""
        return self.candidates[0].rating if self.candidates else None

    @property
    def points(self) -> Float:
        """The points (k, 3) [m] of the scene on which the pose was built, world frame."""
        return self.candidates[0].points if self.candidates else _NONE

    @property
    def normals(self) -> Float:
        """The outward normals (k, 3) of the scene at ``points``."""
        return self.candidates[0].normals if self.candidates else _NONE

    @cached_property
    def weakest(self) -> MapPoint | None:
        """The weakest point of the assembly with the object in place, or None without a place."""
        return None if self.map is None else self.map.weakest()

    @property
    def robustness(self) -> float:
        """The least force [N] of the map afterwards; 0 without a place or without an answer.

        That is the smallest push on any movable body of the scene, one that only rolls, such as an apple, included.
        """
        return 0.0 if self.weakest is None else self.weakest.force

    @property
    def lower(self) -> float:
        """The smallest lower bound [N] over the decided points of the map; 0 without a place or without an answer.

        It holds on imperfect faces if they were given.
        """
        return 0.0 if self.map is None else least_push(self.map, column="lower") or 0.0

    @property
    def contacts(self) -> tuple[Interface, ...]:
        """The interfaces of the object in place."""
        return () if self.assembly is None else tuple(contacts_of(self.name, self.assembly.interfaces))

    def save_png(self, path: str | os.PathLike[str], *, seed: int = 0) -> None:
        """Draw the points on which the pose was built and the pose itself as a PNG.

        ``seed`` selects which of the sampled points are shown.
        """
        paint(self, path, ".png", seed=seed)

    def summary(self) -> Summary:
        """Summarise where the object goes, or why no place was found."""
        facts = [("reason", self.reason), ("attempts", f"{self.attempts} in {self.elapsed:.2g} s"), *self.facts()]
        if self.pose is None:
            return Summary(f"no place found for {self.name}: {self.reason}", facts, notes=self.notes)
        if self.weakest is not None:
            weak = self.weakest
            what = f"{number(weak.force, 'N')} on {weak.body}: {gives_way(weak.mode, weak.moving)}"
            facts.insert(0, ("least push afterwards", "undecided" if weak.status is Status.UNDECIDED else what))
        if self.rating is not None:
            facts[:0] = self.rating.facts(self.name, self.beneath)
        unknown = self.answers.undecided.text_on("points of the map")
        place = f"{self.name} stands at {vector_text(self.pose[:3, 3], '.4g')} m"
        return Summary("; ".join(filter(None, [place, unknown])), facts, notes=self.notes)


_NONE = frozen(np.empty((0, 3)))


def least_push(found: RobustnessMap, column: Literal["force", "lower"] = "force") -> float | None:
    """Return the smallest push [N] over the decided points of a map; None if there are none."""
    known = found.answers.decided
    values = found.force if column == "force" else found.lower
    return float(values[known].min()) if known.any() else None


class PlacedObject(Record):
    """One step: the ``body`` that is placed and its ``pose`` (4, 4), body frame to world.

    ``own`` [N] is the smallest push on it that moves something right after this step. ``rests_on`` names the bodies
    that it touches or rests on, down to the ground, and ``beneath`` [N] is the smallest push on the movable ones, but
    for those that were only balanced before; inf if there are none. Both forces are from the decided points of a coarse
    map, and None if no point is decided. ``balanced`` tells that the object is only balanced, as a ball is: ``own`` is
    then 0.
    """

    body: str
    pose: Float = column("4 4")
    own: float | None
    beneath: float | None
    rests_on: tuple[str, ...]

    @property
    def least(self) -> float | None:
        """The smaller of ``own`` and ``beneath`` [N], or None if neither is known.

        An object that is only balanced rolls wherever it lies: what counts is ``beneath``, None if all that is fixed.
        """
        if self.balanced:
            return None if self.beneath is None or np.isinf(self.beneath) else self.beneath
        return min((force for force in (self.own, self.beneath) if force is not None), default=None)

    @property
    def balanced(self) -> bool:
        """Whether the object is only balanced: the slightest push moves it."""
        return self.own == 0

    @property
    def least_text(self) -> str:
        """The smallest push in words."""
        if self.balanced:
            return "only balanced"
        return "undecided" if self.least is None else number(self.least, "N")


class Placements(Pictured, PublicValue, ask=".stable, which says whether every object has a place, or .status"):
    """Where several objects can be put down, one after the other, so that everything stands after each step.

    ``status`` is one of three. STABLE: every object has a place. UNSTABLE: the scene does not stand before anything is
    put down. UNDECIDED: some objects, which ``left`` names, have found no place, which does not prove that there is
    none; or it is not known whether the scene stands. ``reason`` explains the status.

    ``steps`` are those of the best of ``tries`` attempts, ``assembly`` is the assembly after them, and ``apart`` [m] is
    the smallest distance between the objects. ``engine`` and ``claim`` hold for all forces. ``elapsed`` [s] is the
    total time. Its picture shows the states after the steps, with the object that was placed last in colour.
    """

    assembly: Assembly
    status: Status
    reason: str
    steps: tuple[PlacedObject, ...]
    left: tuple[str, ...]
    apart: float
    tries: int
    engine: str
    claim: Claim
    elapsed: float

    plain = "status reason engine claim order left apart least steps tries elapsed"

    @property
    def stable(self) -> bool:
        """Whether every object has a place where everything certainly stands."""
        return self.status is Status.STABLE

    @property
    def order(self) -> tuple[str, ...]:
        """The names of the objects in the order in which they are placed."""
        return tuple(step.body for step in self.steps)

    @property
    def poses(self) -> dict[str, Float]:
        """The poses (4, 4) of the objects by their names, body frame to world."""
        return {step.body: step.pose for step in self.steps}

    @property
    def weakest(self) -> PlacedObject | None:
        """The step with the smallest ``least``, or None if no force is known."""
        known = [(step.least, k) for k, step in enumerate(self.steps) if step.least is not None]
        return self.steps[min(known)[1]] if known else None

    @property
    def least(self) -> float:
        """The smallest push [N] of all steps, leaving out objects that are only balanced; 0 if none is known."""
        return 0.0 if self.weakest is None or self.weakest.least is None else self.weakest.least

    def about(self) -> dict[str, Any]:
        """Return the name of the scene as plain data."""
        return {"scene": self.assembly.scene.name}

    def summary(self) -> Summary:
        """Summarise where every object goes, in order."""
        whole = len(self.steps) + len(self.left)
        headline = f"{len(self.steps)} of {whole} objects placed: {self.reason}"
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("tried", f"{self.tries} in {self.elapsed:.2g} s")]
        balanced = [step.body for step in self.steps if step.balanced]
        if balanced:
            facts.insert(0, ("only balanced", f"{listed(balanced)}: the slightest push moves it"))
        if self.weakest is not None:
            facts.insert(0, ("least push of all steps", f"{number(self.least, 'N')}, after {self.weakest.body}"))
        rows = [
            [
                str(k + 1),
                step.body,
                f"{vector_text(step.pose[:3, 3], '.4g')} m",
                listed(step.rests_on),
                step.least_text,
            ]
            for k, step in enumerate(self.steps)
        ]
        return Summary(headline, facts, ("step", "put down", "at", "on", "least push"), rows)
