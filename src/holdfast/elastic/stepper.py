"""Steps along a load path: the state of the walk, and what a single step meets.

The path is walked plane by plane across its direction (pseudo-arc-length), so that neither a falling load nor a point
that moves back stops it. Its length ℓ is that of the motion of the body that moves most.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import by_reference, compilable, compiled, lean
from holdfast.elastic.cubic import cubic, least_slope
from holdfast.elastic.direction import straight, torn, turn
from holdfast.elastic.fronts import solve
from holdfast.elastic.law import next_change, slid
from holdfast.elastic.linear import ROUNDED, SINGULAR, Work
from holdfast.elastic.model import Elastic
from holdfast.elastic.newton import SHORTEST, Balance, Iteration, newton, unbalance, worst
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.outcome import Event
from holdfast.elastic.resting import bond_all
from holdfast.elastic.sparse import elastic_size
from holdfast.elastic.step_control import (
    DIP,
    FALLEN,
    FARTHEST,
    FLAT,
    QUICK,
    RECORD,
    SLID,
    Progress,
    StepControl,
    hides_dip,
    measure_dip,
    measure_sliding,
    passes_over,
    set_next_step,
)
from holdfast.elastic.vectors import divide, dot, farthest, go, put

TOLERANCE = 1e-7  # unbalance of points on the path, each body's in units of its own weight
OFF, OFF_RISING = 0.1, 0.4  # unbalance midway from which a step may hide a maximum, as a share of the load
LEFT = 0.35  # if the slope stays above this share of what it was before the step, the step hides no maximum
APART = 3e-3  # least relative rise of the load from one stored point to the next
# Drag, and largest number of Newton steps, in the search for forces that balance the load alone
FAINT, MOST_ALONE = 1e-8, 30
CAREFUL = 1.0  # largest growth after a step that failed
# Largest number of Newton steps for one point, and the number up to which a point counts as found easily
MOST_NEWTON, EASY = 16, 8
# The same limit for the first point, and the least share of one step; which idle faces part is still open
FIRST_NEWTON, FIRST_SHARE = 60, 0.01
AWAY = 0.7  # distance from where the directions at both ends lead, as a share of the motion, that hints at a branch
HARDLY_AWAY = 0.4  # the same for points that are not found easily
DOUBTS = 2  # how often one step is tried again because it may have left its branch or hidden a maximum
SHORTER = 0.3  # factor by which a step is shortened
NEAR = 0.03  # share of a failed step from which a corner inside it is approached
BEFORE = 0.999  # share of the way to a corner that is covered before the corner is crossed
SHORTENINGS = 4  # times that one step is shortened, after which the path continues behind the next change of a node
MOST_CHANGES = 200  # largest number of changes of nodes behind which a path may continue


@by_reference
class Stepper(NamedTuple):
    """A walk along a load path: all that one step hands on to the next; ``now`` is written to, and so are all arrays.

    The point ``q`` (n,) with the path's direction ``tangent``, dq/dℓ; the point ``trial`` that is being tried and where
    it was ``aimed``; displacement and plane of the highest point so far (``peak_q``, ``peak_plane``); displacement,
    tangent and plane of the point before the peak, displacement and tangent of the one behind it; ``start``, the state
    of rest. ``scratch`` is just that. ``path`` is the balance that all points keep. ``stuck`` (2, n) are the
    displacements under the wrench and under the load alone, if every contact stuck.

    ``stored_q`` is the displacement of a point on the way to the peak, from which the beginning motion is sought.
    """

    now: Progress
    q: Float
    tangent: Float
    trial: Float
    aimed: Float
    peak_q: Float
    peak_plane: Float
    rising_q: Float
    rising_tangent: Float
    rising_plane: Float
    falling_q: Float
    falling_tangent: Float
    scratch: Float
    start: Float
    path: Balance
    stored_q: Float
    stuck: Float


def make_stepper(stuck: Float, pace: StepControl = QUICK) -> Stepper:
    """A walk among n = 6J displacements, which are ``stuck`` (n,) under the wrench if every contact sticks.

    Its numbers are a record that compiled code can write.
    """
    now = np.zeros(1, RECORD)[0]
    for name, value in pace._asdict().items():
        now[name] = value
    *vectors, stored_q, anchor = np.zeros((len(Stepper._fields) - 2, len(stuck)))
    path = Balance(1.0, 0.0, 0.0, anchor)
    return Stepper._make([cast(Progress, now), *vectors, path, stored_q, np.stack([stuck, stuck])])


@compilable
@lean
def begin(m: Elastic, work: Work, stepper: Stepper, start: Float, load: Float, fronts: Fronts | None) -> Event:
    """Find the direction of the path at the state of rest ``start`` (n,) under ``load`` (n,)."""
    now, q = stepper.now, stepper.q
    put(q, start)
    put(stepper.start, start)
    put(stepper.peak_q, start)
    put(stepper.falling_q, start)
    stepper.falling_tangent[:] = 0.0
    bond_all(m, work, load, stepper.stuck[1], fronts)
    put(work.w, load)
    put(work.c, load)
    now.strength = worst(m, load)
    now.elastic = elastic_size(m, q, load)
    now.rest = by_springs(m, q)
    now.length, now.last, now.turned, now.highest, now.at_peak, now.short = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    now.points, now.systems, now.changes, now.shortened, now.late, now.doubted = 0, 0, 0, 0, 0, 0
    now.beyond, now.noted, now.corner, now.stored = 0.0, 0.0, False, 0.0
    now.peaked, now.topped, now.slid, now.before = False, False, 0.0, 0.0
    now.dipped, now.first, now.sharpest, now.crest, now.trough = 0.0, 0.0, 0.0, 0.0, 0.0
    now.flat_since, now.similar_since, now.fastest = np.inf, np.inf, now.growth
    rest = newton(m, work, stepper.path, q, 0.0, dot(load, q), TOLERANCE, 5, 0.0, fronts)
    if not rest.converged:
        return Event.NO_BEGINNING
    now.s, now.systems = rest.s, 1
    now.orientation = rest.sign if work.rhs[len(q), 1] > 0 else -rest.sign
    now.slope = turn(work, rest.sign, now.orientation, stepper.tangent)
    now.step = min(0.1 / (now.strength * now.slope), 10 * now.elastic) if now.slope > 0 else 1e-3 * now.elastic
    before_peak(work, stepper)
    put(stepper.peak_plane, work.c)
    now.rising_s, now.falling_s, now.falling_slope, now.closed = 0.0, 0.0, 0.0, now.slope <= 0
    return Event.BEGUN


@compilable
@lean
def before_peak(work: Work, stepper: Stepper) -> None:
    """Let the present point be the one before the peak."""
    now = stepper.now
    put(stepper.rising_q, stepper.q)
    put(stepper.rising_tangent, stepper.tangent)
    put(stepper.rising_plane, work.c)
    now.rising_s, now.rising_slope = now.s, now.slope


@compilable
@lean
def behind_peak(stepper: Stepper) -> None:
    """Let the present point be the one behind the peak."""
    now = stepper.now
    put(stepper.falling_q, stepper.q)
    put(stepper.falling_tangent, stepper.tangent)
    now.falling_s, now.falling_slope, now.closed = now.s, now.slope, True


@compilable
@lean
def tolerance_at(now: Progress) -> float:
    """The unbalance that a point there may have: more where displacement or load are large."""
    return TOLERANCE * max(1.0, min(1e-7 * now.length / now.elastic, 10.0), 0.01 * now.strength * abs(now.s))


@compilable
@lean
def advance(m: Elastic, work: Work, stepper: Stepper, fronts: Fronts | None) -> Event:
    """Try a step along the path, and take it if it leads to a new point."""
    now, q, trial, aimed = stepper.now, stepper.q, stepper.trial, stepper.aimed
    go(trial, q, now.step, stepper.tangent)
    put(aimed, trial)
    s, level = now.s + now.step * now.slope, dot(work.c, trial)
    first = now.points == 0
    steps, least = (FIRST_NEWTON, FIRST_SHARE) if first else (MOST_NEWTON, SHORTEST)
    point = newton(m, work, stepper.path, trial, s, level, tolerance_at(now), steps, least, fronts)
    now.systems += point.systems
    backward = now.orientation * point.sign < 0  # behind its plane the path would come back: rather another branch
    now.turned = farthest(trial, aimed) / max(farthest(aimed, q), 1e-300)
    if point.converged and backward and now.shortened > 0 and straight(work, stepper.tangent):
        now.orientation, backward = -now.orientation, False  # another branch leaves the path, which goes on
    if point.converged and not backward and now.doubted < DOUBTS and doubtful(m, work, stepper, point):
        now.doubted += 1
        if first and point.s > now.s:
            lead(work, stepper, point.s)
        now.step *= SHORTER
        return Event.TORN
    if not point.converged or (backward and now.shortened < SHORTENINGS - 1):
        now.shortened += 1
        if now.shortened == SHORTENINGS:
            return Event.STUCK
        shorten(m, stepper, backward)
        return Event.SHORTENED
    if not first:
        now.sharpest = max(now.sharpest, now.turned)
    land(m, work, stepper, point.s, point.sign)
    now.by_springs = by_springs(m, q)
    return Event.ADVANCED


@compilable
@lean
def doubtful(m: Elastic, work: Work, stepper: Stepper, point: Iteration) -> bool:
    """Whether the ``point`` that was found may lie on another branch, or the step to it may hide a maximum."""
    now, sign = stepper.now, point.sign
    rise, falls = now.slope * now.step, work.rhs[-1, 1] * now.step  # both across the plane of the step
    if hides_dip(now, rise, point.s, falls):
        return True
    if now.points > 0 and now.doubted == 0 and strays(m, work, stepper, point, rise, falls):
        return True
    if not now.turned > now.correction:
        return False
    most = AWAY if now.points == 0 or point.systems <= EASY else HARDLY_AWAY
    # torn once: where the path has a sharp corner every step is
    if now.doubted == 0 and torn(
        work, sign, now.orientation, stepper.q, stepper.tangent, stepper.trial, now.step, most
    ):
        return True
    return passes_over(now, rise, point.s, falls)


@compilable
@lean
def strays(m: Elastic, work: Work, stepper: Stepper, point: Iteration, rise: float, falls: float) -> bool:
    """Whether the path may be elsewhere midway than where both ends' directions lead, and clearly higher there.

    It may be if the slope before the step leads clearly higher, if no more than LEFT of that slope remains somewhere
    in the step, and if the unbalance midway is a large share of the load: OFF, and OFF_RISING times what remains more.
    """
    now, middle = stepper.now, stepper.scratch
    n, left = len(middle), least_slope(now.s, rise, point.s, falls) / max(rise, 1e-300)
    if left > LEFT or now.s + rise < point.s + (1 - FALLEN) * abs(point.s):
        return False
    for i in range(n):
        middle[i] = 0.5 * (stepper.q[i] + stepper.trial[i]) + 0.125 * now.step * (stepper.tangent[i] - work.rhs[i, 1])
    unbalance(m, work, stepper.path, middle, cubic(0.5, now.s, rise, point.s, falls))
    return worst(m, work.r) > (OFF + OFF_RISING * max(left, 0.0)) * now.strength * max(now.highest, point.s)


@compilable
@lean
def lead(work: Work, stepper: Stepper, s: float) -> None:
    """Let the path begin straight towards the point that was tried, with load ``s``, instead of along its direction.

    At rest many faces touch without force, and which of them part is not known before the first point is. Up to there
    all displacements are in proportion to the load, as long as nothing else changes.
    """
    now, q, trial, tangent = stepper.now, stepper.q, stepper.trial, stepper.tangent
    n = len(q)
    go(tangent, trial, -1.0, q)
    put(work.rhs[:n, 1], tangent)
    work.rhs[n, 1] = s - now.s
    now.slope = turn(work, 1.0, 1.0, tangent)


@compilable
@lean
def shorten(m: Elastic, stepper: Stepper, backward: bool) -> None:
    """Shorten a step that failed: to just before the next change of a node if that may be why, else by a factor.

    There the path has a corner, and perhaps turns back: then the point found was ``backward``.
    """
    now = stepper.now
    now.beyond = SHORTER * now.step if now.shortened == 1 else now.beyond
    change = next_change(m, stepper.q, stepper.tangent)
    now.corner = (backward or now.shortened > 1) and bool(NEAR * now.step <= change <= now.step)
    now.step *= BEFORE * change / now.step if now.corner else SHORTER
    now.fastest = CAREFUL


@compiled
@lean
def by_springs(m: Elastic, q: Float) -> float:
    """What the regularisation spring carries at q (n,), of each body's own weight and size."""
    top = 0.0
    for i in range(len(q)):
        top = max(top, abs(m.scale[i] * m.hold[i] * q[i]))
    return top


