"""Contacts that cannot press without a load, found body by body, with no program to solve.

The forces on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie on
one side of a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others one-sided: a
stack of boxes is peeled from its corners. What is left may be clamped, or not.
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean

CLEAR = 1e-6  # sine of the angle by which every force must be off the plane
TRIALS = 100  # planes that are tried for a body; as many find any that every force is off by some 6 degrees


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
    peel(inward[order], mu[order], order % max(len(nodes), 1), other[order], first, left)
    return left


@compiled
def peel(inward: Float, mu: Float, node: Int, other: Int, first: Int, left: Bool) -> None:
    """Clear ``left`` (I,) at nodes of one-sided bodies.

    Body j has the entries ``first[j]`` to ``first[j + 1]`` - 1. Each of them is a ``node`` with its normal ``inward``
    (3,), its friction coefficient and the ``other`` body, -1 if that is fixed.
    """
    count = len(first) - 1
    waiting, stack = np.ones(count, np.bool_), np.arange(count)
    size = count
    while size > 0:
        size -= 1
        body = stack[size]
        waiting[body] = False
        low, high = first[body], first[body + 1]
        if not one_sided(inward[low:high], mu[low:high], node[low:high], left):
            continue
        for k in range(low, high):
            if left[node[k]] and other[k] >= 0 and not waiting[other[k]]:
                waiting[other[k]] = True
                stack[size] = other[k]
                size += 1
            left[node[k]] = False


@compiled
@lean
def one_sided(inward: Float, mu: Float, node: Int, left: Bool) -> bool:
    """Whether all forces on a body, at those of its nodes that are ``left``, lie on one side of a plane.

    A plane is sought by turning it towards the force that is farthest behind it, until none is (the perceptron). Where
    its normal vanishes, there is none: some forces balance each other.
    """
    x = y = z = 0.0  # along the normal of the plane
    for k in range(len(node)):
        if left[node[k]]:
            x, y, z = x + inward[k, 0], y + inward[k, 1], z + inward[k, 2]
    step = np.sqrt(x * x + y * y + z * z)  # of a turn
    for _ in range(TRIALS):
        size = np.sqrt(x * x + y * y + z * z)
        if size < CLEAR:
            return False
        worst, fx, fy, fz = np.inf, 0.0, 0.0, 0.0
        for k in range(len(node)):
            if not left[node[k]]:
                continue
            nx, ny, nz = inward[k, 0], inward[k, 1], inward[k, 2]
            ahead = (nx * x + ny * y + nz * z) / size
            tx, ty, tz = x / size - ahead * nx, y / size - ahead * ny, z / size - ahead * nz
            across = np.sqrt(tx * tx + ty * ty + tz * tz)
            length = np.sqrt(1 + mu[k] * mu[k])
            room = (ahead - mu[k] * across) / length
            if room < worst:
                worst = room
                back = mu[k] / max(across, 1e-300)  # friction acts against the part along the surface
                fx, fy, fz = (nx - back * tx) / length, (ny - back * ty) / length, (nz - back * tz) / length
        if worst > CLEAR:
            return True
        x, y, z = x + step * fx, y + step * fy, z + step * fz
    return False
