"""One point of a path: semi-smooth Newton with line search on the bordered system."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable, compiled
from holdfast.elastic.law import Elastic, add_wrench, evaluate, sheet_twist
from holdfast.elastic.linear import SparseSolver, Work, solve

HALVINGS = 8
ROUNDING = 5e-17  # share of the largest term that sums lose, as measured where bodies have drifted far


@compiled
def viscous(m: Elastic, work: Work, q: Float, anchor: Float) -> None:
    """work.r -= ε D (q - anchor): the drag of bonded contacts."""
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
        add_wrench(m, p, work.F, -work.ask[0], work.r)


@compiled
def unbalance(m: Elastic, work: Work, weight: float, q: Float, s: float, anchor: Float) -> int:
    """work.r = what is left of weight, contact forces, load and drag at (q, s); returns the states of the nodes."""
    states = evaluate(m, weight, q, work.r, work.K, work.v, work.F)
    if work.ask[0] > 0:
        viscous(m, work, q, anchor)
    for i in range(len(work.r)):
        work.r[i] += s * work.w[i]
    return states


@compiled
def worst(m: Elastic, r: Float) -> float:
    """The largest component of r, each body's in units of its own weight and size."""
    top = 0.0
    for i in range(len(r)):
        top = max(top, abs(m.scale[i] * r[i]))
    return top


@compiled
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
def squared(m: Elastic, r: Float) -> float:
    """The sum of squares of the same."""
    total = 0.0
    for i in range(len(r)):
        total += (m.scale[i] * r[i]) ** 2
    return total


@compiled
def dot(a: Float, b: Float) -> float:
    """A · b."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@compilable
def newton(
    m: Elastic,
    work: Work,
    weight: float,
    q: Float,
    s: Float,
    level: float,
    tolerance: float,
    most: int,
    anchor: Float,
    told: Float,
    sparse: SparseSolver | None,
) -> None:
    """Improve (q, s) in place until the unbalance is below ``tolerance`` on the plane c·q = ``level``.

    In the end ``told`` holds whether it converged (1 or 0), the steps taken, and
    the states of the nodes; after success ``rhs[:, 1]`` is the direction (dq, ds) of the path, dℓ = c·dq = 1.
    """
    n = len(q)
    told[0] = 0.0
    states = unbalance(m, work, weight, q, s[0], anchor)
    slow, before = 0, np.inf
    for step in range(most + 1):
        told[1], told[2] = step, states
        error = worst(m, work.r)
        off = level - dot(work.c, q)
        work.rhs[:n, 0] = work.r
        work.rhs[:n, 1] = 0.0
        work.rhs[n, 0], work.rhs[n, 1] = off, 1.0
        done = error <= tolerance
        slow = slow + 1 if error > 0.5 * before else 0
        before = error
        if not np.isfinite(error) or (not done and (step == most or slow > max(3, most // 4))):
            return
        solve(m, work, sparse)
        if work.ask[2] == 0.0:
            return
        if done:
            told[0] = 1.0
            return
        base = squared(m, work.r)
        share = 1.0
        for _ in range(HALVINGS):
            work.trial[:] = q + share * work.rhs[:n, 0]
            states = unbalance(m, work, weight, work.trial, s[0] + share * work.rhs[n, 0], anchor)
            if squared(m, work.r) <= (1 - 0.01 * share) * base or worst(m, work.r) <= tolerance:
                break
            share *= 0.5
        q[:] = work.trial
        s[0] += share * work.rhs[n, 0]
