"""Decide for a body in any state of an assembly whether it may be taken out while the others stand and do not move.

The gripper holds the body at its centre of mass. Its force rises from 0 to the body's weight, against gravity, and then
pulls along the lift direction. Let the contact forces f balance the assembly, and let f' balance the rest without the
body. When the share s of the weight is taken, the forces (1-s) f + s f' are an equilibrium, because friction cones are
convex and the contact forces of the body fade in proportion. So if both ends stand, an equilibrium exists all the way.
Where an engine claims more than existence, it is asked at points along the way. Where the contacts could clamp the
body, it is asked what moves when the body comes off.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable
from dataclasses import KW_ONLY, replace
from enum import StrEnum, auto
from functools import cached_property
from typing import TypeVar

import numpy as np

from holdfast.applications.disassembly.least_hold import HandHold
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.archive import archived
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, message, no_truth
from holdfast.base.public import PublicValue, Summary
from holdfast.base.rigid import wrench_at
from holdfast.base.text import listed
from holdfast.certificates.certified import CertifiedStates
from holdfast.contacts.neighbours import components
from holdfast.engines.answers import Claim
from holdfast.engines.contract import FORCES_ONLY, RELEASES, Engine
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.verdict import ContactForces, Status, Verdict
from holdfast.geometry.sweep import Swept, hit_distance
from holdfast.queries.lower_bounds import verdict_on_bearing
from holdfast.queries.request import CERTAIN_ENGINE, engine_of
from holdfast.queries.result import vector_text
from holdfast.scene.hold import hold_ends

T = TypeVar("T")

WHOLE = 1e-3  # relative tolerance: a lift this close to the weight takes all of it
# Share of the weight that the gripper takes before a pull that is not upward. With all of it, no contact force would
# remain, and what the pull moves would be undefined.
TAKEN = 0.9
SHARES = (0.3, 0.6, 0.9)  # shares of the weight at which stability is checked along the way
SAFE = "the rest stands without it and while its weight is taken"  # the reason of a SAFE answer
CACHED = 8  # largest number of prepared states in memory


class Exits:
    """The obstacles on each body's straight way out along the unit vector ``direction`` (3,), with their distances [m].

    Bodies stay in place until they are taken out, so each pair is checked only once. Two surfaces may overlap by the
    contact tolerance of their pair, so a wall along which a body slides is not an obstacle.
    """

    def __init__(self, assembly: Assembly, direction: Float) -> None:
        self.assembly, self.direction = assembly, direction
        self._found: dict[str, tuple[tuple[str, float], ...]] = {}

    @cached_property
    def _swept(self) -> dict[str, Swept]:
        return {body.name: Swept(body.reduced_world, self.direction) for body in self.assembly.bodies}

    @cached_property
    def _boxes(self) -> tuple[Float, Float]:
        """The lowest and highest coordinates (n, 3) [m] of all bodies, across and along the direction."""
        swept = self._swept.values()
        return np.array([s.low for s in swept]), np.array([s.high for s in swept])

    def in_the_way(self, name: str) -> tuple[tuple[str, float], ...]:
        """Return all bodies that ``name`` would hit on its way out, each with its distance [m], the nearest first."""
        if name not in self._found:
            bodies, index = self.assembly.bodies, list(self._swept).index(name)
            low, high = self._boxes
            beside = ((low[:, :2] < high[index, :2]) & (low[index, :2] < high[:, :2])).all(1)
            ahead = high[:, 2] >= low[index, 2] - self.assembly.tolerances.widest(self.assembly.scene)
            found = []
            for k in np.flatnonzero(beside & ahead).tolist():
                if k != index:
                    tolerance = self.assembly.tolerances.between(bodies[index], bodies[k]).depth
                    distance = hit_distance(self._swept[name], self._swept[bodies[k].name], tolerance)
                    if np.isfinite(distance):
                        found.append((bodies[k].name, distance))
            self._found[name] = tuple(sorted(found, key=lambda hit: hit[1]))
        return self._found[name]

    def blockers(self, name: str, remaining: Collection[str]) -> tuple[tuple[str, float], ...]:
        """Return those of the bodies ``in_the_way`` that are fixed or among ``remaining``."""
        index = self.assembly.index
        return tuple(hit for hit in self.in_the_way(name) if hit[0] in remaining or index[hit[0]] == FIXED)


@archived
class Answer(StrEnum):
    """The answer to whether a body may be taken out now."""

    SAFE = auto()
    UNSAFE = auto()
    UNDECIDED = auto()

    def __bool__(self) -> bool:
        raise no_truth(self, f"compare it: answer == {self.value!r}")


class Removal(CertifiedStates, PublicValue, kw_only=False, ask=".safe or .answer"):
    """The answer for one body in one state of the assembly, with its ``reason`` in words.

    ``answer`` is SAFE, UNSAFE or UNDECIDED. ``blockers`` are the bodies on its straight way out, each with its distance
    [m]. ``moving`` names the other bodies that fall without it or move while it is taken out, as far as their first
    motion shows.

    ``lift`` is the upward force at the body's centre of mass, divided by its weight, at which the body comes off or
    another body moves. It is inf if neither happens, and 0 if the answer was known without it.
    ``hold`` means that the body must also be held against turning: if it were lifted only at its centre of mass, it
    would move before its weight is taken. ``holds`` are the other bodies that hands hold while it is taken out and
    afterwards, each with the least force and moment that this takes once it is gone. They are part of a SAFE answer in
    an order with hands; where ``can_remove`` finds a body not SAFE, it would be with them.
    """

    body: str
    answer: Answer
    reason: str
    _: KW_ONLY
    blockers: tuple[tuple[str, float], ...] = ()
    moving: tuple[str, ...] = ()
    lift: float = 0.0
    hold: bool = False
    holds: tuple[HandHold, ...] = ()

    @property
    def safe(self) -> bool:
        """Whether the body may certainly be taken out."""
        return self.answer is Answer.SAFE

    @property
    def falling(self) -> bool:
        """Whether a certificate has to prove that something falls."""
        return not self.safe

    def summary(self) -> Summary:
        """Summarise the answer by the bodies in the way and the bodies that would move."""
        facts = [("reason", self.reason)]
        facts += [("in the way", listed([name for name, _ in self.blockers]))] if self.blockers else []
        facts += [("would move", listed(self.moving))] if self.moving else []
        facts += [("hands", listed([hold.text for hold in self.holds]))] if self.holds else []
        return Summary(f"{self.body}: {self.answer}, {self.reason}", facts)


class Removals:
    """The answers for the bodies of one assembly in any state of its disassembly, with a cache.

    Bodies that are connected only through fixed bodies do not affect each other. So the bodies fall into independent
    parts, each with its own verdict and answers.
    """

    def __init__(self, assembly: Assembly, engine: Engine, lift: Float) -> None:
        refuse_joined(
            assembly, "removal", "leave out tension and cohesion: what it takes to tear bodies off is not told"
        )
        if any(FIXED not in ends for ends in hold_ends(assembly.scene.holds, assembly.index, FIXED)):
            problem = "something holds bodies on others, and what it takes to take these apart is not told"
            raise SceneError(message("removal", problem, "leave out holds with on="))
        self.assembly, self.engine, self.lift = assembly, engine, lift
        self.exits = Exits(assembly, lift)
        self._releases = RELEASES.of(engine_of(CERTAIN_ENGINE), engine=CERTAIN_ENGINE, where="disassembly")
        self.checks = 0  # number of checks by contact forces so far
        self._verdicts: dict[frozenset[str], Verdict] = {}
        self._states: OrderedDict[frozenset[str], Groups] = OrderedDict()
        self._reduced: OrderedDict[frozenset[str], Assembly] = OrderedDict()
        self._answers: dict[tuple[frozenset[str], str], Removal] = {}

    @property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return self.assembly.scene.up

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the bodies that can be taken out."""
        return tuple(body.name for body in self.assembly.movable)

    def answer(self, name: str, remaining: frozenset[str], *, exit_first: bool = True) -> Removal:
        """Decide whether ``name`` may be taken out while the bodies ``remaining``, which include it, are present.

        With ``exit_first``, a blocked way out is answered without a check by contact forces.
        """
        blockers = self.exits.blockers(name, remaining)
        if blockers and exit_first:
            return Removal(name, Answer.UNSAFE, self._blocked(blockers), blockers=blockers)
        found = self.by_forces(name, remaining)
        if not blockers:
            return found
        reason = self._blocked(blockers) + (f"; {found.reason}" if found.moving else "")
        return replace(found, answer=Answer.UNSAFE, reason=reason, blockers=blockers)

    def by_forces(self, name: str, remaining: frozenset[str]) -> Removal:
        """Decide by contact forces alone whether the others stand without ``name`` and while it is taken out."""
        part = self.part_of(name, remaining)
        if (part, name) not in self._answers:
            self.checks += 1
            self._answers[part, name] = self._judge(name, part)
        return self._answers[part, name]

    def parts(self, remaining: Collection[str]) -> list[frozenset[str]]:
        """Return the parts of the bodies ``remaining`` that do not affect each other."""
        names = [name for name in self.names if name in remaining]
        number = {name: k for k, name in enumerate(names)}
        whole = len(names)
        ends = [(number[a], number[b]) for a, b in self.joined if a in number and b in number]
        groups = components(whole, ends)
        return [frozenset(names[k] for k in group) for group in groups]

    def part_of(self, name: str, remaining: Collection[str]) -> frozenset[str]:
        """Return the part of the bodies ``remaining`` that contains ``name``."""
        return next(part for part in self.parts(remaining) if name in part)

    def verdict(self, part: frozenset[str]) -> Verdict:
        """Return the verdict on whether a part stands."""
        if part not in self._verdicts:
            self._verdicts[part] = verdict_on_bearing(self.state(part))
        return self._verdicts[part]

    def state(self, part: frozenset[str]) -> Groups:
        """Return the engine prepared for a part, from a cache."""
        return _cached(self._states, part, lambda: prepared(self.engine, self.reduced(part)))

    def reduced(self, part: frozenset[str]) -> Assembly:
        """Return the assembly of a part and the fixed bodies, from a cache."""
        gone = [name for name in self.names if name not in part]
        return _cached(self._reduced, part, lambda: self.assembly.without(gone))

    @cached_property
    def joined(self) -> list[tuple[str, str]]:
        """Pairs of bodies that touch, or that may touch once the bodies between them are gone."""
        return [*(i.bodies for i in self.assembly.interfaces), *self.assembly.occluded]

    @cached_property
    def beside(self) -> dict[str, list[str]]:
        """The bodies that each body is ``joined`` with."""
        found: dict[str, list[str]] = {body.name: [] for body in self.assembly.bodies}
        for a, b in self.joined:
            found[a].append(b)
            found[b].append(a)
        return found

    def _blocked(self, blockers: tuple[tuple[str, float], ...]) -> str:
        words = [f"{name} after {distance * 1e3:.3g} mm" if distance > 0 else name for name, distance in blockers]
        return f"its way out along {vector_text(self.lift)} is blocked: {listed(words)}"

    def _judge(self, name: str, part: frozenset[str]) -> Removal:
        """Decide by contact forces alone, first without the body and then while it is taken out."""
        verdicts = [self.verdict(rest) for rest in self.parts(part - {name})]
        falls = [verdict for verdict in verdicts if verdict.status is Status.UNSTABLE]
        if falls:
            moving, what = gives_way_in(falls)
            return Removal(name, Answer.UNSAFE, f"without it {what}", moving=moving)
        for verdict in verdicts:
            if verdict.status is Status.UNDECIDED:
                return Removal(name, Answer.UNDECIDED, f"whether the rest stands without it: {verdict.reason}")
        if self.engine.claim is Claim.HOLDS:  # may something move while its weight is taken upwards?
            assembly, weight = self.reduced(part), self.force(name, part, self.up)
            loads = ((f"with {share:.0%} of its weight taken", share * weight) for share in SHARES)
            found = self._under(name, assembly, loads)
            if found is not None:
                return self._held(name, part) if found.moving == (name,) else found
        return self.released(name, part)

    def released(self, name: str, part: frozenset[str]) -> Removal:
        """Decide whether anything comes along with a body whose weight is taken."""
        assembly = self.reduced(part)
        if self._releases.comes_loose(assembly, name, self.up):
            return Removal(name, Answer.SAFE, SAFE, lift=1.0)
        if self.engine.claim is Claim.EXISTS:  # equilibria may exist with and without clamping forces
            return Removal(name, Answer.UNDECIDED, "its neighbours could clamp it: engine 'compliant' can decide")
        return self._comes_off(name, part) if self.lift @ self.up > 1 - 1e-9 else self._pulled(name, part)

    def _comes_off(self, name: str, part: frozenset[str]) -> Removal:
        """Find what moves when the upward force grows beyond the body's weight."""
        answers = self.state(part).load_factor(self.force(name, part, self.up)[:, None], FORCES_ONLY)
        lift, others = float(answers.force[0]), tuple(n for n in answers.moving[0] if n != name)
        if answers.status[0] is Status.UNDECIDED:
            return Removal(name, Answer.UNDECIDED, "its neighbours could clamp it; whether they do was not found")
        if np.isinf(lift):
            return Removal(name, Answer.UNSAFE, "no lift at its centre of mass frees it", lift=lift)
        if others:
            when = f"lifted by {lift:.3g} times its weight, it moves {listed(others)}"
            return Removal(name, Answer.UNSAFE, when, moving=others, lift=lift)
        return self._held(name, part, lift) if lift < 1 - WHOLE else Removal(name, Answer.SAFE, SAFE, lift=lift)

    def _pulled(self, name: str, part: frozenset[str]) -> Removal:
        """Find what moves when most of the body's weight is taken and it is pulled along the lift direction."""
        state = prepared(self.engine, self.reduced(part), TAKEN * self.force(name, part, self.up))
        answers = state.load_factor(self.force(name, part, self.lift)[:, None], FORCES_ONLY)
        others = tuple(n for n in answers.moving[0] if n != name)
        if answers.status[0] not in (Status.FINITE, Status.INFINITE):
            return Removal(name, Answer.UNDECIDED, "its neighbours could clamp it; what a pull moves was not found")
        if np.isinf(answers.force[0]):
            return Removal(name, Answer.UNSAFE, "no pull at its centre of mass frees it")
        if others:
            return Removal(name, Answer.UNSAFE, f"pulled out, it moves {listed(others)}", moving=others)
        return Removal(name, Answer.SAFE, SAFE)

    def _held(self, name: str, part: frozenset[str], lift: float = 0.0) -> Removal:
        """Answer for a body that would move before its weight is taken, unless it is also held against turning.

        While it is held, all its contact forces decrease in proportion.
        """
        forces = self.state(part).verdict().forces
        if forces is None:
            return Removal(name, Answer.UNDECIDED, "its contact forces are not known", lift=lift)
        whole, rest = self.reduced(part), self.reduced(part - {name})
        load = pressing_on(rest, name, whole, forces)
        loads = ((f"with {share:.0%} of its contact forces gone", (1 - share) * load) for share in SHARES)
        found = self._under(name, rest, loads)
        if found is not None:
            return found
        early = f"at {lift:.3g} times its weight" if lift else "before its weight is taken"
        reason = f"the rest stands without it; hold it against turning: lifted at its centre of mass it moves {early}"
        return Removal(name, Answer.SAFE, reason, lift=lift, hold=True)

    def _under(self, name: str, assembly: Assembly, loads: Iterable[tuple[str, Float]]) -> Removal | None:
        """Return the answer for the first load under which other bodies move or may move, or None if there is none."""
        for when, load in loads:
            verdict = verdict_on_bearing(prepared(self.engine, assembly, load))
            if verdict.status is Status.UNSTABLE:
                moving, what = gives_way_in([verdict])
                return Removal(name, Answer.UNSAFE, f"{when} {what}", moving=moving)
            if verdict.status is Status.UNDECIDED:
                return Removal(name, Answer.UNDECIDED, f"{when}: {verdict.reason}")
        return None

    def force(self, name: str, part: frozenset[str], direction: Float) -> Float:
        """Return the load (6J,) with the weight of ``name`` as a force at its centre of mass along ``direction``.

        J counts the movable bodies of its part.
        """
        names = [n for n in self.names if n in part]
        k = names.index(name)
        body = self.assembly.scene.body(name)
        assert body.mass is not None
        load = np.zeros(6 * len(names))
        load[6 * k : 6 * k + 3] = body.mass * np.linalg.norm(self.assembly.scene.gravity) * direction
        return load


