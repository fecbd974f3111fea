"""Answers of load paths that deserve doubt, compared with limit analysis, which proves above which load bodies move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.elastic.system import PathOutcome
from holdfast.engines.answers import Answers, only_balanced
from holdfast.engines.compliant.amendment import Amendment, LoadQuestion
from holdfast.engines.compliant.load_bearing import HUGE, rests_alone
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import Status

# Share by which a peak may lie above the proved bound before it counts as wrong: four of the experiments with a robot's
# pushes do by more (tests/cases/test_experiments.py)
CONTRADICTION = 0.05
PATIENCE = 200  # largest number of Newton steps in the search for rest under a load alone
ENDLESS = 1e3  # a lower bound above this many weights of the group leaves it to limit analysis whether there is an end


class _Answer(NamedTuple):
    """One answer, with the names that the columns of a table have."""

    status: Status
    force: float
    lower: float
    mechanism: Mechanism | None


ENDLESS_ANSWER = _Answer(Status.INFINITE, np.inf, np.inf, None)
UNDECIDED_ANSWER = _Answer(Status.UNDECIDED, 0.0, 0.0, None)


@dataclass(frozen=True, eq=False)
class LimitReview(Amendment):
    """Compares answers with limit analysis where they deserve doubt.

    Answers to loads of bodies that a regularisation spring keeps in their places, as it has to keep those that are only
    balanced, are all compared; of others those that are undecided, that have no lower bound, or that exceed HUGE times
    the weight.
    """

    name: ClassVar[str] = "limit analysis"
    why: ClassVar[str] = "limit analysis proves when something moves at the latest, and which loads have no end"

    def amend(self, found: Answers, asked: LoadQuestion) -> Answers:
        """Return the answers ``found``, mended where limit analysis proves more.

        - A push becomes 0 if it gains power in a motion that no contact resists (balanced.py).
        - An answer above the proved bound by more than CONTRADICTION is undecided; one that is less far above it is
          lowered to it.
        - A peak above HUGE times the weight is infinite if contact forces balance the load alone, with friction, by
          both methods. So is a peak whose lower bound, which the finer grid confirms, is above ENDLESS times the
          weight, if limit analysis finds forces that balance the load alone: there the weight is nothing but a
          disturbance of the balance, of the size of those that a path is lost by. If nothing of this is found, such a
          peak without a lower bound is, where limit analysis finds no end, infinite if the finer grid finds none
          either, and undecided otherwise. An undecided answer is infinite if its path was lost above HUGE times the
          weight that counts beside its load and one of the two searches for rest succeeds, or if it has no end, on the
          finer grid neither, where every body is held.
        """
        W, grid, neutral = asked.W, self.grid, self.state.neutral
        size, held = np.abs(grid.loads(W)).max(axis=1, initial=0.0), grid.loads_held(W)
        gained = np.zeros(len(size), dtype=bool) if neutral is None else neutral.gained(W)
        finite = found.status == Status.FINITE
        peak = np.where(finite, found.force, 0.0)
        unsure = held | (found.status == Status.UNDECIDED) | (finite & (peak * size > HUGE))
        if asked.bounded:
            unsure |= finite & (found.lower <= 0)
        doubtful = np.flatnonzero(gained | np.asarray((size > 0) & unsure))
        if not len(doubtful) or not grid.certain.verdict().equilibrium_exists:
            return found
        certain = grid.certain.load_factor(W[:, doubtful])
        upper = np.array(found.upper)
        known: dict[str, Any] = {name: np.array(getattr(found, name)) for name in _Answer._fields}
        upper[doubtful] = np.minimum(upper[doubtful], certain.upper)
        for k, row in enumerate(doubtful.tolist()):
            answer = _Answer._make(column[row] for column in known.values())
            if gained[row]:
                mechanism = certain.mechanism[k] if answer.mechanism is None else answer.mechanism
                mended = _Answer(Status.FINITE, 0.0, 0.0, mechanism)
            else:
                load, endless = W[:, row], certain.status[k] is Status.INFINITE
                mended = self._mended(
                    answer, load, float(size[row]), float(upper[row]), endless, held=held[row], bounded=asked.bounded
                )
            for column, value in zip(known.values(), mended, strict=True):
                column[row] = value
        names = () if neutral is None else neutral.named(grid.assembly)
        notes = (*found.notes, only_balanced(names)) if names else found.notes
        return replace(found, **known, upper=upper, notes=notes)

    def _mended(
        self, answer: _Answer, load: Float, size: float, top: float, endless: bool, *, held: bool, bounded: bool
    ) -> _Answer:
        """Return the answer for one ``load`` (6J,) of a ``size`` relative to all weights, mended as ``amend`` says.

        Limit analysis proves its ``top``, or that it is ``endless``.
        """
        if answer.status is Status.UNDECIDED:
            return ENDLESS_ANSWER if endless and self._endless_behind(load, size) else answer
        if answer.force > (1 + CONTRADICTION) * top:
            return UNDECIDED_ANSWER
        confirmed = not held and answer.lower * size > ENDLESS  # a regularisation spring may have helped
        if endless and (confirmed or self._endless(load, float(answer.force))):
            return ENDLESS_ANSWER
        if endless and bounded and answer.lower <= 0 and answer.force * size > HUGE:
            finer = self.grid.finer.paths(load[:, None]).outcome[0]
            return ENDLESS_ANSWER if finer == PathOutcome.ENDLESS else UNDECIDED_ANSWER
        force = min(answer.force, top)
        return answer._replace(force=force, lower=min(answer.lower, force))

    def _endless_behind(self, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) was lost although it has no end."""
        reached = float(self.grid.paths(column[:, None]).peak[0])
        beside = self.grid.load_bearing.weight(self.grid.loads(column[:, None])[0])
        if HUGE * beside < reached * size < np.inf and self._endless(column, reached):
            return True
        # where bodies lie on whole multiples of their size, some of them come to be only balanced on the way
        for grid in (self.grid, self.grid.finer):
            found = grid.with_hold.paths(column[:, None])
            if found.outcome[0] != PathOutcome.ENDLESS and not found.peak[0] * size > ENDLESS:
                return False
        return True

    def _endless(self, column: Float, peak: float) -> bool:
        """Tell whether elastic contacts balance one load (6J,) without any weight, or its ``peak`` is infinite."""
        if not np.isfinite(peak):
            return True
        load = self.grid.loads(column[:, None])[0]
        if self.grid.load_bearing.balance(load):
            return True
        return rests_alone(self.grid.with_hold.system.under(load / np.abs(load).max()), PATIENCE)
