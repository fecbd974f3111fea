"""Find the fastest motion of a carrier from rest to rest along a path on which its load holds.

The carrier follows q(s) without turning, so its acceleration is q' s'' + q'' s'². Limits on it are half-planes in
u = s'' and x = s'², and x' = 2 u along s. On a grid of s, a pass backwards finds the largest x of each point from which
the rest can be reached within the limits; a pass forwards then takes the largest u everywhere (Pham & Pham, A new
approach to time-optimal path parameterization based on reachability analysis, T-RO 2018). The limits are a polygon of
answers along directions; ``carry`` judges what comes out, and has the last word.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.carrying.carry import Carried, carry
from holdfast.applications.carrying.profile import Profile
from holdfast.applications.transport import checked_margin, transport_limits
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.ranges import COORDINATES, LENGTH, PLACE, SCALE
from holdfast.base.text import listed
from holdfast.engines.answers import Claim
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import qhull
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load, checked_assembly
from holdfast.queries.sets import ACCELERATION_BOUND
from holdfast.scene.scene import Scene

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

WHERE = "fastest_carry"
CELLS = 100  # of the grid between two corners, and one more for each turn by TURN
TURN = 0.05  # [rad] the polygon of limits has a corner every 0.06
FINE = 50  # points between two waypoints from which the turn is known
MISSED = 1e-3  # share of the length of a path by which the motion may end beside it
DIRECTIONS = 100  # of the polygon of limits: it is 0.05 % inside a circle
CORNER = np.cos(np.radians(30.0))  # a path that turns by more at a waypoint has a corner there
FLAT = 1e-6  # share of the length of a path by which its waypoints may be out of one plane
SPARE = 1e-6  # the motion is slowed down by this share more, lest rounding leave it above the limit
NUDGE = 1e-3  # share of a cell's time that the acceleration takes at either end to become that of the next cell
Piece = tuple[float, Float, Float]  # duration [s]; times (n,) [s] since its beginning; accelerations (n, d) [m/s²]


def fastest_carry(
    assembly: Assembly | Scene,
    waypoints: ArrayLike,
    *,
    margin: float = 0.1,
    speed: float | None = None,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    imperfect: Imperfect | None = None,
) -> Carried:
    """Find the fastest motion of the carrier along a path, from rest to rest, on which all that it carries holds.

    ``waypoints`` (n, 3) or (n, 2) [m] are points that the carrier passes, along the axes of the scene, and lie in one
    plane. It keeps its orientation. Between corners it follows the cubic spline through the waypoints; at a corner, a
    waypoint at which the path turns by more than 30 degrees, it stops. ``speed`` [m/s] is the largest that it may have.
    ``margin`` in [0, 1) is the share of the load's capacity that remains unused at every time.

    Return the answer of ``carry`` for that motion, with the same ``standing``, ``engine`` and ``imperfect``:
    ``profile`` is the motion, ``profile.time[-1]`` how long it takes, ``profile.course()`` its speeds and places, and
    ``used`` the share of the capacity at every time. A motion that ``carry`` finds to use more than ``margin`` leaves
    is slowed down as a whole. Where no speed is known to be safe it is not, and ``holds`` is False.

    Raises HoldfastError if in some direction of the plane no acceleration is known to be safe, if the engine promises
    no lower bound, or if the curve bends too sharply for the motion to follow it to a thousandth of its length.
    """
    given, standing = checked_assembly(assembly), tuple(standing)
    unused = checked_margin(margin, WHERE)
    points = _checked_waypoints(waypoints)
    most = np.inf if speed is None else checked_number(speed, f"{WHERE}: speed", above=0, within=SCALE)
    _, size, every = np.linalg.svd(points - points[0], full_matrices=False)
    count = int((size > FLAT * size[0]).sum())
    if count > 2:
        raise HoldfastError(message(f"{WHERE}: waypoints", "are not in one plane", "needs a path in one plane"))
    axes = every[:count]
    flat = (points - points[0]) @ axes.T
    limits = _limits(given, axes, standing, engine, imperfect) / (1 - unused)
    along = np.diff(flat, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    corners = np.flatnonzero((along[1:] * along[:-1]).sum(1) < CORNER) + 1
    ends = [0, *corners.tolist(), len(flat) - 1]
    pieces = [_piece(flat[i : j + 1], limits, most) for i, j in pairwise(ends)]
    begin = np.cumsum([0.0, *(piece[0] for piece in pieces)])
    times = np.concatenate([start + piece[1] for start, piece in zip(begin, pieces, strict=False)])
    times[0], times[-1] = 0.0, begin[-1]
    motion = Profile(times, np.vstack([piece[2] for piece in pieces]) @ axes, name="fastest along a path")
    missed = float(np.linalg.norm(motion.course()[1][-1] - (points[-1] - points[0])))
    if missed > MISSED * np.linalg.norm(np.diff(points, axis=0), axis=1).sum():
        problem = f"bend so sharply that the motion would end {missed:.2g} m from the last one"
        raise HoldfastError(message(f"{WHERE}: waypoints", problem, "space them more evenly"))
    ride = carry(given, motion, standing=standing, engine=engine, imperfect=imperfect)
    scale = ride.time_scale(margin=unused)
    if 0 < scale < 1:
        slower = motion.at_speed(scale * (1 - SPARE))
        ride = carry(given, slower, standing=standing, engine=engine, imperfect=imperfect)
    return ride


def _checked_waypoints(value: ArrayLike) -> Float:
    points = checked(value, (None, None), f"{WHERE}: waypoints", within=PLACE)
    if len(points) < 2 or points.shape[1] not in (2, 3):
        problem = f"have the shape {points.shape}"
        raise HoldfastError(message(f"{WHERE}: waypoints", problem, "needs two or more points (n, 2) or (n, 3)"))
    points = np.hstack([points, np.zeros((len(points), 3 - points.shape[1]))])
    near = np.linalg.norm(np.diff(points, axis=0), axis=1) < LENGTH.least
    if near.any():
        problem = f"point {int(np.argmax(near))} and the next are at the same place"
        raise HoldfastError(message(f"{WHERE}: waypoints", problem, "name each place once"))
    return points


def _limits(
    assembly: Assembly, axes: Float, standing: tuple[Load, ...], engine: EngineChoice, imperfect: Imperfect | None
) -> Float:
    """Return A (m, d) such that the load holds at the accelerations a (d,) along the axes with A a <= 1 [m/s²].

    The region is the convex hull of the accelerations that the engine promises, at most 5 g along each direction.
    Where what it promises is not convex, the hull says too much; ``carry`` finds that out.
    """
    turn = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)
    ways = np.array([[1.0], [-1.0]]) if len(axes) == 1 else np.column_stack([np.cos(turn), np.sin(turn)])
    found = transport_limits(assembly, ways @ axes, standing=standing, engine=engine, imperfect=imperfect)
    if found.claim is Claim.ESTIMATED:
        problem = f"engine {found.engine!r} promises no lower bound"
        raise HoldfastError(message(WHERE, problem, "ask engine 'compliant' or 'limit'"))
    bound = ACCELERATION_BOUND * float(np.linalg.norm(assembly.scene.gravity))
    k = int(np.argmin(found.lower))
    if found.lower[k] <= COORDINATES * bound:
        stands = found.verdict.status is Status.STABLE
        why = listed(found.moving[k]) + " would move" if found.moving[k] else found.undecided.text
        problem = f"no acceleration along {np.round(found.directions[k], 3).tolist()} is known to be safe: "
        raise HoldfastError(
            message(WHERE, problem + (why if stands else found.verdict.reason), "hold what moves, or leave it out")
        )
    promised = ways * np.minimum(found.lower, bound)[:, None]
    if len(axes) == 1:
        return np.asarray(1 / promised)
    sides = qhull(promised).equations
    return np.asarray(sides[:, :-1] / -sides[:, -1:])


def _piece(points: Float, limits: Float, speed: float) -> Piece:
    """Return the fastest motion from rest to rest along the smooth curve through points (n, d)."""
    from scipy.interpolate import CubicSpline  # here, because importing it takes long

    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    curve = CubicSpline(np.concatenate([[0.0], np.cumsum(chords)]), points)
    s = _grid(curve)
    double = 2 * np.diff(s)
    first, second = curve(s, 1), curve(s, 2)
    g, h = first @ limits.T, second @ limits.T  # at each point of the grid: g u + h x <= 1
    g = np.hstack([g, np.zeros((len(s), 1))])
    h = np.hstack([h, (first**2).sum(1, keepdims=True) / speed**2])
    # A cell keeps the limits at both of its ends, with the same u: at its far end, x is larger by 2 u times its length
    g = np.hstack([g[:-1], g[1:] + double[:, None] * h[1:]])
    h = np.hstack([h[:-1], h[1:]])
    r = np.ones(g.shape[1])
    most = np.zeros(len(s))
    for k in reversed(range(len(double))):  # and the far end's x is from 0 to the largest there
        own = np.append(g[k], [double[k], -double[k]]), np.append(h[k], [1, -1]), np.append(r, [most[k + 1], 0])
        most[k] = _largest(*own)
    u, x = np.zeros(len(double)), np.zeros(len(s))
    for k in range(len(double)):
        up = g[k] > 0
        u[k] = min(((1 - h[k, up] * x[k]) / g[k, up]).min(initial=np.inf), (most[k + 1] - x[k]) / double[k])
        x[k + 1] = max(x[k] + double[k] * u[k], 0.0)
    rate = np.sqrt(x)
    last = double / (rate[1:] + rate[:-1])
    ends = np.concatenate([[0.0], np.cumsum(last)])
    time = np.column_stack([ends[:-1] + NUDGE * last, ends[1:] - NUDGE * last])
    # The mean of what is safe is safe, and with it the speeds at the ends of all cells come out exactly
    a = np.diff(first * rate[:, None], axis=0) / last[:, None]
    return ends[-1], time.ravel(), np.repeat(a, 2, axis=0)


def _grid(curve: CubicSpline) -> Float:
    """Return places (n,) along a smooth curve, those of its waypoints and enough between them.

    Each cell turns by TURN at most. Cells at both ends are short: the carrier is slow there, and they take as long.
    """
    knots = curve.x
    fine = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(FINE) / FINE).ravel(), knots[-1])
    along = curve(fine, 1)
    along /= np.linalg.norm(along, axis=1)[:, None]
    turned = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(along, axis=0), axis=1))])
    many = CELLS * np.arccos(1 - 2 * fine / fine[-1]) / np.pi + turned / TURN
    parts = [np.linspace(i, j, int(np.ceil(j - i)), endpoint=False) for i, j in pairwise(many[::FINE])]
    return np.asarray(np.interp(np.concatenate([*parts, many[-1:]]), many, fine))


def _largest(g: Float, h: Float, r: Float) -> float:
    """Return the largest x such that g u + h x <= r (each (m,)) for some u, of rows that x = u = 0 satisfies."""
    level, up, down = g == 0, g > 0, g < 0
    slope, end = h[~level] / g[~level], r[~level] / g[~level]
    up, down = up[~level], down[~level]
    slopes = np.concatenate([h[level], np.subtract.outer(slope[up], slope[down]).ravel()])
    ends = np.concatenate([r[level], np.subtract.outer(end[up], end[down]).ravel()])
    closing = slopes > 0
    return float((ends[closing] / slopes[closing]).min())
