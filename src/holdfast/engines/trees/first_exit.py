"""The first load at which a plane contact on an even bed gives way: it tips about an edge, or slides and turns.

The wrench on the contact is that at rest plus a multiple of the load's. Both are mixed, (1 - θ) rest + θ load, so that
θ from 0 to 1 takes the multiple θ / (1 - θ) from nothing to no end; what a contact can carry does not depend on the size
of the wrench. It tips where the centre of pressure reaches the border of the hull: a line of θ for each of its edges.
Before that it slides where the friction asked for is all that there is. While the bed presses everywhere, its pressure
and with it its friction are linear in θ, and the wrenches that it carries are a convex set: what holds at one θ holds
at all before. Once a part has lifted, that is looked at in STEPS places on the way to tipping.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.engines.trees.bed import Bed, Scratch, find_pressure, friction, second_moments, share_used, solved

NEVER, TIPS, SLIDES, UNKNOWN = 0, 1, 2, 3
STEPS = 5  # places at which a bed that has lifted in part is looked at, each 16 times closer to tipping
# Share of the load that tips it which is not looked at, where the bed presses on next to nothing: ten times as much if no
# pressure is found there, and at most LONG
SHORT, LONG = 1e-5, 1e-3
CERTAIN = 1e-6  # relative error of a share of friction above which it counts as not found


@compiled
@lean
def _share_at(bed: Bed, rest: Float, load: Float, at: float, s: Scratch, near: bool) -> float:
    """Return the share of friction that is used at θ = ``at``; -1 if it is not found."""
    for i in range(3):
        s.q[i] = (1 - at) * rest[i] + at * load[i]
    if not find_pressure(bed, s.q, s, near):
        return -1.0
    for i in range(3):
        s.t[i] = (1 - at) * rest[3 + i] + at * load[3 + i]
    share, error = share_used(bed, s.t, s)
    return share if error <= CERTAIN else -1.0


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
    return share * (gained - share * friction(bed, s.p, s.new, s.m, s, s.other_f, s.other_K))


@compiled
@lean
def _lifts_at(bed: Bed, rest: Float, load: Float, s: Scratch) -> float:
    """Return the θ up to which the bed presses everywhere: 0 if it does not do so at rest."""
    s.p[0], s.p[1], s.p[2] = 1.0, 0.0, 0.0
    second_moments(bed, s.p, 0.0, 0.0, s.M)
    for i in range(3):
        s.q[i], s.t[i] = rest[i], load[i]
    if not (solved(s.M, s.q, s.new) and solved(s.M, s.t, s.trial)):
        return 0.0
    until = 1.0
    for k in range(len(bed.edges)):
        x, y = bed.edges[k, 0], bed.edges[k, 1]
        before, behind = s.new[0] + s.new[1] * x + s.new[2] * y, s.trial[0] + s.trial[1] * x + s.trial[2] * y
        if before <= 0.0:
            return 0.0
        if behind < 0.0:
            until = min(until, before / (before - behind))
    return until


@compiled
@lean
def first_exit(bed: Bed, rest: Float, load: Float, s: Scratch, out: Float) -> int:
    """Tell how a contact gives way under ``rest`` plus a growing multiple of ``load`` (6,), and write when to ``out``.

    Both are what the bed carries: N, N x, N y of its pressure, and the force and the torque along the plane. ``out``
    (6,) is θ, a θ that is certainly not too large and one that is not too small, and the motion with which it slides or,
    if it tips, the number of the edge of the hull in place of the first of its numbers.
    """
    tips, edge = 1.0, -1
    for k in range(len(bed.hull)):
        before, behind = 0.0, 0.0
        for i in range(3):
            before += bed.hull[k, i] * rest[i]
            behind += bed.hull[k, i] * load[i]
        if behind < 0.0 and before / (before - behind) < tips:
            tips, edge = before / (before - behind), k
    short = 0.0 if edge < 0 else SHORT
    end = tips * (1 - short) / (1 - tips * short)
    at = min(_lifts_at(bed, rest, load, s), end)
    low, high = 0.0, -1.0
    s.m[0], s.m[1], s.m[2] = 0.0, 0.0, 0.0
    share = _share_at(bed, rest, load, at, s, False)
    lifted, step = at, 0
    while True:
        if share < 0.0:
            if at < end or short == 0.0 or 10 * short > LONG:
                return UNKNOWN
            short *= 10
            at = end = tips * (1 - short) / (1 - tips * short)
        else:
            if share > 1.0:
                high = at
                break
            low = at
            step += 1
            if low >= end or step > STEPS:
                break
            at = tips - (tips - lifted) / 16.0**step if short > 0.0 else lifted + (end - lifted) * step / STEPS
            at = min(at, end)
        share = _share_at(bed, rest, load, at, s, share >= 0.0)
    if high < 0.0:
        out[0], out[1], out[2], out[3], out[4], out[5] = tips, end, tips, edge, 0.0, 0.0
        return NEVER if edge < 0 else TIPS
    for _ in range(60):  # Newton's method between two places of which one holds
        slope = _slope(bed, rest, load, share, s)
        new = at - (share - 1) / slope if slope > 0.0 else -1.0
        close = CERTAIN * high * (1 - low) + 1e-15
        if high - low <= close or (low < new < high and abs(new - at) <= close):
            break
        at = new if low < new < high else (low + high) / 2
        share = _share_at(bed, rest, load, at, s, True)
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
def first_exits(bed: Bed, rest: Float, loads: Float, out: Float, kinds: Int, s: Scratch) -> None:
    """Write what ``first_exit`` finds of each of the ``loads`` (n, 6) to ``out`` (n, 6) and ``kinds`` (n,)."""
    for k in range(len(loads)):
        kinds[k] = first_exit(bed, rest, loads[k], s, out[k])


@compiled
def share_at_rest(bed: Bed, rest: Float, s: Scratch) -> float:
    """Return which share of its friction a contact uses under ``rest`` (6,): -1 if not found, 2 if it tips."""
    for k in range(len(bed.hull)):
        if bed.hull[k, 0] * rest[0] + bed.hull[k, 1] * rest[1] + bed.hull[k, 2] * rest[2] <= 0.0:
            return 2.0
    s.m[0], s.m[1], s.m[2] = 0.0, 0.0, 0.0
    return _share_at(bed, rest, rest, 0.0, s, False)