@compilable
@lean
def cross_change(m: Elastic, work: Work, stepper: Stepper, fronts: Fronts | None) -> Event:
    """Go straight on to just behind the next change of a node's state, and take the path's direction there."""
    now, q = stepper.now, stepper.q
    n, tolerance = len(q), tolerance_at(now)
    change = next_change(m, q, stepper.tangent)
    if now.corner and change > NEAR * now.beyond:  # it was none: the path goes on without it
        now.corner = False
        set_next_step(now)
        return Event.ADVANCED
    now.changes += 1
    # further out rounding would balance anything
    if now.changes > MOST_CHANGES or not now.length + change <= FARTHEST * now.elastic:
        return Event.ASTRAY
    change = change * (1 + 1e-7) + 1e-12 * (now.elastic + now.length)
    go(q, q, change, stepper.tangent)
    now.s += change * now.slope
    now.length += change
    unbalance(m, work, stepper.path, q, now.s)
    work.rhs[:] = 0.0
    work.rhs[n, 1] = 1.0
    # a body that comes to stand on one point may tip and turn in any direction; a level path goes on behind such points
    rises = now.slope * now.length > FLAT * abs(now.s)
    sign = solve(m, work, 0.0, 0.0, fronts, ROUNDED if rises else 0.0)
    now.systems += 1
    if sign == SINGULAR:
        if now.s > now.highest and worst(m, work.r) <= tolerance:
            now.highest = now.s
            put(stepper.peak_q, q)
        return Event.RELEASED
    now.slope = turn(work, sign, now.orientation, stepper.tangent)
    now.step = min(now.beyond, 0.1 * (now.elastic + now.length))
    now.shortened, now.corner, now.fastest = 0, False, now.growth
    return Event.NODE_CHANGED


