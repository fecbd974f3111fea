"""Compare stable poses, and shift the best few to where there is more room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from holdfast.applications.placement.checks import Checks
from holdfast.applications.placement.margins import contacts_of, normals_into, rests_on
from holdfast.applications.placement.place_search import Clock
from holdfast.applications.placement.rating import MOST_RATED, Rating, least_push, weakest_of
from holdfast.applications.placement.refine import refined
from holdfast.applications.placement.result import Candidate
from holdfast.applications.standing_faces import UPRIGHT, Face, rolls_on
from holdfast.assembly.assembly import Assembly
from holdfast.base.progress import OutOfTimeError, reported, until
from holdfast.engines.groups import prepared
from holdfast.queries.map import RobustnessMap

REFINED = 3  # number of the best poses that are refined


@dataclass(frozen=True, eq=False)
class Compared:
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
) -> list[Compared]:
    """Rate all poses and refine the best few of them; return them in decreasing order of their ratings."""

    def in_order(entries: list[Compared]) -> list[Compared]:
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
) -> Compared:
    """Rate a stable pose by coarse maps of at most about ``points`` points each.

    The rating uses ``lower`` of the maps if faces are imperfect, and ``force`` otherwise.
    """
    options, name = checks.options, checks.body.name
    beneath = rests_on(after, name)
    known = prepared(checks.engine, checks.assembly).verdict().balanced  # a ball rolls whatever is put beside it
    movable = [body.name for body in after.movable if body.name in beneath and body.name not in known]
    placed = after.scene.body(name)
    edge, clear = checks.room(placed, contacts_of(name, after.interfaces), beneath)
    own = below = None
    try:
        with until(clock.by("compare")):
            own = weakest_of(after, [name], options.spacing, points, checks.engine, options.imperfect)
            if movable:
                below = weakest_of(after, movable, options.spacing, points, checks.engine, options.imperfect)
    except OutOfTimeError:
        own = below = None
    column: Literal["force", "lower"] = "force" if options.imperfect is None else "lower"
    rating = Rating(
        own=None if own is None else least_push(own, column=column),
        beneath=np.inf if not movable else None if below is None else least_push(below, column=column),
        edge=edge,
        clearance=clear,
        rolls=rolls_on(faces, candidate.pose, normals_into(after, name)),
        upright=not options.prefer_upright or bool(candidate.pose[:3, 2] @ checks.up >= UPRIGHT),
        size=placed.size,
    )
    ideal = [least_push(found) for found in (own, below) if found is not None]
    robustness = min((force for force in ideal if force is not None), default=None)
    lower = None if options.imperfect is None else rating.least
    return Compared(replace(candidate, robustness=robustness, lower=lower, rating=rating), after, rating, beneath, own)
