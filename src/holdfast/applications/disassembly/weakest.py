"""Find the smallest push that moves something in every state of a building, reusing earlier answers.

A body that is put in affects the bodies that it touches. Only these are pushed again after each step; the answers for
the others are reused. Most pushes need no full answer: a load path up to the smallest push known so far shows that a
push is no weaker.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.engines.contract import Engine
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.verdict import Status
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.map import MapPoint, map_point
from holdfast.queries.request import push_columns

CLOSE = 0.97  # pushes that hold at this share of the smallest known push get no full answer


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known of one body: all pushes on it hold at ``force`` [N], and the weakest ``point`` with an answer."""

    force: float
    point: MapPoint | None

    @property
    def settled(self) -> bool:
        """Whether no push on the body is much weaker than its ``point``."""
        return self.point is not None and self.force >= CLOSE * self.point.force


@dataclass(eq=False)
class WeakestPoints:
    """The weakest points of the states of a building: call ``after`` for each body that is put in, in order.

    The spacing of points is chosen so that there are about ``pushes`` on all bodies.
    """

    engine: Engine
    pushes: int
    _known: dict[str, _Known] = field(default_factory=dict)

    def after(self, state: Assembly, name: str) -> MapPoint | None:
        """Return the weakest point of a ``state`` into which ``name`` was put last; None if no surface is exposed.

        If no push is decided, the status of the point is UNDECIDED.
        """
        near = [name, *touched(state, name)]
        area = sum(body.surface_world.area for body in state.movable)
        spacing = float(np.sqrt(area / self.pushes))
        asked = prepared(self.engine, state)
        for each in near:
            self._known.pop(each, None)
        for each in near:
            self._known[each] = _pushed(asked, each, spacing, self._least)
        for each, known in list(self._known.items()):
            if not known.settled and known.force < CLOSE * self._least:  # it may be the weakest now
                self._known[each] = _pushed(asked, each, spacing, self._least)
        points = [known.point for known in self._known.values() if known.point is not None]
        return min(points, key=_rank, default=None)

    @property
    def _least(self) -> float:
        """The smallest push [N] that is known to move something; inf if there is none."""
        found = (known.point for known in self._known.values())
        return min((p.force for p in found if p is not None and p.status is not Status.UNDECIDED), default=np.inf)


def touched(assembly: Assembly, name: str) -> list[str]:
    """Return the movable bodies that ``name`` touches."""
    pairs = (interface.bodies for interface in assembly.interfaces if name in interface.bodies)
    others = dict.fromkeys(b if a == name else a for a, b in pairs)
    return [other for other in others if assembly.index[other] != FIXED]


def _pushed(asked: Groups, name: str, spacing: float, least: float) -> _Known:
    """Find the weakest push on a body, or show that none is much weaker than ``least`` [N].

    Pushes with a long lever arm about the centre of mass come first, since they turn the body. If no push can be
    excluded by a short load path, all are answered at once.
    """
    cells = exposed_cells(asked.assembly, name, spacing)[0]
    number = asked.assembly.index[name]
    columns = push_columns(asked.assembly, number, cells.points, -cells.normals)
    arm = np.linalg.norm(columns[6 * number + 3 : 6 * number + 6], axis=0)
    rows = np.argsort(-arm, kind="stable")
    points: list[MapPoint] = []
    screened = np.inf
    while len(rows):
        several = 1
        if least < screened:
            held = asked.held(CLOSE * least * columns[:, rows])
            rows, screened, several = rows[~held], least, 1 if held.any() else len(rows)
        answers = asked.load_factor(columns[:, rows[:several]])
        points += [
            map_point(answers, k, name, cells.points[row], cells.normals[row]) for k, row in enumerate(rows[:several])
        ]
        least = min([least, *(p.force for p in points if p.status is not Status.UNDECIDED)])
        rows = rows[several:]
    return _Known(CLOSE * least, min(points, key=_rank, default=None))


def _rank(point: MapPoint) -> tuple[bool, float]:
    return point.status is Status.UNDECIDED, point.force
