"""Maps from few load paths: what is known of 1/R at some pushes, carried over to those between.

γ(w) = 1/R(w) is homogeneous of degree one, piecewise smooth and nearly convex. Every path gives γ and its slope (the
cut of path.py), so over a triangle of solved pushes along one direction γ is known twice: by interpolating the values
and by interpolating the planes that touch there. Of a quadratic the mean of both is exact; of a convex function the one
is above, the highest plane below. How far apart they are is the stated error; where a plane passes above the value of
another corner, all planes count. What a path then gives at a point inside says whether the stated error was wide
enough; where it was not, it is widened over the whole face.

Only finite values are interpolated. Between pushes that nothing moves every push has a path of its own: where bodies
wedge, some of them give way at a few weights though forces of the law could balance any multiple of the push.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.directions import flat_groups, moment_frame
from holdfast.geometry.hull import corner_numbers
from holdfast.geometry.triangulation import fan, inserted, located

STATED = 3.0  # stated over expected error
WIDER = 1.5  # stated error over the relative distance of the answer from its bounds, at first
KINK = 0.4  # weight of the relative distance between values and planes in that: it is large where slopes differ
MIXED = 0.6  # weight of the same where not all corners move in the same way
FLOOR = 1e-2  # minimum relative error stated: what grids and path steps alone may hide
UNTESTED = 16  # interpolated points in one triangle, above which one of them is followed to test the rest


class Solved(NamedTuple):
    """What paths gave for k pushes.

    ``outcome`` (k,) of PathOutcome; ``value`` (k,) γ; ``slope`` (k, 6) its derivative by the load; ``motion`` (k,)
    numbers of what gives way.
    """

    outcome: Int
    value: Float
    slope: Float
    motion: Int


Follow = Callable[[Int], Solved]


@dataclass
class Face:
    """Pushes along one direction: ``members`` among all, ``places`` (k, 2) in a box of 1 by 1, and what is solved."""

    members: Int
    places: Float
    triangles: Int
    wider: float = WIDER


@dataclass(frozen=True, eq=False)
class Survey:
    """What is known of n pushes: γ ``value`` (n,), relative ``error`` (n,) of 1/γ.

    Where ``solved`` (n,), a push has a path of its own, with ``outcome`` (n,) of PathOutcome. ``corner`` (n, 3) are the
    solved pushes that a value was interpolated between, ``share`` (n, 3) with which weights.
    """

    solved: Bool
    outcome: Int
    value: Float
    error: Float
    corner: Int
    share: Float


def survey(loads: Float, follow: Follow, gap: float) -> Survey:
    """Values of γ at loads (n, 6) on one body with expected errors of at most ``gap``; STATED times that is stated.

    ``follow(indices)`` follows the paths of some of the loads.
    """
    count = len(loads)
    solved, value = np.zeros(count, dtype=bool), np.zeros(count)
    known = Solved(np.zeros(count, dtype=np.int64), value, np.zeros((count, 6)), np.zeros(count, dtype=np.int64))
    outcome = known.outcome
    error, corner, share = np.zeros(count), np.tile(np.arange(count)[:, None], 3), np.tile([1.0, 0.0, 0.0], (count, 1))
    groups, others = flat_groups(loads)
    faces, wanted = [], [others]
    for members in groups:
        places = _places(loads[members])
        corners = corner_numbers(places)
        if len(corners) < 3:
            wanted.append(members)
            continue
        faces.append(Face(members, places, fan(corners)))
        wanted.append(members[corners])
    _solve(np.unique(np.concatenate(wanted)), follow, solved, known)
    while faces:
        picked, open_faces = [], []
        for face in faces:
            asked = np.flatnonzero(~solved[face.members])
            if not len(asked):
                continue
            where, weights = located(face.places, face.triangles, asked)
            within = face.members[face.triangles[where]]
            points = face.members[asked]
            middle, spread = _between(loads, points, within, weights, known)
            stated = face.wider * spread + FLOOR
            value[points], error[points], corner[points], share[points] = middle, stated, within, weights
            endless = (outcome[within] == PathOutcome.ENDLESS).all(1)
            if endless.any():
                picked.append(points[endless])
            spread[endless] = stated[endless] = 0.0
            chosen = _doubtful(where, weights, spread, stated, STATED * gap)
            if len(chosen):
                picked.append(points[chosen])
                open_faces.append((face, asked[chosen]))
        if not picked:
            break
        fresh = np.concatenate(picked)
        expected = value[fresh]
        _solve(fresh, follow, solved, known)
        miss = dict(zip(fresh.tolist(), np.abs(value[fresh] - expected).tolist(), strict=True))
        for face, added in open_faces:
            for k in added.tolist():
                number = face.members[k]
                if outcome[number] == PathOutcome.PEAK and np.isfinite(error[number]):
                    off = max(miss[number] / value[number] - FLOOR / 2, 0.0)
                    estimated = (error[number] - FLOOR) / face.wider
                    if off > estimated > 0:
                        face.wider = min(face.wider * off / estimated, 4 * face.wider)
                face.triangles = inserted(face.places, face.triangles, k)
        error[fresh], share[fresh], corner[fresh] = 0.0, (1.0, 0.0, 0.0), fresh[:, None]
        faces = [face for face, _ in open_faces]
    return Survey(solved, outcome, value, error, corner, share)


def _places(loads: Float) -> Float:
    """(k, 2) of pushes along one direction, in a box of 1 by 1."""
    chart = loads[:, 3:] @ moment_frame(loads[0, :3]).T
    low, high = chart.min(0), chart.max(0)
    size = np.where(high - low > 1e-9 * float((high - low).max()), high - low, np.inf)
    return np.ascontiguousarray((chart - low) / size)


def _solve(indices: Int, follow: Follow, solved: Bool, known: Solved) -> None:
    """Enter what the paths of some loads give into ``known``, and that they are ``solved``."""
    if len(indices):
        solved[indices] = True
        for column, found in zip(known, follow(indices), strict=True):
            column[indices] = found


def _doubtful(where: Int, weights: Float, spread: Float, stated: Float, most: float) -> Int:
    """One point of each triangle that holds too much doubt, or too many points to be left untested."""
    crowded = np.bincount(where)[where] > UNTESTED
    doubt = np.where(stated > most, np.minimum(spread, 1e6), 0.0) + 1e-6 * weights.min(1)
    asked = np.flatnonzero((stated > most) | crowded)
    order = asked[np.lexsort((-doubt[asked], where[asked]))]
    return order[np.flatnonzero(np.diff(where[order], prepend=-1))]


@compiled
def _between(loads: Float, points: Int, corners: Int, shares: Float, known: Solved) -> tuple[Float, Float]:
    """γ at points within triangles, and how far apart the estimates are, relative; inf where corners are not alike."""
    value, slopes, motion = known.value, known.slope, known.motion
    middle, spread = np.zeros(len(points)), np.zeros(len(points))
    for n in range(len(points)):
        finite = 0
        for i in range(3):
            finite += known.outcome[corners[n, i]] == PathOutcome.PEAK
        if finite < 3:
            middle[n], spread[n] = np.nan, np.inf
            continue
        flat, touching, top, bottom = 0.0, 0.0, -np.inf, np.inf
        for i in range(3):
            c = corners[n, i]
            plane = 0.0
            for j in range(6):
                plane += slopes[c, j] * loads[points[n], j]
            flat += shares[n, i] * value[c]
            touching += shares[n, i] * plane
            top, bottom = max(top, plane), min(bottom, plane)
        dented = 0.0
        for i in range(3):
            for k in range(3):
                there = 0.0
                for j in range(6):
                    there += slopes[corners[n, i], j] * loads[corners[n, k], j]
                dented = max(dented, there / value[corners[n, k]] - 1)
        low, high = min(top, flat), max(top, flat)
        if dented > 1e-3:
            low, high = min(bottom, flat), max(top, flat)
        alike = motion[corners[n, 0]] == motion[corners[n, 1]] == motion[corners[n, 2]]
        kink = KINK if alike else MIXED
        mean = (flat + touching) / 2
        best = (mean + min(max(mean, low), high)) / 2  # planes may overshoot where γ is not convex
        middle[n] = best
        spread[n] = (
            np.inf if min(low, touching) <= 0 else max(best / low - 1, 1 - best / high, kink * (flat / touching - 1))
        )
    return middle, spread
