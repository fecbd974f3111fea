"""The largest factor of one load, with the evidence that proves it."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.base.arrays import Float
from holdfast.engines.verdict import Status


@dataclass(frozen=True, eq=False)
class LoadLimit:
    """The largest ``factor`` of one load, with its bounds ``lower`` and ``upper``, its ``status`` and the evidence.

    If the factor is finite, the evidence is the dual ``twists`` (6J,) of the movable bodies, scaled so that the power
    of the load is 1. If it is infinite, the evidence is the ``ray`` (I, 3) [N] along the world axes: contact forces on
    the second body of each node that balance the load alone, so that any multiple of the load is carried.
    """

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
    ray: Float | None = None
