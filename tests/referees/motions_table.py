"""The motion that each push begins, beside engine ``limit`` and a simulation at 1.1 times the force, as a table.

``python tests/referees/motions_table.py [pushes] [seed] [--alone]``: random slanted pushes over shipped scenes and all
random families. ``--alone``: without the simulator.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from referee_queries import SCENES, shipped
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.baselines import mujoco
from bench.baselines.search import push
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import Push, random_pushes
from holdfast.assembly.assembly import Assembly
from holdfast.engines.compliant.elastic_model import Places
from holdfast.engines.mechanism import modes_of

OVER = 1.1  # times the force, in the simulation
RAMP, LAST = 0.05, 0.8  # [s] over which the load grows; until which motion is waited for
FAR = 2e-3  # sizes of the assembly that a contact or body is to move: elastic motions are a thousandth of that
MOVES = 0.05  # of the fastest body, by |v| + size |ω|
SIDE = 5  # nodes along a side
ALIKE = np.cos(np.radians(5))
LARGEST = 30.0  # total weights of pushes that are compared


class Motion(NamedTuple):
    """The twists (J, 6) of all bodies, which of them move, and what contacts do."""

    twists: np.ndarray
    moving: frozenset[str]
    mode: str

    def like(self, other: Motion, size: float) -> bool:
        """The same axes within 5 degrees, or the same bodies with the same mode."""
        mine, theirs = (each.twists * np.repeat([1.0, size], 3) for each in (self, other))
        alike = np.vdot(mine, theirs) >= ALIKE * np.linalg.norm(mine) * np.linalg.norm(theirs)
        return bool(alike) or (self.moving, self.mode) == (other.moving, other.mode)


class Case(NamedTuple):
    """A push on an assembly, and the motions that begin there."""

    name: str
    push: Push
    size: float
    compliant: Motion
    limit: Motion | None
    simulated: Motion | None


def motion(assembly: Assembly, twists: np.ndarray, mode: str) -> Motion:
    speeds = np.linalg.norm(twists[:, :3], axis=1) + assembly.size * np.linalg.norm(twists[:, 3:], axis=1)
    moves = speeds > MOVES * speeds.max()
    return Motion(twists, frozenset(b.name for b, m in zip(assembly.movable, moves, strict=True) if m), mode)


def simulated(world: mujoco.World, load: np.ndarray) -> Motion | None:
    """How the bodies have moved once something has moved far, or None if nothing does."""
    assembly, data, size = world.assembly, world.data, world.assembly.size
    world.mujoco.mj_setState(world.model, data, world.start, world.mujoco.mjtState.mjSTATE_INTEGRATION)
    world.mujoco.mj_forward(world.model, data)
    count = len(assembly.movable)
    centres, turns = data.xipos[1 : count + 1].copy(), data.xmat[1 : count + 1].reshape(-1, 3, 3).copy()
    wrench, twists = load.reshape(-1, 6), np.zeros((count, 6))
    for step in range(1, round(LAST / mujoco.STEP) + 1):
        share = min(1.0, step * mujoco.STEP / RAMP)
        data.xfrc_applied[1 : count + 1] = share * share * (3 - 2 * share) * wrench
        world.mujoco.mj_step(world.model, data)
        if step % 50:
            continue
        twists[:, :3] = data.xipos[1 : count + 1] - centres
        spun = data.xmat[1 : count + 1].reshape(-1, 3, 3) @ turns.transpose(0, 2, 1)
        twists[:, 3:] = Rotation.from_matrix(spun).as_rotvec()
        if np.abs(twists * np.repeat([1.0, size], 3)).max() > FAR * size:
            nodes = world.nodes
            velocity = Places.at(assembly, nodes).velocities(twists.reshape(1, -1))
            return motion(assembly, twists, modes_of(assembly, nodes, twists[None], velocity, dual=False)[0])
    return None


def assemblies(rng: np.random.Generator) -> Iterator[tuple[str, Assembly]]:
    """Shipped scenes and random ones in turn, without end."""
    while True:
        for name in SCENES:
            yield name, shipped(name)
        for name, family in FAMILIES.items():
            yield name, standing(family, rng)


def cases(count: int, seed: int, *, alone: bool = False) -> Iterator[Case]:
    """``count`` pushes with a finite answer, two at most on each assembly."""
    rng, done = np.random.default_rng(seed), 0
    for name, assembly in assemblies(rng):
        world = None
        for one in random_pushes(assembly, rng, 2, slant=60):
            found = hf.robustness(assembly, one.body, one.point, one.direction)
            mechanism = found.mechanism[0]
            if mechanism is None or not 0 < found.force[0] < LARGEST * assembly.weight:
                continue
            other = hf.robustness(assembly, one.body, one.point, one.direction, engine="limit").mechanism[0]
            if world is None and not alone:
                world = mujoco.World(assembly, Places.of(assembly, SIDE).nodes)
            load = OVER * found.force[0] * push(assembly, one.body, one.point, one.direction)
            yield Case(
                name,
                one,
                assembly.size,
                motion(assembly, mechanism.twists, mechanism.mode),
                None if other is None else motion(assembly, other.twists, other.mode),
                None if world is None else simulated(world, load),
            )
            done += 1
            if done == count:
                return


def main(count: int = 100, seed: int = 0, *, alone: bool = False) -> None:
    rows = []
    for k, case in enumerate(cases(count, seed, alone=alone)):
        against = [None if o is None else case.compliant.like(o, case.size) for o in (case.limit, case.simulated)]
        between = None
        if case.limit is not None and case.simulated is not None:
            between = case.limit.like(case.simulated, case.size)
        rows.append((*against, between))
        told = [f"{sorted(m.moving)} {m.mode}" if m else "-" for m in (case.compliant, case.limit, case.simulated)]
        if not all(rows[-1]):
            line = (k, case.name, case.push.body, case.push.point, case.push.direction, *told, rows[-1])
            sys.stdout.write(" | ".join(map(str, line)) + "\n")
    for name, column in zip(("limit", "simulation", "limit beside simulation"), zip(*rows, strict=True), strict=True):
        known = [same for same in column if same is not None]
        unknown = len(column) - len(known)
        sys.stdout.write(f"{name}: {sum(known)} of {len(known)} alike, {unknown} without a motion\n")


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    main(*numbers, alone="--alone" in sys.argv)
