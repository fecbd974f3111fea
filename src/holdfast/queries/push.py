"""How hard may one push here: robustness at given points, and the factor of a set of loads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Objects, checked, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.contract import Capacity, Claim, Engine, Mechanism, Mode, State, Status
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    checked_assembly,
    engine_of,
    pushes,
    total_wrench,
)
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Robustness:
    """The largest push at each of n points.

    ``force`` (n,) [N], with ``status`` FINITE, INFINITE (force inf: no push moves anything), UNSTABLE (force 0: it
    does not stand anyway) or UNDECIDED (force 0: not known). ``lower`` and ``upper`` (n,) [N] bound the true answer as
    far as the engine can promise. ``moving`` (names), ``mode`` ("slip", "topple", "mixed", "none") and ``mechanism``
    (Mechanism or None), each (n,), tell what gives way. ``points`` and ``directions`` (n, 3), world.
    """

    engine: str
    claim: Claim
    body: str
    points: Float
    directions: Float
    force: Float
    status: Objects
    lower: Float
    upper: Float
    moving: Objects
    mode: Objects
    mechanism: Objects
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class LoadFactor:
    """The largest ``factor`` by which a set of loads may be multiplied together; fields as in Robustness."""

    engine: str
    claim: Claim
    factor: float
    status: Status
    lower: float
    upper: float
    moving: tuple[str, ...]
    mode: Mode
    mechanism: Mechanism | None
    notes: tuple[str, ...]


def robustness(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bound: bool = False,
) -> Robustness:
    """R(p, e): the largest force [N] at each point of ``body`` along each direction before anything moves (eq. 12).

    ``points`` and ``directions`` are (n, 3) or (3,), world frame; a single one is repeated for the other; directions
    need not be of unit length. ``standing`` loads act all the while. ``bound`` asks engine ``compliant`` for ``upper``:
    above it no equilibrium exists, by engine ``limit``. A point further from the body's surface than the
    contact tolerance raises SceneError.
    """
    assembly = checked_assembly(assembly)
    p, e, W = pushes(assembly, body, points, directions, f"robustness of {body!r}")
    method = engine_of(engine)
    held = total_wrench(assembly, standing)
    state, capacity = solved(method, assembly, W, held, bound=bound)
    return Robustness(
        method.name,
        method.claim,
        body,
        p,
        e,
        capacity.factor,
        objects(capacity.status),
        capacity.lower,
        capacity.upper,
        objects(capacity.moving),
        objects(capacity.mode),
        objects(capacity.mechanism),
        state.notes,
    )


def load_factor(
    assembly: Assembly | Scene,
    loads: Iterable[Load],
    *,
    standing: Iterable[Load] = (),
    acceleration: ArrayLike | None = None,
    engine: EngineChoice = DEFAULT_ENGINE,
    bound: bool = False,
) -> LoadFactor:
    """The largest factor by which all ``loads`` together may be multiplied before anything moves.

    ``standing`` loads and the inertial forces of a support that accelerates by ``acceleration`` (3,) [m/s²] act all
    the while, unscaled. ``bound`` as in ``robustness``.
    """
    assembly = checked_assembly(assembly)
    method = engine_of(engine)
    W = total_wrench(assembly, loads)[:, None]
    moved = None if acceleration is None else checked(acceleration, (3,), "load_factor: acceleration")
    held = total_wrench(assembly, standing)
    state, capacity = solved(method, assembly, W, held, moved, bound=bound)
    return LoadFactor(
        method.name,
        method.claim,
        float(capacity.factor[0]),
        capacity.status[0],
        float(capacity.lower[0]),
        float(capacity.upper[0]),
        capacity.moving[0],
        capacity.mode[0],
        capacity.mechanism[0],
        state.notes,
    )


def solved(
    method: Engine,
    assembly: Assembly,
    W: Float,
    standing: Float,
    acceleration: Float | None = None,
    *,
    bound: bool,
) -> tuple[State, Capacity]:
    """The engine made ready, and the capacities of load columns W (6J, n).

    ``bound``: with upper bounds by limit analysis over the corners of the patches, which contain all nodes.
    """
    state = method.prepare(assembly, standing, acceleration)
    capacity = state.load_factor(W)
    if not bound or method.claim is Claim.EXISTS:
        return state, capacity
    if method.claim is Claim.ESTIMATED:
        remedy = "engine graph is not ordered against limit: ask 'compliant', or 'limit' itself"
        raise HoldfastError(message("bound", f"asked of engine {method.name!r}", remedy))
    certain = engine_of(CERTAIN_ENGINE).prepare(assembly, standing, acceleration).load_factor(W)
    return state, replace(capacity, upper=np.minimum(capacity.upper, certain.upper))
