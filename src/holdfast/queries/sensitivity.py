"""How one robustness changes with friction, masses, centres of mass and the point of the push."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, unit
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.engines.capabilities import GRADIENTS
from holdfast.engines.contract import Claim
from holdfast.queries.intervals import Pair
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    Load,
    body_number,
    checked_assembly,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of the largest push ``force`` [N] (between ``lower`` and ``upper``).

    ``d_mu`` [N] by the two bodies of an interface; ``d_mass`` [N/kg] by movable body, its centre of mass held;
    ``d_com`` (3,) [N/m] by movable body, for its centre of mass in the world, contacts held; ``d_point`` (3,) [N/m] for
    the point of the push, direction held. ``moving``: the bodies of the mechanism.
    """

    engine: str
    claim: Claim
    body: str
    force: float
    lower: float
    upper: float
    d_mu: dict[Pair, float]
    d_mass: dict[str, float]
    d_com: dict[str, Float]
    d_point: Float
    moving: tuple[str, ...]


def sensitivity(
    assembly: Assembly | Scene,
    body: str,
    point: ArrayLike,
    direction: ArrayLike,
    *,
    standing: Iterable[Load] = (),
) -> Sensitivity:
    """Derivatives of R(p, e) by engine ``limit``, all from one solve; ``point``, ``direction`` (3,) world.

    They hold where R is differentiable: one mechanism, and contact forces that are unique where it slides. At a kink
    (two mechanisms at the same push) they belong to one of the mechanisms or a mean of them, and in masses they still
    bound R from above (R is concave in them); whether a kink is met is not tested. Contact nodes, the push and
    standing loads stay where they are. Raises HoldfastError where R is zero, infinite or undecided.
    """
    assembly = checked_assembly(assembly)
    where = f"sensitivity of {body!r}"
    p = checked(point, (3,), f"{where}: point")
    e = checked(direction, (3,), f"{where}: direction")
    if not np.linalg.norm(e) > 0:
        raise SceneError(message(where, "the direction is zero", "needs a vector with a length"))
    e, number = unit(e), body_number(assembly, body)
    method = engine_of(CERTAIN_ENGINE)
    state = method.prepare(assembly, total_wrench(assembly, standing))
    gradients = GRADIENTS.of(state, engine=method.name, where=where)
    verdict = state.verdict()
    if not verdict.equilibrium_exists:
        raise HoldfastError(message(where, f"the assembly is {verdict.status}", verdict.reason))
    found = gradients.gradient(push_columns(assembly, number, p[None], e[None])[:, 0], where)
    names = [b.name for b in assembly.movable]
    return Sensitivity(
        method.name,
        method.claim,
        body,
        found.factor,
        found.lower,
        found.upper,
        found.d_mu,
        dict(zip(names, found.d_mass.tolist(), strict=True)),
        dict(zip(names, found.d_com, strict=True)),
        -found.factor * np.cross(e, found.twists[number, 3:]),
        found.moving,
    )
