"""How the largest factor of one load changes with friction, masses and centres of mass, all from one solve.

R is the largest s with G f + w_g + s w = 0 and f in the friction cones, so for a dual motion y with y·w = 1

    R = -y·w_g,   u = Gᵀy in the dual cones,   f·u = 0 at the optimum,

and where f and y are unique the derivative of R is that of the Lagrangian with f and y held (envelope theorem).
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.capabilities import Gradient
from holdfast.engines.limit.load_limit import LoadLimit
from holdfast.engines.mechanism import describe, relative_velocity


def gradient(assembly: Assembly, nodes: ContactNodes, limit: LoadLimit, normal: Float, where: str) -> Gradient:
    """The derivatives at one solved load, whose contacts press with ``normal`` (I,) [N]."""
    if limit.twists is None:
        problem = f"the push is {limit.status}"
        raise HoldfastError(message(where, problem, "there are derivatives only where a finite push moves something"))
    motion = limit.twists.reshape(-1, 6)
    weights = assembly.mass[:, None] * assembly.scene.gravity
    return Gradient(
        limit.factor,
        limit.lower,
        limit.upper,
        motion,
        _by_friction(assembly, nodes, motion, normal),
        -motion[:, :3] @ assembly.scene.gravity,
        -np.cross(weights, motion[:, 3:]),
        describe(assembly, nodes, motion, "none", dual=True).moving,
    )


def _by_friction(assembly: Assembly, nodes: ContactNodes, motion: Float, normal: Float) -> dict[tuple[str, str], float]:
    """dR/dμ of every pair: Σ |u_t| f_n over its nodes, for where a node slides its multiplier is |u_t|."""
    slip = np.linalg.norm(relative_velocity(nodes, assembly.com, motion)[:, 1:], axis=1)
    found = dict.fromkeys((interface.bodies for interface in assembly.interfaces), 0.0)
    for k, share in zip(nodes.interface, slip * np.maximum(normal, 0), strict=True):
        found[assembly.interfaces[k].bodies] += float(share)
    return found
