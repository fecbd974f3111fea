"""A walk along a load path: where it is, what it has met, and the peak between two of its points."""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compilable
from holdfast.elastic.linear import Work
from holdfast.elastic.vectors import put

STATIONS = 4  # points before the peak that are kept


class Progress:
    """The numbers of a walk along a path.

    Constants: ``orientation``, the sign of the stiffness's determinant at rest; ``strength``, the largest component of
    the load, each body's in its own weight and size; ``elastic``, the largest displacement at rest.

    Where it is: ``s`` and the ``slope`` ds/dℓ; what the faint hold has ``carried``, of each body's own weight; the
    ``step`` Δℓ to be tried; the ``length`` ℓ so far; ``last``, s of the last regular point; ``turned``, the last
    correction as a share of its step; ``points`` found, linear ``systems`` solved, node ``changes`` crossed; how often
    this step was ``shortened``, and whether that was because it was ``doubted`` to lie on the same branch; the
    ``fastest`` growth of the step for now; whether a ``corner`` lies just behind the step, and the step to be tried
    ``beyond`` it.

    Of the peak: ``highest`` s; ``noted``, the last s that counted as a new peak, at the length ``at_peak``, and the
    points since (``late``); ``short``, by how much it may be too low. It lies between a point where s rises
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
    points: int = 0
    systems: int = 0
    changes: int = 0
    shortened: int = 0
    fastest: float = 4.0
    beyond: float = 0.0
    corner: bool = False
    doubted: bool = False
    highest: float = 0.0
    noted: float = 0.0
    at_peak: float = 0.0
    late: int = 0
    short: float = 0.0
    rising_s: float = 0.0
    rising_slope: float = 0.0
    falling_s: float = 0.0
    falling_slope: float = 0.0
    closed: bool = False
    stations: int = 0
    flat_since: float = 0.0
    similar_since: float = 0.0


class Stepper(NamedTuple):
    """A walk along a load path: all that one step hands on to the next; ``now`` is written to, and so are all arrays.

    The point ``q`` (n,) with the path's direction ``tangent``, dq/dℓ; the point ``trial`` that is being tried and where
    it was ``aimed``; displacement and plane of the highest point so far (``peak_q``, ``peak_plane``); displacement,
    tangent and plane of the point before the peak, displacement and tangent of the one behind it; ``origin``, zeros.

    Of some points on the way to the peak, each higher than the one before: the load (STATIONS,), displacement and plane
    (STATIONS, n); the last ones are kept, and those that are not there yet have the load 0.
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
    origin: Float
    station_s: Float
    station_q: Float
    station_plane: Float


RECORD = np.dtype(
    [(name, {"float": "f8", "int": "i8", "bool": "?"}[kind]) for name, kind in Progress.__annotations__.items()],
    align=True,
)


def make_stepper(n: int, *, dense: bool) -> Stepper:
    """A walk among n = 6J displacements; if ``dense`` its numbers are a record that compiled code can write."""
    now = cast(Progress, np.zeros(1, RECORD)[0]) if dense else Progress()
    vectors = np.zeros((len(Stepper._fields) - 4, n))
    return Stepper._make([now, *vectors, np.zeros(STATIONS), *np.zeros((2, STATIONS, n))])


@compilable
def before_peak(work: Work, stepper: Stepper) -> None:
    """Let the present point be the one before the peak."""
    now = stepper.now
    put(stepper.rising_q, stepper.q)
    put(stepper.rising_tangent, stepper.tangent)
    put(stepper.rising_plane, work.c)
    now.rising_s, now.rising_slope = now.s, now.slope


@compilable
def keep_station(work: Work, stepper: Stepper) -> None:
    """Keep the present point in the place of the oldest one that is kept."""
    at = stepper.now.stations % STATIONS
    stepper.station_s[at] = stepper.now.s
    put(stepper.station_q[at], stepper.q)
    put(stepper.station_plane[at], work.c)
    stepper.now.stations += 1


@compilable
def behind_peak(stepper: Stepper) -> None:
    """Let the present point be the one behind the peak."""
    now = stepper.now
    put(stepper.falling_q, stepper.q)
    put(stepper.falling_tangent, stepper.tangent)
    now.falling_s, now.falling_slope, now.closed = now.s, now.slope, True
