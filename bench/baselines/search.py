"""What the simulators share: trials of a load, the search for the largest load that rests, grids of contact nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, checked, unit
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import tangents, wrench_at
from holdfast.contacts.interface import Patch

MOST_UNDECIDED = 4  # trials without a verdict after which a search ends
FIRST = 0.05  # total weights: the first load
ENDLESS = 30.0  # total weights: the largest load that is tried
RECTANGLE = 1e-6  # relative: by how much less than its bounding rectangle a rectangular patch may cover


@dataclass(frozen=True)
class Trial:
    """Whether an assembly comes to rest under a load, and the measurements behind that verdict.

    ``holds`` is None where neither rest nor motion was seen. ``drift`` [m]: the largest relative displacement of
    contact nodes under the load; ``speed`` [m/s]: their largest relative speed at the end; ``steps``: time steps.
    """

    holds: bool | None
    drift: float
    speed: float
    steps: int


@dataclass(frozen=True)
class Peak:
    """The end of a load search [N]: ``held`` is the largest load seen to rest, ``moves`` the smallest seen to move.

    ``held`` is 0 where the assembly does not stand, ``moves`` is inf where nothing moved. ``drift`` and
    ``drift_beyond`` [m]: the largest relative displacement of contact nodes in the trials at ``held`` and at ``moves``.
    ``undecided``: number of trials in which neither rest nor motion was seen; ``steps``: time steps of all trials.
    """

    held: float
    moves: float
    drift: float
    drift_beyond: float
    undecided: int
    steps: int

    @property
    def force(self) -> float:
        """The middle of the bracket [N]; inf where nothing moved."""
        return (self.held + self.moves) / 2

    @property
    def width(self) -> float:
        """Half the width of the bracket, relative to its middle."""
        return (self.moves - self.held) / (self.moves + self.held) if 0 < self.moves < np.inf else 0.0


class World(Protocol):
    """An assembly in a simulator, at rest under its weight; ``weighed`` is the trial under the weight alone."""

    weighed: Trial

    def trial(self, load: Float) -> Trial:
        """Apply ``load`` (6J,) [N, N m] to the assembly at rest and see whether it comes to rest again."""
        ...


def trial_under(world: World, load: Float | None) -> Trial:
    """The trial under the weight alone or, if it rests and a ``load`` (6J,) [N, N m] is given, under both."""
    return world.weighed if load is None or not world.weighed.holds else world.trial(load)


def largest_load(world: World, weight: float, column: Float, accuracy: float, most: float | None = None) -> Peak:
    """The largest multiple [N] of a unit push (6J,) that rests, up to ``most`` [N] (ENDLESS total weights).

    Every load is tried from rest under the weight alone, to ``accuracy`` times the load.
    """
    if not world.weighed.holds:
        return no_peak(world.weighed)
    end = ENDLESS * weight if most is None else most
    return bracketed(lambda load: world.trial(load * column), FIRST * weight, end, accuracy)


def no_peak(trial: Trial) -> Peak:
    """The result of a search in an assembly that does not rest under its weight, or whose rest was not seen."""
    return Peak(0.0, 0.0, 0.0, trial.drift, int(trial.holds is None), trial.steps)


def bracketed(trial: Callable[[float], Trial], start: float, most: float, accuracy: float) -> Peak:
    """Raise a load from ``start`` [N] by factors of 1.5 until something moves or it reaches ``most`` [N]; then bisect.

    The bisection ends when the bracket is narrower than ``accuracy`` times the larger of ``moves`` and ``start``. After
    a trial in which neither rest nor motion is seen, a load nearer to ``held`` is tried, at most MOST_UNDECIDED times.
    """
    held, moves, drift, drift_beyond, undecided, steps = 0.0, np.inf, 0.0, 0.0, 0, 0
    load = min(start, most)
    while np.isinf(moves) or moves - held > accuracy * max(moves, start):
        if held >= most or undecided > MOST_UNDECIDED:
            break
        seen = trial(load)
        steps += seen.steps
        if seen.holds is None:
            undecided += 1
            load = (3 * load + held) / 4
            continue
        if seen.holds:
            held, drift = load, seen.drift
        else:
            moves, drift_beyond = load, seen.drift
        load = min(1.5 * held, most) if np.isinf(moves) else (held + moves) / 2
    return Peak(held, moves, drift, drift_beyond, undecided, steps)


def push(assembly: Assembly, body: str, point: Float, direction: Float) -> Float:
    """(6J,) wrenches of a unit push at ``point`` (3,) [m] of a body along ``direction`` (3,), world axes."""
    assembly.scene.body(body)
    k = assembly.index[body]
    if k == FIXED:
        raise HoldfastError(message("referee", f"body {body!r} is fixed", "push a movable one"))
    where = f"push on {body!r}"
    at, along = checked(point, (3,), f"{where}: point"), checked(direction, (3,), f"{where}: direction")
    if not np.any(along):
        raise HoldfastError(message(where, "direction is zero", "needs a direction"))
    wrench = np.zeros(6 * len(assembly.movable))
    wrench[6 * k : 6 * k + 6] = wrench_at(unit(along), at, assembly.com[k])
    return wrench


def grid_nodes(assembly: Assembly, side: int) -> ContactNodes:
    """``side`` x ``side`` contact nodes on every patch, which must be a rectangle, boundary included.

    The weights [m²] are those of the trapezoidal rule: corners count a quarter, edges half. ``side`` = 2 leaves the
    corners alone.
    """
    if side < 2:
        raise HoldfastError(message("grid_nodes", f"side = {side}", "needs at least 2"))
    share = np.ones(side)
    share[[0, -1]] = 0.5
    weights = np.outer(share, share).ravel()
    weights /= weights.sum()
    u = np.linspace(0, 1, side)
    square = np.stack(np.meshgrid(u, u, indexing="ij"), -1).reshape(-1, 2)
    points, areas, normals, owner = [], [], [], []
    for number, interface in enumerate(assembly.interfaces):
        for patch in interface.patches:
            axes, low, high = _rectangle(patch, interface.bodies)
            points.append(patch.lifted((low + square * (high - low)) @ axes))
            areas.append(weights * patch.area)
            normals.append(np.broadcast_to(patch.normal, (side * side, 3)))
            owner.append(np.full(side * side, number))
    normal = np.vstack(normals)
    of = np.concatenate(owner)
    ends = np.array(assembly.ends, dtype=np.int64)[of]
    frame = np.stack([normal, *tangents(normal)], axis=1)
    mu = np.array(assembly.mu)[of]
    none = np.zeros(len(of))
    return ContactNodes(np.vstack(points), frame, mu, np.concatenate(areas), of, ends[:, 0], ends[:, 1], none)


def _rectangle(patch: Patch, bodies: tuple[str, str]) -> tuple[Float, Float, Float]:
    """Axes (2, 2), low and high corner (2,) [m] of a rectangular patch in its own frame; an error for any other."""
    where = f"contact of {bodies[0]!r} and {bodies[1]!r}"
    if patch.kind != "face":
        raise HoldfastError(message(where, f"is a {patch.kind}", "grids need faces: give nodes of your own"))
    axes, low, high, _ = patch.rectangle
    if patch.area < (1 - RECTANGLE) * float(np.prod(high - low)):
        raise HoldfastError(message(where, "is no rectangle", "grids need rectangles: give nodes of your own"))
    return axes, low, high
