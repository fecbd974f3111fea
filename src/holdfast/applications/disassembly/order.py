"""Decide whether one body may be taken out, and find an order in which an assembly can be taken apart, body by body."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.disassembly.hands import Hands, held_still, propped
from holdfast.applications.disassembly.least_hold import handled, hands_column
from holdfast.applications.disassembly.order_search import Plan, everything, fewest
from holdfast.applications.disassembly.removal import WHOLE, Answer, Removal, Removals, gives_way_in
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, checked_direction, checked_items, checked_whole
from holdfast.base.errors import HoldfastError, SceneError, SolverError, UnstableError, message
from holdfast.base.public import Of, Pictured, PublicValue, Record, Summary, column, number
from holdfast.base.ranges import MANY
from holdfast.base.text import listed, quoted
from holdfast.certificates.certified import CertifiedStates, asking
from holdfast.certificates.question import Question
from holdfast.engines.answers import Claim, Undecided
from holdfast.engines.contract import FORCES_ONLY, Engine
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, body_number, checked_assembly, engine_of
from holdfast.scene.scene import Scene

HANDS = ("hands", "falsework")
SHOWN = 8  # largest number of body names in one line
SOLVES = 2000  # number of checks by contact forces after which a search stops


class PaperRow(Record):
    """The paper's test of one body (Sec. VII-C), which compares R with the body's weight.

    ``force`` [N] is R at the centre of mass, upwards, or None if R is undecided, and ``weight`` [N] is the body's
    weight. The paper calls a body removable if the two are equal. Every voussoir of an arch passes this unsafe test, so
    the table is for information only.
    """

    body: str
    force: float | None
    weight: float
    removable: bool


class StepByStep(CertifiedStates, PublicValue):
    """An order of ``steps``, each of which concerns one ``body`` and what hands hold then."""

    assembly: Assembly
    method: Engine
    lift: Float = column("3")
    steps: tuple[Any, ...]
    reached: bool
    proven: bool
    hands: int = 0
    falsework: tuple[str, ...] = ()

    builds: ClassVar[bool] = False  # bodies are put in, not taken out
    engine = Of[str]("method.name", "The name of the engine.")
    claim = Of[Claim]("method.claim", "What the engine promises about its answers.")

    @property
    def order(self) -> tuple[str, ...]:
        """The names of the bodies, step by step."""
        return tuple(step.body for step in self.steps)

    @property
    def questions(self) -> tuple[Question, ...]:
        """What a certificate proves: that everything stands before the first step, and after each.

        What hands hold is fixed there.
        """
        every = range(len(self.order) + 1)
        gone = [self.order[k:] if self.builds else self.order[:k] for k in every]
        held = [frozenset(hold.body for hold in step.holds) for step in self.steps]
        held.insert(len(held) if self.builds else 0, frozenset())
        return tuple(Question.of(held_still(self.assembly.without(gone[k]), held[k])) for k in every)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; without hands, nothing is told of them."""
        data = {"scene": self.assembly.scene.name} | super().to_dict()
        return data if self.hands else {name: item for name, item in data.items() if name not in HANDS}


