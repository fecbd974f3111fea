"""Coming to rest: from bonded contacts to the elastic law, with ever less drag.

    r(q) = ε D q,   D the stiffness with all contacts bonded,   ε from 1 to 0

is one implicit step, of length 1/ε, of the overdamped motion D q' = r(q) from the undeformed assembly
(pseudo-transient continuation). Where the assembly stands, q converges as ε falls; where it does not, some bodies drift
apart at a constant rate: q grows as 1/ε while the force that drives them stays the same. With friction that is not
associated these single steps can have no solution for some ε, or several; then the motion itself is followed, in steps
r(q) = ε D (q - q_before) of whatever length 1/ε succeeds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable, lean
from holdfast.elastic.fronts import solve
from holdfast.elastic.linear import Work
from holdfast.elastic.model import Elastic
from holdfast.elastic.newton import Balance, newton, rounding, unbalance, worst
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.outcome import RestOutcome
from holdfast.elastic.vectors import farthest, go, largest, put, scale

EXACT = 1e-11  # unbalance of a state of rest, each body's in units of its own weight
ON_THE_WAY = 1e-9  # unbalance of intermediate states, with drag
# Growth of ON_THE_WAY for each size of the bonded displacement that bodies have moved, since rounding errors grow
FARTHER = 1e-6
STEADY = 0.01  # relative change of its rate below which a drift is steady
DECADES = 1e4  # factor by which ε must have fallen while a drift was steady
LONG = 1e3  # factor by which time must have grown while a drift was steady, where the motion itself is followed
CLEAR = 100.0  # a force drives a drift if it is at least this many times the rounding error of the balance
LEAST_DRAG = 1e-13  # ε below which no rest is sought in single steps
SLOWEST = 0.97  # factor by which ε falls at least from one single step to the next
STIFFEST = 1e3  # ε above which the motion is not followed in still shorter steps
MOST_STEPS = 6000  # largest number of Newton steps along the motion; half as many while the drag decreases


class Rest(NamedTuple):
    """How the search for rest ended; ``steps`` of Newton's method, and the ``drag`` ε of the last state found."""

    outcome: RestOutcome
    steps: int
    drag: float


@compilable
def lessen_drag(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, exact: float, most: int, fronts: Fronts | None
) -> Rest:
    """Find q (6J,) at rest under ``weight`` times the wrench and no load, with ever less drag.

    A state is at rest if its unbalance is at most ``exact``, each body's in units of its own weight.

    Each state is sought in a single step from the undeformed assembly, and q is at first the displacement with all
    contacts bonded. Where bodies drift, ``drift`` (6J,) becomes their velocity. The search ends after ``most`` steps of
    Newton's method.
    """
    n = len(q)
    origin, old = np.zeros(n), np.zeros(n)
    work.w[:] = 0.0
    work.c[:] = 0.0
    bonded = q.copy()
    found = newton(m, work, Balance(weight, 0.0, 1.0, origin), q, 0.0, 0.0, exact, 30, 0.0, fronts)
    taken, reached = found.steps, 1.0
    if found.converged:
        return Rest(RestOutcome.RESTS, taken, reached)
    scale(q, 0.5, bonded)
    drag, factor = 1.0, 0.5
    steady, rate, states = drag, 0.0, -1
    while drag > LEAST_DRAG and taken < most:
        put(old, q)
        spread = largest(q) / max(largest(bonded), 1e-300)
        tolerance = ON_THE_WAY * max(1.0, FARTHER * spread)
        found = newton(m, work, Balance(weight, drag, 1.0, origin), q, 0.0, 0.0, tolerance, 25, 0.0, fronts)
        taken += found.steps + 1
        if not found.converged:
            put(q, old)
            if factor > SLOWEST:
                break
            drag /= factor
            factor = np.sqrt(factor)
            drag *= factor
            continue
        reached = drag
        go(drift, q, -1.0, old)
        top = largest(q)
        if abs(drag * top - rate) > STEADY * rate or found.states != states:
            steady = drag
        growing = drag * top > 0.5 * rate
        rate, states = drag * top, found.states
        if steady >= DECADES * drag:
            return Rest(RestOutcome.DRIFTS, taken, reached)
        steps = found.steps
        if not growing or steady > 0.99 * drag:
            put(old, q)
            found = newton(m, work, Balance(weight, 0.0, 1.0, origin), old, 0.0, 0.0, exact, 12, 0.0, fronts)
            taken += found.steps + 1
            if found.converged:
                put(q, old)
                return Rest(RestOutcome.RESTS, taken, reached)
            steps = found.steps
        if steps < 6 or factor > 0.9:
            factor = max(factor * factor, 0.01)
        drag *= factor
    return Rest(RestOutcome.LOST, taken, reached)


@compilable
def move(
    m: Elastic, work: Work, weight: float, q: Float, drift: Float, exact: float, most: int, fronts: Fronts | None
) -> Rest:
    """Find rest as ``lessen_drag`` does, but along the overdamped motion D q' = r(q) from q, by implicit steps.

    It drifts where its velocity has been the same for nearly all of the time and of the way, with a force that is no
    rounding error. It gives up after ``most`` steps of Newton's method.
    """
    n = len(q)
    origin, trial, steady = np.zeros(n), np.zeros(n), np.zeros(n)
    first = q.copy()
    work.w[:] = 0.0
    work.c[:] = 0.0
    drag, time, since, before, taken, reached = 1.0, 0.0, 0.0, 0.0, 0, 0.0
    while taken < most and drag < STIFFEST:
        noise = rounding(m, q)
        put(trial, q)
        found = newton(m, work, Balance(weight, drag, 1.0, q), trial, 0.0, 0.0, max(ON_THE_WAY, noise), 12, 0.0, fronts)
        taken += found.steps + 1
        reached = drag
        if not found.converged:
            drag *= 4
            continue
        steps = found.steps
        go(drift, trial, -1.0, q)
        scale(drift, drag, drift)
        put(q, trial)
        time += 1 / drag
        rate = largest(steady)
        if not farthest(drift, steady) <= STEADY * rate or rate == 0.0:
            put(steady, drift)
            since, before = time, farthest(q, first)
        free = Balance(weight, 0.0, 1.0, origin)
        unbalance(m, work, free, q, 0.0)
        clear = worst(m, work.r) > CLEAR * max(ON_THE_WAY, noise)
        if clear and time > LONG * since and rate * (time - since) > before:
            return Rest(RestOutcome.DRIFTS, taken, reached)
        put(trial, q)
        tolerance = max(exact, min(noise, ON_THE_WAY))
        found = newton(m, work, free, trial, 0.0, 0.0, tolerance, 8 if clear else 30, 0.0, fronts)
        taken += found.steps + 1
        if found.converged:
            put(q, trial)
            return Rest(RestOutcome.RESTS, taken, reached)
        if steps == 0:  # no step is due, and none leads to rest
            break
        if steps <= 3:
            drag /= 4
        elif steps <= 6:
            drag /= 2
    return Rest(RestOutcome.LOST, taken, reached)


@compilable
@lean
def bond_all(m: Elastic, work: Work, load: Float, q: Float, fronts: Fronts | None) -> None:
    """Set q (6J,) to the displacement under a ``load`` (6J,) with all contacts bonded."""
    n = len(q)
    work.K[:] = 0.0
    work.w[:] = 0.0
    work.c[:] = 0.0
    work.rhs[:] = 0.0
    put(work.rhs[:n, 0], load)
    solve(m, work, 1.0, 1.0, fronts)  # drag alone: that of bonds
    put(q, work.rhs[:n, 0])
