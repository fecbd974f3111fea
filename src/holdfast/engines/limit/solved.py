"""The answer to one load."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.base.arrays import Float
from holdfast.engines.verdict import Status


@dataclass(frozen=True, eq=False)
class Solved:
    """``factor`` with bounds and ``status``, and what proves it.

    Finite: the dual ``twists`` (6J,), scaled to unit load power. Infinite: the ``ray`` (I, 3) [N], world: forces on
    each node's second body that balance the load alone, so that any multiple of it is carried.
    """

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
    ray: Float | None = None
