"""The cubic between two points of a load path: how high or low the load was between, as far as slopes tell.

It leads from (0, ``start``) to (1, ``end``) with slopes ``a`` and ``b`` there, per unit of that share of the step.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.compiled import compilable, lean

ONCE = 0.1  # share of the step within which a bend counts as lying at one of its ends
NOWHERE = -1.0  # the place of an extremum that the cubic does not have between its ends


@compilable
@lean
def cubic(x: float, start: float, a: float, end: float, b: float) -> float:
    """Its height at x."""
    rise = end - start
    return float(start + x * (a + x * (3 * rise - 2 * a - b + x * (a + b - 2 * rise))))


@compilable
@lean
def maximum_at(start: float, a: float, end: float, b: float) -> float:
    """Where it is highest between its ends, 0 < x < 1, as far as it falls on both sides there; else NOWHERE.

    Nor does it count where the slopes have the same sign and a single bend, ONCE from either end, would explain them.
    """
    rise = end - start
    if a * b >= 0 and ONCE < (rise - b) / (a - b if a != b else 1e-300) < 1 - ONCE:
        return NOWHERE
    B, C = 3 * rise - 2 * a - b, 3 * (a + b - 2 * rise)  # its slope is a + 2 B x + C x²
    inside = B * B - a * C
    if inside <= 0 or (B > 0 and C >= 0):
        return NOWHERE
    root = np.sqrt(inside)
    x = -(B + root) / C if B > 0 else a / (root - B)
    return float(x) if 0 < x < 1 else NOWHERE


@compilable
@lean
def minimum_at(start: float, a: float, end: float, b: float) -> float:
    """Where it is lowest between its ends, 0 < x < 1, as far as it rises on both sides there; else NOWHERE."""
    return maximum_at(-start, -a, -end, -b)


@compilable
@lean
def least_slope(start: float, a: float, end: float, b: float) -> float:
    """Its least slope between the ends."""
    rise = end - start
    B, C = 3 * rise - 2 * a - b, 3 * (a + b - 2 * rise)
    return float(a - B * B / C) if B < 0 and C > -B else min(a, b)


@compilable
@lean
def summit(start: float, a: float, end: float, b: float) -> tuple[float, float]:
    """Where the load is highest between two points, 0 < x < 1, and how high, as far as both ends tell.

    It is where their tangents meet, if it rises at the first and falls at the other: no higher, if it bends downwards
    all the way. Where they meet elsewhere it does not, and the cubic tells. If that has no maximum, it is midway, and
    not above where the first tangent leads.
    """
    if a > 0 > b:
        x = (end - b - start) / (a - b)
        if 0 < x < 1:
            return x, start + a * x
    x = maximum_at(start, a, end, b)
    if x > 0:
        return x, cubic(x, start, a, end, b)
    return 0.5, start + a
