"""Linear pressure without tension on a rectangle, by exact moments of the part in touch."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled

EDGE = 1e-4  # [-] of half a side: a resultant nearer to the edge is moved to this distance from it
RESIDUAL = 1e-12  # [-] of the resultant: the imbalance at which Newton's method ends
ROUNDING = 1e-13  # [-] of the energy: a rise that is attributed to rounding
STEPS = 200  # most iterations of Newton's method; about ten are usual, thirty at the edge

# The pressure does not depend on the sides: everything here is on the square [0, 2] x [0, 2] whose origin is the corner
# nearest the resultant. From there the strips and triangles of a nearly toppled block keep their digits.


@compiled
def touching(z: Float) -> tuple[Float, int]:
    """The part of the square [0, 2]² where z0 + z1 u + z2 v > 0: corners (5, 2) counter-clockwise, and how many."""
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    part = np.empty((5, 2))
    count = 0
    for k in range(4):
        a, b = square[k], square[(k + 1) % 4]
        pa, pb = z[0] + z[1] * a[0] + z[2] * a[1], z[0] + z[1] * b[0] + z[2] * b[1]
        if pa > 0:
            part[count] = a
            count += 1
        if (pa > 0) != (pb > 0):
            part[count] = a + pa / (pa - pb) * (b - a)
            count += 1
    return part, count


@compiled
def moments(part: Float, count: int) -> Float:
    """(3, 3) integral of φ φᵀ with φ = (1, u, v) over a polygon, exactly: mid-side rule on the triangles of a fan."""
    A = np.zeros((3, 3))
    phi = np.ones(3)
    for k in range(1, count - 1):
        o, a, b = part[0], part[k], part[k + 1]
        area = 0.5 * ((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]))
        for p, q in ((o, a), (a, b), (b, o)):
            phi[1], phi[2] = 0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])
            for i in range(3):
                for j in range(3):
                    A[i, j] += area / 3 * phi[i] * phi[j]
    return A


@compiled
def corner_pressure(u: float, v: float) -> Float:
    """Z (3,): pressure max(0, z0 + z1 u + z2 v) on [0, 2]² with resultant 1 at (u, v), 0 < u, v <= 1; NaN if not found.

    z is the minimum of the convex ψ(z) = ½ ∫ max(0, z·φ)² - z·(1, u, v): its gradient is the imbalance. Newton's method
    with the Hessian of the part in touch, shortened until ψ falls.
    """
    wanted = np.array([1.0, u, v])
    z = np.array([0.25, 0.0, 0.0])
    part, count = touching(z)
    A = moments(part, count)
    for _ in range(STEPS):
        left = wanted - A @ z
        if abs(left[0]) <= RESIDUAL and abs(left[1]) <= RESIDUAL * u and abs(left[2]) <= RESIDUAL * v:
            return z
        step = np.linalg.solve(A, left)
        energy, falls = 0.5 * z @ A @ z - wanted @ z, left @ step
        share = 1.0
        while True:
            tried = z + share * step
            part, count = touching(tried)
            A = moments(part, count)
            if 0.5 * tried @ A @ tried - wanted @ tried <= energy - 1e-4 * share * falls + ROUNDING * abs(energy):
                break
            share *= 0.5
            if share < 1e-10:  # at the limit of rounding: good enough, or not found
                fine = abs(left[0]) <= 1e-9 and abs(left[1]) <= 1e-9 * u and abs(left[2]) <= 1e-9 * v
                return z if fine else np.full(3, np.nan)
        z = tried
    return np.full(3, np.nan)


@compiled
def linear_pressure(half: Float, x: float, y: float) -> tuple[Float, Float, int, Float]:
    """Pressure with resultant 1 at (x, y) on the rectangle |x| <= half[0], |y| <= half[1]: what equilibrium leaves.

    Returns z (3,), p = z0 + z1 ξ + z2 η, the part in touch as corners (5, 2) counter-clockwise, both in coordinates
    (ξ, η) about the resultant, the number of corners, and the resultant's place (2,): (x, y), but not nearer to the
    edge than ``EDGE``.
    """
    hx, hy = half[0], half[1]
    sx, sy = (1.0 if x >= 0 else -1.0), (1.0 if y >= 0 else -1.0)
    u, v = max(1 - abs(x) / hx, EDGE), max(1 - abs(y) / hy, EDGE)
    corner = corner_pressure(u, v)
    part, count = touching(corner)
    # the square's u = 1 - sx x / hx and v = 1 - sy y / hy, and a pressure of resultant 1 is 1 / (hx hy) as large here
    level = corner[0] + corner[1] * u + corner[2] * v
    z = np.array([level, -sx * corner[1] / hx, -sy * corner[2] / hy]) / (hx * hy)
    placed = np.empty((5, 2))
    for k in range(count):
        source = k if sx * sy > 0 else count - 1 - k  # a mirror image runs clockwise
        placed[k, 0], placed[k, 1] = sx * hx * (u - part[source, 0]), sy * hy * (v - part[source, 1])
    return z, placed, count, np.array([sx * hx * (1 - u), sy * hy * (1 - v)])
