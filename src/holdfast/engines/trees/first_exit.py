"""The first load at which a plane contact on an even bed gives way: it tips about an edge, or slides and turns.

The wrench on the contact is that at rest plus a multiple of the load's. Both are mixed, (1 - θ) rest + θ load, so that
θ from 0 to 1 takes the multiple θ / (1 - θ) from nothing to no end; what a contact can carry does not depend on the
size of the wrench. It tips where the centre of pressure reaches the border of the hull: a line of θ for each of its
edges. Before that it slides where the friction asked for is all that there is. While the bed presses everywhere, its
pressure and with it its friction are linear in θ, and the wrenches that it carries are a convex set: what holds at one
θ holds at all before. Once a part has lifted, the share of friction is looked at in places on the way to tipping, so
close to each other that between two of them it stays below 1, by a bound (most_between) or by experience (RISES).
"""

from __future__ import annotations

import math

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.engines.trees.bed import Bed, Scratch, find_pressure, second_moments, solved
from holdfast.engines.trees.limit_surface import FOUND, descend, friction, pushed, share_at_most, share_used

NEVER, TIPS, SLIDES, UNKNOWN = 0, 1, 2, 3  # how a contact gives way
# Logarithms of the ratio of the distances from tipping of two places that follow each other: the longest, and one from
# which on none is put between
LONGEST, FINEST = math.log(16.0), 0.02
# Between two places the share of friction rises above both by at most this, times the logarithm where that is below 1.
# Measured on 20,000 loads on random beds, of which the worst, where a narrow foot lifts, has 0.45
RISES = 0.5
# Share of the load that tips it which is not looked at, where the bed presses on next to nothing; at most LONG, if no
# pressure is found there
SHORT, LONG = 1e-5, 1e-3
SMALL = 0.01  # of what a step would gain, from which on it tells how much all steps would gain
ROUNDING = 1e-9  # relative difference of two θ that is none
CERTAIN = 1e-6  # relative error of a share of friction above which it counts as not found


@compiled
@lean
def _share_at(bed: Bed, rest: Float, load: Float, at: float, s: Scratch, near: bool, short: bool) -> float:
    """Return the share of friction that is used at θ = ``at``; -1 if it is not found.

    If ``short``, a bound of it does where that is less than 1. If ``near``, ``s.p`` is from a θ near by.
    """
    for i in range(3):
        s.q[i] = (1 - at) * rest[i] + at * load[i]
    if not find_pressure(bed, s.q, s, near):
        return -1.0
    for i in range(3):
        s.t[i] = (1 - at) * rest[3 + i] + at * load[3 + i]
    if short and bed.size[1] > 0.0:
        most = share_at_most(s.t, s, bed)
        if most < 1 - CERTAIN:
            return most
    share, error = share_used(bed, s.t, s)
    return share if error <= CERTAIN else -1.0


@compiled
@lean
def most_between(bed: Bed, rest: Float, load: Float, low: float, at: float, squares: float) -> float:
    """Return a share of friction, μ being one for all, that is used at most between θ = ``low`` and θ = ``at``.

    ``squares`` are ∫ p² dA there, a convex function of what is carried, at most. A pressure with the force N and the
    integral S of its square resists a turn about any point with μ N R / 2 at least, R = N √(3 / (2 π S)): a cone of
    that radius does. It resists as well the force μ N in the centre of pressure, and any mixture of both.
    """
    least, force, torque = math.inf, 0.0, 0.0
    d0, d1, d2 = load[0] - rest[0], load[1] - rest[1], load[2] - rest[2]
    d3, d4, d5 = load[3] - rest[3], load[4] - rest[4], load[5] - rest[5]
    for theta in (low, at):
        n, x, y = rest[0] + theta * d0, rest[1] + theta * d1, rest[2] + theta * d2
        tx, ty, tz = rest[3] + theta * d3, rest[4] + theta * d4, rest[5] + theta * d5
        least, force = min(least, n), max(force, math.hypot(tx, ty))
        torque = max(torque, abs(n * tz - x * ty + y * tx))
    if not least > 0.0:
        return math.inf
    torque += abs(d0 * d5 - d1 * d4 + d2 * d3) * (at - low) ** 2 / 4  # between both it is a parabola
    radius = math.sqrt(1.5 / (math.pi * squares)) * least
    return float((2 * torque / (radius * least) + force) / (bed.size[1] * least))


