"""Vectors in hot loops: as short calls, because every array expression is a loop of its own to be compiled."""

from __future__ import annotations

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, lean


@compiled
@lean
def dot(a: Float, b: Float) -> float:
    """A · b."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@compiled
@lean
def largest(a: Float) -> float:
    """The largest |a_i|."""
    top = 0.0
    for i in range(len(a)):
        top = max(top, abs(a[i]))
    return top


@compiled
@lean
def farthest(a: Float, b: Float) -> float:
    """The largest |a_i - b_i|."""
    top = 0.0
    for i in range(len(a)):
        top = max(top, abs(a[i] - b[i]))
    return top


@compiled
@lean
def go(into: Float, a: Float, far: float, b: Float) -> None:
    """Set ``into`` to a + far · b; it may be one of them."""
    for i in range(len(a)):
        into[i] = a[i] + far * b[i]


@compiled
@lean
def mix(into: Float, a: Float, share: float, b: Float) -> None:
    """Set ``into`` to (1 - share) a + share b; it may be one of them."""
    for i in range(len(a)):
        into[i] = (1 - share) * a[i] + share * b[i]


@compiled
@lean
def put(into: Float, a: Float) -> None:
    """Set ``into`` to a."""
    for i in range(len(a)):
        into[i] = a[i]


@compiled
@lean
def scale(into: Float, factor: float, a: Float) -> None:
    """Set ``into`` to factor · a; it may be a."""
    for i in range(len(a)):
        into[i] = factor * a[i]


@compiled
@lean
def divide(into: Float, a: Float, by: float) -> None:
    """Set ``into`` to a / by; it may be a."""
    for i in range(len(a)):
        into[i] = a[i] / by
