"""The coupled truth of a pile of boxes: linear pressure and the whole limit surface, contact by contact.

Derivation, limits and measurements: ``docs/explanation/coupled_truth.md``. There are no nodes, springs or load paths
here, and no code is shared with the engines: pressure and friction are integrated exactly over the part of the
rectangle in touch.
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
