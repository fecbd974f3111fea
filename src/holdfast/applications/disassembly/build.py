"""Find an order in which an assembly can be built, body by body, with everything standing after each step.

Bodies are put in from the top, so a build order is an order of removals reversed, with one condition fewer: neighbours
that could clamp a body while it is pulled out do not matter while it is set down. The search is that of disassembly
(order_search.py).

In every state, the smallest push is sought that moves something. A body that is put in affects the bodies that it
touches: only these are pushed again, and most pushes need no full answer, since a load path up to the smallest push
known so far shows that a push is no weaker.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.disassembly.least_hold import HandHold, handled, hands_column
from holdfast.applications.disassembly.order import SHOWN, SOLVES, StepByStep, planned
from holdfast.applications.disassembly.removal import Answer, Removal, Removals
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Float, checked_direction, checked_whole, frozen
from holdfast.base.progress import reported
from holdfast.base.public import Record, Summary, number
from holdfast.base.ranges import MANY
from holdfast.base.text import listed
from holdfast.engines.contract import Engine
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, exposed_cells, map_point, spacing_for
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of, push_columns
from holdfast.queries.result import amount
from holdfast.scene.scene import Scene

PUSHES = 200  # approximate number of points on all bodies of a state
NOTHING = float("nan")
SAFE = "everything stands with it, and while its weight is set down"
CLOSE = 0.97  # pushes that hold at this share of the smallest known push get no full answer


class BuildStep(Record):
    """One body that is put in, and the weakest point of the state that follows.

    ``hold`` means that the body must be held against turning while it is set down. ``weakest`` is the point of all
    exposed surfaces where the smallest inward push moves something, or None if it was not requested or hands hold
    bodies in some step. ``holds`` are the bodies that hands hold before and while this one is put in, each with the
    least force and moment that this takes just before; once it is in, they may go to those of the next step while the
    gripper still holds it.
    """

    body: str
    reason: str
    hold: bool
    weakest: MapPoint | None
    holds: tuple[HandHold, ...] = ()


class BuildOrder(StepByStep, ask=".reached, which says whether everything can be put in"):
    """An order in which the bodies of ``assembly`` can be put in, each along minus ``lift`` (3,), a unit vector.

    ``steps`` are in order. After each of them, everything that is in place stands by the verdict of ``method``. If
    ``reached`` is False, the bodies ``first`` cannot be put in one by one: they must stand before the first step, for
    example on a support that is removed later, and ``stuck`` says for each of them why it cannot be the last.
    ``proven`` means that no order has fewer such bodies. ``hands`` is how many hands could hold bodies, and
    ``falsework`` names those that have to be propped besides; only if there are none may ``reached`` be true.
    """

    steps: tuple[BuildStep, ...]
    stuck: tuple[Removal, ...]

    builds = True
    plain = "engine claim lift order reached proven first steps stuck hands falsework"

    @property
    def first(self) -> tuple[str, ...]:
        """The names of the bodies that must stand before the first step."""
        return tuple(body.name for body in self.assembly.movable if body.name not in self.order)

    @cached_property
    def force(self) -> Float:
        """The smallest push (n,) [N] that moves something after each step; nan where it is not known."""
        points = [step.weakest for step in self.steps]
        return frozen(np.array([p.force if p and p.status is not Status.UNDECIDED else NOTHING for p in points]))

    @property
    def least(self) -> BuildStep | None:
        """The step after which the smallest push moves something; None if no push is decided."""
        known = [step for step, force in zip(self.steps, self.force, strict=True) if not np.isnan(force)]
        return min(known, key=lambda step: step.weakest.force if step.weakest else np.inf, default=None)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; a force that is not known is None there."""
        force = [None if np.isnan(each) else to_dict(each) for each in self.force]
        return super().to_dict() | {"force": force}

    def summary(self) -> Summary:
        """Summarise the order by its steps and the smallest push that moves something after each."""
        whole = len(self.assembly.movable)
        headline = f"{len(self.steps)} of {whole} bodies go in one by one: {listed(self.order[:SHOWN], SHOWN)}"
        least = self.least
        if least is not None and least.weakest is not None:
            headline += f"; the least push {number(least.weakest.force, 'N')}, after {least.body}"
        facts = [("engine", f"{self.engine} ({self.claim.words})")]
        facts += [("must stand before", listed(self.first))] if self.first else []
        facts += [("falsework", f"props under {listed(self.falsework)}")] if self.falsework else []
        rows = [
            [str(k + 1), step.body, shown(step), *handled(step.holds, self.hands), step.reason]
            for k, step in enumerate(self.steps)
        ]
        heads = ("step", "put in", "least push then", *hands_column(self.hands), "why it may go in")
        return Summary(headline, facts, heads, rows)


def shown(step: BuildStep) -> str:
    """Return the smallest push that moves something after a step, as text."""
    return "" if step.weakest is None else amount(step.weakest.status, step.weakest.force, "N")


