"""The answer to one load."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.arrays import Float
from holdfast.engines.contract import Status


@dataclass(frozen=True, eq=False)
class Solved:
    """``factor`` with bounds, ``status``, and the dual twists (6J,) scaled to unit load power, if finite."""

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
