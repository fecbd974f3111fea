"""The state of a search for a place; compare the stable poses that it found, and shift the best to where there is room.

Steps that become shorter shift a pose: a pattern search, after Hooke and Jeeves (J. ACM 8, 1961).
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal, TypeVar

import numpy as np

from holdfast.applications.placement import margins
from holdfast.applications.placement.checks import STAGES, Checks
from holdfast.applications.placement.result import Candidate, Rating, least_push
from holdfast.applications.resting_poses import UPRIGHT, Face, rolls_on
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, objects
from holdfast.base.progress import OutOfTimeError, reported, until
from holdfast.base.rigid import tangents
from holdfast.base.values import Table
from holdfast.contacts.interface import Interface
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.queries.map import RobustnessMap, exposed_cells, robustness_map, spacing_for
from holdfast.scene.body import Body

# shares of the time limit after which each stage of a plan must end
SHARES: Mapping[str, float] = MappingProxyType(
    {"map": 0.2, "coarse map": 0.25, "search": 0.55, "compare": 0.7, "refine": 0.8, "end": 0.92}
)
FIRST_STEP, LAST_STEP = 4.0, 0.05  # lengths of the longest and the shortest step, as shares of the object's size
GAIN = 0.1  # smallest gain of room for which a step is made, as a share of the step

Place = tuple[Float, Assembly, float]  # a pose (4, 4), the assembly with the object there, the room around it
T = TypeVar("T")

REFINED = 3  # number of the best poses that are refined
ROUGHLY = 3  # spacing of the coarse maps by which poses are compared, as a multiple of the spacing of the full map
MOST_RATED = 150  # approximate largest number of points of such a map
UNASKED = "the time was used up before any push was computed: give more seconds"


@dataclass(frozen=True)
class Clock:
    """A time limit of ``seconds`` (None: no limit) from ``start`` [s] of ``time.perf_counter`` on."""

    start: float
    seconds: float | None

    @classmethod
    def started(cls, seconds: float | None) -> Clock:
        """Return a clock that begins now."""
        return cls(time.perf_counter(), seconds)

    @property
    def elapsed(self) -> float:
        """The time since the start [s]."""
        return time.perf_counter() - self.start

    def by(self, stage: str, share: float = 1.0) -> float:
        """Return the time [s of perf_counter] by which a stage must end, or a ``share`` of the time up to its end."""
        return np.inf if self.seconds is None else self.start + share * SHARES[stage] * self.seconds


@dataclass(eq=False)
class Trials:
    """The state of a search.

    ``flat`` holds the stable poses on flat faces, and ``rolling`` those in which the object balances on one facet of a
    round side, each with the assembly after the placement. ``tried`` counts the attempts, and ``faults`` counts the
    failed ones by their fault; ``nearest`` is the failed attempt that passed the most checks. ``first`` [s] is the time
    until the first stable pose. ``out_of_time`` is True if the search ended at the time limit.
    """

    flat: list[tuple[Candidate, Assembly]] = field(default_factory=list)
    rolling: list[tuple[Candidate, Assembly]] = field(default_factory=list)
    tried: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    nearest: Candidate | None = None
    first: float | None = None
    out_of_time: bool = False

    def failed(self, candidate: Candidate) -> None:
        """Count an attempt that failed."""
        self.faults[candidate.fault] += 1
        if self.nearest is None or STAGES.index(candidate.fault) > STAGES.index(self.nearest.fault):
            self.nearest = candidate

    @property
    def stable(self) -> list[tuple[Candidate, Assembly]]:
        """The stable poses on flat faces or, if there are none, those from which the object would roll."""
        return self.flat or self.rolling


def refined(checks: Checks, after: Assembly, pose: Float, beneath: tuple[str, ...]) -> tuple[Float, Assembly]:
    """Return a pose with more room, and the assembly with the object in it, by a pattern search over horizontal steps.

    The longest steps lead across neighbours to other free places. The object keeps its orientation, its height and its
    supports, and everything stands at each step; contacts at its sides may open. ``after`` is the assembly with the
    object at ``pose`` (4, 4), where it rests on the bodies ``beneath``.
    """
    ways = margins.around(np.array(tangents(checks.up)))
    name, size = checks.body.name, checks.body.size
    carriers = margins.supporting_bodies(name, after.interfaces, checks.up)

    def room(at: Float) -> tuple[float, Body, tuple[Interface, ...]]:
        fault, placed, contacts = checks.fits(at)
        if fault or margins.supporting_bodies(name, contacts, checks.up) != carriers:
            return -1.0, placed, contacts
        return min(checks.room(placed, contacts, beneath)), placed, contacts

    def better(place: Place, way: int, step: float) -> Place | None:
        new = place[0].copy()
        new[:3, 3] += step * ways[way]
        found, placed, contacts = room(new)
        if found <= place[2] + GAIN * step:
            return None
        stands = checks.judged(checks.with_object(placed, contacts))[1]
        return None if stands is None else (new, stands, found)

    start = pose, after, room(pose)[0]
    return pattern_search(start, better, margins.AROUND, first=FIRST_STEP * size, last=LAST_STEP * size)[:2]


def pattern_search(start: T, better: Callable[[T, int, float], T | None], ways: int, *, first: float, last: float) -> T:
    """Return the best state that steps of lengths from ``first`` down to ``last`` lead to.

    ``better(state, way, step)`` returns the state one step away along one of so many ``ways``, or None unless that is
    better. The step is halved when no way is better.
    """
    state, step = start, first
    while step >= last:
        found = next((new for way in range(ways) if (new := better(state, way, step)) is not None), None)
        state, step = (state, step / 2) if found is None else (found, step)
    return state


@dataclass(frozen=True, eq=False)
class RatedPose:
    """A stable pose with its ``rating`` and the assembly ``after`` the placement.

    ``beneath`` names the bodies that the object rests on, directly or through others. ``own`` is the coarse map of the
    object, or None if there was no time for it.
    """

    candidate: Candidate
    after: Assembly
    rating: Rating
    beneath: tuple[str, ...]
    own: RobustnessMap | None


def compared(
    checks: Checks, faces: Sequence[Face], found: Sequence[tuple[Candidate, Assembly]], clock: Clock
) -> list[RatedPose]:
    """Rate all poses and refine the best few of them; return them in decreasing order of their ratings."""

    def in_order(entries: list[RatedPose]) -> list[RatedPose]:
        return sorted(entries, key=lambda entry: entry.rating.key, reverse=True)

    several = len(found) > 1
    ranked = in_order(
        [
            rated(checks, faces, candidate, after, clock)
            for candidate, after in (reported("poses compared", found) if several else found)
        ]
    )
    for number, entry in enumerate(reported("best poses moved about", ranked[:REFINED])):
        try:
            with until(clock.by("refine")):
                pose, after = refined(checks, entry.after, entry.candidate.pose, entry.beneath)
        except OutOfTimeError:
            break
        if after is not entry.after:
            better = rated(checks, faces, replace(entry.candidate, pose=pose), after, clock)
            if better.rating.key > entry.rating.key:
                ranked[number] = better
    return in_order(ranked)


def rated(
    checks: Checks,
    faces: Sequence[Face],
    candidate: Candidate,
    after: Assembly,
    clock: Clock,
    points: int = MOST_RATED,
) -> RatedPose:
    """Rate a stable pose by coarse maps of at most about ``points`` points each.

    The rating uses ``lower`` of the maps if faces are imperfect, and ``force`` otherwise.
    """
    imperfect, name = checks.imperfect, checks.body.name
    beneath = margins.rests_on(after, name)
    known = prepared(checks.engine, checks.assembly).verdict().balanced  # a ball rolls whatever is put beside it
    movable = [body.name for body in after.movable if body.name in beneath and body.name not in known]
    placed = after.scene.body(name)
    edge, clear = checks.room(placed, margins.contacts_of(name, after.interfaces), beneath)

    def weakest_of(names: Sequence[str]) -> RobustnessMap:
        step = max(ROUGHLY * checks.search.spacing, spacing_for(after, names, points))
        return robustness_map(after, names, spacing=step, engine=checks.engine, imperfect=imperfect)

    own = below = None
    try:
        with until(clock.by("compare")):
            own = weakest_of([name])
            below = weakest_of(movable) if movable else None
    except OutOfTimeError:
        own = below = None
    column: Literal["force", "lower"] = "force" if imperfect is None else "lower"
    rating = Rating(
        own=None if own is None else least_push(own, column=column),
        beneath=np.inf if not movable else None if below is None else least_push(below, column=column),
        edge=edge,
        clearance=clear,
        rolls=rolls_on(faces, candidate.pose, margins.normals_into(after, name)),
        upright=not checks.approach.prefers_upright or bool(candidate.pose[:3, 2] @ checks.up >= UPRIGHT),
        size=placed.size,
    )
    ideal = [least_push(found) for found in (own, below) if found is not None]
    robustness = min((force for force in ideal if force is not None), default=None)
    lower = None if imperfect is None else rating.least
    return RatedPose(replace(candidate, robustness=robustness, lower=lower, rating=rating), after, rating, beneath, own)


def unasked_map(assembly: Assembly, name: str, spacing: float, engine: Engine) -> RobustnessMap:
    """Return a map of a few points of one body without answers, for a search that ran out of time."""
    shown, hidden = exposed_cells(assembly, name, max(spacing, spacing_for(assembly, [name], MOST_RATED)))
    verdict = prepared(engine, assembly).verdict()
    known = {"engine": engine.name, "claim": engine.claim, "notes": (UNASKED,)}
    return RobustnessMap(
        answers=Answers.not_standing(len(shown.points), verdict=verdict, **known),
        assembly=assembly,
        points=shown.points,
        normals=shown.normals,
        body=objects([name] * len(shown.points)),
        cells=Table({name: shown}),
        hidden=Table({name: hidden}),
    )
