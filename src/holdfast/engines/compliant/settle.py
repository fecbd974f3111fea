"""Coming to rest: from bonded contacts to the elastic law, with ever less drag.

    r(q) = ε D q,   D the stiffness with all contacts bonded,   ε from 1 to 0

is one implicit step, of length 1/ε, of the overdamped motion D q' = r(q) from the undeformed assembly
(pseudo-transient continuation). Where the assembly stands, q converges as ε falls; where it does not, some bodies drift
apart at a constant rate: q grows as 1/ε while the force that drives them stays the same.
"""

from __future__ import annotations

import numpy as np

from holdfast.arrays import Float
from holdfast.compiled import compilable, compiled
from holdfast.engines.compliant.law import Elastic
from holdfast.engines.compliant.linear import SparseSolver, Work
from holdfast.engines.compliant.newton import newton

REST, DRIFT, LOST = 1, 2, 0

EXACT = 1e-11  # residual of a state at rest, each body's in its own weight
LOOSE = 1e-9  # residual on the way
ROUNDING = 1e-6  # of LOOSE for every size of the bonded displacement: what rounding costs far out
STEADY = 0.01  # a drift whose rate changes by less than this is steady
DECADES = 1e4  # over so much of ε it must be steady


@compilable
def settle(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float, sparse: SparseSolver | None
) -> None:
    """Find q (6J,) at rest under ``weight`` times the wrench and no load.

    In the end ``told[0]`` is REST, DRIFT (then ``drift`` (6J,) is its velocity) or LOST, ``told[1]`` the Newton steps
    taken, ``told[2]`` the ε reached.
    """
    n = len(q)
    inner, s, origin, old = np.zeros(3), np.zeros(1), np.zeros(n), np.zeros(n)
    work.w[:] = 0.0
    work.c[:] = 0.0
    work.ask[0], work.ask[1] = 0.0, 1.0
    told[0], told[1], told[2] = 0.0, 0.0, 1.0
    bonded = q.copy()
    newton(m, work, weight, q, s, 0.0, EXACT, 30, origin, inner, sparse)
    told[1] += inner[1]
    if inner[0] > 0:
        told[0] = 1.0
        return
    q[:] = bonded / 2
    drag, factor = 1.0, 0.5
    steady, rate, states = drag, 0.0, -1.0
    while drag > 1e-13 and told[1] < 3000:
        old[:] = q
        work.ask[0] = drag
        rounding = np.abs(q).max() / max(np.abs(bonded).max(), 1e-300)
        newton(m, work, weight, q, s, 0.0, LOOSE * max(1.0, ROUNDING * rounding), 25, origin, inner, sparse)
        told[1] += inner[1] + 1
        if inner[0] == 0.0:
            q[:] = old
            if factor > 0.97:
                return
            drag /= factor
            factor = np.sqrt(factor)
            drag *= factor
            continue
        told[2] = drag
        drift[:] = q - old
        top = np.abs(q).max()
        if abs(drag * top - rate) > STEADY * rate or inner[2] != states:
            steady = drag
        growing = drag * top > 0.5 * rate
        rate, states = drag * top, inner[2]
        if steady >= DECADES * drag:
            told[0] = 2.0
            work.ask[0] = 0.0
            return
        if not growing or steady > 0.99 * drag:
            old[:] = q
            work.ask[0] = 0.0
            newton(m, work, weight, old, s, 0.0, EXACT, 12, origin, inner, sparse)
            told[1] += inner[1] + 1
            if inner[0] > 0:
                q[:] = old
                told[0] = 1.0
                return
        if inner[1] < 6 or factor > 0.9:
            factor = max(factor * factor, 0.01)
        drag *= factor


@compiled
def settle_dense(m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float) -> None:
    """``settle`` by dense elimination."""
    settle(m, work, weight, q, drift, told, None)