@compiled
@lean
def _slope(bed: Bed, rest: Float, load: Float, share: float, s: Scratch) -> float:
    """Return the derivative by θ of the ``share`` of friction used, where ``_share_at`` found it.

    The motion stays (it is a minimum), and the pressure changes by a linear field where the bed presses.
    """
    for i in range(3):
        s.q[i] = load[i] - rest[i]
    second_moments(bed, s.p, 0.0, 0.0, s.M)
    if not solved(s.M, s.q, s.new):
        return 0.0
    gained = 0.0
    for i in range(3):
        gained += s.m[i] * (load[3 + i] - rest[3 + i])
    return share * (gained - share * friction(bed, s.p, s.new, s.m, s, s.g, s.L))


@compiled
@lean
def _lifts_at(bed: Bed, rest: Float, load: Float, s: Scratch) -> float:
    """Return the θ up to which the bed presses everywhere, 0 if it does not do so at rest.

    ``s.p0`` and ``s.p1`` are then its pressures at rest and under the load alone.
    """
    s.p[0], s.p[1], s.p[2] = 1.0, 0.0, 0.0
    second_moments(bed, s.p, 0.0, 0.0, s.M)
    for i in range(3):
        s.q[i], s.t[i] = rest[i], load[i]
    if not (solved(s.M, s.q, s.p0) and solved(s.M, s.t, s.p1)):
        return 0.0
    until = 1.0
    for k in range(len(bed.edges)):
        x, y = bed.edges[k, 0], bed.edges[k, 1]
        before, behind = s.p0[0] + s.p0[1] * x + s.p0[2] * y, s.p1[0] + s.p1[1] * x + s.p1[2] * y
        if before <= 0.0:
            return 0.0
        if behind < 0.0:
            until = min(until, before / (before - behind))
    return until


@compiled
@lean
def _slides_evenly(bed: Bed, rest: Float, load: Float, end: float, s: Scratch) -> tuple[float, float]:
    """Return the θ before ``end`` at which a bed that presses everywhere slides, and by how much that may be too large.

    Its pressure, and with it its friction, is linear in θ: ``s.p0`` at rest and ``s.p1`` under the load alone. So each
    motion is overcome at a θ that follows from its powers, and the least of them is sought. The θ is ``end`` where
    nothing slides before, and -1 where that is not found.
    """
    at, m, f, K, f0, K0 = end, s.m, s.f, s.K, s.g, s.L
    spare = 0.0
    s.middle[0], s.middle[1], s.middle[2] = 0.0, 0.0, bed.size[0]
    _mixed(rest, load, at, s)
    if pushed(s.t, m, bed.size[0], K) == 0.0:
        return end, 0.0
    power = friction(bed, s.p0, s.p, m, s, f, K)
    for _ in range(60):
        if power < 1.0:
            spare = friction(bed, s.p0, s.p0, m, s, f0, K0)
            for i in range(3):
                spare -= rest[3 + i] * m[i]
            if not spare > 0.0:
                return -1.0, 0.0
            sooner = spare / (spare + 1 - power)
            at *= sooner
            for i in range(3):
                f[i] = f0[i] + sooner * (f[i] - f0[i])
                for j in range(3):
                    K[i, j] = K0[i, j] + sooner * (K[i, j] - K0[i, j])
            _mixed(rest, load, at, s)
            spare *= pushed(s.t, m, bed.size[0], K)
            power = 1.0
        before = power
        gap, power, moved = descend(bed, s.t, power, s)
        if spare == 0.0 and gap < SMALL and before * (1 - 2 * gap) > 1 + CERTAIN:
            return end, 0.0
        if not moved:
            return (at, CERTAIN * at / spare if spare > 0.0 else 0.0) if gap < FOUND else (-1.0, 0.0)
    return -1.0, 0.0


@compiled
@lean
def _mixed(rest: Float, load: Float, at: float, s: Scratch) -> None:
    """Write the pressure ``s.p`` of a bed that presses everywhere, and the tangential wrench ``s.t``, at θ = ``at``."""
    for i in range(3):
        s.p[i] = (1 - at) * s.p0[i] + at * s.p1[i]
        s.t[i] = (1 - at) * rest[3 + i] + at * load[3 + i]


