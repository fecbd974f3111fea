"""Contacts that cannot press without a load, found body by body, with no program to solve.

The forces on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie on
one side of a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others one-sided: a
stack of boxes is peeled from its corners. What is left may be clamped, or not.
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean

CLEAR = 1e-6  # sine of the angle by which every force must be off the plane
TRIALS = 100  # planes that are tried for a body; as many find any that every force is off by some 6 degrees


def clampable(nodes: ContactNodes, corner: float = 1.0) -> Bool:
    """Return which nodes (I,) are left; the others press only if there is a load.

    Forces may lie outside the friction cone by the factor ``corner`` (``FrictionCone.corner``).
    """
    left = np.ones(len(nodes), dtype=bool)
    ends = np.concatenate([nodes.a, nodes.b])
    order = np.argsort(ends, kind="stable")
    order = order[ends[order] >= 0]
    first = np.searchsorted(ends[order], np.arange(ends.max(initial=-1) + 2))
    peel(np.ascontiguousarray(nodes.normals), corner * nodes.mu, nodes.a, nodes.b, first, order % len(nodes), left)
    return left


@compiled
def peel(normals: Float, mu: Float, a: Int, b: Int, first: Int, at: Int, left: Bool) -> None:
    """Clear ``left`` (I,) at nodes of one-sided bodies; body j has the nodes ``at[first[j]:first[j + 1]]``."""
    count = len(first) - 1
    waiting, stack = np.ones(count, np.bool_), np.arange(count)
    size = count
    while size > 0:
        size -= 1
        body = stack[size]
        waiting[body] = False
        if not one_sided(normals, mu, b, body, at[first[body] : first[body + 1]], left):
            continue
        for k in range(first[body], first[body + 1]):
            if not left[at[k]]:
                continue
            left[at[k]] = False
            other = a[at[k]] if b[at[k]] == body else b[at[k]]
            if other >= 0 and not waiting[other]:
                waiting[other] = True
                stack[size] = other
                size += 1


@compiled
@lean
def one_sided(normals: Float, mu: Float, b: Int, body: int, at: Int, left: Bool) -> bool:
    """Whether all forces on a body, at the nodes ``at`` that are ``left``, lie on one side of a plane.

    A plane is sought by turning it towards the force that is farthest behind it, until none is (the perceptron).
    """
    x = y = z = 0.0  # along the normal of the plane
    for k in at:
        if left[k]:
            sign = 1.0 if b[k] == body else -1.0
            x, y, z = x + sign * normals[k, 0], y + sign * normals[k, 1], z + sign * normals[k, 2]
    size = max(np.sqrt(x * x + y * y + z * z), CLEAR)
    x, y, z = x / size, y / size, z / size
    for _ in range(TRIALS):
        size = np.sqrt(x * x + y * y + z * z)
        if size < CLEAR:
            return False
        dx, dy, dz = x / size, y / size, z / size
        worst, fx, fy, fz = np.inf, 0.0, 0.0, 0.0
        for k in at:
            if not left[k]:
                continue
            sign = 1.0 if b[k] == body else -1.0
            nx, ny, nz = sign * normals[k, 0], sign * normals[k, 1], sign * normals[k, 2]
            ahead = nx * dx + ny * dy + nz * dz
            tx, ty, tz = dx - ahead * nx, dy - ahead * ny, dz - ahead * nz
            across = np.sqrt(tx * tx + ty * ty + tz * tz)
            length = np.sqrt(1 + mu[k] * mu[k])
            if (ahead - mu[k] * across) / length < worst:
                worst = (ahead - mu[k] * across) / length
                back = mu[k] / max(across, 1e-300)  # friction acts against the part along the surface
                fx, fy, fz = (nx - back * tx) / length, (ny - back * ty) / length, (nz - back * tz) / length
        if worst > CLEAR:
            return True
        x, y, z = x + fx, y + fy, z + fz
    return False