def gives_way_in(verdicts: Iterable[Verdict]) -> tuple[tuple[str, ...], str]:
    """Return the bodies that move or are crushed in verdicts on what does not stand, and that in words."""
    found = [v.mechanism for v in verdicts if v.mechanism is not None]
    moving = tuple(name for one in found for name in one.moving)
    how = "be crushed" if found and all(one.mode == "crush" for one in found) else "move"
    return moving, f"{listed(moving)} would {how}"


def pressing_on(rest: Assembly, name: str, whole: Assembly, forces: ContactForces) -> Float:
    """Return the load (6J,) that a body puts on those of ``rest`` by its contact ``forces`` in a ``whole`` assembly."""
    load = np.zeros(6 * len(rest.movable))
    for number, interface in enumerate(whole.interfaces):
        if name not in interface.bodies:
            continue
        other = interface.bodies[interface.bodies[0] == name]
        k = rest.index[other]
        if k == FIXED:
            continue
        here, sign = forces.interface == number, 1.0 if interface.bodies[1] == other else -1.0
        load[6 * k : 6 * k + 6] += sign * wrench_at(forces.force[here], forces.points[here], rest.com[k]).sum(0)
    return load


def _cached(cache: OrderedDict[frozenset[str], T], part: frozenset[str], make: Callable[[], T]) -> T:
    """Return the cached value of a part, or make it; the least recently used values are dropped."""
    if part not in cache:
        cache[part] = make()
        if len(cache) > CACHED:
            cache.popitem(last=False)
    cache.move_to_end(part)
    return cache[part]
