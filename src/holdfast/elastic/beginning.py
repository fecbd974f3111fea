"""The motion that begins at the peak of a load path."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable, lean
from holdfast.elastic.fronts import solve
from holdfast.elastic.linear import SINGULAR, Work
from holdfast.elastic.model import Elastic
from holdfast.elastic.newton import Balance, add_drag, newton, rounding, unbalance
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.stepper import TOLERANCE, Stepper
from holdfast.elastic.vectors import divide, dot, go, put

BEYOND = 1.01  # times the peak: the load under which motion begins
LONG_AFTER = 1e-4  # at this drag a step leads so far that contacts have changed as they do in the motion
FALLS, MOST_MOVES = 0.05, 16  # factor by which the drag decreases at first, and largest number of steps
DRAG = 1e-9  # drag in the longest step: contacts that press resist far more
FREE = 0.5  # smallest share of the power of the load that contacts leave to a motion which they allow
MOST_STEPS = 20  # largest number of Newton steps for one step in time


@compilable
@lean
def find_motion(m: Elastic, work: Work, stepper: Stepper, motion: Float, fronts: Fronts | None) -> bool:
    """Set ``motion`` (n,) to what begins to move under a little more than the highest load; whether contacts allow it.

    That is the drift of the overdamped motion from just before the peak, under BEYOND times the load, in ever longer
    implicit steps, as in the search for rest (resting.py); where it is not found, what drag alone resists at the end of
    the path. The path's own direction is no answer: where pressure is concentrated on few nodes, no contact resists
    that a body spins about them, so any such spin may be part of it, and no load drives that.
    """
    now, q = stepper.now, stepper.trial
    put(q, stepper.stored_q if now.stored > 0 else stepper.peak_q)
    put(stepper.scratch, q)
    s, tolerance = BEYOND * now.highest, TOLERANCE * max(1.0, now.strength * abs(now.highest))
    added = s - (now.stored if now.stored > 0 else now.highest)
    work.c[:] = 0.0
    drag, factor = 1.0, FALLS
    for _ in range(MOST_MOVES):
        put(stepper.aimed, q)
        step, enough = Balance(1.0, factor * drag, 1.0, stepper.scratch), max(tolerance, rounding(m, q))
        point = newton(m, work, step, q, s, 0.0, enough, MOST_STEPS, 0.0, fronts)
        now.systems += point.systems
        if not point.converged:
            put(q, stepper.aimed)
            factor = np.sqrt(factor)
            continue
        if drag < LONG_AFTER and dot(q, motion) < dot(stepper.aimed, motion):  # softer than drag: on another branch
            put(q, stepper.aimed)
            break
        go(motion, q, -1.0, stepper.aimed)
        drag *= factor
        if drag <= DRAG:
            break
    go(stepper.aimed, q, -1.0, stepper.scratch)
    power = added * dot(work.w, stepper.aimed)
    work.r[:] = 0.0
    add_drag(m, work, -drag, stepper.aimed, stepper.path.anchor)
    for i in range(len(q)):
        work.r[i] += m.hold[i] * stepper.aimed[i]
    length = np.sqrt(dot(motion, motion))
    if drag < LONG_AFTER and power > 0.0 and length > 0.0 and dot(work.r, stepper.aimed) > FREE * power:
        divide(motion, motion, length)
        return True
    return moves_freely(m, work, stepper, stepper.q, motion, fronts)


@compilable
@lean
def moves_freely(m: Elastic, work: Work, stepper: Stepper, q: Float, motion: Float, fronts: Fronts | None) -> bool:
    """Set ``motion`` (n,) to the slow motion from q under the load, (K + ε D) x = w, of which the load's power is 1.

    False where it is contacts that resist it, not drag or the regularisation spring.
    """
    n = len(q)
    unbalance(m, work, stepper.path, q, stepper.now.s)
    work.rhs[:] = 0.0
    put(work.rhs[:n, 1], work.w)
    sign = solve(m, work, DRAG, 1.0, fronts)
    stepper.now.systems += 1
    power = dot(work.w, work.rhs[:n, 1])
    if sign == SINGULAR or not np.isfinite(power) or power == 0.0:
        return False
    divide(motion, work.rhs[:n, 1], power)
    work.r[:] = 0.0
    add_drag(m, work, DRAG, motion, stepper.path.anchor)
    for i in range(n):
        work.r[i] -= m.hold[i] * motion[i]
    return abs(power * dot(work.r, motion)) > FREE