class Disassembly(Pictured, StepByStep, ask=".reached, which says whether everything comes out"):
    """An order in which bodies can be taken out of ``assembly``.

    ``order`` names the bodies in turn, and ``steps`` holds the answer for each of them with its reason. ``reached``
    says whether everything, or the ``goal``, is taken out. If not, ``remaining`` names the bodies that stay, and
    ``blocked`` says which of them cannot be removed next, and why. ``undecided`` counts the undecided ones.

    ``proven`` means that no order is better: with a goal, none takes fewer removals; without a goal, none takes out
    everything unless this one does. ``fewest`` is a lower bound on the number of removals of any order. ``lift`` (3,)
    is the unit direction in which bodies leave, world frame. ``method`` is the engine that answered, and ``engine`` is
    its name. ``hands`` is how many hands could hold bodies, and ``falsework`` names those that have to be propped
    besides; only if there are none is the order one for these hands, and ``reached`` may be true.

    Its picture shows every state with the next body in colour; of a long order, only every n-th.
    """

    goal: tuple[str, ...]
    steps: tuple[Removal, ...]
    fewest: float

    plain = "engine claim lift goal order assembly_order reached proven fewest blocked hands falsework undecided steps"

    @cached_property
    def removals(self) -> Removals:
        """The answers for the bodies in any state of the assembly, with those of the search in a cache.

        The cache does not travel to a file or to another process.
        """
        return Removals(self.assembly, self.method, self.lift)

    @property
    def assembly_order(self) -> tuple[str, ...]:
        """The order reversed, in which the bodies can be put together again."""
        return self.order[::-1]

    @property
    def remaining(self) -> tuple[str, ...]:
        """The names of the bodies that are not taken out."""
        return tuple(name for name in self.removals.names if name not in self.order)

    @cached_property
    def stuck(self) -> tuple[Removal, ...]:
        """The answers for the remaining bodies that cannot be removed next; empty if ``reached``."""
        if self.reached:
            return ()
        return tuple(removal for removal in self.answers(len(self.steps)) if removal.answer is not Answer.SAFE)

    @property
    def blocked(self) -> dict[str, str]:
        """The remaining bodies that cannot be removed next, each with the reason; empty if ``reached``."""
        return {removal.body: removal.reason for removal in self.stuck}

    @property
    def undecided(self) -> Undecided:
        """How many of the remaining bodies are undecided, and why."""
        unknown = [removal for removal in self.stuck if removal.answer is Answer.UNDECIDED]
        reasons = tuple(f"{removal.body}: {removal.reason}" for removal in unknown)
        return Undecided(count=len(unknown), rows=len(self.remaining), reasons=reasons)

    def answers(self, step: int = 0) -> tuple[Removal, ...]:
        """Return the answer for every body that is present before ``step``, with all reasons against its removal.

        Raises HoldfastError if there is no such step.
        """
        left = self._before(step)
        return tuple(self.removals.answer(name, left, exit_first=False) for name in self.removals.names if name in left)

    def paper_table(self, step: int = 0) -> tuple[PaperRow, ...]:
        """Return the paper's table for the bodies that are present before ``step``; see PaperRow.

        Raises HoldfastError if there is no such step.
        """
        rows = {name: self._paper_row(name, part) for part in self.removals.parts(self._before(step)) for name in part}
        return tuple(rows[name] for name in self.removals.names if name in rows)

    def summary(self) -> Summary:
        """Summarise the answer by its steps in order."""
        whole = len(self.assembly.movable)
        headline = f"{len(self.steps)} of {whole} bodies come out: {listed(self.order[:SHOWN], SHOWN)}"
        if self.undecided.count:
            headline += f"; of the remaining bodies, {self.undecided.text}"
        outcome = f"reached {self.reached}, proven {self.proven}, at least {number(self.fewest)} removals"
        facts = [("engine", f"{self.engine} ({self.claim.words})"), ("outcome", outcome)]
        facts += [("falsework", f"props under {listed(self.falsework)}")] if self.falsework else []
        rows = [
            [str(k + 1), step.body, *handled(step.holds, self.hands), step.reason] for k, step in enumerate(self.steps)
        ]
        return Summary(headline, facts, ("step", "take out", *hands_column(self.hands), "why it may go"), rows)

    def _paper_row(self, name: str, part: frozenset[str]) -> PaperRow:
        column = self.removals.force(name, part, self.removals.up)
        weight = float(np.linalg.norm(column))
        found = self.removals.state(part).load_factor(column[:, None], FORCES_ONLY)
        if found.undecided.count:
            return PaperRow(name, None, weight, removable=False)
        factor = float(found.force[0])
        return PaperRow(name, factor * weight, weight, abs(factor - 1) <= WHOLE)

    def _before(self, step: int) -> frozenset[str]:
        """Return the bodies that are present before a step."""
        number = checked_whole(step, "disassembly: step", 0, len(self.steps), HoldfastError)
        return frozenset(self.removals.names) - set(self.order[:number])


