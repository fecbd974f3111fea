"""Orders with hands: bodies are taken out or put in one by one, while up to k hands hold others where they are.

A body that is held counts as fixed. Between two steps, hands may let go and take hold of other bodies while the gripper
that moves a body still holds that one: what stands then is held by the hands that stay and by the gripper.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from holdfast.applications.disassembly.least_hold import HandHold, least_holds
from holdfast.applications.disassembly.order_search import Plan, depth_first, from_the_top
from holdfast.applications.disassembly.removal import SHARES, Answer, Removal, Removals, pressing_on
from holdfast.assembly.assembly import Assembly
from holdfast.engines.answers import Claim
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.queries.lower_bounds import verdict_on_bearing
from holdfast.scene.hold import holds_among

MOST_TRIED = 8  # bodies that hands are tried at in one step: those held already, the neighbours, those that would move
PROPS = 2  # bodies that falsework is tried for beside the hands
GRIPPED = "the rest stands; the gripper has to hold it all the time, for it would move by itself"

State = frozenset[str]


def held_still(assembly: Assembly, names: State) -> Assembly:
    """Return the assembly with some bodies fixed where they are."""
    if not names:
        return assembly
    scene = assembly.scene
    bodies = tuple(replace(body, fixed=True) if body.name in names else body for body in scene.bodies)
    fixed = {body.name for body in bodies if body.fixed}
    still = replace(scene, bodies=bodies, holds=holds_among(scene.holds, scene.names - fixed, fixed))
    kept = tuple(one for one in assembly.interfaces if not fixed.issuperset(one.bodies))
    return replace(assembly, scene=still, interfaces=kept)


class Move(NamedTuple):
    """One removal, and which bodies are held from then on."""

    removal: Removal
    after: State


class Hands:
    """The answers for bodies of one assembly in any state of its disassembly, with any bodies held."""

    def __init__(self, plain: Removals) -> None:
        self.plain = plain
        self.checks = 0
        self._held: dict[State, Removals] = {frozenset(): plain}
        self._stands: dict[tuple[State, State], bool] = {}

    def removals(self, bodies: State) -> Removals:
        """Return the answers with these bodies held, for all states in which they are present."""
        if bodies not in self._held:
            removals = type(self.plain)(held_still(self.plain.assembly, bodies), self.plain.engine, self.plain.lift)
            removals.exits = self.plain.exits
            self._held[bodies] = removals
        return self._held[bodies]

    def stands(self, present: State, held: State) -> bool:
        """Tell whether the bodies ``present`` certainly stand while some of them are held."""
        key = present, held
        if key not in self._stands:
            self.checks += 1
            removals = self.removals(held)
            parts = removals.parts(present - held)
            self._stands[key] = all(removals.verdict(part).status is Status.STABLE for part in parts)
        return self._stands[key]

    def removal(self, name: str, present: State, before: State, after: State) -> Removal:
        """Decide whether a body may be taken out, if hands hold ``before`` until then and ``after`` from then on."""
        unsafe = Removal(name, Answer.UNSAFE, "it takes more hands")
        if self.plain.exits.blockers(name, present) or not self.stands(present - {name}, after):
            return unsafe
        if not before <= after and not self.stands(present, (before & after) | {name}):
            return unsafe
        removals = self.removals(after)
        if self.stands(present, after):
            found = removals.by_forces(name, present - after)
            if found.answer is Answer.SAFE:
                return found
        if not self.stands(present, after | {name}) or not self._fades(name, present, after):
            return unsafe
        found = removals.released(name, removals.part_of(name, present - after))
        return Removal(name, Answer.SAFE, GRIPPED, hold=True) if found.answer is Answer.SAFE else found

    def remedy(self, name: str, present: State, hands: int) -> tuple[HandHold, ...]:
        """Return what up to so many ``hands`` have to hold so that a body may be taken out; nothing if that is unknown.

        Nothing is held before.
        """
        for held in self.choices(name, present, frozenset(), hands):
            if held and self.removal(name, present, frozenset(), held).answer is Answer.SAFE:
                return self.least(present - {name}, held)
        return ()

    def _fades(self, name: str, present: State, held: State) -> bool:
        """Tell whether all stands while the contact forces of a body that the gripper holds decrease in proportion.

        Where only the existence of an equilibrium is asked for, it does, because it stands at both ends.
        """
        if self.plain.engine.claim is not Claim.HOLDS:
            return True
        gripped, removals = self.removals(held | {name}), self.removals(held)
        for part in gripped.parts(present - held - {name}):
            whole, forces = gripped.reduced(part), gripped.verdict(part).forces
            if forces is None:
                return False
            rest = removals.reduced(part)
            load = pressing_on(rest, name, whole, forces)
            states = (prepared(self.plain.engine, rest, (1 - share) * load) for share in SHARES)
            if any(verdict_on_bearing(state).status is not Status.STABLE for state in states):
                return False
        return True

    def least(self, present: State, held: State) -> tuple[HandHold, ...]:
        """Return the least holds of the bodies that are held, in a state that stands with them."""
        names = [name for name in self.plain.names if name in held]
        return least_holds(self.plain.reduced(present), names) or ()

    def choices(self, name: str, present: State, before: State, hands: int) -> Iterator[State]:
        """Yield sets of bodies to hold once a body is gone: as few as can be, those first that would move first."""
        rest = present - {name}
        moving = [
            mover
            for part in self.plain.parts(rest)
            if (mechanism := self.plain.verdict(part).mechanism) is not None
            for mover in mechanism.moving
        ]
        wanted = dict.fromkeys([*sorted(before), *self.plain.beside[name], *moving])
        tried = [each for each in wanted if each in rest][:MOST_TRIED]
        for count in range(min(hands, len(tried)) + 1):
            yield from map(frozenset, itertools.combinations(tried, count))


def with_hands(plain: Removals, hands: int, goals: State, budget: int) -> Plan:
    """Take bodies out one by one with up to ``hands`` hands, the highest first, until all or the ``goals`` are out.

    The search is depth-first and remembers dead ends. It stops after ``budget`` states were checked.
    """
    states, order, whole = Hands(plain), from_the_top(plain), frozenset(plain.names)
    wanted, dead = goals or whole, set[tuple[State, State]]()

    def left(taken: tuple[Move, ...]) -> State:
        return whole - {move.removal.body for move in taken}

    def moves(taken: tuple[Move, ...]) -> Iterator[Move]:
        present, before = left(taken), taken[-1].after if taken else frozenset[str]()
        if not wanted & present:
            return
        last = plain.beside[taken[-1].removal.body] if taken else ()
        for name in sorted(order, key=lambda name: name not in last):  # beside the last one, hands stay where they are
            if name not in present or plain.exits.blockers(name, present):
                continue
            for after in states.choices(name, present, before, hands):
                if states.checks >= budget:
                    return
                if (present - {name}, after) not in dead:
                    removal = states.removal(name, present, before, after)
                    if removal.answer is Answer.SAFE:
                        yield Move(removal, after)
        dead.add((present, before))

    longest: tuple[Move, ...] = ()
    for taken in depth_first(moves, len(whole)):
        reached = not wanted & left(taken)
        longest = taken if reached else max(longest, taken, key=len)
        if reached:
            break
    steps = tuple(  # with the least holds of what is held once each is done
        replace(move.removal, holds=states.least(left(longest[: k + 1]), move.after)) for k, move in enumerate(longest)
    )
    return Plan(steps, reached, reached and not goals, float(len(wanted)))


def propped(plain: Removals, hands: int, goals: State, budget: int) -> tuple[Plan, tuple[str, ...]]:
    """Return the order that ``with_hands`` finds; if it finds none, one with falsework, and the bodies it props.

    As few bodies are propped as suffice, and each of them in all steps in which it is held.
    """
    first = with_hands(plain, hands, goals, budget)
    if first.reached:
        return first, ()
    for more in range(1, PROPS + 1):
        plan = with_hands(plain, hands + more, goals, budget)
        if plan.reached:
            held = [{hold.body for hold in step.holds} for step in plan.steps]
            props = set[str]()  # at most ``hands`` others are held at any time; those that are held longest come first
            while short := [names - props for names in held if len(names - props) > hands]:
                each = sorted(set().union(*short))
                props.add(max(each, key=lambda name: sum(name in names for names in short)))
            marked = (tuple(replace(hold, prop=hold.body in props) for hold in step.holds) for step in plan.steps)
            steps = tuple(replace(step, holds=holds) for step, holds in zip(plan.steps, marked, strict=True))
            return replace(plan, steps=steps, proven=False), tuple(sorted(props))
    return first, ()