class Placings(Removals):
    """The answers to whether a body may be put in last, for any state of the building, in terms of removals."""

    def released(self, name: str, part: frozenset[str]) -> Removal:
        """Answer SAFE for a body that is set down from above: nothing can come along with it."""
        upright = self.lift @ self.up > 1 - 1e-9
        return Removal(name, Answer.SAFE, SAFE) if upright else super().released(name, part)


def build_order(
    assembly: Assembly | Scene,
    *,
    lift: ArrayLike = (0.0, 0.0, 1.0),
    pushes: int = PUSHES,
    solves: int = SOLVES,
    hands: int = 0,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> BuildOrder:
    """Find an order in which all bodies can be put in along minus ``lift`` (3,), one by one, each state standing.

    A body may be put in if its straight way in is free of the bodies already in place, and if everything stands with it
    and while its weight is set down. Each state is pushed at about ``pushes`` points of its exposed surfaces, to find
    the smallest push that moves something; 0 skips that. ``solves`` limits the number of states that are checked by
    contact forces.

    So many ``hands``, beside the gripper that puts bodies in, may hold others where they are. ``holds`` of each step
    names what they hold, and the least force and moment that this takes. If they are too few, an order is sought with
    props under one or two bodies besides, the ``falsework``. If anything is held, no state is pushed.

    Raises UnstableError (a SceneError) if the assembly does not stand, and SolverError with the verdict if this is
    undecided.
    """
    assembly = checked_assembly(assembly)
    checked_whole(pushes, "build_order: pushes", 0, MANY)
    placings = Placings(assembly, engine_of(engine), checked_direction(lift, "build_order: lift"))
    plan, props = planned(placings, frozenset(), solves, hands, "build_order")
    pushes = pushes if props is None else 0
    steps = plan.steps[::-1]
    there = frozenset(placings.names) - {step.body for step in steps}
    stuck = tuple(placings.answer(name, there, exit_first=False) for name in placings.names if name in there)
    weakest = WeakestPoints(placings.engine, pushes)
    made = []
    for step in reported("states of the building", steps):
        there |= {step.body}
        point = weakest.after(placings.reduced(there), step.body) if pushes else None
        made.append(BuildStep(step.body, step.reason, step.hold, point, step.holds))
    return BuildOrder(
        assembly=assembly,
        method=placings.engine,
        lift=placings.lift,
        steps=tuple(made),
        reached=plan.reached and not props,
        proven=plan.proven,
        stuck=stuck,
        hands=hands,
        falsework=props or (),
    )


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
        pairs = (interface.bodies for interface in state.interfaces if name in interface.bodies)
        others = dict.fromkeys(b if a == name else a for a, b in pairs)
        near = [name, *(other for other in others if state.index[other] != FIXED)]
        spacing = spacing_for(state, [body.name for body in state.movable], self.pushes)
        groups = prepared(self.engine, state)
        for each in near:
            self._known.pop(each, None)
        for each in near:
            self._known[each] = _pushed(groups, each, spacing, self._least)
        for each, known in list(self._known.items()):
            if not known.settled and known.force < CLOSE * self._least:  # it may be the weakest now
                self._known[each] = _pushed(groups, each, spacing, self._least)
        points = [known.point for known in self._known.values() if known.point is not None]
        return min(points, key=_rank, default=None)

    @property
    def _least(self) -> float:
        """The smallest push [N] that is known to move something; inf if there is none."""
        found = (known.point for known in self._known.values())
        return min((p.force for p in found if p is not None and p.status is not Status.UNDECIDED), default=np.inf)


def _pushed(groups: Groups, name: str, spacing: float, least: float) -> _Known:
    """Find the weakest push on a body, or show that none is much weaker than ``least`` [N].

    Pushes with a long lever arm about the centre of mass come first, since they turn the body. If no push can be
    excluded by a short load path, all are answered at once.
    """
    cells = exposed_cells(groups.assembly, name, spacing)[0]
    number = groups.assembly.index[name]
    columns = push_columns(groups.assembly, number, cells.points, -cells.normals)
    arm = np.linalg.norm(columns[6 * number + 3 : 6 * number + 6], axis=0)
    rows = np.argsort(-arm, kind="stable")
    points: list[MapPoint] = []
    screened = np.inf
    while len(rows):
        several = 1
        if least < screened:
            moves_nothing = groups.held(CLOSE * least * columns[:, rows])
            rows, screened, several = rows[~moves_nothing], least, 1 if moves_nothing.any() else len(rows)
        answers = groups.load_factor(columns[:, rows[:several]])
        points += [
            map_point(answers, k, name, cells.points[row], cells.normals[row]) for k, row in enumerate(rows[:several])
        ]
        least = min([least, *(p.force for p in points if p.status is not Status.UNDECIDED)])
        rows = rows[several:]
    return _Known(CLOSE * least, min(points, key=_rank, default=None))


def _rank(point: MapPoint) -> tuple[bool, float]:
    return point.status is Status.UNDECIDED, point.force
