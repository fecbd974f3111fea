"""The load path, from rest to its peak and beyond, by arc length."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import by_reference, compilable, compiled, lean
from holdfast.elastic.beginning import find_motion
from holdfast.elastic.cubic import summit
from holdfast.elastic.direction import turn
from holdfast.elastic.linear import Work
from holdfast.elastic.model import Elastic
from holdfast.elastic.newton import SHORTEST, Balance, newton, worst
from holdfast.elastic.ordering import Fronts
from holdfast.elastic.outcome import Event, PathOutcome, goes_on, outcome_of
from holdfast.elastic.step_control import (
    FALLEN,
    SLID,
    appraise,
    fall,
    may_have_fallen,
    set_next_step,
)
from holdfast.elastic.stepper import (
    TOLERANCE,
    Stepper,
    advance,
    begin,
    cross_change,
    sought_alone,
)
from holdfast.elastic.vectors import divide, dot, go, mix, put

REFINED = 5e-5  # relative accuracy of the peak
REFINEMENTS = 20  # largest number of points that are tried to reach that accuracy
MOST_FAILURES = 5  # largest number of these points in a row that may fail
MOST_SOUGHT = 20  # largest number of Newton steps in search of a point on another grid
# Share of a Newton step below which the search for a load is given up there; states in balance use SHORTEST
TINY = 0.02


@by_reference
class PathResult(NamedTuple):
    """What k load paths gave, among n = 6J displacements.

    ``outcome`` (k,) of PathOutcome; ``peak`` (k,) the largest s found, inf where the path is endless, that of the last
    point where it was not followed further; ``first`` (k,) the first maximum of s from which it dipped before it rose
    to the peak, the peak if there was none; ``before`` (k,) the largest s, at most the peak, before contacts have
    slid far (SLID); ``sharpest`` (k,) the largest correction of a point after the first, as a share
    of its step; ``last`` (k,) s where it ended (residual strength); ``short`` (k,) by how much s of the peak may be too
    low; ``systems`` (k,) linear systems solved; ``q`` (k, n) at the peak, of endless paths under the load alone;
    ``motion`` (k, n) what begins to move above the peak, 0 where the path was lost and nothing does; ``plane`` (k, n)
    across which the peak was found.
    """

    outcome: Int
    peak: Float
    first: Float
    before: Float
    sharpest: Float
    last: Float
    short: Float
    systems: Int
    q: Float
    motion: Float
    plane: Float

    @classmethod
    def lost(cls, count: int, n: int) -> PathResult:
        """``count`` paths of which nothing is known yet."""
        rows: dict[str, tuple[int, ...]] = {"q": (n,), "motion": (n,), "plane": (n,)}
        kinds = {"outcome": np.int64, "systems": np.int64}
        return cls._make(np.zeros((count, *rows.get(name, ())), kinds.get(name, np.float64)) for name in cls._fields)

    @property
    def factor(self) -> Float:
        """(k,) the peak, inf where the path is endless, 0 where it was lost."""
        endless = np.where(self.outcome == PathOutcome.ENDLESS, np.inf, 0.0)
        return np.where(self.outcome == PathOutcome.PEAK, self.peak, endless)

    @property
    def sure(self) -> Float:
        """(k,) the load before which nothing snaps: the peak, or the first maximum from which the load dipped."""
        return np.minimum(self.first, self.peak)

    def chosen(self, which: Int | Bool | slice) -> PathResult:
        """Some of the paths."""
        return PathResult._make(column[which] for column in self)

    def replaced(self, at: Int, others: PathResult) -> PathResult:
        """The same with ``others`` in the places ``at``."""
        columns = [column.copy() for column in self]
        for column, other in zip(columns, others, strict=True):
            column[at] = other
        return PathResult._make(columns).sealed()

    def sealed(self) -> PathResult:
        """Itself, after which nobody can write to it."""
        for column in self:
            column.setflags(write=False)
        return self


@compilable
@lean
def follow(
    m: Elastic,
    work: Work,
    stepper: Stepper,
    start: Float,
    load: Float,
    into: PathResult,
    row: int,
    most: float,
    fronts: Fronts | None,
) -> None:
    """Raise s from 0 at the rest state ``start`` (n,) along the path r(q) + s load = 0; the result goes ``into`` a row.

    1. Find the direction in which the path begins, and 2. step along it, as ``walk`` does. 3. If it has a peak, refine
    that.
    """
    now = stepper.now
    event = walk(m, work, stepper, start, load, most, fronts)
    outcome = outcome_of(event)
    if outcome == PathOutcome.PEAK and now.rises and now.highest <= 0:  # it was left at the first step
        outcome = PathOutcome.LOST
    put(into.q[row], stepper.peak_q)
    if event == Event.NO_BEGINNING:
        return
    if outcome == PathOutcome.PEAK or outcome == PathOutcome.LOST:
        put(into.motion[row], stepper.tangent)
        if not find_motion(m, work, stepper, into.motion[row], fronts) and outcome == PathOutcome.LOST:
            into.motion[row, :] = 0.0
    if outcome == PathOutcome.PEAK:
        refine(m, work, stepper, fronts)
        put(into.q[row], stepper.peak_q)
    put(into.plane[row], stepper.peak_plane)
    into.outcome[row] = outcome
    into.peak[row] = np.inf if outcome == PathOutcome.ENDLESS else now.highest
    into.first[row] = now.first if now.first > 0 else into.peak[row]
    into.sharpest[row] = now.sharpest
    into.last[row], into.short[row], into.systems[row] = now.last, now.short, now.systems
    into.before[row] = min(now.before, into.peak[row]) if now.slid > SLID else into.peak[row]


@compilable
@lean
def walk(
    m: Elastic,
    work: Work,
    stepper: Stepper,
    start: Float,
    load: Float,
    most: float,
    fronts: Fronts | None,
) -> Event:
    """Step along a path until it falls, is flat, far or endless, is lost, or leads to ``most`` times the load."""
    now = stepper.now
    event = begin(m, work, stepper, start, load, fronts)
    now.rises = now.slope > 0
    while goes_on(event) and now.points < now.most:
        event = advance(m, work, stepper, fronts)
        if event == Event.STUCK:
            event = cross_change(m, work, stepper, fronts)
        elif event == Event.ADVANCED:
            event = appraise(now) if now.s < most else Event.REACHED
            if event == Event.ADVANCED and fell_from_crest(m, work, stepper, fronts):
                event = Event.FALLEN
            if event == Event.PROPORTIONAL:
                event = sought_alone(m, work, stepper, fronts)
            if event == Event.ADVANCED and now.corner:
                event = cross_change(m, work, stepper, fronts)
            else:
                set_next_step(now)
    return event


@compiled
@lean
def follow_each(
    m: Elastic,
    work: Work,
    stepper: Stepper,
    start: Float,
    loads: Float,
    into: PathResult,
    rows: Int,
    most: Float,
    fronts: Fronts | None,
) -> None:
    """``follow`` the ``rows`` of ``loads`` (k, n), each up to ``most`` (k,) times the load."""
    for row in rows:
        follow(m, work, stepper, start, loads[row], into, row, most[row], fronts)


@compilable
@lean
def refine(m: Elastic, work: Work, stepper: Stepper, fronts: Fronts | None) -> None:
    """Close in on the peak from both sides, where there is a point behind it.

    Its place and height are estimated from s and slope at both ends (``summit``).
    """
    now, q = stepper.now, stepper.trial
    plane = stepper.rising_plane
    failed = 0
    for _ in range(REFINEMENTS):
        apart = dot(plane, stepper.falling_q) - dot(plane, stepper.rising_q)
        along = dot(plane, stepper.falling_tangent)
        if not now.closed or apart <= 0 or failed > MOST_FAILURES:
            break
        falling = now.falling_slope / along if along > 0 else 0.0
        place, estimate = summit(now.rising_s, now.rising_slope * apart, now.falling_s, falling * apart)
        now.short = max(estimate - now.highest, 0.0)
        if now.short <= REFINED * now.highest:
            break
        x = min(max(place, 0.1), 0.9) * apart * 0.2**failed
        share = x / apart if failed == 0 else 0.0
        back = (apart - x) / along if along > 0 else 0.0
        aim_between(stepper, share, x, back)
        s = (1 - share) * (now.rising_s + now.rising_slope * x) + share * now.falling_s
        put(work.c, plane)
        level = dot(plane, stepper.rising_q) + x
        point = newton(m, work, stepper.path, q, s, level, TOLERANCE, 12, 0.0, fronts)
        now.systems += point.systems
        if not point.converged:
            failed += 1
            continue
        failed = 0
        narrow(work, stepper, point.s, point.sign)


@compilable
@lean
def fell_from_crest(m: Elastic, work: Work, stepper: Stepper, fronts: Fronts | None) -> bool:
    """Whether the load has clearly fallen since its peak, which lies between points: if that decides, it is refined."""
    now = stepper.now
    if not now.closed or now.crest <= now.highest:
        return False
    if not may_have_fallen(fall(now.trough, now.highest), fall(now.trough, now.crest)):
        return False
    put(stepper.scratch, stepper.tangent)
    refine(m, work, stepper, fronts)
    now.crest = now.highest
    put(stepper.tangent, stepper.scratch)
    divide(work.c, stepper.tangent, dot(stepper.tangent, stepper.tangent))  # as ``turn`` sets it
    return now.trough < FALLEN * now.crest


@compilable
@lean
def aim_between(stepper: Stepper, share: float, x: float, back: float) -> None:
    """Aim at the mean of the points ``x`` ahead of one end of the bracket and ``back`` from the other, by ``share``."""
    ahead, behind = stepper.aimed, stepper.trial
    go(ahead, stepper.rising_q, x, stepper.rising_tangent)
    go(behind, stepper.falling_q, -back, stepper.falling_tangent)
    mix(stepper.trial, ahead, share, behind)


@compilable
@lean
def narrow(work: Work, stepper: Stepper, s: float, sign: float) -> None:
    """Let the point that was tried, with load ``s``, replace one end of the bracket of the peak.

    The maximum remains between: in front of a point that is lower than where s still rose, and behind one in a dip.
    """
    now, q, tangent = stepper.now, stepper.trial, stepper.tangent
    slope = turn(work, sign, now.orientation, tangent)
    if s > now.highest:
        now.highest = s
        put(stepper.peak_q, q)
        put(stepper.peak_plane, work.c)
    in_dip = now.rising_slope <= 0 and s < now.falling_s
    if in_dip or (slope > 0 and s >= now.rising_s):
        put(stepper.rising_q, q)
        put(stepper.rising_tangent, tangent)
        put(stepper.rising_plane, work.c)
        now.rising_s, now.rising_slope = s, slope
    else:
        put(stepper.falling_q, q)
        put(stepper.falling_tangent, tangent)
        now.falling_s, now.falling_slope = s, slope


@compiled
def loads_nearby(
    m: Elastic,
    work: Work,
    loads: Float,
    s: Float,
    q: Float,
    plane: Float,
    into: Float,
    rows: Int,
    fronts: Fronts | None,
) -> None:
    """The load at plane · q on paths of another model, from points (s, q) of this one's; -1 where not found.

    The other model has the same bodies and other nodes. Of ``rows`` of ``loads`` (k, n), ``s`` (k,), ``q`` and
    ``plane`` (k, n), it goes ``into`` (k,).
    """
    origin, there = np.zeros(q.shape[1]), np.zeros(q.shape[1])
    for k in rows:
        put(work.w, loads[k])
        put(work.c, plane[k])
        put(there, q[k])
        tolerance = TOLERANCE * max(1.0, worst(m, loads[k]) * s[k])
        path, level = Balance(1.0, 0.0, 0.0, origin), dot(plane[k], there)
        point = newton(m, work, path, there, s[k], level, tolerance, MOST_SOUGHT, TINY, fronts)
        into[k] = point.s if point.converged else -1.0


@compiled
def rests_near(m: Elastic, work: Work, q: Float, fronts: Fronts | None) -> bool:
    """Tell whether the model rests in a state near ``q`` (n,), which becomes that state, without any motion to it."""
    held = Balance(1.0, 0.0, 1.0, np.zeros(len(q)))
    work.c[:] = 0.0
    work.w[:] = 0.0
    return bool(newton(m, work, held, q, 0.0, 0.0, TOLERANCE, MOST_SOUGHT, SHORTEST, fronts).converged)
