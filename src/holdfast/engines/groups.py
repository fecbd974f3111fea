"""An engine prepared for every group of an assembly on its own, so that no answer depends on an unrelated body.

The groups are the connected components of the movable bodies; contacts with fixed bodies do not join them. Forces pass
between bodies of one group only, so a load moves something as soon as it moves something in one group: the largest
factor of a load is the smallest over the groups that it loads.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from threading import RLock
from typing import cast

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.one_group import Part, part_of
from holdfast.assembly.strengths import refuse_joined, with_pull
from holdfast.base.arrays import Bool, Float, Int, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.memory import Same
from holdfast.base.progress import reported
from holdfast.base.text import listed
from holdfast.base.values import Value
from holdfast.engines.answers import Answers, joined_notes
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.contract import EXACT, Accuracy, Engine, Judging, Loadable, State, fresh, held_by
from holdfast.engines.doubts import doubtful_contacts
from holdfast.engines.doubts.near_falls import SupportsInReach
from holdfast.engines.forces import self_stressed
from holdfast.engines.joint_answers import SmallestAnswers, joint, without_negligible
from holdfast.engines.mechanism import Kinematics, Mechanism
from holdfast.engines.rest import corner_nodes, doubt_of, falls_by, firm_fall, hanging, undecided
from holdfast.engines.trees.tree_state import with_trees
from holdfast.engines.verdict import ContactForces, GroupVerdict, Status, Verdict
from holdfast.scene.hold import held_names, refuse_holds

MOST_NAMED = 3  # largest number of overlaps that one reason names


def prepared(
    engine: Engine, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
) -> Groups:
    """Prepare an engine for every group of an assembly; each group is prepared when it is first asked.

    The arguments are those of ``Engine.prepare``. What is prepared is kept in the memory of the assembly, which its
    edits share, so that the next question about a group costs the solve alone. Answers do not depend on it: they are
    the same, to the last digit, whatever was asked before and by whichever thread. Raises SceneError if the scene has
    holds and the engine does not say that it ``takes_holds``, or if poses are uncertain and something holds or joins
    bodies.
    """
    if not getattr(engine, "takes_holds", False):
        refuse_holds(assembly.scene.holds, f"engine {engine.name!r}", 'use engine="limit"')
    if assembly.tolerances.capped:
        refuse_holds(assembly.scene.holds, "pose_sigma", "hold bodies at poses that are known")
        refuse_joined(assembly, "pose_sigma", "leave it out: what joins faces is known for poses that are known")
    standing, acceleration = (None if given is None or not given.any() else given for given in (standing, acceleration))
    return Groups(engine, assembly, standing, acceleration)


@dataclass(frozen=True, eq=False)
class PreparedGroup:
    """One group, prepared: its ``part`` of the assembly, the engine's ``state`` for it and its ``verdict``.

    ``part`` and ``state`` are None for a group that no chain of contacts connects to a fixed body. The bodies of
    ``verdict`` and of its contact forces are numbered as in the whole assembly.
    """

    names: tuple[str, ...]
    verdict: Verdict
    part: Part | None = None
    state: State | None = None

    @property
    def named_verdict(self) -> GroupVerdict:
        """The verdict alone, with the names of the bodies."""
        return GroupVerdict(bodies=self.names, verdict=self.verdict)


@dataclass(frozen=True, eq=False)
class Groups:
    """The state of an engine for an assembly, group by group. It fulfils the contract of ``State``."""

    engine: Engine
    assembly: Assembly
    standing: Float | None
    acceleration: Float | None
    _by_contacts: dict[int, PreparedGroup] = field(default_factory=dict, init=False, repr=False)
    _known: dict[int, PreparedGroup] = field(default_factory=dict, init=False, repr=False)
    _moved: dict[int, tuple[Kinematics, Kinematics]] = field(default_factory=dict, init=False, repr=False)
    _preparing: RLock = field(default_factory=RLock, init=False, repr=False)

    def group(self, number: int) -> PreparedGroup:
        """Return one group, prepared."""
        with self._preparing:
            if number not in self._known:
                self._known.update(self._with_doubts(number, self._by_its_contacts(number)))
            return self._known[number]

    def _with_doubts(self, number: int, group: PreparedGroup) -> dict[int, PreparedGroup]:
        """Return a group, and all that its verdict depends on, with verdicts that allow for poses a little off.

        What overlaps more deeply than its tolerance is not known to stand, and what falls by less than its reach is not
        known to fall.
        """
        if group.verdict.status is Status.STABLE:
            deep = [o.text for o in self.assembly.overlaps if not set(group.names).isdisjoint(o.bodies)]
            if not deep:
                return {number: group}
            verdict = undecided(listed(deep, MOST_NAMED)).after("bodies that overlap", before=group.verdict)
            return {number: replace(group, verdict=verdict)}
        if group.verdict.status is Status.UNDECIDED or not self.assembly.detected:
            return {number: group}
        found = {}
        for k, text in self._remarks(number).items():
            falls = self._by_its_contacts(k)
            reason = f"no contact within tolerance holds {listed(falls.names)}, but {text}"
            doubted = undecided(reason, mechanism=falls.verdict.mechanism)
            verdict = doubted.after("contacts just out of reach", before=falls.verdict)
            found[k] = replace(falls, verdict=verdict) if text else falls
        return found

    def _by_its_contacts(self, number: int) -> PreparedGroup:
        """Return one group, prepared, with the verdict that follows from its contacts as they were found."""
        if number in self._by_contacts:
            return self._by_contacts[number]
        names = self.assembly.groups[number]
        if frozenset(names) in self._hanging:
            key = ("hanging", Same(self.assembly), names, self._wrench.tobytes())
            fall = self.assembly.memory.recalled(key, 1, lambda: hanging(self.assembly, [names], self._wrench))
            group = PreparedGroup(names, fall)
        else:
            part = part_of(self.assembly, names)
            own = self._standing_on(part)
            certain = all(interface.certain for interface in part.assembly.interfaces)
            prepare = with_trees if certain else doubtful_contacts.prepared
            make = partial(prepare, self.engine, part.assembly, own, self.acceleration)
            state = self._recalled(make, part.content, own, len(part.members))
            group = PreparedGroup(names, self._in_terms_of_whole(part, state.verdict()), part, state)
        self._by_contacts[number] = group
        return group

    @cached_property
    def _reach(self) -> SupportsInReach:
        return SupportsInReach(self.engine, self.assembly)

    def _remarks(self, number: int) -> dict[int, str]:
        """Return the remarks of ``SupportsInReach`` on a group that falls, kept with it if the engine is a value."""

        def make() -> dict[int, str]:
            return self._reach.remarks(number, lambda k: self._by_its_contacts(k).verdict)

        if not isinstance(self.engine, Value):
            return make()
        content = Same(self.assembly), number
        key = self._key("remarks", content, self.standing)
        return self.assembly.memory.recalled(key, 1, make)

    @cached_property
    def _firm(self) -> dict[int, GroupVerdict]:
        """The groups that rest as equilibrium alone tells (trees), by number. The engine gives their forces alone."""
        # A protocol that is asked of takes longer than the rest of a verdict
        if not hasattr(self.engine, "firm") or not self._may_be_firm.any():
            return {}
        rests, verdict = cast(Judging, self.engine).firm(self.assembly, self._wrench)
        doubtful = {name for overlap in self.assembly.overlaps for name in overlap.bodies}
        doubtful |= held_names(self.assembly.scene.holds)
        firm = self._may_be_firm
        firm[self.assembly.group_of[~rests]] = False
        known = {}
        for number in np.flatnonzero(firm).tolist():
            names = self.assembly.groups[number]
            if doubtful.isdisjoint(names):
                known[number] = GroupVerdict(bodies=names, verdict=self._with_evidence_of_engine(verdict, number))
        return known

    @property
    def _may_be_firm(self) -> Bool:
        """(G,) which groups touch with faces alone: trees leave open what rests on a line or a point."""
        pairs = zip(self.assembly.ends, self.assembly.interfaces, strict=True)
        thin = [max(ends) for ends, one in pairs if any(patch.kind != "face" for patch in one.patches)]
        found = np.ones(len(self.assembly.groups), dtype=bool)
        found[self.assembly.group_of[thin]] = False
        return found

    def _with_evidence_of_engine(self, verdict: Verdict, number: int) -> Verdict:
        """Return a verdict on a group with the evidence of the engine, worked out when it is read."""
        return verdict.with_evidence(
            lambda: self.group(number).verdict.forces,
            lambda: self.group(number).verdict.residual,
            lambda: self.group(number).verdict.self_stress,
        )

    def _verdict_of(self, number: int) -> GroupVerdict:
        """Return the verdict on one group, prepared only if equilibrium alone does not settle that it rests."""
        return self._firm[number] if number in self._firm else self.group(number).named_verdict

    def group_with(self, body: int) -> PreparedGroup:
        """Return the group, prepared, that holds the movable body with this number."""
        return self.group(int(self.assembly.group_of[body]))

    def together(self, bodies: Sequence[int], where: str) -> tuple[State, Int]:
        """Return one state for all of these movable bodies, and the rows of the whole assembly's loads that it takes.

        It is the state of their group, or that of the whole assembly if they belong to several groups. It takes all
        contacts as detected, even those that may not exist. Raises HoldfastError, with ``where`` in its message, if no
        equilibrium is known to exist there.
        """
        groups = [self.group(number) for number in self._groups_of(bodies)]
        verdict = joint([group.named_verdict for group in groups])
        if not verdict.equilibrium_exists:
            raise HoldfastError(message(where, f"the assembly is {verdict.status}", verdict.reason))
        if len(groups) == 1 and groups[0].part is not None and groups[0].state is not None:
            return doubtful_contacts.as_detected(groups[0].state), groups[0].part.rows
        whole = partial(self.engine.prepare, self.assembly, self.standing, self.acceleration)
        count = len(self.assembly.movable)
        return self._recalled(whole, Same(self.assembly), self.standing, count), np.arange(6 * count)

    def verdict(self) -> Verdict:
        """Say whether the assembly stands: the worst verdict on a group, with the evidence of all groups."""
        return self.verdict_on(range(len(self.assembly.movable)))

    @property
    def verdicts(self) -> tuple[GroupVerdict, ...]:
        """The verdict on each group, in the order of ``assembly.groups``."""
        return tuple(self._verdict_of(number) for number in range(len(self.assembly.groups)))

    def verdicts_under(self, load: Float, numbers: Iterable[int]) -> tuple[GroupVerdict, ...]:
        """Return the verdicts on the groups with these ``numbers``, with the contact forces under ``load`` (6J,).

        They are those of contacts as detected, and None where they are not known. None of them is kept.
        """
        found = []
        for number in numbers:
            group = self.group(number)
            if group.part is None or group.state is None or not load[group.part.rows].any():
                found.append(self._verdict_of(number))
                continue
            state, own = doubtful_contacts.as_detected(group.state), load[group.part.rows]
            if isinstance(state, Loadable):
                verdict = replace(state.verdict(), forces=state.forces_under(own))
            else:
                own = own if self.standing is None else own + self.standing[group.part.rows]
                verdict = self.engine.prepare(group.part.assembly, own, self.acceleration).verdict()
            found.append(GroupVerdict(bodies=group.names, verdict=self._in_terms_of_whole(group.part, verdict)))
        return tuple(found)

    def verdict_on(self, bodies: Iterable[int]) -> Verdict:
        """Say whether the groups of these movable bodies stand, given by the numbers of the bodies."""
        return joint([self._verdict_of(number) for number in reported("rest", self._groups_of(bodies))])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the scene's reader guessed or left out, and the simplifications of all groups that have been asked."""
        known_notes = [group.state.notes for _, group in sorted(self._known.items()) if group.state is not None]
        return joined_notes([self.assembly.scene.notes, *known_notes])

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each load column of W (6J, n): the smallest over the groups that it loads.

        A column that loads no body is INFINITE. The verdict of the answers is that of the loaded groups.
        """
        count = W.shape[1]
        loaded = (W.reshape(len(W) // 6, 6, count) != 0).any(1)
        numbers = self._groups_of(np.flatnonzero(loaded.any(1)))
        groups = list(map(self.group, reported("rest", numbers)))
        verdict, reasons = joint([group.named_verdict for group in groups]), _why_no_answers(groups)
        if len(groups) == 1 and loaded.any(0).all():
            found = self._answers_of_group(groups[0], W, accuracy)
        else:
            table = SmallestAnswers(count)
            for number, group in zip(numbers, groups, strict=True):
                columns = np.flatnonzero(loaded[self.assembly.group_of == number].any(0))
                table.add(columns, self._answers_of_group(group, W[:, columns], accuracy))
            found = table.answers(self.engine, verdict, reasons)
        unchecked = unchecked_limits(self.assembly.bodies)  # nobody looks here at who is crushed
        notes = joined_notes([self.assembly.scene.notes, unchecked, found.notes, reasons])
        return replace(found, verdict=verdict, notes=notes)

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where ``load_factor`` has to be asked.

        All groups that a load reaches must stand, all their contacts be certain, and their engine be able to tell.
        """
        loaded = (W.reshape(len(W) // 6, 6, W.shape[1]) != 0).any(1)
        moves_nothing = np.ones(W.shape[1], dtype=bool)
        for number in self._groups_of(np.flatnonzero(loaded.any(1))):
            group = self.group(number)
            at = np.flatnonzero(loaded[self.assembly.group_of == number].any(0) & moves_nothing)
            if group.verdict.status is not Status.STABLE or group.part is None or group.state is None:
                moves_nothing[at] = False
            elif len(at):
                with self._stopped_anew(group.part):
                    moves_nothing[at] = held_by(group.state, W[group.part.rows][:, at])
        return moves_nothing

    def _groups_of(self, bodies: Iterable[int]) -> list[int]:
        """Return the numbers of the groups of these movable bodies, each once."""
        return sorted(set(self.assembly.group_of[list(bodies)].tolist()))

    def _answers_of_group(self, group: PreparedGroup, W: Float, accuracy: Accuracy) -> Answers:
        """Return the answers of one group for columns W (6J, n), with mechanisms of the whole assembly."""
        if group.part is None or group.state is None:
            return Answers.not_standing(
                W.shape[1], engine=self.engine.name, claim=self.engine.claim, verdict=group.verdict
            )
        W = W[group.part.rows]
        size = group.part.assembly.load_sizes(W)
        with self._stopped_anew(group.part):  # in a size of their own: one load in other units has the same answer
            found = group.state.load_factor(W / size, accuracy).times(1 / size)
        if found.verdict.status is not group.verdict.status:  # the whole assembly raised a doubt about its fall
            known = {"engine": found.engine, "claim": found.claim, "notes": found.notes}
            return Answers.not_standing(W.shape[1], verdict=group.verdict, **known)
        return self._answers_of_whole(group.part, without_negligible(found, W, group.part.assembly))

    @contextmanager
    def _stopped_anew(self, part: Part) -> Iterator[None]:
        """Let the next question about a part begin anew if this one is stopped half way."""
        try:
            yield
        except BaseException:
            if isinstance(self.engine, Value):
                self.assembly.memory.forget(self._key("state", part.content, self._standing_on(part)))
            raise

    def in_whole(self, body: int, found: Answers) -> Answers:
        """Return answers of the state of one body's group with mechanisms of the whole assembly."""
        part = self.group_with(body).part
        return found if part is None else self._answers_of_whole(part, found)

    def _answers_of_whole(self, part: Part, found: Answers) -> Answers:
        """Return answers on a part with mechanisms of the whole assembly."""
        each = {id(m): m for m in found.mechanism}  # rows share mechanisms
        whole = {key: None if m is None else self._mechanism_of_whole(part, m) for key, m in each.items()}
        return replace(found, mechanism=objects([whole[id(m)] for m in found.mechanism]))

    def _standing_on(self, part: Part) -> Float | None:
        """Return the standing loads on the bodies of a part, or None if there are none."""
        own = None if self.standing is None else self.standing[part.rows]
        return None if own is None or not own.any() else own

    def _recalled(self, make: Callable[[], State], content: Same, standing: Float | None, cost: int) -> State:
        """Return the engine's state for ``content``, from the memory of the assembly or now.

        It remembers no question that was asked before. Engines that are no values may change: they are not kept.
        """
        if not isinstance(self.engine, Value):
            return make()
        names = frozenset(self.assembly.known_names)
        # the engine may name bodies and materials of the whole that are unknown in another one with the same part
        state, _ = self.assembly.memory.recalled(
            self._key("state", content, standing), cost, lambda: (make(), names), valid=lambda known: known[1] <= names
        )
        return fresh(state)

    def _key(self, what: str, content: Hashable, standing: Float | None) -> Hashable:
        """Return the key by which ``what`` the engine says of ``content`` is kept with the assembly."""
        loads = (None if load is None else load.tobytes() for load in (standing, self.acceleration))
        return (what, self.engine, content, *loads)

    @cached_property
    def _hanging(self) -> set[frozenset[str]]:
        return {frozenset(names) for names in self.assembly.hanging}

    @cached_property
    def _wrench(self) -> Float:
        """What acts on all movable bodies (6J,) without any load."""
        weight = self.assembly.weight_wrench(self.acceleration)
        return weight if self.standing is None else weight + self.standing

    def _in_terms_of_whole(self, part: Part, verdict: Verdict) -> Verdict:
        """Return a group's verdict in terms of the whole assembly.

        A fall that would press the group against another body, at a contact outside the model, is not certain.
        """
        doubt = ""
        if verdict.status is Status.UNSTABLE and verdict.mechanism is not None:
            twists, judged = self._mechanism_of_whole(part, verdict.mechanism).twists, part.assembly.index
            doubt = doubt_of(self.assembly, twists, judged)
            firm = self._firm_fall(part) if doubt else None
            if firm is not None:
                verdict, doubt = replace(firm, steps=verdict.steps), ""
        if verdict.status is Status.STABLE:
            return verdict.with_evidence(
                lambda: self._forces_of_whole(part, verdict),
                lambda: verdict.residual,
                lambda: self_stressed(part.assembly, corner_nodes(part.assembly).contacts),
            )
        mechanism, reason = None, verdict.reason
        if verdict.mechanism is not None:
            mechanism = self._mechanism_of_whole(part, verdict.mechanism)
            reason = reason.replace(verdict.mechanism.text, mechanism.text)  # bodies and pairs in the scene's order
        if doubt:
            doubted = undecided(f"{reason}; but {doubt}", mechanism=mechanism)
            return doubted.after("bodies outside of the group", before=verdict)
        return replace(verdict, reason=reason, mechanism=mechanism, forces=self._forces_of_whole(part, verdict))

    def _forces_of_whole(self, part: Part, verdict: Verdict) -> ContactForces | None:
        """Return the contact forces of a verdict on a part, at the interfaces of the whole assembly."""
        forces = verdict.forces
        if forces is None:
            return None
        sign = np.where(part.flipped, -1.0, 1.0)[forces.interface][:, None]
        return replace(
            forces,
            normal=sign * forces.normal,
            force=sign * forces.force,
            interface=part.interfaces[forces.interface],
        )

    def _firm_fall(self, part: Part) -> Verdict | None:
        """Return the verdict that a part falls whatever its sharp contacts with others carry; None if unknown."""
        names = [body.name for body in part.assembly.movable]
        motion = firm_fall(self.assembly, names, self._wrench)
        if motion is None:
            return None
        nodes, wrench = corner_nodes(part.assembly), with_pull(part.assembly, self._wrench[part.rows])
        verdict, _ = falls_by(part.assembly, nodes, nodes.under(wrench), motion[part.members])
        return verdict if verdict.status is Status.UNSTABLE else None

    def _mechanism_of_whole(self, part: Part, mechanism: Mechanism) -> Mechanism:
        """Return a mechanism of one part as one of the whole assembly."""
        known = self._moved.get(id(mechanism.kinematics))
        if known is None or known[0] is not mechanism.kinematics:
            pairs = tuple(self.assembly.interfaces[k].bodies for k in part.interfaces.tolist())
            count = len(self.assembly.movable)
            known = mechanism.kinematics, mechanism.kinematics.within(part.members, count, part.interfaces, pairs)
            self._moved[id(mechanism.kinematics)] = known
        return mechanism.within(known[1])


_WORDS = {Status.UNSTABLE: "does not stand", Status.UNDECIDED: "undecided"}


def _why_no_answers(groups: Sequence[PreparedGroup]) -> tuple[str, ...]:
    """Say for each group that does not stand, or may not stand, why it has no answers."""
    return tuple(
        f"{listed(group.names)}: {_WORDS[group.verdict.status]}: {group.verdict.reason}"
        for group in groups
        if group.verdict.status is not Status.STABLE
    )
