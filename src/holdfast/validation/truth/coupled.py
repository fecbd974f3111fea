"""The coupled truth of a pile of boxes: linear pressure and the whole limit surface, contact by contact.

Derivation, limits and measurements: ``docs/coupled_truth.md``. There are no nodes, springs or load paths here, and no
code is shared with the engines: pressure and friction are integrated exactly over the part of the rectangle in touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, checked_pushes, unit
from holdfast.base.compiled import compiled
from holdfast.base.errors import SceneError, SolverError, message
from holdfast.base.rigid import wrench_at
from holdfast.contacts.interface import Patch
from holdfast.validation.truth.friction import sustained
from holdfast.validation.truth.pressure import linear_pressure

WHERE = "coupled truth"
SQUARE = 1e-6  # [-] how far a patch may be from a rectangle, relative to its size
NOTHING = 1e-12  # [-] of the weight: a smaller load along the contact counts as zero
ROUNDING = 1e-9  # [-] by which the use of friction may exceed 1 in a contact that still holds
STATIONS = 96  # values of the load parameter τ at which the use of friction is evaluated
HALVINGS = 50  # bisections between two stations
SECTIONS = 25  # golden sections towards a maximum between two stations


@dataclass(frozen=True, eq=False)
class Joint:
    """One contact of the pile: its rectangle and what it carries.

    ``centre`` (3,) [m]; ``axes`` (3, 3) rows: two along the sides, the normal into the upper part; ``half`` (2,) half
    sides [m]; ``above``: numbers of the bodies it carries; ``load`` (6,): their weight, in ``contact_load``'s order.
    """

    centre: Float
    axes: Float
    half: Float
    mu: float
    above: tuple[int, ...]
    load: Float


def robustness(
    assembly: Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
) -> Float:
    """The largest pushes (n,) [N] on ``body`` at ``points`` (n, 3) [m] along ``directions`` (n, 3), world axes.

    Infinite where no push moves anything, 0 where the pile does not stand by itself. The scene must be a pile: one
    column of bodies on a fixed one, each with a single rectangular contact below; anything else raises SceneError.
    """
    p, e = checked_pushes(points, directions, f"{WHERE} of {body!r}")
    assembly.scene.body(body)
    joints, weight, number = pile(assembly), assembly.weight, assembly.index[body]
    force = np.full(len(p), np.inf)
    for joint in joints:
        rest, carried = joint.load / weight, number in joint.above
        if first_motion(rest, np.zeros(6), joint.mu, joint.half, np.inf) == 0:
            return np.zeros(len(p))
        for k in range(len(p) if carried else 0):
            push = contact_load(e[k], p[k], joint)
            found = first_motion(rest, push, joint.mu, joint.half, force[k] / weight)
            if np.isnan(found):
                problem = f"no limit found for the push at {p[k]} along {e[k]}"
                raise SolverError(message(WHERE, problem, "report this push: every one should have a limit"))
            force[k] = min(force[k], weight * found)
    return force


def pile(assembly: Assembly) -> list[Joint]:
    """The contacts of a column from the ground up; SceneError where the assembly is not a column."""
    count = len(assembly.movable)
    if count == 0 or len(assembly.interfaces) != count:
        problem = f"{count} movable bodies and {len(assembly.interfaces)} interfaces"
        raise SceneError(message(WHERE, problem, "needs a column: one interface under each body"))
    order: list[int] = []
    found: list[tuple[int, bool]] = []  # interface, and whether its normal points up the column
    below = FIXED
    while len(found) < count:
        used = {number for number, _ in found}
        onward = [(k, a == below) for k, (a, b) in enumerate(assembly.ends) if below in (a, b) and k not in used]
        if len(onward) != 1:
            name = "the ground" if below == FIXED else repr(assembly.movable[below].name)
            problem = f"{len(onward)} bodies stand on {name}"
            raise SceneError(message(WHERE, problem, "needs a column, one body on the other"))
        found.append(onward[0])
        k, upward = onward[0]
        below = assembly.ends[k][1 if upward else 0]
        order.append(below)
    return [_joint(assembly, k, upward, tuple(order[level:])) for level, (k, upward) in enumerate(found)]


def contact_load(force: Float, point: Float, joint: Joint) -> Float:
    """The load (6,) of a force (3,) at a point (3,) on a joint: (f_x, f_y, m_z, N, ∫ x p, ∫ y p) in its axes."""
    wrench = wrench_at(force, point, joint.centre)
    (fx, fy, fn), (mx, my, mn) = joint.axes @ wrench[:3], joint.axes @ wrench[3:]
    return np.array([fx, fy, mn, -fn, my, -mx])


@compiled
def use(load: Float, mu: float, half: Float) -> float:
    """The share of its friction that a contact uses under a load (6,) as in ``contact_load``; it holds up to 1.

    The resultant of the pressure must lie inside the rectangle.
    """
    normal, along = load[3], load[:3].copy()
    if np.hypot(np.hypot(along[0], along[1]), along[2] / np.hypot(half[0], half[1])) <= NOTHING:
        return 0.0
    if normal <= 0 or mu == 0:
        return np.inf
    z, part, count, at = linear_pressure(half, load[4] / normal, load[5] / normal)
    along[2] -= at[0] * along[1] - at[1] * along[0]  # about the resultant of pressure: the scale of a small part
    factor = sustained(z, part, count, along / normal)
    return 1 / (mu * factor) if factor > 0 else np.nan if np.isnan(factor) else np.inf


@compiled
def first_motion(rest: Float, push: Float, mu: float, half: Float, most: float) -> float:
    """The first s at which a contact gives way under rest + s push, at most ``most``; 0 if it does not hold at s = 0.

    Friction and pressure are homogeneous, so s from 0 to infinity is the way (1 - τ) rest + τ push, 0 <= τ <= 1, whose
    end is the push alone. Toppling, where the pressure's resultant reaches a side, is linear in τ.
    """
    tip = most / (1 + most) if np.isfinite(most) else 1.0
    for axis in range(2):
        for sign in (-1.0, 1.0):
            inside = half[axis] * rest[3] + sign * rest[4 + axis]
            change = half[axis] * push[3] + sign * push[4 + axis]
            if inside <= 0:
                return 0.0
            if change < -NOTHING * half[axis]:
                tip = min(tip, inside / (inside - change))
    end = tip
    before = worst = use(rest, mu, half)
    if before > 1 + ROUNDING:
        return 0.0
    earlier = before
    for k in range(1, STATIONS + 1):
        tau = end * k / STATIONS
        now = use((1 - tau) * rest + tau * push, mu, half)
        if np.isnan(now):
            return np.nan
        low, high = tau - end / STATIONS, tau
        if now <= 1 + ROUNDING and before > earlier and before > now and k > 1:
            # a maximum lies between: it may reach beyond friction and come back
            high, worst = highest(rest, push, mu, half, tau - 2 * end / STATIONS, tau)
            low = tau - 2 * end / STATIONS
        else:
            worst = now
        if worst > 1 + ROUNDING:
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if use((1 - middle) * rest + middle * push, mu, half) > 1 + ROUNDING:
                    high = middle
                else:
                    low = middle
            return low / (1 - low)
        earlier, before = before, now
    return tip / (1 - tip) if tip < 1 else np.inf


@compiled
def highest(rest: Float, push: Float, mu: float, half: Float, low: float, high: float) -> tuple[float, float]:
    """(τ, use) at the maximum of ``use`` between two stations."""
    golden = 0.5 * (np.sqrt(5.0) - 1)
    a, b = high - golden * (high - low), low + golden * (high - low)
    at_a, at_b = use((1 - a) * rest + a * push, mu, half), use((1 - b) * rest + b * push, mu, half)
    for _ in range(SECTIONS):
        if at_a > at_b:
            high, b, at_b = b, a, at_a
            a = high - golden * (high - low)
            at_a = use((1 - a) * rest + a * push, mu, half)
        else:
            low, a, at_a = a, b, at_b
            b = low + golden * (high - low)
            at_b = use((1 - b) * rest + b * push, mu, half)
    return (a, at_a) if at_a > at_b else (b, at_b)


def _joint(assembly: Assembly, number: int, upward: bool, above: tuple[int, ...]) -> Joint:
    """The joint of an interface whose normal points into the upper body (``upward``) or out of it."""
    interface = assembly.interfaces[number]
    where = f"{WHERE}: interface {interface.bodies}"
    if len(interface.patches) != 1:
        raise SceneError(message(where, f"has {len(interface.patches)} patches", "needs a single rectangle"))
    patch = interface.patches[0] if upward else interface.patches[0].flipped()
    half, axes = _rectangle(patch, where)
    joint = Joint(patch.centroid, axes, half, assembly.mu[number], above, np.zeros(6))
    weights = [contact_load(assembly.mass[k] * assembly.scene.gravity, assembly.com[k], joint) for k in above]
    return Joint(patch.centroid, axes, half, assembly.mu[number], above, np.sum(weights, axis=0))


def _rectangle(patch: Patch, where: str) -> tuple[Float, Float]:
    """Half sides (2,) and axes (3, 3) of a rectangular patch."""
    corners = patch.hull
    fits = patch.kind == "face" and len(corners) == 4
    if fits:
        sides = np.roll(corners, -1, axis=0) - corners
        square = abs(sides[0] @ sides[1]) <= SQUARE * np.linalg.norm(sides[0]) * np.linalg.norm(sides[1])
        closed = np.abs(sides[0] + sides[2]).max() <= SQUARE * patch.size
        full = abs(np.linalg.norm(np.cross(sides[0], sides[1])) - patch.area) <= SQUARE * patch.area
        fits = bool(square and closed and full)
    if not fits:
        problem = f"is a {patch.kind} with {len(corners)} corners and {len(patch.holes)} holes"
        raise SceneError(message(where, problem, "needs a rectangle"))
    x = unit(sides[0])
    axes = np.array([x, np.cross(patch.normal, x), patch.normal])
    return 0.5 * np.linalg.norm(sides[:2], axis=1), axes
