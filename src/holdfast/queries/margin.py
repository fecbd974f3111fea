"""The margin of a verdict: by what share gravity may lean over, or friction be lower, before something moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holdfast.assembly.assembly import Assembly, body_forces
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.values import altered
from holdfast.engines.answers import Bound
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.queries.crushing import unless_crushed, verdict_on_bearing
from holdfast.scene.hold import Grip

WAYS = 36  # level directions that are asked; between them at most 1 - cos(180° / 36) = 0.4 % is lost
CLOSE = 1e-3  # share of all friction to which a margin is known


def margin_of(engine: Engine, assembly: Assembly, standing: Float, pressed: Float) -> float:
    """Return the largest share m in [0, 1] by which either of two things may be worse, 0 if it does not surely stand.

    Every movable body may bear m times its weight as a level force, all in the same direction, whichever that is; and
    all coefficients of friction may be (1 - m) times as large. ``standing`` (6J,) [N, N m] are loads that act all the
    time, and ``pressed`` (B,) [N] is how much they press each body down. Nothing is crushed either way. Raises
    HoldfastError if the engine promises no lower bound.
    """
    if not assembly.movable or not prepared(engine, assembly, standing).verdict().stable:
        return 0.0
    level = _level(engine, assembly, standing, pressed)
    stands, falls = 0.0, min(level, 1.0)

    def rests(share: float) -> bool:
        slippery = _slippery(assembly, 1 - share)
        return verdict_on_bearing(prepared(engine, slippery, standing), pressed).stable

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


def _level(engine: Engine, assembly: Assembly, standing: Float, pressed: Float) -> float:
    """Return the share of the weight that may act along any level direction, inf without gravity.

    Loads that move nothing form a convex set about 0, as far as they are known to be balanced, so that between two
    directions it reaches at least as far as the chord.
    """
    gravity = float(np.linalg.norm(assembly.scene.gravity))
    if not gravity:
        return np.inf
    ways = assembly.scene.horizontal_directions(WAYS)
    weight = gravity * assembly.mass
    W = np.column_stack([body_forces(weight[:, None] * way) for way in ways])
    state = prepared(engine, assembly, standing)
    found = unless_crushed(state.load_factor(W), state, W, (pressed, np.zeros((len(pressed), WAYS))))
    if found.lower_bound is Bound.NONE:
        remedy = "ask engine 'compliant' or 'limit'"
        raise HoldfastError(message("margin", f"engine {engine.name!r} promises no lower bound", remedy))
    return float(found.lower.min() * np.cos(np.pi / WAYS))
