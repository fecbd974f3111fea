"""Bounds of the gauge γ(w) = 1/R(w), the reciprocal of the largest factor of a load w, by cutting planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.engines.limit.load_limit import LoadLimit
from holdfast.engines.limit.rounding import gamma
from holdfast.engines.mechanism import moving_bodies


@dataclass
class CuttingPlanes:
    """Lower bounds for loads on single bodies: γ(w) >= row @ w for each of ``rows`` (6J,) and any such w (6J,).

    ``motions`` (6J,) are the collapse mechanisms of the solved loads that the rows come from. ``certain`` says whether
    the lower bounds of all loads that were learned are proved. ``scale`` (6J,) are units of the motion of every body.

    A row is zero for bodies that hardly move. A motion that lifts nothing, as that of a body that rolls, costs no more
    than rounding. What the solver leaves of another body's motion beside it would then bound pushes on that body, and
    by up to 9 % too low.
    """

    scale: Float
    rows: list[Float] = field(default_factory=list)
    motions: list[Float] = field(default_factory=list)
    certain: bool = True

    def learn(self, limits: Sequence[LoadLimit]) -> list[int | None]:
        """Add the cutting planes that solved loads prove; returns the number of each, None where there is none."""
        self.certain &= all(limit.certain for limit in limits)
        first = len(self.rows)
        numbers: list[int | None] = []
        rows: list[Float] = []
        for limit in limits:
            proves = limit.twists is not None and limit.upper > 0
            numbers.append(first + len(rows) if proves else None)
            if limit.twists is not None and proves:
                rows.append(np.zeros_like(limit.twists) if limit.proof is None else limit.proof / limit.upper)
                self.motions.append(limit.twists)
        if rows:
            every = np.array(rows)
            every[np.repeat(~moving_bodies(every, self.scale), 6, axis=1)] = 0.0
            self.rows += list(every)
        return numbers


@dataclass
class Field:
    """Bounds ``low`` (n,) and ``high`` (n,) of γ at ``loads`` (n, 6) on one body.

    The body's rows of a load column (6J,) start at ``first``. ``plane`` (n,) is the number of the cutting plane that
    gives ``low``, or -1 if none does. ``solved`` (n,) is True for loads that were solved themselves, and ``undecided``
    (n,) for those of them for which the solver found no answer. ``endless`` (n,) is True where any multiple of the load
    is carried; for those that were solved, ``spare`` (n, 6) is the slope of LoadLimit. The first ``seen`` cutting
    planes have already been applied.
    """

    loads: Float
    first: int
    planes: CuttingPlanes
    low: Float
    high: Float
    plane: Int
    spare: Float
    solved: Bool
    undecided: Bool
    endless: Bool
    seen: int = 0

    def rise(self) -> None:
        """Raise ``low`` to the values that the cutting planes added since the last call prove."""
        fresh = self.planes.rows[self.seen :]
        if fresh:
            rows = np.array(fresh)[:, self.first : self.first + 6].T
            values = self.loads @ rows
            values -= gamma(6) * (np.abs(self.loads) @ np.abs(rows))
            best = np.argmax(values, axis=1)
            top = values[np.arange(len(values)), best]
            better = top > self.low
            self.low[better] = top[better]
            self.plane[better] = self.seen + best[better]
            self.seen += len(fresh)

    def doubtful(self, members: Int, accuracy: float) -> Bool:
        """Say which of the loads ``members`` (k,) are unsolved with bounds that are further apart than ``accuracy``.

        The distance is (upper - lower) / upper of the factor.
        """
        low, high = self.low[members], self.high[members]
        return np.asarray(~self.solved[members] & ~self.endless[members] & ~(low >= (1 - accuracy) * high))