@compiled
@lean
def first_exit(bed: Bed, rest: Float, load: Float, until: float, s: Scratch, out: Float) -> int:
    """Tell how a contact gives way under ``rest`` plus a growing multiple of ``load`` (6,), and write when to ``out``.

    Both are what the bed carries: N, N x, N y of its pressure, and the force and the torque along the plane. ``out``
    (6,) is θ, a θ that is certainly not too large and one that is not too small, and the motion with which it slides
    or, if it tips, the number of the edge of the hull, that of another one that it reaches at once, or -1, and how fast
    it does so, over the first. From θ = ``until`` on, something else gives way: NEVER says that this contact does not
    before.
    """
    tips, edge, other, rate, slower = until, -1, -1, 0.0, 0.0
    for k in range(len(bed.hull)):
        before, behind = 0.0, 0.0
        for i in range(3):
            before += bed.hull[k, i] * rest[i]
            behind += bed.hull[k, i] * load[i]
        if behind >= 0.0 or before >= (before - behind) * tips * (1 + ROUNDING):
            continue
        if edge >= 0 and before > (before - behind) * tips * (1 - ROUNDING):  # the corner between two edges
            other, slower = k, behind
        else:
            tips, edge, other, rate = before / (before - behind), k, -1, behind
    end = tips if edge < 0 else _before(tips, SHORT)
    lifted, around = min(_lifts_at(bed, rest, load, s), end), 0.0
    if lifted > 0.0:
        at, around = _slides_evenly(bed, rest, load, lifted, s)
        if at < 0.0:
            return UNKNOWN
        if around > 0.0:
            out[0], out[1], out[2], out[3], out[4], out[5] = at, max(at - around, 0.0), at, s.m[0], s.m[1], s.m[2]
            return SLIDES
    low, high, before, near, step, squares = lifted, -1.0, -1.0, False, 0.0, 0.0
    last = tips if edge >= 0 else tips + (tips - lifted) / 15
    while low < end * (1 - ROUNDING):
        at = min(last - (last - low) * math.exp(-step), end)
        share = _share_at(bed, rest, load, at, s, near, True)
        if share < 0.0:
            if edge >= 0 and low >= _before(tips, LONG):
                break
            if step <= FINEST:
                return UNKNOWN
            step, near = step / 2, False
            continue
        near = True
        if share > 1.0:
            high = at
            break
        most, sure = s.p[0] * s.q[0] + s.p[1] * s.q[1] + s.p[2] * s.q[2], False
        if bed.size[1] > 0.0 and step > 0.0:
            sure = most_between(bed, rest, load, low, at, max(squares, most)) < 1.0
        if not sure and step > FINEST and max(before, share) > 1 - RISES * min(step, 1.0):
            step /= 2
        else:
            low, before, squares, step = at, share, most, min(2 * step, LONGEST) if step > 0.0 else LONGEST
    if high < 0.0:
        out[0], out[1], out[2], out[3], out[4], out[5] = tips, low, tips, edge, other, slower / rate if rate else 0.0
        return NEVER if edge < 0 else TIPS
    at, slope = high, 0.0
    for _ in range(60):  # Newton's method between two places of which one holds
        slope = _slope(bed, rest, load, share, s)
        new = at - (share - 1) / slope if slope > 0.0 else -1.0
        close = CERTAIN * high * (1 - low) + 1e-15
        if high - low <= close or (low < new < high and abs(new - at) <= close):
            break
        at = new if low < new < high else (low + high) / 2
        share = _share_at(bed, rest, load, at, s, True, False)
        if share < 0.0:
            return UNKNOWN
        if share > 1.0:
            high = at
        else:
            low = at
    around = 10 * CERTAIN * at * (1 - at)
    out[0], out[1], out[2] = at, max(at - around, 0.0), min(at + around, tips)
    out[3], out[4], out[5] = s.m[0], s.m[1], s.m[2]
    return SLIDES


@compiled
@lean
def _before(tips: float, short: float) -> float:
    """Return the θ at which the load is smaller by the share ``short`` than at θ = ``tips``."""
    return tips * (1 - short) / (1 - tips * short)


@compiled
def first_exits(bed: Bed, rest: Float, loads: Float, until: Float, out: Float, kinds: Int, s: Scratch) -> None:
    """Write what ``first_exit`` finds of each of the ``loads`` (n, 6) to ``out`` (n, 6) and ``kinds`` (n,)."""
    for k in range(len(loads)):
        s.m[0], s.m[1], s.m[2] = 0.0, 0.0, 0.0  # so that no answer depends on the load before
        kinds[k] = first_exit(bed, rest, loads[k], until[k], s, out[k])


@compiled
def share_at_rest(bed: Bed, rest: Float, s: Scratch) -> float:
    """Return which share of its friction a contact uses under ``rest`` (6,): -1 if not found, 2 if it tips."""
    for k in range(len(bed.hull)):
        if bed.hull[k, 0] * rest[0] + bed.hull[k, 1] * rest[1] + bed.hull[k, 2] * rest[2] <= 0.0:
            return 2.0
    s.m[0], s.m[1], s.m[2] = 0.0, 0.0, 0.0
    return _share_at(bed, rest, rest, 0.0, s, False, False)
