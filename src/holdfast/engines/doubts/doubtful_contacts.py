"""Contacts that may not exist: answers for the scene as detected, bounded over the presence of such contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import RLock

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of, with_pull
from holdfast.base.arrays import Float
from holdfast.base.rigid import cross
from holdfast.base.text import listed
from holdfast.conic.solve import Outcome
from holdfast.engines.answers import Answers, Bound, weakest_bound
from holdfast.engines.contract import EXACT, Accuracy, Engine, ForcesOnly, State, fresh
from holdfast.engines.doubts.pose_allowance import PoseAllowance
from holdfast.engines.forces import solve_forces
from holdfast.engines.limit_engine import Limit
from holdfast.engines.mechanism import Mechanism, about_origin
from holdfast.engines.rest import corner_nodes
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.friction import NOTHING

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
        return self._sets_found[0]

    @property
    def complete(self) -> bool:
        """Whether every interface that may be absent is so in one of the sets."""
        return self._sets_found[1]

    @cached_property
    def _sets_found(self) -> tuple[tuple[Absent, ...], bool]:
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
        return not absent or self._verdict_without(absent).status in (
            Status.STABLE,
            self._verdict_without(frozenset()).status,
        )

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

    def _verdict_without(self, absent: Absent) -> Verdict:
        """Return the verdict without these contacts, under what the scene was seen at rest with."""
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


LEANS = 1e-3  # relative drop of ``lower`` above which an answer leans on the contacts that were taken away
CARRIES = 1e-6  # speed into a contact, relative to the fastest body, above which the contact resists a motion
NAMED = 8  # largest number of pairs that one note names
LEVEL = "poses are uncertain in position alone: give pose_sigma=(metres, degrees), or lower does not allow for leaning"


def prepared(
    engine: Engine, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
) -> State:
    """Prepare ``engine`` for an assembly of which some contacts may not exist (``Interface.certain`` is False).

    The arguments are those of ``Engine.prepare``. The state answers for the scene as detected, and its ``lower`` and
    ``upper`` are the least and the greatest over all sets of contacts that may be absent together (``Absences``).
    """
    absences = Absences(engine, assembly, standing, acceleration)
    state = absences.state(frozenset())
    return state if state.verdict().status is Status.UNSTABLE else Doubtful(state, absences)


def as_detected(state: State) -> State:
    """Return the engine's own state, in which all contacts that were detected exist."""
    return state.detected if isinstance(state, Doubtful) else state


