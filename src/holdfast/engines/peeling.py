"""Contacts that cannot press without a load, found body by body, with no program to solve.

The forces on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie on
one side of a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others one-sided: a
stack of boxes is peeled from its corners. What is left may be clamped, or not.
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool
from holdfast.native import core


def clampable(nodes: ContactNodes, corner: float = 1.0) -> Bool:
    """Return which nodes (I,) are left; the others press only if there is a load.

    Forces may lie outside the friction cone by the factor ``corner`` (``FrictionCone.corner``).
    """
    left = np.ones(len(nodes), dtype=bool)
    body, other = np.concatenate([nodes.b, nodes.a]), np.concatenate([nodes.a, nodes.b])
    inward, mu = np.concatenate([nodes.normals, -nodes.normals]), np.tile(corner * nodes.mu, 2)
    order = np.argsort(body, kind="stable")
    order = order[body[order] >= 0]
    first = np.searchsorted(body[order], np.arange(body.max(initial=-1) + 2))
    core.peel(inward[order], mu[order], order % max(len(nodes), 1), other[order], first, left)
    return left
