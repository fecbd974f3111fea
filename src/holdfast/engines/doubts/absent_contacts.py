"""Which uncertain contacts an assembly can stand without: the sets of contacts that may all be absent at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Float
from holdfast.conic.solve import Outcome
from holdfast.engines.contract import Engine, State
from holdfast.engines.forces import solve_forces
from holdfast.engines.rest import corner_nodes
from holdfast.engines.verdict import Status, Verdict

SETS = 8  # largest number of sets of absent contacts that are sought
SIDE = 0.5  # cosine of the angle between a normal and the vertical below which a contact is on a side
CHEAP = 1e-7  # tolerance of the force programs that rule out what cannot stand
MANY = 24  # uncertain interfaces above which only those on sides are taken away, all together

Absent = frozenset[int]  # numbers of interfaces that are taken away


@dataclass(frozen=True, eq=False)
class Absences:
    """The sets of uncertain interfaces of an assembly without which everything still stands.

    The scene was seen at rest. What it cannot stand without therefore exists, and what it can stand without may be
    absent. Rest is judged under the weight alone, because loads and accelerations need not have acted when the scene
    was seen; if the assembly rests only with them, under ``standing`` (6J,) and ``acceleration`` (3,) as well.
    """

    engine: Engine
    assembly: Assembly
    standing: Float | None = None
    acceleration: Float | None = None
    _parts: dict[Absent, Assembly] = field(default_factory=dict, init=False, repr=False)
    _rests: dict[Absent, bool] = field(default_factory=dict, init=False, repr=False)
    _states: dict[tuple[Absent, bool], State] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def uncertain(self) -> tuple[int, ...]:
        """The numbers of the interfaces that may not exist, beginning with the widest apart."""
        numbers = [k for k, interface in enumerate(self.assembly.interfaces) if not interface.certain]
        return tuple(sorted(numbers, key=lambda k: (-(self.assembly.interfaces[k].separation or 0.0), k)))

    @cached_property
    def _single(self) -> tuple[int, ...]:
        """Those of the uncertain interfaces without which, alone, the assembly may rest: no set holds another one.

        Contacts on sides seldom carry weight, and what can go together can go alone: one program may settle them all.
        """
        up = self.assembly.scene.up
        on_sides = frozenset(
            k for k in self.uncertain if all(abs(p.normal @ up) < SIDE for p in self.assembly.interfaces[k].patches)
        )
        settled = on_sides if on_sides and self._may_rest(on_sides) else frozenset()
        if self._many:
            return tuple(k for k in self.uncertain if k in settled)
        return tuple(k for k in self.uncertain if k in settled or self._may_rest(frozenset([k])))

    @property
    def _many(self) -> bool:
        return len(self.uncertain) > MANY

    @cached_property
    def optional(self) -> tuple[int, ...]:
        """The numbers of the interfaces that are absent in at least one of the sets, in the order of the assembly."""
        return tuple(sorted(frozenset().union(*self.sets)))

    @property
    def sets(self) -> tuple[Absent, ...]:
        """The largest sets that may be absent, at most SETS; none if everything is needed."""
        return self._found[0]

    @property
    def complete(self) -> bool:
        """Whether every interface that may be absent is so in one of the sets."""
        return self._found[1]

    @cached_property
    def _found(self) -> tuple[tuple[Absent, ...], bool]:
        """Find sets to which nothing can be added: first the widest gaps are opened, then the narrowest.

        Then every interface that no set holds yet comes first once. What stands without two sets together need not
        exist, so in most scenes there is one set alone.
        """
        order = self._single
        found = [self.largest(order)]
        if self._many:
            return tuple(absent for absent in found if absent), False
        found += [absent for absent in [self.largest(order[::-1])] if absent not in found]
        for k in order:
            if any(k in absent for absent in found):
                continue
            if len(found) >= SETS:
                return tuple(found), False
            absent = self.largest([k, *(other for other in order if other != k)])
            if k in absent:
                found.append(absent)
        return tuple(absent for absent in found if absent), True

    def largest(self, order: Sequence[int]) -> Absent:
        """Return the interfaces of ``order`` without which the assembly stands, the first ones of it above all.

        None of those that are left can be added. Engine ``limit``'s equilibrium decides, as it is cheap and no other
        engine stands without it; only where the engine does not find the whole set at rest, it is asked at each step.
        """
        candidates = [k for k in order if k in self._single]
        quick = self._opened(candidates, sure=False)
        return quick if self.stands(quick) else self._opened(candidates, sure=True)

    def _opened(self, order: Sequence[int], *, sure: bool) -> Absent:
        """Return interfaces of ``order`` without which the assembly rests; if ``sure``, the engine says so each time.

        The first one is tried alone, then all others at once, or else halves of them, and so on: so a few needed ones
        among many cost few verdicts.
        """
        absent: Absent = frozenset()
        parts = [list(part) for part in (order[1:], order[:1]) if part]  # the last is tried first
        while parts:
            part = parts.pop()
            more = absent | frozenset(part)
            if self._may_rest(more) and (not sure or self.stands(more)):
                absent = more
            elif len(part) > 1:
                middle = len(part) // 2
                parts += [part[middle:], part[:middle]]
        return absent

    def part(self, absent: Absent) -> Assembly:
        """Return the assembly without these interfaces."""
        if absent not in self._parts:
            self._parts[absent] = self.assembly.without_interfaces(absent) if absent else self.assembly
        return self._parts[absent]

    def stands(self, absent: Absent) -> bool:
        """Tell whether the engine finds the assembly at rest without these interfaces, as surely as with them."""
        return not absent or self._seen(absent).status in (Status.STABLE, self._seen(frozenset()).status)

    def state(self, absent: Absent, *, loaded: bool = True) -> State:
        """Return the engine's state without these interfaces, under the weight and, if ``loaded``, all that acts."""
        acting = (load for load in (self.standing, self.acceleration) if load is not None)
        key = absent, loaded and any(bool(load.any()) for load in acting)
        if key not in self._states:
            loads = (self.standing, self.acceleration) if key[1] else (None, None)
            self._states[key] = self.engine.prepare(self.part(absent), *loads)
        return self._states[key]

    @cached_property
    def _seen_loaded(self) -> bool:
        """Whether rest is judged under the standing loads and the acceleration, too."""
        return self.state(frozenset(), loaded=False).verdict().status is Status.UNSTABLE

    def _seen(self, absent: Absent) -> Verdict:
        return self.state(absent, loaded=self._seen_loaded).verdict()

    def _may_rest(self, absent: Absent) -> bool:
        """Tell whether limit analysis finds an equilibrium without these interfaces, or does not settle it."""
        if absent not in self._rests:
            part = self.assembly.without_interfaces(absent) if absent else self.assembly
            wrench = part.weight_wrench(self.acceleration if self._seen_loaded else None)
            if self._seen_loaded and self.standing is not None:
                wrench = wrench + self.standing
            self._rests[absent] = not part.hanging
            if not part.hanging:
                nodes = corner_nodes(part)
                forces = solve_forces(part, nodes, nodes.under(with_pull(part, wrench)), tolerance=CHEAP)
                self._rests[absent] = forces.outcome is not Outcome.INFEASIBLE
        return self._rests[absent]
