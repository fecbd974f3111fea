"""The coupled truth of a pile of boxes: linear pressure and the whole limit surface, contact by contact.

It is the value that engine ``compliant`` tends to with many nodes, found without nodes, springs or load paths. No
code is shared with the engines. What was compared with it: bench/notes/table1.md.

**What it covers.** A column: one movable body on the ground, the next one on it, and so on, with a single
rectangular contact under each. Boxes may be of any size and mass and may be shifted, and the ground may be tilted.
Statics does not tell how the two legs of a table share the load, so a table is refused.

**One contact at a time.** Cut the column at a contact. It alone balances everything above it, so its load is known
without any stiffness: the weights above, plus s times the push if the pushed body is above. In axes along its sides
2a and 2b and its normal z, a force F and a moment M on the upper part require

    N = -F_z,   ∫ x p = M_y,   ∫ y p = -M_x            (pressure)
    (F_x, F_y, M_z) =: T                               (friction)

A contact above the pushed body only holds its own weight. Therefore R is the least, over the contacts below the
pushed body, of the first s at which that contact gives way, and 0 if any contact fails at s = 0. A column cannot
rack: every motion opens or shears one of these contacts, and below the smallest such s all of them hold at once.

**Pressure** is that of rigid bodies on an elastic layer that cannot pull: p = max(0, z0 + z1 x + z2 y). N and two
moments determine the three numbers. Friction does not enter, since it lies in the plane of the contact. The body
topples when the resultant reaches the edge, which is linear in s. Inside the kern the whole rectangle presses;
outside, a polygon of it.

**Friction**: among all tractions with |t| <= μ p, the largest multiple λ of T that they hold is, by the upper-bound
theorem,

    λ = min over motions v = (v_x, v_y, ω) with T·v = 1 of  D(v),     D(v) = μ ∫ p |(v_x - ω y, v_y + ω x)| dA.

Slip is ω = 0, torsion is one particular centre of rotation; here all centres compete. Both integrals are exact
(rectangle.py).

**The first s, and when there is none.** The load is w_0 + s w_1. A contact uses the share 1/λ of its friction, and
holds up to 1. Pressure and D are homogeneous, so s from 0 to ∞ is the segment (1 - τ) w_0 + τ w_1. Let K be the
closed cone of loads that are held.

- If the push alone is not held, R is finite: if w_0 + s w_1 were in K for all s, w_1 would be in K.
- If weights and push each press the whole rectangle and are each held, R is infinite: there p is linear in the
  load, and K is convex.
- Otherwise K need not be convex. Where the rectangle opens, torsion falls below the sum of what the two loads would
  have singly. So the use is evaluated at 96 stations over all of τ, with golden sections where three of them show a
  maximum in between, and the first crossing of 1 is bisected. Of 3,075 random downward pushes on the cube whose
  resultant ends inside, 1,758 are held at the end; 108 of these have the largest use on the way, and 8 give way
  there (use up to 1.087).

**What it leaves out.** Stiffness is equal over the contact, and bodies are rigid. Friction is the best possible for
the load; elastic friction along one straight path reaches the same at its peak, other histories may stop earlier.
Within 1e-4 half sides of the edge the pressure is taken as at 1e-4 (toppling stays exact); a slip there, and a
crossing narrower than 1/96 of the way, may be missed: too high. A SolverError is raised where a search does not
converge (none in 21,000 load paths).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.truth.rectangle import first_motion
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, checked_pushes, unit
from holdfast.base.errors import SceneError, SolverError, message
from holdfast.base.rigid import wrench_at
from holdfast.contacts.interface import Patch

WHERE = "coupled truth"
SQUARE = 1e-6  # [-] how far a patch may be from a rectangle, relative to its size


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
        rest, above = joint.load / weight, number in joint.above
        if first_motion(rest, np.zeros(6), joint.mu, joint.half, np.inf) == 0:
            return np.zeros(len(p))
        for k in range(len(p) if above else 0):
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
