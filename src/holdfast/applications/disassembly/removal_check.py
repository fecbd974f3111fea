"""Decide whether one body may be taken out of an assembly."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from holdfast.applications.disassembly.hands import Hands
from holdfast.applications.disassembly.removal import Answer, Removal, Removals, gives_way_in
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import checked_direction, checked_whole
from holdfast.base.errors import SceneError, message
from holdfast.base.text import listed, quoted
from holdfast.certificates.certified import asking
from holdfast.certificates.question import Question
from holdfast.engines.verdict import Status
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, body_number, checked_assembly, engine_of
from holdfast.scene.scene import Scene


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
