"""The numbers of a walk along a load path, and what follows from them alone: whether it ends, and the next step."""

from __future__ import annotations

import numpy as np

from holdfast.base.compiled import compilable, lean
from holdfast.elastic.outcome import Event

DIP = 2e-3  # relative fall below the peak so far from which that was a maximum, even if the path rises above it later
FALLEN = 0.99  # share of the peak below which the path has clearly fallen
LEVEL, HIDDEN = 0.05, 0.05  # of the slope before a step, where a maximum may hide in it, and of the load: how high
FLAT = 1e-4  # relative rise still to come, if the slope fell as 1/ℓ², below which the path counts as flat
ENOUGH = 1.01  # times a step that leads to where a path has been flat for long enough: it may bend
FARTHEST = 1e8  # length, in sizes of the displacement at rest, at which rounding would show
CARRIED = 1e-5  # share of a body's weight or of the load that the faint hold carries where a path ends
FASTEST = 3.0  # largest growth of the step from one point to the next
TURN = 0.3  # wanted correction of a point, as a share of the step
RECOVERY = 1.4  # factor by which the largest growth recovers from one point to the next
LATE, FARTHER = 12, 1.5  # points without a new peak, and growth of the length, after which none is expected
TOO_LATE = 40  # points without a new peak after which none is waited for, however near


class Progress:
    """The numbers of a walk along a path.

    Constants: ``orientation``, the sign of the stiffness's determinant at rest; ``strength``, the largest component of
    the load, each body's in its own weight and size; ``elastic``, the largest displacement at rest that counts.

    Where it is: ``s`` and the ``slope`` ds/dℓ; what the faint hold has ``carried``, of each body's own weight; the
    ``step`` Δℓ to be tried; the ``length`` ℓ so far; ``last``, s of the last regular point; ``turned``, the last
    correction as a share of its step, and the ``sharpest``, the largest of all points but the first; ``points`` found,
    linear ``systems`` solved, node ``changes`` crossed; how often this step failed and was ``shortened``, and how often
    it was ``doubted``; the ``fastest`` growth of the step for now; whether a ``corner`` lies just behind the step, and
    the step to be tried ``beyond`` it.

    Of the peak: ``highest`` s; ``noted``, the last s that counted as a new peak, at the length ``at_peak``, and the
    points since (``late``); ``short``, by how much it may be too low; the maximum from which s has ``dipped``, and the
    ``first`` one above which it has risen after that, 0 if there was none; the ``crest``, the highest s between points,
    as estimated, and the lowest point since, the ``trough``. The peak lies between a point where s rises
    (``rising_s``, ``rising_slope``) and one where it does not (``falling_s``, ``falling_slope``), once the latter is
    known: ``closed``. The number of ``stations`` kept on the way to it.

    Of the end: the lengths since which the path has been flat (``flat_since``) and since which s has grown in
    proportion to ℓ (``similar_since``); inf if it is not.
    """

    orientation: float = 0.0
    strength: float = 0.0
    elastic: float = 0.0
    s: float = 0.0
    slope: float = 0.0
    carried: float = 0.0
    step: float = 0.0
    length: float = 0.0
    last: float = 0.0
    turned: float = 0.0
    sharpest: float = 0.0
    points: int = 0
    systems: int = 0
    changes: int = 0
    shortened: int = 0
    fastest: float = FASTEST
    beyond: float = 0.0
    corner: bool = False
    doubted: int = 0
    highest: float = 0.0
    noted: float = 0.0
    at_peak: float = 0.0
    late: int = 0
    short: float = 0.0
    dipped: float = 0.0
    first: float = 0.0
    crest: float = 0.0
    trough: float = 0.0
    rising_s: float = 0.0
    rising_slope: float = 0.0
    falling_s: float = 0.0
    falling_slope: float = 0.0
    closed: bool = False
    stations: int = 0
    flat_since: float = 0.0
    similar_since: float = 0.0


RECORD = np.dtype(
    [(name, {"float": "f8", "int": "i8", "bool": "?"}[kind]) for name, kind in Progress.__annotations__.items()],
    align=True,
)


@compilable
@lean
def measure_dip(now: Progress, rise: float, s: float, falls: float) -> None:
    """Take note of the highest s between points and of the lowest point since, where a step leads to ``s``.

    ``rise`` is what s would have risen by at the slope before the step, and ``falls`` at the slope behind it.
    """
    top = max(now.s, s)
    if rise > 0 > falls:
        top = extremum(now.s, rise, s, falls)
    if top > now.crest:
        now.crest, now.trough = top, s
    now.trough = min(now.trough, s)


