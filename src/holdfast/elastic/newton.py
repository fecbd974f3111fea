"""One point of a path: semi-smooth Newton with line search on the bordered system."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, lean
from holdfast.base.rounding import UNIT
from holdfast.elastic.fronts import solve
from holdfast.elastic.law import evaluate
from holdfast.elastic.linear import SINGULAR, Work
from holdfast.elastic.model import Elastic
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.twists import add_wrench, sheet_twist
from holdfast.elastic.vectors import dot, go, put

HALVINGS = 8  # largest number of times that a Newton step is halved in search of a smaller unbalance
SHORTEST = 0.1  # share of a Newton step below which a point of a path is given up, where each point is expensive
ROUNDING = 0.5 * UNIT  # of a sum over its largest term, measured on bodies that have drifted far: 5e-17


class Balance(NamedTuple):
    """Which unbalance is to vanish: r(q, s) = weight · wrench + contact forces + s w - ε D (q - anchor).

    ``weight`` scales the model's wrench; ``drag`` is ε; ``corner`` is d of the bordered system (linear.py): 0 on a
    path, 1 where s shall stay as it is; ``anchor`` (n,) is the displacement without drag. On a path all of the weight
    acts, without drag.
    """

    weight: float
    drag: float
    corner: float
    anchor: Float


class Iteration(NamedTuple):
    """How Newton's method ended.

    ``converged``; ``s`` with which it ended; the ``steps`` taken; ``systems`` solved; ``states``: a number that tells
    which nodes are open, stuck or sliding; ``sign`` of the determinant of the last system, 0 (SINGULAR) if there was
    none.
    """

    converged: bool
    s: float
    steps: int
    systems: int
    states: int
    sign: float


@compiled
@lean
def add_drag(m: Elastic, work: Work, drag: float, q: Float, anchor: Float) -> None:
    """work.r -= ε D (q - anchor): the drag of bonded contacts, and on the world."""
    for p in range(len(m.a)):
        sheet_twist(m, p, q, work.v)
        sheet_twist(m, p, anchor, work.F)
        for i in range(6):
            work.v[i] -= work.F[i]
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += m.bonded[p, i, j] * work.v[j]
            work.F[i] = total
        add_wrench(m, p, work.F, -drag, work.r)
    for i in range(len(q)):
        work.r[i] -= drag * m.still[i] * (q[i] - anchor[i])


@compiled
@lean
def unbalance(m: Elastic, work: Work, balance: Balance, q: Float, s: float) -> int:
    """Set work.r (n,) to the unbalance at (q, s), work.K to the stiffness there; returns the states of the nodes."""
    states = evaluate(m, balance.weight, q, work.r, work.K, work.v, work.F)
    if balance.drag > 0:
        add_drag(m, work, balance.drag, q, balance.anchor)
    for i in range(len(work.r)):
        work.r[i] += s * work.w[i]
    return states


@compiled
@lean
def worst(m: Elastic, r: Float) -> float:
    """The largest component of r, each body's in units of its own weight and size."""
    top = 0.0
    for i in range(len(r)):
        top = max(top, abs(m.scale[i] * r[i]))
    return top


@compiled
@lean
def rounding(m: Elastic, q: Float) -> float:
    """What rounding alone leaves of the balance at q, in the units of ``worst``: forces come from differences."""
    top = 0.0
    for p in range(len(m.a)):
        far, scale, stiff = 0.0, 0.0, 0.0
        for body in (m.a[p], m.b[p]):
            if body >= 0:
                for i in range(6 * body, 6 * body + 6):
                    far = max(far, abs(q[i]))
                    scale = max(scale, m.scale[i])
        for i in range(6):
            stiff = max(stiff, m.bonded[p, i, i])
        top = max(top, far * scale * stiff)
    return ROUNDING * top


@compiled
@lean
def squared(m: Elastic, r: Float) -> float:
    """The sum of squares of the components of r, each body's in units of its own weight and size."""
    total = 0.0
    for i in range(len(r)):
        total += (m.scale[i] * r[i]) ** 2
    return total


@compiled
@lean
def set_sides(work: Work, off: float) -> None:
    """Set the right-hand sides to the unbalance, ``off`` the plane, and to a unit of length along the path."""
    n = len(work.r)
    for i in range(n):
        work.rhs[i, 0], work.rhs[i, 1] = work.r[i], 0.0
    work.rhs[n, 0], work.rhs[n, 1] = off, 1.0


@compiled
@lean
def newton(
    m: Elastic,
    work: Work,
    balance: Balance,
    q: Float,
    s: float,
    level: float,
    tolerance: float,
    most: int,
    least: float,
    fronts: Fronts | None,
) -> Iteration:
    """Improve q (in place) and s until the unbalance is below ``tolerance`` on the plane c·q = ``level``.

    It gives up after ``most`` steps, or where less than the share ``least`` of one brings an improvement.
    After success ``work.rhs[:, 1]`` is the direction (dq, ds) of the path, dℓ = c·dq = 1, and ``sign`` belongs to it:
    from the system of the last whole step if no node changed its state in that. What such a step leaves of the
    unbalance is of the order of its length times what it changes in the stiffness, and that is below ``tolerance``.
    """
    n = len(q)
    states = unbalance(m, work, balance, q, s)
    slow, before, sign, same = 0, np.inf, SINGULAR, False
    for step in range(most + 1):
        error = worst(m, work.r)
        done = error <= tolerance
        if done and same:
            return Iteration(True, s, step, step, states, sign)
        set_sides(work, level - dot(work.c, q))
        slow = slow + 1 if error > 0.5 * before else 0
        before = error
        if not np.isfinite(error) or (not done and (step == most or slow > max(3, most // 4))):
            break
        sign = solve(m, work, balance.drag, balance.corner, fronts)
        if done or sign == SINGULAR:
            return Iteration(sign != SINGULAR, s, step, step + 1, states, sign)
        last = states
        base = squared(m, work.r)
        share = 1.0
        for _ in range(HALVINGS):
            go(work.trial, q, share, work.rhs[:n, 0])
            states = unbalance(m, work, balance, work.trial, s + share * work.rhs[n, 0])
            if squared(m, work.r) <= (1 - 0.01 * share) * base or worst(m, work.r) <= tolerance:
                break
            share *= 0.5
            if share < least:
                return Iteration(False, s, step, step + 1, states, sign)
        put(q, work.trial)
        s += share * work.rhs[n, 0]
        same = share == 1.0 and states == last
    return Iteration(False, s, step, step, states, sign)
