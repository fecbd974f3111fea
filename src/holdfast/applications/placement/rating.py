"""How good a stable pose is: what the object and what it rests on withstand, and how much room there is about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived
from holdfast.base.arrays import objects
from holdfast.base.public import number
from holdfast.base.text import listed
from holdfast.base.values import Table, Value, seal
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.map import RobustnessMap, robustness_map

ROUGHLY = 3  # spacing of the coarse maps by which poses are compared, as a multiple of the spacing of the full map
MOST_RATED = 150  # about the most points of such a map
UNASKED = "the time was spent before it was asked how hard anything can be pushed: give more seconds"
NARROW = 0.25  # worth of a pose without any room about it, as a share of that of one with all the room in the world
USUAL = 0.25  # of the object's size: the room at which the worth is midway between these
LEAST_ROOM = 1e-6  # [m] less than this is told as no room
TOPPLED = 0.5  # worth of a pose in which the object does not stand the way up in which it was modelled


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Rating(Value):
    """What makes a stable pose good or bad.

    ``own`` [N] is the least push on the object that moves something, and ``beneath`` [N] the least push on the movable
    bodies that it touches or rests on, down to the ground; inf if there are none. Both are those of the decided points
    of a coarse map, and None if no point was decided. ``edge`` [m] is how far inside the edges of its supports the
    object stands, and ``clearance`` [m] its distance from the nearest body that does not carry it, 0 where it touches
    one, at most its size. ``rolls`` says that it balances on one facet of a round side, and ``upright`` that it stands
    the way up in which it was modelled. ``room`` [m] is the lesser of ``edge`` and ``clearance``. ``size`` [m] is that
    of the object. ``score`` [N] is what the pose is worth.
    """

    own: float | None
    beneath: float | None
    edge: float
    clearance: float
    rolls: bool
    upright: bool
    size: float

    def __post_init__(self) -> None:
        seal(self)

    @property
    def least(self) -> float | None:
        """The least push [N] on the object and on what it rests on; None if nothing is known of either."""
        known = [force for force in (self.own, self.beneath) if force is not None]
        return min(known, default=None)

    @property
    def room(self) -> float:
        """How far the object could be put beside its place in any direction [m]."""
        return min(self.edge, self.clearance)

    @property
    def score(self) -> float:
        """The least push [N], reduced where there is little room and where the object does not stand upright.

        With the room d and w = USUAL * size the worth of the room is (NARROW w + d) / (w + d).
        """
        wide = USUAL * self.size
        worth = (NARROW * wide + self.room) / (wide + self.room)
        least = 0.0 if self.least is None else min(self.least, 1e300)
        return least * worth * (1.0 if self.upright else TOPPLED)

    def facts(self, name: str, beneath: Sequence[str]) -> list[tuple[str, str]]:
        """Return the rating in words for an object ``name`` on the bodies ``beneath``."""
        told = [(f"least push on {name}", _newtons(self.own))]
        if self.beneath is None or np.isfinite(self.beneath):
            told.append(("on what it rests on", f"{_newtons(self.beneath)} ({listed(beneath)})"))
        told.append(("room", f"{_room(self.edge)} to the edges, {_room(self.clearance)} to the next body"))
        return told

    @property
    def key(self) -> tuple[float, ...]:
        """What decides between two poses; the larger is the better.

        A pose of whose object nothing is known is below every other, then one in which it would roll. The score
        decides between the others, and then what the object itself withstands.
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
    """Return a map of the bodies ``names`` by which poses are compared, of about ``most`` points at most."""
    area = sum(assembly.scene.body(name).surface_world.area for name in names)
    step = max(ROUGHLY * spacing, float(np.sqrt(area / most)))
    return robustness_map(assembly, names, spacing=step, engine=engine, imperfect=imperfect)


def full_map(assembly: Assembly, spacing: float, engine: Engine, imperfect: Imperfect | None) -> RobustnessMap:
    """Return the map of all movable bodies after the placement."""
    return robustness_map(assembly, None, spacing=spacing, engine=engine, imperfect=imperfect)


def unasked_map(assembly: Assembly, name: str, spacing: float, engine: Engine) -> RobustnessMap:
    """Return a map of a few points of one body without answers, for an assembly that there was no time to push."""
    area = assembly.scene.body(name).surface_world.area
    shown, hidden = exposed_cells(assembly, name, max(spacing, float(np.sqrt(area / MOST_RATED))))
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
    """Return the least push [N] of a map over its decided points; None if there is none."""
    known = found.answers.decided
    values = found.force if column == "force" else found.lower
    return float(values[known].min()) if known.any() else None