@dataclass(frozen=True, eq=False)
class Doubtful:
    """An assembly with contacts that may not exist: its state as ``detected``, and the ``absences`` it may have."""

    detected: State
    absences: Absences
    _allowances: dict[tuple[Absent, bool], tuple[PoseAllowance, State]] = field(
        default_factory=dict, init=False, repr=False
    )
    _asking: RLock = field(default_factory=RLock, init=False, repr=False)
    _states_here: dict[int, State] = field(default_factory=dict, init=False, repr=False)

    def fresh(self) -> Doubtful:
        """Return the same state, its contacts sorted out once for both, as it was before it was asked anything."""
        other = Doubtful(fresh(self.detected), self.absences)
        other.__dict__.update(_allowances=self._allowances, _asking=self._asking)
        return other

    def _remembering_here(self, state: State) -> State:
        """Return a copy of a state of ``absences``, which others share, that remembers only what this object asked."""
        return self._states_here.setdefault(id(state), fresh(state))

    def verdict(self) -> Verdict:
        """Say whether the scene as detected stands."""
        return self.detected.verdict()

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of the engine, and the pairs of bodies that need not touch for everything to stand."""
        with self._asking:
            optional = self.absences.optional
            note = f"contacts that may not exist, all stands without them: {self._named(optional)}"
            return (*self.detected.notes, note) if optional else self.detected.notes

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each column of W (6J, n) [N, N m], with bounds for contacts that may not exist.

        ``force``, ``status`` and ``mechanism`` are those of the scene as detected. ``lower`` is the least of the lower
        bounds over the sets of contacts that may be absent, and ``upper`` the greatest of the upper bounds; neither is
        better known than the worst of them. ``ForcesOnly`` leaves the bounds out. Of several threads that ask, one
        waits for the other.
        """
        with self._asking:
            answers = self.detected.load_factor(W, accuracy)
            if isinstance(accuracy, ForcesOnly):
                return replace(
                    answers,
                    lower=np.zeros(len(answers)),
                    upper=np.full(len(answers), np.inf),
                    lower_bound=Bound.NONE,
                    upper_bound=Bound.NONE,
                    notes=self.notes,
                )
            cases = [(absent, self._answers_without(absent, W, accuracy)) for absent in self._tried]
            greatest = self._answers_raised(answers, W, accuracy)
            known_cases = [np.where(case.status == Status.UNDECIDED, 0.0, case.upper) for _, case in cases]
            return replace(
                answers,
                lower=np.minimum.reduce([answers.lower, answers.force, *(case.lower for _, case in cases)]),
                upper=np.maximum.reduce([answers.upper, answers.force, greatest.upper, *known_cases]),
                lower_bound=weakest_bound([answers.lower_bound, *(case.lower_bound for _, case in cases)]),
                upper_bound=weakest_bound(
                    [answers.upper_bound, greatest.upper_bound, *(case.upper_bound for _, case in cases)]
                ),
                notes=(*answers.notes, *self._notes_on(answers, cases)),
            ).after("contacts that may not exist", "lower is the least over all sets of contacts that may be absent")

    @cached_property
    def _tried(self) -> tuple[Absent, ...]:
        """The sets of absent contacts to ask about; where poses are uncertain, nothing absent is a case of its own.

        Seen poses tilt contacts, and a body may then seem to hang between its neighbours. Where poses are uncertain, a
        set counts only if everything stands in spite of what the poses may be off, unless that holds for none.
        """
        if not self._poses_uncertain:
            return self.absences.sets
        every = self.absences.sets or (frozenset(),)
        return tuple(absent for absent in every if self._allowance_for(absent, wider=False)[0].share > 0) or every

    @property
    def _poses_uncertain(self) -> bool:
        return self.absences.assembly.tolerances.capped

    def _answers_without(self, absent: Absent, W: Float, accuracy: Accuracy) -> Answers:
        """Return the answers without these contacts; where poses are uncertain, ``lower`` allows for that."""
        if not self._poses_uncertain:
            return self._remembering_here(self.absences.state(absent)).load_factor(W, accuracy)
        allowance, state = self._allowance_for(absent, wider=False)
        with_narrower_cones = self._remembering_here(state).load_factor(W, accuracy)
        lower = allowance.lowered(with_narrower_cones.lower, W, accuracy)
        return replace(
            with_narrower_cones,
            lower=lower,
            lower_bound=weakest_bound([with_narrower_cones.lower_bound, Bound.ESTIMATED]),
        )

    def _answers_raised(self, detected: Answers, W: Float, accuracy: Accuracy) -> Answers:
        """Return the answers as ``detected``; where poses are uncertain, those of which ``upper`` allows for that.

        Nothing is added where no ``upper`` is known. Only ``upper`` and ``upper_bound`` of the result are meant to be
        used.
        """
        if not self._poses_uncertain or not np.isfinite(detected.upper).any():
            return detected
        allowance, state = self._allowance_for(frozenset(), wider=True)
        with_wider_cones = self._remembering_here(state).load_factor(W, accuracy)
        upper = allowance.raised(with_wider_cones.upper, W, accuracy)
        return replace(
            with_wider_cones, upper=upper, upper_bound=weakest_bound([with_wider_cones.upper_bound, Bound.ESTIMATED])
        )

    def _allowance_for(self, absent: Absent, *, wider: bool) -> tuple[PoseAllowance, State]:
        """Return what uncertain poses take from bounds without these contacts, and the state that answers then."""
        absences, key = self.absences, (absent, wider)
        if key not in self._allowances:
            loads = absences.standing, absences.acceleration
            allowance = PoseAllowance.of(absences.part(absent), *loads, wider=wider)
            is_limit = isinstance(absences.engine, Limit) and absences.engine == Limit()
            self._allowances[key] = (
                allowance,
                allowance.state if is_limit else absences.engine.prepare(allowance.assembly, *loads),
            )
        return self._allowances[key]

    def _notes_on(self, answers: Answers, cases: Sequence[tuple[Absent, Answers]]) -> tuple[str, ...]:
        """Say on which of the contacts the answers lean, and what was not settled."""
        notes = [LEVEL] if self._poses_uncertain and not self.absences.assembly.tolerances.tilt else []
        met: set[int] = set()  # what motions without them run into; where no motion is known, all that was taken away
        for absent, case in cases:
            for row in np.flatnonzero(case.lower < answers.lower * (1 - LEANS)):
                motion = case.mechanism[row]
                met |= {k for k in absent - met if motion is None or self._resists(k, motion)}
        leaned = sorted(met)
        if leaned:
            words = "answers lean on contacts that may not exist, and lower is without them"
            notes.append(f"{words}: {self._named(leaned)}")
        unknown = np.zeros(len(answers), dtype=bool)
        for _, case in cases:
            unknown |= (case.status == Status.UNDECIDED) & (answers.status != Status.UNDECIDED)
        if unknown.any():
            share = f"{unknown.sum()} of {len(answers)} answers"
            notes.append(f"{share} are undecided without contacts that may not exist: lower is 0 there")
        if not self.absences.complete:
            notes.append(
                f"not all sets of contacts that may not exist were tried ({len(cases)}): lower may be too high"
            )
        return tuple(notes)

    def _resists(self, number: int, motion: Mechanism) -> bool:
        """Tell whether a contact would resist a motion: its bodies slide there or press, or move at all if joined."""
        assembly = self.absences.assembly
        joined = strengths_of(assembly)[number] != NOTHING
        interface = assembly.interfaces[number]
        of_first, of_second = about_origin(assembly, motion.twists, interface.bodies)
        relative = of_second - of_first
        for patch in interface.patches:
            points = patch.polygon if patch.spots is None else patch.spots.points
            normals = patch.normals_at(points)
            velocity = relative[:3] + cross(relative[3:], points)
            if joined and (np.linalg.norm(velocity, axis=1) > CARRIES).any():
                return True
            opening = (velocity * normals).sum(1)
            sliding = np.linalg.norm(velocity - opening[:, None] * normals, axis=1)
            if (opening < assembly.mu[number] * sliding - CARRIES).any():
                return True
        return False

    def _named(self, numbers: Sequence[int]) -> str:
        """Name the pairs of bodies of these interfaces, with how far they are apart."""
        parts = []
        for k in numbers:
            interface = self.absences.assembly.interfaces[k]
            apart = interface.separation
            if apart is None:
                place = ""
            else:
                place = f" ({abs(apart) * 1e3:.1f} mm {'apart' if apart >= 0 else 'into each other'})"
            parts.append("-".join(sorted(interface.bodies)) + place)
        return listed(parts, NAMED)
