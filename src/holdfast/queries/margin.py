"""The margin of a verdict: by what share gravity may lean over, or friction be lower, before something moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.assembly.assembly import Assembly, body_forces
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message
from holdfast.base.values import altered
from holdfast.engines.answers import Bound
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.queries.crushing import unless_crushed, verdict_on_bearing
from holdfast.scene.hold import Grip

WAYS = 36  # level directions that are asked; between them at most 1 - cos(180° / 36) = 0.4 % is lost
CLOSE = 1e-3  # share of all friction to which a margin is known


def margin_of(
    engine: Engine, assembly: Assembly, standing: Float, pressed: Float, groups: Sequence[int] | None = None
) -> float:
    """Return the largest share m in [0, 1] by which either of two things may be worse, 0 if it does not surely stand.

    Every movable body of some ``groups``, by default of all, may bear m times its weight as a level force, all in the
    same direction, whichever that is; and all coefficients of friction may be (1 - m) times as large. Bodies that are
    only balanced bear no such force, and where no other is left, the share is 0. ``standing`` (6J,) [N, N m] are loads
    that act all the time, and ``pressed`` (B,) [N] is how much they press each body down. Nothing is crushed either
    way. Raises HoldfastError if the engine promises no lower bound.
    """
    asked = np.flatnonzero(np.isin(assembly.group_of, range(len(assembly.groups)) if groups is None else groups))
    verdict = prepared(engine, assembly, standing).verdict_on(asked.tolist())
    loaded = np.array([assembly.movable[k].name not in verdict.balanced for k in asked], dtype=bool)
    if not verdict.stable or not loaded.any():
        return 0.0
    level = _level(engine, assembly, standing, pressed, asked[loaded])
    stands, falls = 0.0, min(level, 1.0)

    def rests(share: float) -> bool:
        slippery = _slippery(assembly, 1 - share)
        return verdict_on_bearing(prepared(engine, slippery, standing), pressed, asked.tolist()).stable

    if rests(falls):
        return falls
    while falls - stands > CLOSE:
        share = (stands + falls) / 2
        stands, falls = (share, falls) if rests(share) else (stands, share)
    return stands


def _slippery(assembly: Assembly, share: float) -> Assembly:
    """Return the assembly with this share of all friction, that of fingers and suction cups included."""
    less = assembly.with_mu([share * mu for mu in assembly.mu])
    if not assembly.scene.holds:
        return less
    holds = (altered(hold, mu=share * hold.mu) if isinstance(hold, Grip) else hold for hold in assembly.scene.holds)
    return replace(less, scene=replace(less.scene, holds=tuple(holds)))


def _level(engine: Engine, assembly: Assembly, standing: Float, pressed: Float, bodies: Int) -> float:
    """Return the share of the weight of some bodies that may act along any level direction, inf without gravity.

    Loads that move nothing form a convex set about 0, as far as they are known to be balanced, so that between two
    directions it reaches at least as far as the chord.
    """
    gravity = float(np.linalg.norm(assembly.scene.gravity))
    if not gravity:
        return np.inf
    ways = assembly.scene.horizontal_directions(WAYS)
    weight = np.zeros(len(assembly.movable))
    weight[bodies] = gravity * assembly.mass[bodies]
    W = np.column_stack([body_forces(weight[:, None] * way) for way in ways])
    state = prepared(engine, assembly, standing)
    found = unless_crushed(state.load_factor(W), state, W, (pressed, np.zeros((len(pressed), WAYS))))
    if found.lower_bound is Bound.NONE:
        remedy = "ask engine 'compliant' or 'limit'"
        raise HoldfastError(message("margin", f"engine {engine.name!r} promises no lower bound", remedy))
    return float(found.lower.min() * np.cos(np.pi / WAYS))
