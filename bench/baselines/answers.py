"""The largest push at many points as a simulator or the paper's optimisation finds it, in one form for all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from bench.baselines import lmgc90, mujoco, pybullet
from bench.baselines.search import Peak, World, largest_load
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.verdict import Status
from holdfast.queries.request import checked_assembly, pushes

Simulator = Literal["pybullet", "mujoco", "lmgc90"]
Protocol = Literal["printed", "hold"]

RANGE = 100.0  # [N] largest force of the paper's search
WIDEST = 0.05  # relative width of a bracket above which a search is undecided
NEARLY_NOTHING = 1e-3  # a bracket narrower than this, in total weights, always counts as an answer

Answer: TypeAlias = tuple[Status, float, float, float]  # status; force, lower and upper [N]


@dataclass(frozen=True, eq=False)
class Answers:
    """The largest push at each of n points according to a ``method`` that engines are compared with.

    Nothing is certified. ``force`` (n,) [N] goes with ``status`` (n,): FINITE; INFINITE (force inf: no motion was seen
    in the range that was searched); UNSTABLE (force 0: the assembly does not stand); UNDECIDED (force 0). ``lower`` and
    ``upper`` (n,) [N] are the ends of the last bracket of the search.
    """

    method: str
    body: str
    points: Float
    directions: Float
    force: Float
    status: Objects
    lower: Float
    upper: Float

    @classmethod
    def of(cls, method: str, body: str, points: Float, directions: Float, answers: Sequence[Answer]) -> Answers:
        """Collect the answers to all pushes."""
        values = np.array([answer[1:] for answer in answers])
        status = objects([answer[0] for answer in answers])
        return cls(method, body, points, directions, values[:, 0], status, values[:, 1], values[:, 2])

    @property
    def undecided(self) -> int:
        """The number of pushes whose status is UNDECIDED."""
        return int((self.status == Status.UNDECIDED).sum())


def simulated(
    assembly: Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    *,
    engine: Simulator = "pybullet",
    protocol: Protocol = "hold",
    most: float = RANGE,
    accuracy: float = 5e-3,
) -> Answers:
    """Find the largest push at each point with a simulator; ``points`` and ``directions`` as in ``robustness``.

    Protocol "printed" is Algorithm 2 of Nadeau & Kelly in PyBullet (``baselines/pybullet.py``), which always searches
    up to 100 N and ignores ``most`` and ``accuracy``. Protocol "hold" works in every simulator: it searches up to
    ``most`` [N], keeps each load on until rest or motion is seen, and ends when the bracket is narrower than
    ``accuracy`` times the load. The answer is infinite where nothing moves up to the end of the range.
    """
    checked_assembly(assembly)
    where = f"simulated robustness of {body!r}"
    for name, value, known in (("engine", engine, Simulator), ("protocol", protocol, Protocol)):
        if value not in get_args(known):
            raise HoldfastError(message(where, f"{name} = {value!r}", f"known: {', '.join(get_args(known))}"))
    p, e, W = pushes(assembly, body, points, directions, where)
    if protocol == "hold":
        world = _world(assembly, engine)
        peaks = [largest_load(world, assembly.weight, column, accuracy, most) for column in W.T]
    elif engine == "pybullet":
        once = pybullet.World(assembly, pybullet.PRINTED_STEP, pybullet.PRINTED_ITERATIONS)
        peaks = [once.printed(column) for column in W.T]
        most = pybullet.PRINTED_RANGE
    else:
        raise HoldfastError(message(where, f"protocol 'printed' in {engine}", "is PyBullet's: ask for 'hold'"))
    found = [_answer(peak, most, NEARLY_NOTHING * assembly.weight) for peak in peaks]
    return Answers.of(f"{engine} ({protocol})", body, p, e, found)


def _world(assembly: Assembly, engine: Simulator) -> World:
    if engine == "pybullet":
        return pybullet.World(assembly)
    return mujoco.World(assembly) if engine == "mujoco" else lmgc90.World(assembly)


def _answer(peak: Peak, most: float, nothing: float) -> Answer:
    """The answer of a search up to ``most`` [N]: finite if its bracket is narrower than WIDEST or ``nothing`` [N]."""
    if peak.moves == 0:
        if peak.undecided:
            return Status.UNDECIDED, 0.0, 0.0, np.inf
        return Status.UNSTABLE, 0.0, 0.0, 0.0
    if np.isinf(peak.moves):
        if peak.held >= (1 - 1e-9) * most:  # after 100 bisections, the search is at the end of its range
            return Status.INFINITE, np.inf, peak.held, np.inf
        return Status.UNDECIDED, 0.0, peak.held, np.inf
    if peak.moves - peak.held > max(WIDEST * peak.moves, nothing):
        return Status.UNDECIDED, 0.0, peak.held, peak.moves
    return Status.FINITE, peak.force, peak.held, peak.moves
