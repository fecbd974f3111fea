"""How closely load paths are followed."""

from __future__ import annotations

from typing import NamedTuple


class StepControl(NamedTuple):
    """How closely a path is followed.

    ``growth``: the largest growth of the step from one point to the next; ``correction``: that of a point that is
    wanted, as a share of the step; ``patience``: points without a new peak after which none is waited for; ``most``
    points of a path.
    """

    growth: float
    correction: float
    patience: int
    most: int


QUICK = StepControl(2.5, 0.2, 80, 600)
BRIEF = QUICK._replace(patience=40)  # where linear systems are expensive
CLOSE = StepControl(1.5, 0.05, 1000, 20_000)  # slow and misses less: the reference for the quick step control
