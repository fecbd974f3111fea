"""Derivatives of the largest factor of one load by friction, masses and centres of mass, all from one solve.

R is the largest s with G f + w_g + s w = 0 and f in the friction cones. For the dual motion y with y·w = 1,

    R = -y·w_g,   u = Gᵀy in the dual cones,   f·u = 0 at the optimum.

Where f and y are unique, the derivative of R is that of the Lagrangian with f and y held (envelope theorem).
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.engines.answers import Answers
from holdfast.engines.capabilities import Gradient
from holdfast.engines.mechanism import relative_velocity


def gradient(assembly: Assembly, nodes: ContactNodes, twists: Float, forces: Float, answers: Answers) -> Gradient:
    """Return the derivatives of the largest factor of one solved load.

    ``twists`` (6J,) is the dual motion that limits the load, ``forces`` (I, 3) [N] are those at the limit, along the
    axes of the nodes, and ``answers`` is the table with the one row of this load.
    """
    motion = twists.reshape(-1, 6)
    weights = assembly.mass[:, None] * assembly.scene.gravity
    return Gradient(
        answers=answers,
        assembly=assembly,
        nodes=nodes,
        forces=nodes.world(forces),
        twists=motion,
        d_mu=_by_friction(assembly, nodes, motion, forces[:, 0]),
        d_mass=-motion[:, :3] @ assembly.scene.gravity,
        d_com=-np.cross(weights, motion[:, 3:]),
    )


def _by_friction(assembly: Assembly, nodes: ContactNodes, motion: Float, normal: Float) -> dict[tuple[str, str], float]:
    """Return dR/dμ for every pair of bodies: the sum of |u_t| f_n over its nodes.

    |u_t| is the multiplier of the friction limit of a node.
    """
    slip = np.linalg.norm(relative_velocity(nodes, assembly.com, motion)[:, 1:], axis=1)
    found = dict.fromkeys((interface.bodies for interface in assembly.interfaces), 0.0)
    for k, share in zip(nodes.interface, slip * np.maximum(normal, 0), strict=True):
        found[assembly.interfaces[k].bodies] += float(share)
    return found
