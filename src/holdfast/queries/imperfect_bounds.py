"""Lower bounds for imperfect faces, from the same query on samples of faces that are not flat or equally stiff."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import reported
from holdfast.base.text import quoted
from holdfast.engines.answers import Answers, Bound, weakest_bound
from holdfast.engines.compliant.engine import Compliant, Rough
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect, RandomFaces
from holdfast.engines.verdict import Status

STAGE = "imperfect faces"
WEAK = 0.1  # share of a body's points, the weakest ones, that are computed on every sample
FEWEST = 24  # smallest number of points of a body that are computed on every sample
WORST = 4  # number of samples on which all other points are computed: those on which the weak points are weakest


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
        table = self._lower(range(self.imperfect.samples), W)
        return self._with_lower(found, self._quantile(table.lower), table.fallen, table.undecided, "")

    def sample(self, number: int) -> Rough:
        """Return the engine on one of the samples."""
        return Rough(self.engine, RandomFaces(self.imperfect, number))

    def over_surface(self, found: Answers, W: Float) -> Answers:
        """Do the same as ``over`` for many points on one body, at less cost.

        The weakest points are computed on every sample. The others are computed only on the WORST samples for the weak
        points. They are likely, but not certain, to be no weaker on the remaining samples.
        """
        weak = self._weak(found)
        others = np.setdiff1d(np.arange(len(found)), weak)
        if not len(others):
            return self.over(found, W)
        table = self._lower(range(self.imperfect.samples), W[:, weak])
        lower = np.zeros(len(found))
        lower[weak] = self._quantile(table.lower)
        worst = np.argsort(table.lower.sum(1), kind="stable")[:WORST]
        rest = self._lower(worst.tolist(), W[:, others])
        lower[others] = rest.lower.min(0)
        remark = (
            f"; {len(others)} of {len(found)} points were asked only on the {len(worst)} samples worst for the rest"
        )
        return self._with_lower(found, lower, table.fallen, table.undecided + rest.undecided, remark)

    def _weak(self, found: Answers) -> Int:
        count = max(FEWEST, int(np.ceil(WEAK * len(found))))
        return np.sort(np.argsort(np.where(found.decided, found.force, np.inf), kind="stable")[:count])

    def _lower(self, samples: Iterable[int], W: Float) -> _Table:
        rows, fallen, undecided = [], 0, 0
        for sample in reported(STAGE, list(samples)):
            found = prepared(self.sample(sample), self.assembly, self.standing, self.acceleration).load_factor(W)
            rows.append(found.lower)
            fallen += bool((found.status == Status.UNSTABLE).any())
            undecided += int((~found.decided).sum())
        return _Table(np.array(rows), fallen, undecided)

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


@dataclass(frozen=True, eq=False)
class _Table:
    """Lower bounds (samples, n), the number of samples that do not stand, and the number of undecided answers."""

    lower: Float
    fallen: int
    undecided: int


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
