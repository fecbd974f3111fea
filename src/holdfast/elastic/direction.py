"""The direction of a load path at a point: which way is onwards, and what directions tell of other branches."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, lean
from holdfast.elastic.linear import Work
from holdfast.elastic.vectors import put

STRAIGHT = 0.9999  # cosine of the angle between two directions up to which a path went straight on


@compiled
@lean
def squares(work: Work) -> tuple[float, float]:
    """The squared motion of the body that moves most along the direction that was found, and that of all together."""
    best, whole = 0.0, 0.0
    for j in range((len(work.rhs) - 1) // 6):
        total = 0.0
        for i in range(6 * j, 6 * j + 6):
            total += work.rhs[i, 1] ** 2
        best, whole = max(best, total), whole + total
    return best, whole


@compiled
@lean
def turn(work: Work, sign: float, orientation: float, tangent: Float) -> float:
    """Point ``tangent`` (n,) onwards along the path, scale it, set work.c to its plane; returns ds/dℓ.

    Onwards is where s rises while the stiffness has the sign of determinant it had at rest, and falls while it has the
    other: the ``sign`` of the bordered determinant tells, whatever the border. The plane is across the motion of all
    bodies: across that of a single one more paths turn back.
    """
    n = len(tangent)
    best, whole = squares(work)
    size = orientation * sign / max(np.sqrt(best), 1e-300)
    for i in range(n):
        tangent[i] = size * work.rhs[i, 1]
        work.c[i] = tangent[i] * best / max(whole, 1e-300)
    return float(size * work.rhs[n, 1])


@compiled
@lean
def straight(work: Work, tangent: Float) -> bool:
    """Whether the path goes on at the point found as it came, along ``tangent`` (n,)."""
    along, here, before = 0.0, 0.0, 0.0
    for i in range(len(tangent)):
        along += work.rhs[i, 1] * tangent[i]
        here += work.rhs[i, 1] ** 2
        before += tangent[i] ** 2
    return bool(along > STRAIGHT * np.sqrt(here * before))


@compiled
def torn(
    work: Work, sign: float, orientation: float, q: Float, tangent: Float, trial: Float, step: float, most: float
) -> bool:
    """Whether the step from q to ``trial`` ends farther than ``most`` of it from where both ends' directions lead.

    Then a nearer solution may lie on the path, and this one on another branch.
    """
    there = np.zeros(len(q))
    plane = work.c.copy()
    turn(work, sign, orientation, there)
    put(work.c, plane)
    away, far = 0.0, 0.0
    for i in range(len(q)):
        moved = trial[i] - q[i]
        away = max(away, abs(moved - 0.5 * step * (tangent[i] + there[i])))
        far = max(far, abs(moved))
    return bool(away > most * far)