@compilable
@lean
def passes_over(now: Progress, rise: float, s: float, falls: float) -> bool:
    """Whether a step to where the path is nearly level, at ``s``, may have passed over a maximum of the load.

    That may have gone on as before for a while: by HIDDEN more than it is now, had it done so all the way. The slopes
    at both ends are as ``measure_dip`` has them.
    """
    return bool(falls < LEVEL * rise and now.s + rise > s + HIDDEN * abs(s))


@compilable
@lean
def hides_dip(now: Progress, rise: float, s: float, falls: float) -> bool:
    """Whether a step to ``s`` may hide how far the load falls, where that decides about a maximum.

    Where the slopes at both ends, as ``measure_dip`` has them, differ in sign, there is an extremum between: about as
    high or low as that of the cubic with these slopes, or hardly beyond the ends.
    """
    if not (rise > 0 > falls or rise < 0 < falls):
        return False
    between = extremum(now.s, rise, s, falls)
    high = max(now.highest, s)
    low = min(now.trough, s) if s < now.highest else s
    if rise > 0:
        top, bottom = max(high, between), low
    else:
        top, bottom = now.crest, min(now.trough, between)
    clearly = bottom < FALLEN * top and not low < FALLEN * high
    return clearly or (now.dipped == 0 and bottom < (1 - DIP) * top and not low < (1 - DIP) * high)


@compilable
@lean
def extremum(start: float, a: float, end: float, b: float) -> float:
    """The extremum of the cubic from (0, ``start``) to (1, ``end``) with slopes a and b there, of opposite signs."""
    x = extremum_at(start, a, end, b)
    return float(start + x * (a + x * (3 * (end - start) - 2 * a - b + x * (a + b - 2 * (end - start)))))


@compilable
@lean
def extremum_at(start: float, a: float, end: float, b: float) -> float:
    """Where that extremum is: 0 < x < 1."""
    rise, sign = end - start, 1.0 if a > 0 else -1.0  # a minimum is a maximum of what is upside down
    A, B, C = sign * a, sign * (3 * rise - 2 * a - b), 3 * sign * (a + b - 2 * rise)
    root = np.sqrt(max(B * B - A * C, 0.0))
    return float(-(B + root) / C if B > 0 else A / (root - B))  # where A + 2 B x + C x² = 0


@compilable
@lean
def appraise(now: Progress) -> Event:
    """Whether the new point is the end of the path: FALLEN, FAR, FLAT, perhaps PROPORTIONAL, or else ADVANCED."""
    s, slope, length, elastic = now.s, now.slope, now.length, now.elastic
    late = now.late > TOO_LATE or (now.late > LATE and length > FARTHER * now.at_peak)
    if s < FALLEN * now.highest or length >= (10 if slope < 0 else 100) * now.at_peak or late:
        return Event.FALLEN
    if abs(slope) * length > FLAT * abs(s):
        now.flat_since = np.inf
    elif length >= flat_end(now):
        return Event.FLAT
    else:
        now.flat_since = min(now.flat_since, length)
    if slope > 0 and abs(slope * length - s) < 0.05 * s:
        now.similar_since = min(now.similar_since, length)
        if length >= 10 * now.similar_since and length > 100 * elastic:
            now.similar_since = length
            return Event.PROPORTIONAL
    else:
        now.similar_since = np.inf
    if length > FARTHEST * elastic or now.carried > CARRIED * max(1.0, now.strength * abs(s)):
        now.short = max(slope * length, 0.0) if s >= now.highest else 0.0
        return Event.FAR
    return Event.ADVANCED


@compilable
@lean
def flat_end(now: Progress) -> float:
    """The length up to which a path has to remain flat to have no other end."""
    return max(10 * min(now.flat_since, now.length), 30 * now.elastic)


@compilable
@lean
def set_next_step(now: Progress) -> None:
    """Make the next step longer or shorter, as the last one needed little correction or much.

    Where the load falls it is to be seen how far: a longer step would pass over the dip. One that is longer than it
    takes to see that a path remains flat would lead to where other contacts stop bodies that have long begun to slide.
    """
    now.step = min(now.step * min(max(TURN / max(now.turned, 1e-9), 0.7), now.fastest), 3 * now.length)
    if now.slope < 0:
        now.step = min(now.step, (1 - FALLEN) * now.highest / -now.slope)
    if now.flat_since < np.inf and now.length < flat_end(now):
        now.step = min(now.step, ENOUGH * (flat_end(now) - now.length))
    now.fastest = min(RECOVERY * now.fastest, FASTEST)
