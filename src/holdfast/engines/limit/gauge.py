"""Bounds of the gauge γ(w) = 1/R(w), the reciprocal of the largest factor of a load w, by cutting planes.

``LoadLimit`` is what one solve says of a load. Pushes that share their direction are affine functions of points in one
plane (``flat_groups``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import tangents
from holdfast.engines.limit.rounding import gamma
from holdfast.engines.mechanism import moving_bodies
from holdfast.engines.verdict import Status

FLAT_GROUP = 12  # smallest number of pushes along one direction for which a triangulation pays off


def by_body(W: Float, least: int) -> list[tuple[int, Int]]:
    """Group columns of W (6J, n) that load a single body each: the number of the body, and those of its columns.

    Columns that load several bodies, or none, are in no group, nor are fewer than ``least`` columns of a body.
    """
    loaded = (W.reshape(len(W) // 6, 6, W.shape[1]) != 0).any(1)
    single = loaded & (loaded.sum(0) == 1)
    return [(int(body), np.flatnonzero(single[body])) for body in np.flatnonzero(single.sum(1) >= least)]


def flat_groups(loads: Float) -> tuple[list[Int], Int]:
    """Group loads (n, 6) by their force.

    Returns the numbers of the members of each group of at least FLAT_GROUP loads, and the numbers of all other loads.
    """
    _, group, size = np.unique(np.round(loads[:, :3], 9) + 0.0, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    groups = [np.flatnonzero(group == number) for number in np.flatnonzero(size >= FLAT_GROUP)]
    return groups, np.flatnonzero(size[group] < FLAT_GROUP)


def moment_frame(force: Float) -> Float:
    """Return two unit axes (2, 3) normal to ``force`` (3,). They span the moments of all pushes along the force."""
    return np.array(tangents(force / np.linalg.norm(force)))


@dataclass(frozen=True, eq=False)
class LoadLimit:
    """The largest ``factor`` of one load, with its bounds ``lower`` and ``upper``, its ``status`` and the evidence.

    Finite: the dual ``twists`` (6J,) of the movable bodies, scaled so that the load does work at unit power, and
    ``proof`` (6J,), the same motion mended (repair.py) so that it proves ``upper`` and a cutting plane for all other
    loads. Where it cannot be mended, ``proof`` is None and ``upper`` infinite. Infinite: the ``ray`` (I, 3) [N], world
    axes: forces on each node's second body that balance the load alone, so that any multiple of it is carried.
    ``certain`` says whether ``lower`` is proved. ``slope`` (6J,): where the ray is proved with room to spare, any
    multiple of the load and of a wrench w with the sum of slope |w| <= 1 is carried together.
    """

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
    proof: Float | None = None
    ray: Float | None = None
    certain: bool = False
    slope: Float | None = None


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
