"""The numbers of a walk along a load path, and what follows from them alone: whether it ends, and the next step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.compiled import compilable, lean
from holdfast.elastic.cubic import cubic, maximum_at, minimum_at
from holdfast.elastic.outcome import Event

# Relative fall from which the highest point so far counts as a maximum, even if the path rises above it later
DIP = 2e-3
FALLEN = 0.99  # share of the peak below which the path has clearly fallen
DEEPER = 3.0  # how many times its estimate the depth of a fall between two points may be
# Share of the slope before a step below which it may hide a maximum, and how high, as a share of the load
LEVEL, HIDDEN = 0.05, 0.05
FLAT = 1e-4  # a path is flat if it would rise by less than this in all, were its slope to fall as 1/ℓ²
ENOUGH = 1.01  # extra length of the step that is to show that a path has been flat or lower for long enough
NEW_PEAK = 1e-4  # relative rise above the peak so far that counts as a new peak
FARTHEST = 1e8  # largest length of a path, in displacements at rest: beyond it rounding would show
SPRING_SHARE = 1e-5  # share of a body's weight or of the load that the regularisation spring carries where a path ends
# How far the contacts of a body may slide, in times what it would move if every contact stuck, before a load counts as
# held only after sliding. In this law friction opposes all of the displacement, in reality the last of it: both agree
# until contacts have slid a few times as far as they give. Of 473 pushes in jams, piles and ordinary scenes, MuJoCo and
# discrete elements both let none go below what is reached at 3, and one at 4 (bench/suites/held.py)
SLID = 3.0
RECOVERY = 1.4  # factor by which the largest growth recovers from one point to the next
# How far behind a peak another one is awaited, in lengths at the peak: if the load fell, and if not
SOON, LONG = 10.0, 100.0


class StepControl(NamedTuple):
    """How closely a path is followed.

    ``growth``: the largest growth of the step from one point to the next; ``correction``: that of a point that is
    wanted, as a share of the step; ``patience``: points without a new peak after which none is waited for; ``most``
    points of a path.
    """

    growth: float
    correction: float
    patience: int
    most: int


QUICK = StepControl(2.5, 0.2, 80, 600)
BRIEF = QUICK._replace(patience=40)  # where linear systems are expensive
CLOSE = StepControl(1.5, 0.05, 1000, 20_000)  # slow and misses less: the reference for the quick step control


class Progress:
    """The numbers of a walk along a path.

    Constants: the StepControl; ``orientation``, the sign of the stiffness's determinant at rest; ``strength``, the
    largest component of the load, each body's in its own weight and size; ``elastic``, the largest displacement at rest
    that counts.

    Where it is: ``s`` and the ``slope`` ds/dℓ; what the regularisation spring has carried, ``by_springs``, of each
    body's own weight, and carries at ``rest``; the ``step`` Δℓ to be tried; the ``length`` ℓ so far; ``last``, s of the
    last regular point; ``turned``, the last correction as a share of its step, and the ``sharpest``, the largest of all
    points but the first; ``points`` found, linear ``systems`` solved, node ``changes`` crossed; how often this step
    failed and was ``shortened``, and how often it was ``doubted``; the ``fastest`` growth of the step for now; whether
    a ``corner`` lies just behind the step, and the step to be tried ``beyond`` it; whether the path began to rise
    (``rises``).

    Of the peak: ``highest`` s; ``noted``, the last s that counted as a new peak, at the length ``at_peak``, and the
    points since (``late``); ``short``, by how much it may be too low; the maximum from which s has ``dipped``, and the
    ``first`` one above which it has risen after that, 0 if there was none; the ``crest``, the highest s between points,
    as estimated, and the lowest point since, the ``trough``; whether the last step ``topped`` what was highest, and
    whether it hid a maximum (``peaked``). The peak lies between a point where s rises
    (``rising_s``, ``rising_slope``) and one where it does not (``falling_s``, ``falling_slope``), once the latter is
    known: ``closed``. The load ``stored`` of a point on the way to it, 0 if there is none.

    Of what was reached before contacts have slid far (SLID): how far they had ``slid`` at the last point, or where that
    first was far, and the highest s ``before`` that.

    Of the end: the lengths since which the path has been flat (``flat_since``) and since which s has grown in
    proportion to ℓ (``similar_since``); inf if it is not.
    """

    growth: float = QUICK.growth
    correction: float = QUICK.correction
    patience: int = QUICK.patience
    most: int = QUICK.most
    orientation: float = 0.0
    strength: float = 0.0
    elastic: float = 0.0
    s: float = 0.0
    slope: float = 0.0
    by_springs: float = 0.0
    rest: float = 0.0
    step: float = 0.0
    length: float = 0.0
    last: float = 0.0
    turned: float = 0.0
    sharpest: float = 0.0
    points: int = 0
    systems: int = 0
    changes: int = 0
    shortened: int = 0
    fastest: float = QUICK.growth
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
    stored: float = 0.0
    peaked: bool = False
    topped: bool = False
    rises: bool = False
    slid: float = 0.0
    before: float = 0.0
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
    x = maximum_at(now.s, rise, s, falls)
    between = cubic(x, now.s, rise, s, falls) if x > 0 else now.s
    now.peaked, top = between > max(now.s, s), max(between, s)
    now.topped = top > now.crest or s > now.highest
    if top > now.crest:
        now.crest, now.trough = top, s
        if top > now.noted * (1 + NEW_PEAK):
            now.at_peak, now.late, now.noted = now.length - (1 - x if now.peaked else 0.0) * now.step, 0, top
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
def measure_sliding(now: Progress, rise: float, s: float, falls: float, slid: float) -> None:
    """Take note of the highest s before contacts have slid far, where a step leads to ``s`` and they have ``slid``.

    ``rise`` and ``falls`` are as ``measure_dip`` has them. Once they have slid far, what follows does not count.
    """
    reached = s if slid <= SLID else cubic((SLID - now.slid) / (slid - now.slid), now.s, rise, s, falls)
    now.before, now.slid = max(now.before, reached), slid


@compilable
@lean
def hides_dip(now: Progress, rise: float, s: float, falls: float) -> bool:
    """Whether a step to ``s`` may hide how far the load falls, where that decides about a maximum.

    Between the ends it is about as high and low as the cubic with the slopes there, which ``measure_dip`` has, too.
    """
    high_at, low_at = maximum_at(now.s, rise, s, falls), minimum_at(now.s, rise, s, falls)
    if high_at < 0 and low_at < 0:
        return False
    top, bottom, most = now.crest, now.trough, 0.0
    for second in (False, True):  # a maximum and a minimum, as they follow each other
        if high_at > 0 and second == (0 < low_at < high_at):
            between = cubic(high_at, now.s, rise, s, falls)
            if between > top:
                top, bottom = between, between
        if low_at > 0 and second == (0 < high_at < low_at):
            bottom = min(bottom, cubic(low_at, now.s, rise, s, falls))
            most = fall(bottom, top)
    most = max(most, fall(min(bottom, s), top))
    seen = fall(min(now.trough, s) if s < now.highest else s, max(now.highest, s))
    clearly = seen <= 1 - FALLEN and may_have_fallen(seen, most)
    return clearly or (now.dipped == 0 and seen <= DIP < most)


@compilable
@lean
def fall(low: float, high: float) -> float:
    """By how much of ``high`` the load has fallen."""
    return float(1 - low / max(high, 1e-300))


@compilable
@lean
def may_have_fallen(seen: float, estimate: float) -> bool:
    """Whether a load may have clearly fallen that did so by ``seen`` from point to point, and between by estimate."""
    return bool(seen + DEEPER * max(estimate - seen, 0.0) > 1 - FALLEN)


@compilable
@lean
def appraise(now: Progress) -> Event:
    """Whether the new point is the end of the path: FALLEN, FAR, FLAT, perhaps PROPORTIONAL, or else ADVANCED."""
    s, slope, length, elastic = now.s, now.slope, now.length, now.elastic
    longest = (SOON if has_fallen(now) else LONG) * now.at_peak
    if s < FALLEN * now.highest or length >= longest or now.late > now.patience:
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
    if length > FARTHEST * elastic or now.by_springs > now.rest + SPRING_SHARE * max(1.0, now.strength * abs(s)):
        now.short = max(slope * length, 0.0) if s >= now.highest else 0.0
        return Event.FAR
    return Event.ADVANCED


@compilable
@lean
def has_fallen(now: Progress) -> bool:
    """Whether the load falls or is below a maximum."""
    return bool(now.slope < 0 or now.s < (1 - DIP) * now.crest)


@compilable
@lean
def flat_end(now: Progress) -> float:
    """The length up to which a path has to remain flat to have no other end."""
    return max(10 * min(now.flat_since, now.length), 30 * now.elastic)


@compilable
@lean
def set_next_step(now: Progress) -> None:
    """Make the next step longer or shorter, as the last one needed little correction or much.

    Where the load falls it is to be seen how far: a longer step would pass over the dip, and behind a maximum it soon
    may rise to a higher one. One that is longer than it takes to see that a path remains flat, or that the load remains
    below its peak, would lead to where other contacts stop bodies that have long begun to slide.
    """
    fastest = 1.0 if now.peaked else now.fastest
    now.step = min(now.step * min(max(now.correction / max(now.turned, 1e-9), 0.7), fastest), 3 * now.length)
    if now.slope < 0:
        now.step = min(now.step, (1 - FALLEN) * now.highest / -now.slope)
    end = FARTHEST * now.elastic
    if has_fallen(now) and now.length < SOON * now.at_peak:
        end = min(end, SOON * now.at_peak)
    if now.flat_since < np.inf and now.length < flat_end(now):
        end = min(end, flat_end(now))
    now.step = min(now.step, ENOUGH * (end - now.length))
    now.fastest = min(RECOVERY * now.fastest, now.growth)
