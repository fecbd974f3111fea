"""Lower answers: to where no body bears more than it may, and to what holds on faces that are not ideal.

The contact forces of what is crushed are those of the verdict under each load, so whoever is crushed is so by the
forces that ``stability`` shows there. For imperfect faces, the same query is asked on samples of faces that are not
flat or not equally stiff.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import reported
from holdfast.base.text import listed, quoted
from holdfast.engines.answers import Answers, Bound, weakest_bound
from holdfast.engines.bearing import CRUSHED, UNCHECKED, bearings, concerns, limited
from holdfast.engines.compliant.engine import Compliant, Rough
from holdfast.engines.contract import Engine
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.imperfect import Imperfect, RandomFaces
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
STAGE = "imperfect faces"
WEAK = 0.1  # share of a body's points, the weakest ones, that are computed on every sample
FEWEST = 24  # smallest number of points of a body that are computed on every sample
WORST = 4  # number of samples on which all other points are computed: those on which the weak points are weakest


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
    gripped = sorted({*held_names(state.assembly.scene.holds)} & {*names})
    if gripped:
        notes.append(f"what {listed(gripped)} may bear was not compared: what holds it exerts is not known")
    force, lower = np.array(found.force), np.array(found.lower)
    status, mechanism = found.status.tolist(), found.mechanism.tolist()
    loads = _BearingUnderLoads(state, [name for name in names if name not in gripped], W, pressed)
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


class _BearingUnderLoads:
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
        # far beyond the weight and all limits
        areas = dict.fromkeys(self.groups, 0.0)
        for interface in self.assembly.interfaces:
            areas |= {n: max(areas[n], interface.area) for n in interface.bodies if n in areas}
        bodies = [self.assembly.scene.body(name) for name in self.groups]
        limits = [max(b.top_load or 0.0, (b.pressure or 0.0) * areas[b.name]) for b in bodies]
        size = max(
            float(np.abs(self.W[:, k].reshape(-1, 6)[:, :3]).max(initial=0.0)), float(self.pressed[1][:, k].max())
        )
        # a load that stays just within friction may have a largest factor far beyond
        ends = max(self.assembly.weight, *limits) / (size or 1.0) * FAR
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


@dataclass(frozen=True, eq=False)
class Covering:
    """Computes lower bounds that hold on samples of ``imperfect`` faces.

    ``assembly``, ``standing`` and ``acceleration`` are the arguments of ``Engine.prepare``.
    """

    engine: Compliant
    imperfect: Imperfect
    assembly: Assembly
    standing: Float | None = None
    acceleration: Float | None = None

    def over(self, found: Answers, W: Float) -> Answers:
        """Return ``found``, the answers on ideal faces for load columns W (6J, n), with lower bounds for the samples.

        ``lower`` is reduced to the smallest of the samples' lower bounds, or to the quantile that ``imperfect`` asks
        for. A sample that is undecided or does not stand counts as 0.
        """
        lower, fallen, undecided = self._lower(range(self.imperfect.samples), W)
        return self._with_lower(found, self._quantile(lower), fallen, undecided, "")

    def sample(self, number: int) -> Rough:
        """Return the engine on one of the samples."""
        return Rough(self.engine, RandomFaces(self.imperfect, number))

    def over_surface(self, found: Answers, W: Float) -> Answers:
        """Do the same as ``over`` for many points on one body, at less cost.

        The weakest points are computed on every sample. The others are computed only on the WORST samples for the weak
        points. They are likely, but not certain, to be no weaker on the remaining samples.
        """
        count = max(FEWEST, int(np.ceil(WEAK * len(found))))
        weak = np.sort(np.argsort(np.where(found.decided, found.force, np.inf), kind="stable")[:count])
        others = np.setdiff1d(np.arange(len(found)), weak)
        if not len(others):
            return self.over(found, W)
        sampled, fallen, undecided = self._lower(range(self.imperfect.samples), W[:, weak])
        lower = np.zeros(len(found))
        lower[weak] = self._quantile(sampled)
        worst = np.argsort(sampled.sum(1), kind="stable")[:WORST]
        rest, _, unknown = self._lower(worst.tolist(), W[:, others])
        lower[others] = rest.min(0)
        remark = (
            f"; {len(others)} of {len(found)} points were asked only on the {len(worst)} samples worst for the rest"
        )
        return self._with_lower(found, lower, fallen, undecided + unknown, remark)

    def _lower(self, samples: Iterable[int], W: Float) -> tuple[Float, int, int]:
        """Return lower bounds (samples, n), the number of samples that do not stand, and of undecided answers."""
        rows, fallen, undecided = [], 0, 0
        for sample in reported(STAGE, list(samples)):
            found = prepared(self.sample(sample), self.assembly, self.standing, self.acceleration).load_factor(W)
            rows.append(found.lower)
            fallen += bool((found.status == Status.UNSTABLE).any())
            undecided += int((~found.decided).sum())
        return np.array(rows), fallen, undecided

    def _quantile(self, lower: Float) -> Float:
        """Return for each column of lower bounds (samples, n) the quantile that ``imperfect`` asks for, (n,)."""
        allowed = int(self.imperfect.quantile * len(lower))
        return np.asarray(np.sort(lower, axis=0)[allowed])

    def _with_lower(self, found: Answers, lower: Float, fallen: int, undecided: int, more: str) -> Answers:
        notes = [f"lower covers {covered(self.imperfect)}{more}"]
        if fallen:
            notes.append(f"on {fallen} of {self.imperfect.samples} samples of imperfect faces not all bodies stand")
        if undecided:
            notes.append(f"{undecided} answers on imperfect faces are undecided and count as 0")
        return replace(
            found,
            lower=np.minimum(found.lower, lower),
            lower_bound=weakest_bound([found.lower_bound, Bound.ESTIMATED]),
            notes=(*found.notes, *notes),
        )


def covered(imperfect: Imperfect) -> str:
    """Describe in words the faces for which a lower bound holds."""
    low, high = imperfect.stiffness_range
    how = "the least" if imperfect.quantile == 0 else f"the {imperfect.quantile:.3g} quantile"
    faces = f"{how} of {imperfect.samples} samples of faces with {1e3 * imperfect.flatness:.3g} mm from peak to valley"
    if imperfect.flatness > 0:
        faces += f" on a bed of {imperfect.bed_stiffness:.3g} N/m³"
    return faces if low == high else f"{faces}, pairs {low:.3g} to {high:.3g} times as stiff"


def covering(
    imperfect: object,
    engine: Engine,
    assembly: Assembly,
    standing: Float | None = None,
    acceleration: Float | None = None,
) -> Covering | None:
    """Return the Covering of ``imperfect`` faces, or None if ``imperfect`` is None.

    The other arguments are those of ``Engine.prepare``. Raises HoldfastError if ``imperfect`` is anything else, or if
    the engine has no elastic contacts.
    """
    if imperfect is None:
        return None
    if not isinstance(imperfect, Imperfect):
        problem = f"is a {type(imperfect).__name__}"
        raise HoldfastError(message("imperfect", problem, "needs hf.Imperfect(flatness=..., ...)"))
    if not isinstance(engine, Compliant):
        remedy = "only engine 'compliant' knows contacts that give way"
        raise HoldfastError(message("imperfect", f"asked of engine {quoted(engine.name)}", remedy))
    return Covering(engine, imperfect, assembly, standing, acceleration)
