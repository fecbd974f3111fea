"""Falls that no one has seen: a body that would come to rest within reach of where it was seen may be at rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.text import quoted
from holdfast.contacts.detect import TooFineError
from holdfast.contacts.interface import Interface
from holdfast.contacts.nearby import WIDE, Nearby
from holdfast.contacts.tolerances import DOUBTFUL_GAP, doubtful_gap
from holdfast.engines.contract import Engine
from holdfast.engines.mechanism import about_origin
from holdfast.engines.rest import find_rest
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.body import materials_of
from holdfast.scene.hold import held_names, holds_among
from holdfast.scene.scene import Scene

LEVELS = (1e-3, 3e-3, DOUBTFUL_GAP)  # [m] gaps at which contacts are sought, one after another
CLOSING = 1e-4  # speed at which a contact closes, relative to that of the bodies there, below which it does not
MOST_TURN = math.radians(10)  # largest rotation until a contact has closed: further on a body has left its place
BELOW = 0.5  # cosine of the angle between a normal and the vertical up to which a contact is below a body


@dataclass(frozen=True, eq=False)
class SupportsInReach:
    """What would hold groups of an assembly's bodies if they were moved by no more than the reach of their poses.

    A group that falls is followed: contacts that are not there yet but that its motion closes within ``reach`` are
    added, until the group stands or moves on without meeting anything. It is judged under its weight alone, with the
    bodies that support it as fixed: loads need not have acted when the scene was seen.
    """

    engine: Engine
    assembly: Assembly
    _judged: dict[Hashable, Verdict] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def _nearby(self) -> Nearby:
        touching = {frozenset(interface.bodies) for interface in self.assembly.interfaces}
        return Nearby(self.assembly.scene, self.assembly.tolerances, touching)

    def remarks(self, number: int, verdict_of: Callable[[int], Verdict]) -> dict[int, str]:
        """Return what ``_remark`` says of a group that falls, and of those near it that fall, by their numbers.

        ``verdict_of`` is the verdict on each group by its contacts. What is within reach of a group supports it if it
        is fixed or may stand, so groups that hover over each other are settled from below.
        """
        groups = self.assembly.groups
        supports = {body.name for body in self.assembly.bodies if body.fixed}
        falling, seen, left = dict[int, set[int]](), {number}, [number]  # the groups that fall, with those near each
        while left:
            one = left.pop()
            if verdict_of(one).status is not Status.UNSTABLE:
                supports.update(groups[one])
                continue
            beside = {body.name for name in groups[one] for body in self._nearby.beside(name) if not body.fixed}
            falling[one] = {int(self.assembly.group_of[self.assembly.index[name]]) for name in beside}
            left += falling[one] - seen
            seen |= falling[one]
        said = dict.fromkeys(sorted(falling), "")
        for gap in LEVELS:  # the nearest support comes first, even if it is held up by another that is as near
            tried = set(said)
            while tried:
                found = {k: self._remark(groups[k], supports, gap) for k in sorted(tried) if not said[k]}
                new = {k: text for k, text in found.items() if text}
                said |= new
                supports.update(name for k in new for name in groups[k])
                tried = {k for k in said if not falling[k].isdisjoint(new)}  # nothing else has new supports
        return said

    def _remark(self, names: Sequence[str], supports: Collection[str], gap: float) -> str:
        """Say what is within ``gap`` [m] of a group that falls and would hold it, or "" if nothing is.

        If there is too much to compare, say so: words must not cost more than verdicts.
        ``supports`` are the names of the bodies that may hold it: all fixed ones, and those of groups that may stand.
        """
        pairs = self._nearby.pairs(names, supports)
        part = self._part(names, supports)
        if part is None:
            return ""
        verdict = self._verdict(part, by_engine=False)
        by_engine = verdict.status is not Status.UNSTABLE
        if by_engine:
            verdict = self._verdict(part, by_engine=True)
        for wide in (False, True):
            try:
                found = [c for a, b in pairs for c in self._nearby.contacts(a, b, gap, wide=wide)]
            except TooFineError:
                problem = f"whether it would rest on something within {gap * 1e3:g} mm was not searched"
                return f"{problem}: too many faces are near each other there: settle, or give simpler meshes"
            met = self._contacts_met(part, verdict, found, by_engine=by_engine)
            if met:
                return self._words(names, met, gap, wide=wide)
        return ""

    def _contacts_met(
        self, part: Assembly, verdict: Verdict, found: Sequence[Interface], *, by_engine: bool
    ) -> list[Interface]:
        """Return those of the contacts ``found`` that the fall meets until the part may stand; none if it falls on.

        The engine judges the part if ``by_engine``, else limit analysis does.
        """
        met: list[Interface] = []
        left = list(found)
        while verdict.status is Status.UNSTABLE:
            mechanism = verdict.mechanism
            closing = [] if mechanism is None else [c for c in left if self._closes(part, c, mechanism.twists)]
            if not closing:
                return []
            met += closing
            left = [contact for contact in left if contact not in closing]
            verdict = self._verdict(replace(part, interfaces=(*part.interfaces, *met)), by_engine=by_engine)
        return met

    def _closes(self, part: Assembly, contact: Interface, twists: Float) -> bool:
        """Tell whether a motion of the part, ``twists`` (J, 6), closes a contact that is open before it goes too far.

        How far is measured where the contact is, along the motion: a wall beside a falling body is never met.
        """
        of_first, of_second = about_origin(part, twists, contact.bodies)
        relative = of_second - of_first
        (patch,) = contact.patches
        velocity = relative[:3] + np.cross(relative[3:], patch.polygon)
        speed, closing = np.linalg.norm(velocity, axis=1), -(velocity @ patch.normal)
        meets = closing > CLOSING * speed.max(initial=0.0)
        if not meets.any():
            return False
        time = max(contact.separation or 0.0, 0.0) / closing[meets]
        a, b = (part.scene.body(name) for name in contact.bodies)
        turn = float(np.linalg.norm(relative[3:]))
        return bool(((time * speed[meets] <= doubtful_gap(a, b)) & (time * turn <= MOST_TURN)).any())

    def _part(self, names: Sequence[str], supports: Collection[str]) -> Assembly | None:
        """Return the group with its contacts, its supports held fixed; None if there are none within reach."""
        whole = self.assembly.scene
        members = [whole.body(name) for name in names]
        near = {b.name for _, b in self._nearby.pairs(names, supports)} - set(names)
        touching = [i for i in self.assembly.interfaces if not set(names).isdisjoint(i.bodies)]
        holds = holds_among(whole.holds, names, [body.name for body in whole.bodies if body.fixed])
        near |= {name for i in touching for name in i.bodies} | held_names(holds)
        near -= set(names)
        others = [b if b.fixed else replace(b, fixed=True) for b in whole.bodies if b.name in near]
        if not others:
            return None
        bodies = [*others, *members]
        table = whole.friction.among({body.name for body in bodies} | materials_of(bodies))
        scene = Scene(bodies, table, whole.gravity, holds=holds)
        overlaps = tuple(o for o in self.assembly.overlaps if scene.names.issuperset(o.bodies))
        known = self.assembly.known_names
        return Assembly(scene, tuple(touching), self.assembly.tolerances, overlaps, detected=False, absent=known)

    def _verdict(self, part: Assembly, *, by_engine: bool) -> Verdict:
        """Return the verdict on a part, kept: wider gaps mostly find the same contacts as the one before.

        The engine may know of a fall where limit analysis does not, but not under loads.
        """
        bodies = tuple((body.name, body.fixed) for body in part.bodies)
        key = (
            by_engine,
            bodies,
            tuple((i.bodies, *(patch.polygon.tobytes() for patch in i.patches)) for i in part.interfaces),
        )
        if key not in self._judged:
            if by_engine:
                self._judged[key] = self.engine.prepare(part).verdict()
            else:
                self._judged[key] = find_rest(part, part.weight_wrench()).verdict
        return self._judged[key]

    def _words(self, names: Sequence[str], met: Sequence[Interface], gap: float, *, wide: bool) -> str:
        """Name the nearest of the contacts that a fall meets, with its distance and what to do about it."""
        scene, tolerances = self.assembly.scene, self.assembly.tolerances

        def beyond(contact: Interface) -> float:
            """How far the bodies are apart beyond their tolerance [m]; what is within it comes last."""
            a, b = (scene.body(name) for name in contact.bodies)
            apart = contact.separation or 0.0
            return apart if apart > tolerances.between(a, b).gap else np.inf

        nearest = min(met, key=lambda c: (beyond(c), c.separation or 0.0, c.bodies))
        a, b = (scene.body(name) for name in nearest.bodies)
        height = float(nearest.patches[0].normal @ scene.up)  # the normal points from a into b
        upper, lower = (b, a) if height > 0 or a.name not in names else (a, b)
        place = "above" if abs(height) > BELOW else "from"
        apart, own = max(nearest.separation or 0.0, 0.0), tolerances.between(a, b)
        known, remedies = f"gap tolerance {own.gap * 1e3:.2g} mm", [f"gap={gap:g}"] if gap > own.gap else []
        if wide:
            known = f"{known}, angle {own.angle:.2g} degrees"
            remedies.append(f"angle_degrees={WIDE:g}")
        remedy = f"settle, or {', '.join(remedies)}" if remedies else "settle"
        far = f"is {apart * 1e3:.2g} mm {place} {quoted(lower.name)}"
        if apart <= own.gap:
            far = f"touches {quoted(lower.name)} tilted beyond tolerance"
        return f"{upper.name} {far} ({known}) and would rest there: {remedy}"
