"""Find an order in which an assembly can be built, body by body, with everything standing after each step.

Bodies are put in from the top, so a build order is an order of removals reversed, with one condition fewer: neighbours
that could clamp a body while it is pulled out do not matter while it is set down. The search is that of disassembly
(order_search.py).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.disassembly.hands import held_still, propped
from holdfast.applications.disassembly.least_hold import HandHold, handled, hands_column
from holdfast.applications.disassembly.order import SHOWN, SOLVES, StepByStep, check_stands
from holdfast.applications.disassembly.order_search import everything
from holdfast.applications.disassembly.removal import Answer, Removal, Removals
from holdfast.applications.disassembly.weakest import WeakestPoints
from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Float, checked_direction, checked_whole
from holdfast.base.progress import reported
from holdfast.base.public import Record, Summary, number
from holdfast.base.ranges import MANY
from holdfast.base.text import listed
from holdfast.certificates.question import Question
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.queries.result import amount
from holdfast.scene.scene import Scene

PUSHES = 200  # approximate number of points on all bodies of a state
NOTHING = float("nan")
SAFE = "everything stands with it, and while its weight is set down"


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

    plain = "engine claim lift order reached proven first steps stuck hands falsework"

    @property
    def first(self) -> tuple[str, ...]:
        """The names of the bodies that must stand before the first step."""
        return tuple(body.name for body in self.assembly.movable if body.name not in self.order)

    @property
    def questions(self) -> tuple[Question, ...]:
        """What a certificate proves: that everything stands before the first step, and after each.

        What hands hold is fixed there.
        """
        states = [self.assembly.without(set(self.order[k:])) for k in range(len(self.order) + 1)]
        held = [frozenset(hold.body for hold in step.holds) for step in self.steps]
        return tuple(Question.of(held_still(*each)) for each in zip(states, [*held, frozenset[str]()], strict=True))

    @cached_property
    def force(self) -> Float:
        """The smallest push (n,) [N] that moves something after each step; nan where it is not known."""
        known = [NOTHING if step.weakest is None else _known(step.weakest) for step in self.steps]
        found = np.array(known, dtype=np.float64)
        found.setflags(write=False)
        return found

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


def _known(point: MapPoint) -> float:
    return NOTHING if point.status is Status.UNDECIDED else point.force


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
    method = engine_of(engine)
    checked_whole(solves, "build_order: solves", 0, MANY)
    checked_whole(pushes, "build_order: pushes", 0, MANY)
    checked_whole(hands, "build_order: hands", 0, len(assembly.movable))
    direction = checked_direction(lift, "build_order: lift")
    placings = Placings(assembly, method, direction)
    check_stands(placings)
    props: tuple[str, ...] = ()
    plan = everything(placings, solves)
    if hands and not plan.reached:
        plan, props = propped(placings, hands, frozenset(), solves)
        pushes = 0
    steps = plan.steps[::-1]
    there = frozenset(placings.names) - {step.body for step in steps}
    stuck = tuple(placings.answer(name, there, exit_first=False) for name in placings.names if name in there)
    weakest = WeakestPoints(method, pushes)
    made = []
    for step in reported("states of the building", steps):
        there |= {step.body}
        point = weakest.after(placings.reduced(there), step.body) if pushes else None
        made.append(BuildStep(step.body, step.reason, step.hold, point, step.holds))
    return BuildOrder(
        assembly=assembly,
        method=method,
        lift=direction,
        steps=tuple(made),
        reached=plan.reached and not props,
        proven=plan.proven,
        stuck=stuck,
        hands=hands,
        falsework=props,
    )
