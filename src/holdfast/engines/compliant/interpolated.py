"""Maps from few load paths: 1/R is interpolated between pushes whose paths were followed.

γ(w) = 1/R(w) is homogeneous of degree one, piecewise smooth and nearly convex. Every path gives γ and its gradient (the
gradient of path.py). Over a triangle of solved pushes along one direction, γ therefore has two estimates: the
interpolated values, and the interpolated tangent planes. For a quadratic function the mean of both is exact. For a
convex function, the interpolated values are an upper bound and the highest tangent plane is a lower bound. The stated
error follows from the distance between them. If a tangent plane passes above the value at another corner, γ is not
convex there, and all planes are taken into account. Paths that are then followed at points inside show whether the
stated error was large enough; if not, it is enlarged over the whole face.

Only finite values are interpolated. Between pushes that move nothing, every push has a path of its own: where bodies
wedge, some of these pushes move them at a few weights although contact forces could balance any multiple of the push.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.directions import flat_groups, moment_frame
from holdfast.geometry.hull import corner_numbers
from holdfast.geometry.triangulation import fan, inserted, located

STATED = 3.0  # stated error over expected error
WIDER = 1.5  # initial ratio of the stated error to the spread of the estimates
KINK = 0.4  # weight in the spread of the relative distance between interpolated values and planes; large at kinks of γ
MIXED = 0.6  # the same weight where the three corners do not all have the same mechanism
FLOOR = 1e-2  # minimum stated relative error, for the errors of grids and path steps
# Share of the difference of the lower bounds around that is added: answers in between may come from other grids
UNLIKE = 0.5
MANY = 0.3  # once this share of the points of a face is solved, all doubtful ones are followed in one round
UNTESTED = 16  # number of interpolated points in a triangle above which the path of one is followed to test the others


class Solved(NamedTuple):
    """The results of the load paths of k pushes.

    ``outcome`` (k,) holds a PathOutcome each, ``value`` (k,) is γ, and ``slope`` (k, 6) its derivative by the load.
    ``motion`` (k,) numbers the kinds of mechanism; -1 means none. ``share`` (k,) is the lower bound of 1/γ as a share
    of it.
    """

    outcome: Int
    value: Float
    slope: Float
    motion: Int
    share: Float


Follow = Callable[[Int, Int], Solved]


@dataclass
class Face:
    """The k pushes along one direction, with a triangulation of those that are solved.

    ``members`` (k,) are the numbers of the pushes among all, ``places`` (k, 2) their points in a unit square, and
    ``triangles`` (t, 3) index the members. ``wider`` is the ratio of the stated error to the spread of the estimates.
    """

    members: Int
    places: Float
    triangles: Int
    wider: float = WIDER

    def begins(self, left: int) -> bool:
        """Say whether few pushes are solved yet, if this many are left."""
        return left > (1 - MANY) * len(self.members)

    def learn(self, off: float, spread: float) -> None:
        """Widen the stated error, for a push of this ``spread`` was ``off`` by that, both relative."""
        if off > spread > 0:
            self.wider = min(self.wider * off / spread, 4 * self.wider)


@dataclass(frozen=True, eq=False)
class Survey:
    """The values of γ at n pushes, solved or interpolated.

    ``value`` (n,) is γ, and ``error`` (n,) the stated relative error of 1/γ. Where ``solved`` (n,) is True, a push has
    a path of its own that ended with ``outcome`` (n,). Other values are interpolated between the solved pushes
    ``corner`` (n, 3) with the weights ``share`` (n, 3).
    """

    solved: Bool
    outcome: Int
    value: Float
    error: Float
    corner: Int
    share: Float


def survey(loads: Float, bodies: Sequence[Int], follow: Follow, accuracy: float) -> Survey:
    """Find γ at ``loads`` (n, 6) [N, N m], with expected relative errors of at most ``accuracy``.

    ``bodies`` are the numbers of the loads on each body. Those on none of them have paths of their own. Stated errors
    are at most STATED times ``accuracy``. ``follow(indices, corners)`` follows the paths of the loads with these
    numbers, each of which lies between three ``corners`` (k, 3) that have been followed, or is its own corners.
    """
    count = len(loads)
    solved, value = np.zeros(count, dtype=bool), np.zeros(count)
    whole, none = np.ones(count), np.zeros(count, dtype=np.int64)
    known = Solved(none.copy(), value, np.zeros((count, 6)), none.copy(), whole)
    outcome, spreads = known.outcome, np.zeros(count)
    error, corner, share = np.zeros(count), np.tile(np.arange(count)[:, None], 3), np.tile([1.0, 0.0, 0.0], (count, 1))
    faces, wanted = [], [np.setdiff1d(np.arange(count), np.concatenate(bodies))]
    flat = [(own, *flat_groups(loads[own])) for own in bodies]
    wanted += [own[others] for own, _, others in flat]
    for members in [own[group] for own, groups, _ in flat for group in groups]:
        places = _places(loads[members])
        corners = corner_numbers(places)
        if len(corners) < 3:
            wanted.append(members)
            continue
        faces.append(Face(members, places, fan(corners)))
        wanted.append(members[corners])
    first = np.unique(np.concatenate(wanted))
    _solve(first, corner[first], follow, solved, known)
    while faces:
        picked, doubted = [], []
        for face in faces:
            asked = np.flatnonzero(~solved[face.members])
            if not len(asked):
                continue
            where, weights = located(face.places, face.triangles, asked)
            within = face.members[face.triangles[where]]
            points = face.members[asked]
            middle, spread = _between(loads, points, within, weights, known)
            stated = face.wider * spread + FLOOR + UNLIKE * np.ptp(known.share[within], axis=1)
            value[points], error[points], corner[points], share[points] = middle, stated, within, weights
            spreads[points] = spread
            endless = (outcome[within] == PathOutcome.ENDLESS).all(1)
            if endless.any():
                picked.append(points[endless])
            spread[endless] = stated[endless] = 0.0
            doubted.append((face, asked, _Doubts(where, weights, spread, stated)))
        chosen = [doubts.chosen(STATED * accuracy, each=face.begins(len(asked))) for face, asked, doubts in doubted]
        open_faces = [(face, asked[k]) for (face, asked, _), k in zip(doubted, chosen, strict=True) if len(k)]
        picked += [face.members[added] for face, added in open_faces]
        if not picked:
            break
        fresh = np.concatenate(picked)
        expected = value[fresh]
        _solve(fresh, corner[fresh], follow, solved, known)
        miss = dict(zip(fresh.tolist(), np.abs(value[fresh] - expected).tolist(), strict=True))
        for face, added in open_faces:
            for k in added.tolist():
                number = face.members[k]
                if outcome[number] == PathOutcome.PEAK and value[number] > 0 and np.isfinite(error[number]):
                    face.learn(max(miss[number] / value[number] - FLOOR / 2, 0.0), spreads[number])
                face.triangles = inserted(face.places, face.triangles, k)
        error[fresh], share[fresh], corner[fresh] = 0.0, (1.0, 0.0, 0.0), fresh[:, None]
        faces = [face for face, _ in open_faces]
    return Survey(solved, outcome, value, error, corner, share)


def _places(loads: Float) -> Float:
    """Return the points (k, 2) of pushes along one direction, scaled to a unit square."""
    chart = loads[:, 3:] @ moment_frame(loads[0, :3]).T
    low, high = chart.min(0), chart.max(0)
    size = np.where(high - low > 1e-9 * float((high - low).max()), high - low, np.inf)
    return np.ascontiguousarray((chart - low) / size)


def _solve(indices: Int, corners: Int, follow: Follow, solved: Bool, known: Solved) -> None:
    """Follow the paths of the loads ``indices``, enter the results into ``known``, and mark the loads as ``solved``."""
    if len(indices):
        solved[indices] = True
        for column, found in zip(known, follow(indices, corners), strict=True):
            column[indices] = found


class _Doubts(NamedTuple):
    """What is known of the k points of a face that are not solved.

    ``where`` (k,) are their triangles and ``weights`` (k, 3) their shares in the corners; ``spread`` (k,) and
    ``stated`` (k,) are the relative spread of the estimates and the stated error.
    """

    where: Int
    weights: Float
    spread: Float
    stated: Float

    def chosen(self, most: float, *, each: bool) -> Int:
        """Choose points with a too large stated error (above ``most``): all, or with ``each`` one of each triangle.

        One of the points is also chosen in triangles with too many points.
        """
        crowded = np.bincount(self.where)[self.where] > UNTESTED
        wrong = self.stated > most
        doubt = np.where(wrong, np.minimum(self.spread, 1e6), 0.0) + 1e-6 * self.weights.min(1)
        asked = np.flatnonzero(wrong | crowded)
        order = asked[np.lexsort((-doubt[asked], self.where[asked]))]
        first = np.diff(self.where[order], prepend=-1) != 0
        return np.asarray(order[first if each else first | wrong[order]])


@compiled
def _between(loads: Float, points: Int, corners: Int, shares: Float, known: Solved) -> tuple[Float, Float]:
    """Return γ (n,) at n points within triangles, and the relative spread (n,) of its estimates.

    The spread is inf where a corner of the triangle has no finite peak or where an estimate is not positive.
    """
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
