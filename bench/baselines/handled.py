"""MuJoCo as a referee for one body that is taken out, or pushed slowly until it moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.baselines import mujoco
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.base.arrays import Float
from holdfast.queries.request import push_columns

NODES = 16  # default number of nodes of an interface
TAKEN = 0.6  # share of a body's weight that is taken, besides the whole weight
SLOW = 1.0  # [s] time over which a push grows
LOOK = 50  # time steps between two measurements
MOVED = 1e-3  # [m] displacement at which the push ends


def rests_without(assembly: Assembly, body: str, nodes: int = NODES) -> bool | None:
    """Whether all rest without a body, and with TAKEN of its weight taken; None if that is not certain."""
    rest = assembly.without([body])
    if rest.hanging:
        return False
    trials = [mujoco.holds(rest, None, _nodes(rest, nodes)).holds] if rest.movable else []
    if False not in trials:
        k = 6 * assembly.index[body]
        load = np.zeros(6 * len(assembly.movable))
        load[k : k + 6] = -TAKEN * assembly.weight_wrench()[k : k + 6]
        trials.append(mujoco.holds(assembly, load, _nodes(assembly, nodes)).holds)
    return False if False in trials else None if None in trials else True


@dataclass(frozen=True)
class Pushed:
    """How far [m] the pushed body and the others have gone, at most, when the push ended at ``force`` [N]."""

    force: float
    own: float
    others: float


def pushed(world: mujoco.World, body: str, point: Float, direction: Float, force: float) -> Pushed:
    """Push a body at ``point`` [m] along the unit ``direction`` slowly, up to ``force`` [N] or until it has MOVED.

    ``world`` is at rest under its weight. The push stays where it was applied on the body, and keeps its direction.
    """
    assembly, model, data = world.assembly, world.model, world.data
    k = assembly.index[body]
    column = push_columns(assembly, k, point[None], direction[None])[:, 0].reshape(-1, 6)
    world.mujoco.mj_setState(model, data, world.start, world.mujoco.mjtState.mjSTATE_INTEGRATION)
    world.mujoco.mj_forward(model, data)
    start = _places(assembly, data)
    steps = round(SLOW / mujoco.STEP)
    own = others = share = 0.0
    for step in range(1, round((SLOW + mujoco.HOLD) / mujoco.STEP) + 1):
        share = min(1.0, step / steps)
        data.xfrc_applied[1:] = share * force * column
        world.mujoco.mj_step(model, data)
        if step % LOOK:
            continue
        gone = np.abs(_places(assembly, data) - start).max(axis=(1, 2))
        own, others = float(gone[k]), float(np.delete(gone, k).max(initial=0.0))
        if own > MOVED or others > MOVED:
            break
    return Pushed(share * force, own, others)


def _places(assembly: Assembly, data: object) -> Float:
    """The centre of every movable body and the ends of its axes, as long as the body is large, (J, 4, 3) [m]."""
    count = len(assembly.movable)
    turns = data.xmat[1 : count + 1].reshape(count, 3, 3)  # type: ignore[attr-defined]
    size = np.array([body.size for body in assembly.movable])[:, None, None] / 2
    centres = data.xipos[1 : count + 1, None]  # type: ignore[attr-defined]
    return np.concatenate([centres, centres + size * turns.transpose(0, 2, 1)], axis=1)


def _nodes(assembly: Assembly, count: int) -> ContactNodes:
    return contact_nodes(assembly, count, "quadrature")