@compilable
@lean
def land(m: Elastic, work: Work, stepper: Stepper, s: float, sign: float) -> None:
    """Take the point that was tried, with load ``s``, as the present one, and keep the bracket of the peak."""
    now, trial = stepper.now, stepper.trial
    higher, rise = s > now.highest, now.slope * now.step
    now.shortened, now.doubted = 0, 0
    now.points += 1
    now.late += 1
    now.length += now.step
    if now.dipped == 0 and s < (1 - DIP) * now.highest:
        now.dipped = now.highest
    falls = work.rhs[-1, 1] * now.step
    measure_dip(now, rise, s, falls)
    if now.slid <= SLID:
        far = slid(m, stepper.start, trial, stepper.stuck, s, work.v, work.F, stepper.scratch)
        measure_sliding(now, rise, s, falls, far)
    if now.topped:
        before_peak(work, stepper)
    if higher:
        if now.first == 0:
            now.first = now.dipped
        now.highest = s
        put(stepper.peak_q, trial)
    now.slope = turn(work, sign, now.orientation, stepper.tangent)
    put(stepper.q, trial)
    now.s = now.last = s
    if higher:
        put(stepper.peak_plane, work.c)
        if s > (1 + APART) * now.stored:
            now.stored = s
            put(stepper.stored_q, stepper.q)
    if now.topped and not (now.peaked or now.slope <= 0):
        now.closed = False
        before_peak(work, stepper)
    elif now.topped or not now.closed:
        behind_peak(stepper)


@compilable
def sought_alone(m: Elastic, work: Work, stepper: Stepper, fronts: Fronts | None) -> Event:
    """ENDLESS if contact forces balance the load without any weight, sought from the present point over s; ADVANCED.

    If they do, ``peak_q`` becomes the displacement under the load alone and ``peak_plane`` the present plane; if not,
    ``peak_q`` becomes the present point.
    """
    now, q = stepper.now, stepper.peak_q
    divide(q, stepper.q, now.s)
    plane, anchor = work.c.copy(), q.copy()
    work.c[:] = 0.0
    held = Balance(0.0, FAINT, 1.0, anchor)  # bodies that the load does not reach float: a faint drag holds them
    alone = newton(m, work, held, q, 1.0, 0.0, TOLERANCE * now.strength, MOST_ALONE, 0.0, fronts)
    unbalance(m, work, Balance(0.0, 0.0, 0.0, anchor), q, 1.0)
    now.systems += alone.systems
    if alone.converged and worst(m, work.r) <= 10 * TOLERANCE * now.strength:
        put(stepper.peak_plane, plane)
        return Event.ENDLESS
    put(work.c, plane)
    put(q, stepper.q)
    return Event.ADVANCED