def disassembly_order(
    assembly: Assembly | Scene,
    *,
    lift: ArrayLike = (0.0, 0.0, 1.0),
    goal: str | Iterable[str] | None = None,
    solves: int = SOLVES,
    hands: int = 0,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> Disassembly:
    """Find an order in which bodies can be lifted out along ``lift`` (3,), one by one, while the others stand.

    A body may be taken out if four conditions hold: its straight way out is free of all other bodies; the others stand
    without it; nothing else moves while its weight is taken; and nothing comes along with it. With a ``goal``, the
    bodies that it names are taken out with the fewest removals; without one, all movable bodies are taken out.
    ``solves`` limits the number of states that are checked by contact forces.

    So many ``hands``, beside the gripper that takes bodies out, may hold others where they are. ``holds`` of each step
    names what they hold from then on, and the least force and moment that this takes. If they are too few, an order is
    sought with props under one or two bodies besides, the ``falsework``. Orders with hands need not be the shortest.

    Raises UnstableError (a SceneError) if the assembly does not stand, and SolverError with the verdict if this is
    undecided. Raises SceneError if the goal is empty, unknown or fixed.
    """
    assembly = checked_assembly(assembly)
    goals = _goals(assembly, goal)
    removals = Removals(assembly, engine_of(engine), checked_direction(lift, "disassembly_order: lift"))
    plan, props = planned(removals, frozenset(goals), solves, hands, "disassembly_order")
    found = Disassembly(
        assembly=assembly,
        method=removals.engine,
        lift=removals.lift,
        goal=goals,
        steps=plan.steps,
        reached=plan.reached and not props,
        proven=plan.proven,
        fewest=plan.bound,
        hands=hands,
        falsework=props or (),
    )
    vars(found)["removals"] = removals  # fills the cached property, so that nothing is computed twice
    return found


def _goals(assembly: Assembly, goal: str | Iterable[str] | None) -> tuple[str, ...]:
    if goal is None:
        return ()
    if not isinstance(goal, Iterable):
        raise SceneError(message("disassembly_order: goal", f"got {quoted(goal)}", "needs names of bodies"))
    names = (goal,) if isinstance(goal, str) else tuple(checked_items(goal, "disassembly_order: goal", "names"))
    if not names:
        raise SceneError(message("disassembly_order: goal", "is empty", "name bodies, or leave it out for all"))
    for name in names:
        if assembly.scene.body(name).fixed:
            raise SceneError(
                message("disassembly_order: goal", f"{quoted(name)} is fixed", "name bodies that can move")
            )
    return tuple(dict.fromkeys(names))


def planned(
    removals: Removals, goals: frozenset[str], solves: int, hands: int, where: str
) -> tuple[Plan, tuple[str, ...] | None]:
    """Return an order in which the ``goals``, or all, come out, and the bodies to prop; None if it needs no hands.

    Raises UnstableError if the whole assembly does not stand, SolverError if that is undecided, and HoldfastError, with
    ``where`` in its message, for limits out of range.
    """
    checked_whole(solves, f"{where}: solves", 0, MANY)
    checked_whole(hands, f"{where}: hands", 0, len(removals.names))
    for part in [*removals.parts(removals.names), frozenset(removals.names)]:  # several may lie on one fixed body
        verdict = removals.verdict(part)
        scene = f"scene {removals.assembly.scene.name!r}"
        if verdict.status is Status.UNSTABLE:
            problem = f"does not stand ({verdict.reason})"
            raise UnstableError(message(scene, problem, "only what stands can be taken apart"))
        if verdict.status is Status.UNDECIDED:
            problem = f"is undecided ({verdict.reason})"
            raise SolverError(message(scene, problem, "only what stands for certain can be taken apart"))
    plan = fewest(removals, goals, solves) if goals else everything(removals, solves)
    return propped(removals, hands, goals, solves) if hands and not plan.reached else (plan, None)


def can_remove(
    assembly: Assembly | Scene,
    body: str,
    *,
    lift: ArrayLike = (0.0, 0.0, 1.0),
    hands: int = 0,
    engine: EngineChoice = DEFAULT_ENGINE,
) -> Removal:
    """Decide whether ``body`` may be taken out now, along the direction ``lift`` (3,), while all others stay.

    It may (``safe``) if four conditions hold: its straight way out is free of all other bodies; the others stand
    without it; nothing else moves while its weight is taken; and nothing comes along with it. If it may not, ``moving``
    names the bodies that would move and ``blockers`` those in the way. What is not known is undecided, with the reason.
    If it may not although its way out is free, up to so many ``hands`` are tried at other bodies: ``holds`` of the
    answer says which of them to hold, and with which least force and moment, so that it may.

    Apart from the way out, only the body's own group counts: the movable bodies that touch it directly or through
    others. If that group does not stand in the first place, the body may not be taken out. Raises SceneError if the
    body is fixed or unknown.
    """
    assembly = checked_assembly(assembly)
    if body_number(assembly, body) == FIXED:
        raise SceneError(message(f"removal of {quoted(body)}", "the body is fixed", "name a movable body"))
    checked_whole(hands, "can_remove: hands", 0, len(assembly.movable))
    removals = Removals(assembly, engine_of(engine), checked_direction(lift, "can_remove: lift"))
    whole = frozenset(removals.names)
    part = removals.part_of(body, whole)
    states = [Question.of(removals.reduced(names)) for names in (part, part - {body})]
    return asking(_answer(removals, body, whole, hands), *states)


def _answer(removals: Removals, body: str, whole: frozenset[str], hands: int) -> Removal:
    verdict = removals.verdict(removals.part_of(body, whole))
    blockers = removals.exits.blockers(body, whole)
    if verdict.status is Status.UNSTABLE:
        moving, what = gives_way_in([verdict])
        reason = f"it does not stand as it is: {what}"
        return Removal(body, Answer.UNSAFE, reason, blockers=blockers, moving=moving)
    if verdict.status is Status.UNDECIDED and not blockers:
        return Removal(body, Answer.UNDECIDED, f"whether it stands as it is: {verdict.reason}")
    found = removals.answer(body, whole, exit_first=False)
    if found.answer is Answer.SAFE or blockers or not hands:
        return found
    holds = Hands(removals).remedy(body, whole, hands)
    reason = f"{found.reason}; it may with hands: {listed([hold.text for hold in holds])}" if holds else found.reason
    return replace(found, holds=holds, reason=reason)
