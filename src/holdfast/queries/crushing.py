"""Lower answers for loads to where no body bears more than it may: the largest factor that crushes nothing.

The contact forces are those of the verdict under each load, so whoever is crushed is so by the forces that
``stability`` shows there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from holdfast.base.arrays import Float, objects
from holdfast.base.progress import reported
from holdfast.base.text import listed
from holdfast.engines.answers import Answers, Bound, weakest_bound
from holdfast.engines.bearing import CRUSHED, UNCHECKED, bearings, concerns, limited
from holdfast.engines.groups import Groups
from holdfast.engines.mechanism import crush_of
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.hold import held_names

Pressed: TypeAlias = tuple[Float, Float]

CLOSE = 1e-6  # relative accuracy of a factor at which a body is crushed
NEAR = np.array([1 - CLOSE, 0.99, 0.9, 0.5])  # of the largest factor: just below it forces may not be known
FAR = np.array([1e2, 1e1, 1e0, 1e-1, 1e-2])  # of the weight and all limits, for loads that move nothing
MUCH = 1e6  # share of a limit that stands for all larger ones
NAME = "what bodies may bear"
WHY = "beyond it a body would bear more than its top_load or pressure"


def unless_crushed(found: Answers, state: Groups, W: Float, pressed: Pressed) -> Answers:
    """Return the answers for load columns W (6J, n) of a ``state``, none of them beyond where a body is crushed.

    ``pressed`` is how much the standing loads (B,) and the columns (B, n) press each of the B bodies down [N].

    ``force`` and ``lower`` end there, with the mode "crush"; what is crushed even without the load is UNSTABLE.
    ``lower`` also ends where forces are no longer known. Bodies count that a load can reach through contacts, except
    those that something holds. No bound is proved any more, for nothing proves which forces come about. ``upper`` stays
    that of rigid bodies.
    """
    names = limited(state.assembly.bodies)
    if not names:
        return found
    notes = [note for note in found.notes if note != UNCHECKED]
    held = sorted({*held_names(state.assembly.scene.holds)} & {*names})
    if held:
        notes.append(f"what {listed(held)} may bear was not compared: what holds it exerts is not known")
    force, lower = np.array(found.force), np.array(found.lower)
    status, mechanism = found.status.tolist(), found.mechanism.tolist()
    loads = _Loads(state, [name for name in names if name not in held], W, pressed)
    bearing, unknown = False, 0
    for k in reported("who is crushed", list(range(len(found)))):
        reached = loads.reached(k)
        if not reached or status[k] not in (Status.FINITE, Status.INFINITE):
            continue
        bearing = True
        force[k], known, first = loads.most(k, reached, force[k], lower[k])
        unknown += known < lower[k] * (1 - 2 * CLOSE) and not first
        lower[k] = min(lower[k], known)
        if first:
            mechanism[k] = crush_of(first, len(state.assembly.movable))
            status[k] = Status.FINITE if force[k] else Status.UNSTABLE
    if unknown:
        notes.append(f"what bodies bear is not known up to {unknown} of the answers: lower ends where it is known")
    how = weakest_bound([found.lower_bound, Bound.ESTIMATED]) if bearing else found.lower_bound
    lowered = replace(
        found,
        force=force,
        lower=lower,
        status=objects(status),
        mechanism=objects(mechanism),
        lower_bound=how,
        notes=tuple(notes),
    )
    return lowered.after(NAME, WHY)


def verdict_on_bearing(state: Groups, pressed: Float | None = None, bodies: Sequence[int] | None = None) -> Verdict:
    """Return the verdict of a ``state``, UNSTABLE also where a body bears more than it may.

    ``pressed`` (B,) [N] is how much standing loads press each of the B bodies down. By default all movable bodies have
    to stand; if ``bodies`` are given, by number, their groups.
    """
    verdict, assembly = state.verdict() if bodies is None else state.verdict_on(bodies), state.assembly
    if not verdict.stable or not limited(assembly.bodies):
        return verdict
    first = next((one for one in bearings(assembly, state.verdicts, pressed) if one.crushed), None)
    if first is None:
        return verdict
    crush = crush_of(first.body, len(assembly.movable))
    return replace(verdict, status=Status.UNSTABLE, reason=first.text, mechanism=crush).after(NAME)


class _Loads:
    """What bodies with a limit bear under load columns W (6J, n) beside the loads of a ``state``.

    ``pressed`` is how much the standing loads (B,) and the columns (B, n) press each of the B bodies down [N].
    """

    def __init__(self, state: Groups, names: Sequence[str], W: Float, pressed: Pressed) -> None:
        self.state, self.assembly, self.W, self.pressed = state, state.assembly, W, pressed
        groups = self.assembly.groups
        self.groups = {n: {k for k, g in enumerate(groups) if concerns(self.assembly, g, n)} for n in names}
        self.rest: dict[tuple[str, ...], tuple[float, str]] = {}

    def reached(self, k: int) -> tuple[str, ...]:
        """Return the names of the bodies with a limit on which the load in column ``k`` may press."""
        groups = {*self.assembly.group_of[self.W[:, k].reshape(-1, 6).any(1)].tolist()}
        down = {b.name for b, most in zip(self.assembly.bodies, self.pressed[1][:, k], strict=True) if most}
        return tuple(name for name, own in self.groups.items() if name in down or not own.isdisjoint(groups))

    def share(self, k: int, factor: float, names: tuple[str, ...]) -> tuple[float, str]:
        """Return the largest share of a limit at a ``factor`` of column ``k``, and whose it is: "" if unknown."""
        numbers = sorted(set().union(*(self.groups[name] for name in names)))
        verdicts = self.state.verdicts_under(factor * self.W[:, k], numbers)
        found = bearings(self.assembly, verdicts, self.pressed[0] + factor * self.pressed[1][:, k], names)
        if {one.body for one in found} != {*names}:
            return MUCH, ""
        return min(found[0].share, MUCH), found[0].body

    def most(self, k: int, names: tuple[str, ...], largest: float, sure: float) -> tuple[float, float, str]:
        """Return the factor of column ``k``, its lower bound, and who is crushed beyond, "" if nobody is known to be.

        That is at most the ``largest`` factor, which may be inf, of which ``sure`` is a lower bound. Where forces are
        not known far enough, the factor is where a straight line through those that are known leads to, and the bound
        ends with them.
        """
        from scipy.optimize import brentq  # only here, as it takes long to import

        if names not in self.rest:
            self.rest[names] = self.share(k, 0.0, names)
        rest, first = self.rest[names]
        if not first or not largest:  # forces at rest are not known, or the least load moves something
            return largest, 0.0, ""
        if rest > CRUSHED:
            return 0.0, 0.0, first
        ends = self._far(k) * FAR  # a load that stays just within friction may have a largest factor far beyond
        if np.isfinite(largest):
            ends = np.sort([sure * NEAR[0], *largest * NEAR, *ends[ends < largest * NEAR[-1]]])[::-1]
        tried = ((end, *self.share(k, end, names)) for end in ends.tolist() if end)
        end, share, first = next((each for each in tried if each[2]), (0.0, rest, ""))
        if share > CRUSHED:
            if rest >= 1:
                return 0.0, 0.0, first
            beyond = lambda factor: self.share(k, factor, names)[0] - 1  # noqa: E731
            factor = float(brentq(beyond, 0.0, end, xtol=CLOSE**2 * end, rtol=CLOSE))
            return factor, factor * (1 - CLOSE), self.share(k, factor, names)[1] or first
        if end == ends[0]:
            return largest, largest, ""
        middle, _ = self.share(k, end / 2, names)
        ahead = end * (1 + (1 - share) / (share - middle) / 2) if share > middle + CLOSE else np.inf
        return (ahead, end, first) if ahead < largest else (largest, end, "")

    def _far(self, k: int) -> float:
        """Return a factor of column ``k`` far beyond the weight and all limits."""
        areas = dict.fromkeys(self.groups, 0.0)
        for interface in self.assembly.interfaces:
            areas |= {n: max(areas[n], interface.area) for n in interface.bodies if n in areas}
        bodies = [self.assembly.scene.body(name) for name in self.groups]
        limits = [max(b.top_load or 0.0, (b.pressure or 0.0) * areas[b.name]) for b in bodies]
        size = max(
            float(np.abs(self.W[:, k].reshape(-1, 6)[:, :3]).max(initial=0.0)), float(self.pressed[1][:, k].max())
        )
        return max(self.assembly.weight, *limits) / (size or 1.0)
