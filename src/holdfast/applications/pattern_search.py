"""Improve a pose by steps that become shorter: a pattern search, after Hooke and Jeeves (J. ACM 8, 1961)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from holdfast.base.arrays import Float

T = TypeVar("T")

AROUND = 8  # number of directions of a step


def around(axes: Float) -> Float:
    """Return the unit directions (AROUND, 3) of steps in the plane of two ``axes`` (2, 3)."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    return np.column_stack([np.cos(angles), np.sin(angles)]) @ axes


def pattern_search(start: T, better: Callable[[T, int, float], T | None], ways: int, *, first: float, last: float) -> T:
    """Return the best state that steps of lengths from ``first`` down to ``last`` lead to.

    ``better(state, way, step)`` returns the state one step away along one of so many ``ways``, or None unless that is
    better. The step is halved when no way is better.
    """
    state, step = start, first
    while step >= last:
        found = next((new for way in range(ways) if (new := better(state, way, step)) is not None), None)
        state, step = (state, step / 2) if found is None else (found, step)
    return state
