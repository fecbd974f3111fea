"""Rate a stable pose by the pushes that the object and its supports withstand, and by the room around it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import objects
from holdfast.base.public import Record, number
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.map import RobustnessMap, exposed_cells, robustness_map, spacing_for

ROUGHLY = 3  # spacing of the coarse maps by which poses are compared, as a multiple of the spacing of the full map
MOST_RATED = 150  # approximate largest number of points of such a map
UNASKED = "the time was used up before any push was computed: give more seconds"
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

        Poses rank lowest if ``own`` is not known, and next lowest if the object would roll. The others rank by score,
        and then by ``own``.
        """
        own = -1.0 if self.own is None else self.own
        return float(self.own is not None), float(not self.rolls), round(self.score, 9), own


def _newtons(force: float | None) -> str:
    return "not known" if force is None else number(force, "N")


def _room(distance: float) -> str:
    return f"{1e3 * distance if distance > LEAST_ROOM else 0.0:.3g} mm"


def weakest_of(
    assembly: Assembly, names: Sequence[str], spacing: float, most: int, engine: Engine, imperfect: Imperfect | None
) -> RobustnessMap:
    """Return a coarse map of the bodies ``names``, with at most about ``most`` points, for comparing poses."""
    step = max(ROUGHLY * spacing, spacing_for(assembly, names, most))
    return robustness_map(assembly, names, spacing=step, engine=engine, imperfect=imperfect)


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


def least_push(found: RobustnessMap, column: Literal["force", "lower"] = "force") -> float | None:
    """Return the smallest push [N] over the decided points of a map; None if there are none."""
    known = found.answers.decided
    values = found.force if column == "force" else found.lower
    return float(values[known].min()) if known.any() else None
