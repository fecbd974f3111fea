"""The load path, from rest to its peak and beyond, by arc length."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable, compiled
from holdfast.elastic.law import Elastic, next_change
from holdfast.elastic.linear import SparseSolver, Work, solve
from holdfast.elastic.newton import dot, newton, unbalance, worst

PEAK, ENDLESS, LOST = 1, 2, 0
KIND = 0  # entry of what follow tells

TOLERANCE = 1e-7  # residual of points on the path
FALLEN = 0.99  # share of the peak at which the path has clearly fallen
NEW_PEAK = 1e-5  # relative: what counts as a higher peak
FAINT = 1e-8  # drag while forces under the load alone are sought
FLAT = 1e-4  # relative rise that the path would still bring if its slope fell as 1/length², below which it is flat
REFINED = 5e-5  # relative accuracy of the peak
FARTHEST = 1e8  # length over the size of the rest state at which rounding would show
FASTEST = 4.0  # growth of the step from one point to the next
TURN = 0.3  # share of a step that its correction should be
TORN = 0.7  # share of a step by which it leaves the mean of the directions at its ends, if it led to another branch
POINTS = 400  # on a path
LATE = 60  # points without a new peak after which there is none to come


@compiled
def _turn(work: Work, t: Float, first: float) -> float:
    """Point the path's direction t (n,) onwards, scale it, set work.c to its plane; returns ds/dℓ.

    Onwards is where s rises while the stiffness has the sign of determinant it had at rest, and falls while it has the
    other: the sign of the bordered determinant tells, whatever the border. The plane is across the motion of the body
    that moves most.
    """
    n = len(t)
    best, body = -1.0, 0
    for j in range(n // 6):
        total = 0.0
        for i in range(6 * j, 6 * j + 6):
            total += work.rhs[i, 1] ** 2
        if total > best:
            best, body = total, j
    size = first * work.ask[2] / max(np.sqrt(best), 1e-300)
    for i in range(n):
        t[i] = size * work.rhs[i, 1]
        work.c[i] = t[i] if i // 6 == body else 0.0
    return float(size * work.rhs[n, 1])


@compiled
def _torn(work: Work, q: Float, t: Float, trial: Float, step: float, first: float) -> bool:
    """Whether the step from q along t to ``trial`` leaves what the directions of the path at both ends say.

    Then a nearer solution may lie on the path, and this one on another branch.
    """
    there = np.zeros(len(t))
    plane = work.c.copy()
    _turn(work, there, first)
    work.c[:] = plane
    away, far = 0.0, 0.0
    for i in range(len(t)):
        moved = trial[i] - q[i]
        away = max(away, abs(moved - 0.5 * step * (t[i] + there[i])))
        far = max(far, abs(moved))
    return bool(away > TORN * far)


@compilable
def _resistance(
    m: Elastic, work: Work, c: Float, qa: Float, qb: Float, s: float, cut: Float, sparse: SparseSolver | None
) -> None:
    """How the peak between the points qa and qb answers to other loads: peak / peak' = cut · load' to first order.

    ``cut`` (6J,) is the left null vector of the stiffness, cut · load = 1. Where a node changes its state at the peak,
    it is the mean of the vectors from both sides under which moving along the path changes nothing.
    """
    n = len(cut)
    cut[:] = 0.0
    work.c[:] = c
    work.ask[0], work.ask[1], work.ask[3] = 0.0, 0.0, 1.0
    before = 0.0
    for side in range(2):
        unbalance(m, work, 1.0, qa if side == 0 else qb, s, qa)
        work.rhs[:] = 0.0
        work.rhs[n, 0] = -1.0
        solve(m, work, sparse)
        if work.ask[2] == 0.0:
            break
        slope = -work.rhs[n, 0]
        if side == 0:
            before = slope
            cut[:] = work.rhs[:n, 0]
        else:
            share = 1.0 if abs(slope) < abs(before) else 0.0
            if before > 0 > slope:
                share = before / (before - slope)
            cut[:] = (1 - share) * cut + share * work.rhs[:n, 0]
    work.ask[3] = 0.0


@compilable
def _alone(
    m: Elastic, work: Work, strength: float, q: Float, most: int, inner: Float, sparse: SparseSolver | None
) -> bool:
    """Whether forces of this law balance the load work.w alone, found from q, which they change."""
    one, anchor = np.ones(1), q.copy()
    work.c[:] = 0.0
    work.ask[0], work.ask[1] = FAINT, 1.0  # bodies that the load does not reach float: a faint drag holds them
    newton(m, work, 0.0, q, one, 0.0, TOLERANCE * strength, most, anchor, inner, sparse)
    work.ask[0], work.ask[1] = 0.0, 0.0
    unbalance(m, work, 0.0, q, 1.0, anchor)
    return bool(inner[0] > 0 and worst(m, work.r) <= 10 * TOLERANCE * strength)


@compilable
def follow(
    m: Elastic,
    work: Work,
    start: Float,
    load: Float,
    peak: Float,
    motion: Float,
    plane: Float,
    cut: Float,
    told: Float,
    sparse: SparseSolver | None,
) -> None:
    """Raise s from 0 at the rest state ``start`` (6J,) along the path r(q) + s load = 0.

    Plane by plane across the motion (pseudo-arc-length), so that neither a falling load nor a point that moves back
    stops it. Where no step succeeds, a node is about to change its state: the path is then continued from just behind
    that change. In the end ``told`` (8,) holds: PEAK, ENDLESS or LOST; the peak of s; the last s; by how much the peak
    may be missed; the systems solved; the points; the length reached over the size of the rest state. ``peak`` is q at
    the peak (ENDLESS: under the load alone), ``plane`` (6J,) the direction across which it was found, ``motion`` the
    direction of the path at its end. ``cut`` (6J,) tells how the peak answers to other loads (_resistance); empty (0,)
    if that is not wanted.
    """
    n = len(start)
    inner, s, trial_s, origin = np.zeros(3), np.zeros(1), np.zeros(1), np.zeros(n)
    q, trial, t = start.copy(), start.copy(), np.zeros(n)
    qa, ta, ca, qb, tb, cp = q.copy(), np.zeros(n), np.zeros(n), q.copy(), np.zeros(n), np.zeros(n)
    aimed = np.zeros(n)
    told[:] = 0.0
    peak[:] = start
    work.ask[0], work.ask[1] = 0.0, 0.0
    work.w[:] = load
    work.c[:] = load
    strength = worst(m, load)
    elastic = max(np.abs(q).max(), 1e-300)
    newton(m, work, 1.0, q, s, dot(load, q), TOLERANCE, 5, origin, inner, sparse)
    if inner[0] == 0.0:
        return
    solved = 1.0
    first = work.ask[2] if work.rhs[n, 1] > 0 else -work.ask[2]  # the sign of the stiffness's determinant
    slope = _turn(work, t, first)
    step = min(0.1 / (strength * slope), 10 * elastic) if slope > 0 else 1e-3 * elastic
    length, at_peak, flat_since, similar = 0.0, 0.0, np.inf, np.inf
    highest, kinks, shortened, points, late, doubted = 0.0, 0, 0, 0, 0, False
    # the peak lies between the points a, where s rises, and b, once b is ``closed``
    qa[:], ta[:], ca[:], cp[:] = q, t, work.c, work.c
    sa, pa, sb, pb, closed = 0.0, slope, 0.0, 0.0, slope <= 0
    while points < POINTS:
        trial[:] = q + step * t
        trial_s[0] = s[0] + step * slope
        aimed[:] = trial
        exact = TOLERANCE * max(1.0, min(1e-7 * length / elastic, 10.0), 0.01 * strength * abs(s[0]))
        newton(m, work, 1.0, trial, trial_s, dot(work.c, trial), exact, 8, origin, inner, sparse)
        solved += inner[1] + 1
        backward = first * work.ask[2] < 0  # behind its plane the path would come back: rather another branch
        turned = np.abs(trial - aimed).max() / max(np.abs(aimed - q).max(), 1e-300)
        if inner[0] > 0 and not backward and not doubted and turned > TURN:
            doubted = _torn(work, q, t, trial, step, first)
            if doubted:  # once: where the path has a sharp corner every step is torn
                step *= 0.3
                continue
        if inner[0] == 0.0 or (backward and shortened < 3):
            shortened += 1
            if shortened < 4:
                step *= 0.3
                continue
            change = next_change(m, q, t)
            kinks += 1
            if kinks > 40 or not length + change <= FARTHEST * elastic:  # further out rounding would balance anything
                break
            change = change * (1 + 1e-7) + 1e-12 * (elastic + length)
            q += change * t
            s[0] += change * slope
            length += change
            unbalance(m, work, 1.0, q, s[0], origin)
            work.rhs[:] = 0.0
            work.rhs[n, 1] = 1.0
            solve(m, work, sparse)
            solved += 1
            if work.ask[2] == 0.0:  # a body has lost its last contact
                if s[0] > highest and worst(m, work.r) <= exact:
                    highest = s[0]
                    peak[:] = q
                break
            slope = _turn(work, t, first)
            step = min(100 * step, 0.1 * (elastic + length))
            shortened = 0
            continue
        shortened, doubted = 0, False
        points += 1
        late += 1
        if trial_s[0] > highest:
            if trial_s[0] > highest * (1 + NEW_PEAK):
                at_peak, late = length + step, 0
            highest = trial_s[0]
            peak[:] = trial
            qa[:], ta[:], ca[:], sa, pa = q, t, work.c, s[0], slope
            slope = _turn(work, t, first)
            cp[:] = work.c
            closed = slope <= 0
            if closed:
                qb[:], tb[:], sb, pb = trial, t, trial_s[0], slope
            else:
                qa[:], ta[:], ca[:], sa, pa = trial, t, work.c, trial_s[0], slope
        else:
            slope = _turn(work, t, first)
            if not closed:
                qb[:], tb[:], sb, pb, closed = trial, t, trial_s[0], slope, True
        q[:] = trial
        s[0] = trial_s[0]
        length += step
        told[2], told[5], told[6] = s[0], points, length / elastic
        if s[0] < FALLEN * highest or length >= (10 if slope < 0 else 100) * at_peak or late > LATE:
            told[0] = 1.0
            break
        if length > FARTHEST * elastic:
            told[0], told[3] = 1.0, max(slope * length, 0.0) if s[0] >= highest else 0.0
            break
        if abs(slope) * length > FLAT * abs(s[0]):
            flat_since = np.inf
        elif length >= 10 * min(flat_since, length) and length > 30 * elastic:
            told[0] = 1.0
            break
        else:
            flat_since = min(flat_since, length)
        if slope > 0 and abs(slope * length - s[0]) < 0.05 * s[0]:
            similar = min(similar, length)
            if length >= 10 * similar and length > 100 * elastic:
                similar = length
                peak[:] = q / s[0]
                plane[:] = work.c
                carried = _alone(m, work, strength, peak, 12, inner, sparse)
                solved += inner[1] + 1
                if carried:
                    told[0], told[1], told[4] = 2.0, np.inf, solved
                    motion[:] = t
                    return
                work.c[:] = plane
                peak[:] = q
        else:
            similar = np.inf
        step = min(step * min(max(TURN / max(turned, 1e-9), 0.7), FASTEST), 3 * length)
    motion[:] = t
    failed = 0
    for _ in range(20):
        h = dot(ca, qb) - dot(ca, qa)
        along = dot(ca, tb)
        if not closed or told[0] == 0.0 or h <= 0 or failed > 5:
            break
        falling = pb / along if along > 0 else 0.0
        x, estimate = 0.5 * h, sa + pa * h
        if falling < 0 < pa:
            x = min(max((sb - falling * h - sa) / (pa - falling), 0.0), h)
            estimate = sa + pa * x
        told[3] = max(estimate - highest, 0.0)
        if told[3] <= REFINED * highest:
            break
        x = min(max(x, 0.1 * h), 0.9 * h) * 0.2**failed
        share = x / h if failed == 0 else 0.0
        back = (h - x) / along if along > 0 else 0.0
        trial[:] = (1 - share) * (qa + x * ta) + share * (qb - back * tb)
        trial_s[0] = (1 - share) * (sa + pa * x) + share * sb
        work.c[:] = ca
        newton(m, work, 1.0, trial, trial_s, dot(ca, qa) + x, TOLERANCE, 12, origin, inner, sparse)
        solved += inner[1] + 1
        if inner[0] == 0.0:
            failed += 1
            continue
        failed = 0
        slope = _turn(work, t, first)
        if trial_s[0] > highest:
            highest = trial_s[0]
            peak[:], cp[:] = trial, work.c
        if slope > 0:
            qa[:], ta[:], ca[:], sa, pa = trial, t, work.c, trial_s[0], slope
        else:
            qb[:], tb[:], sb, pb = trial, t, trial_s[0], slope
    plane[:] = cp
    if len(cut) > 0 and told[0] > 0:
        _resistance(m, work, ca, qa, qb if closed else qa, highest, cut, sparse)
        solved += 2
    told[1], told[4] = highest, solved


@compiled
def follow_dense(
    m: Elastic,
    work: Work,
    start: Float,
    loads: Float,
    peak: Float,
    motion: Float,
    plane: Float,
    cut: Float,
    told: Float,
) -> None:
    """``follow`` with dense elimination for loads (n, 6J), into rows of the results."""
    for k in range(len(loads)):
        follow(m, work, start, loads[k], peak[k], motion[k], plane[k], cut[k], told[k], None)


@compilable
def again(m: Elastic, work: Work, load: Float, s: float, q: Float, plane: Float, sparse: SparseSolver | None) -> float:
    """The load at the displacement of a peak (s, q), plane · q, on the nodes of another model; -1 if not found."""
    inner, found, trial, origin = np.zeros(3), np.zeros(1), q.copy(), np.zeros(len(q))
    work.ask[:] = 0.0
    work.w[:] = load
    work.c[:] = plane
    found[0] = s
    newton(
        m, work, 1.0, trial, found, dot(plane, q), TOLERANCE * max(1.0, worst(m, load) * s), 20, origin, inner, sparse
    )
    return found[0] if inner[0] > 0 else -1.0


@compiled
def again_dense(m: Elastic, work: Work, loads: Float, s: Float, q: Float, plane: Float, found: Float) -> None:
    """``again`` by dense elimination for k peaks, into ``found`` (k,)."""
    for k in range(len(s)):
        found[k] = again(m, work, loads[k], s[k], q[k], plane[k], None)
