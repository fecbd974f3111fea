"""Coming to rest: from bonded contacts to the elastic law, with ever less drag.

    r(q) = ε D q,   D the stiffness with all contacts bonded,   ε from 1 to 0

is one implicit step, of length 1/ε, of the overdamped motion D q' = r(q) from the undeformed assembly
(pseudo-transient continuation). Where the assembly stands, q converges as ε falls; where it does not, some bodies drift
apart at a constant rate: q grows as 1/ε while the force that drives them stays the same. With friction that is not
associated these single steps can have no solution for some ε, or several; then the motion itself is followed, in steps
r(q) = ε D (q - q_before) of whatever length 1/ε succeeds.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable, compiled
from holdfast.elastic.law import Elastic
from holdfast.elastic.linear import SparseSolver, Work
from holdfast.elastic.newton import newton, rounding, unbalance, worst

REST, DRIFT, LOST = 1, 2, 0

EXACT = 1e-11  # residual of a state at rest, each body's in its own weight
LOOSE = 1e-9  # residual on the way
ROUNDING = 1e-6  # of LOOSE for every size of the bonded displacement: what rounding costs far out
STEADY = 0.01  # a drift whose rate changes by less than this is steady
DECADES = 1e4  # over so much of ε it must be steady
LONG = 1e3  # where the motion is followed, a drift must be steady over so much of its time
CLEAR = 100.0  # times what rounding leaves of a balance: forces that drive a drift are at least that
STIFFEST = 1e3  # drag with which a step must succeed
MOST = 6000  # Newton steps


@compilable
def settle(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float, sparse: SparseSolver | None
) -> None:
    """Find q (6J,) at rest under ``weight`` times the wrench and no load.

    In the end ``told[0]`` is REST, DRIFT (then ``drift`` (6J,) is its velocity) or LOST, ``told[1]`` the Newton steps
    taken, ``told[2]`` the ε reached.
    """
    bonded = q.copy()
    _less_drag(m, work, weight, q, drift, told, sparse)
    if told[0] == 0.0:
        q[:] = bonded
        move(m, work, weight, q, drift, told, sparse)
    work.ask[0] = 0.0


@compilable
def _less_drag(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float, sparse: SparseSolver | None
) -> None:
    """``settle`` in single steps from the undeformed assembly, with ever less drag."""
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


@compilable
def move(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float, sparse: SparseSolver | None
) -> None:
    """``settle`` along the overdamped motion D q' = r(q) from q, by implicit steps.

    It drifts where its velocity has been the same for nearly all of the time and of the way, with a force that is no
    rounding.
    """
    n = len(q)
    inner, s, origin, trial, steady = np.zeros(3), np.zeros(1), np.zeros(n), np.zeros(n), np.zeros(n)
    first = q.copy()
    told[0] = 0.0
    work.w[:] = 0.0
    work.c[:] = 0.0
    work.ask[1] = 1.0
    drag, time, since, before, taken = 1.0, 0.0, 0.0, 0.0, 0.0
    while taken < MOST and drag < STIFFEST:
        noise = rounding(m, q)
        trial[:] = q
        work.ask[0] = drag
        newton(m, work, weight, trial, s, 0.0, max(LOOSE, noise), 12, q, inner, sparse)
        taken += inner[1] + 1
        told[1] += inner[1] + 1
        told[2] = drag
        if inner[0] == 0.0:
            drag *= 4
            continue
        steps = inner[1]
        drift[:] = drag * (trial - q)
        q[:] = trial
        time += 1 / drag
        rate = np.abs(steady).max()
        if not np.abs(drift - steady).max() <= STEADY * rate or rate == 0.0:
            steady[:] = drift
            since, before = time, np.abs(q - first).max()
        work.ask[0] = 0.0
        unbalance(m, work, weight, q, 0.0, origin)
        clear = worst(m, work.r) > CLEAR * max(LOOSE, noise)
        if clear and time > LONG * since and rate * (time - since) > before:
            told[0] = 2.0
            return
        trial[:] = q
        newton(m, work, weight, trial, s, 0.0, min(max(EXACT, noise), LOOSE), 8 if clear else 30, origin, inner, sparse)
        taken += inner[1] + 1
        told[1] += inner[1] + 1
        if inner[0] > 0:
            q[:] = trial
            told[0] = 1.0
            return
        if steps == 0:  # no step is due, and none leads to rest
            return
        if steps <= 3:
            drag /= 4
        elif steps <= 6:
            drag /= 2


@compiled
def settle_dense(m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float) -> None:
    """``settle`` by dense elimination."""
    settle(m, work, weight, q, drift, told, None)


@compiled
def move_dense(m: Elastic, work: Work, weight: float, q: Float, drift: Float, told: Float) -> None:
    """``move`` by dense elimination."""
    move(m, work, weight, q, drift, told, None)
