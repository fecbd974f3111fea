"""Twists, wrenches and stiffness of sheets, along the axes and about the centres of the bodies that they lie between.

A body's twist is (u, ω), along axes that all bodies share and about its centre. At a sheet whose origin is an ``arm`` p
away from that centre, and whose axes are the rows of R, its twist is

    T (u, ω) = (R (u + ω x p), R ω)

A product with the 6x6 matrix T takes three times as many multiplications as a turn by R and a shift by p.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, fused, lean
from holdfast.elastic.model import Elastic


@compiled
@lean
def set_units(m: Elastic) -> None:
    """Fill ``unit`` from ``bonded`` and ``still``, or from ``hold`` where that is more: 1 where nothing resists."""
    stiff = m.unit
    for i in range(len(stiff)):
        stiff[i] = m.still[i]
    for p in range(len(m.a)):
        R, D = m.axes[p], m.bonded[p]
        for body, arm in ((m.a[p], m.arm_a[p]), (m.b[p], m.arm_b[p])):
            if body < 0:
                continue
            for k in range(3):
                one, two = (k + 1) % 3, (k + 2) % 3
                for i in range(3):
                    v = arm[one] * R[i, two] - arm[two] * R[i, one]  # of a turn about axis k, along row i
                    for j in range(3):
                        w = arm[one] * R[j, two] - arm[two] * R[j, one]
                        stiff[6 * body + k] += R[i, k] * D[i, j] * R[j, k]
                        stiff[6 * body + 3 + k] += v * D[i, j] * w + 2 * v * D[i, 3 + j] * R[j, k]
                        stiff[6 * body + 3 + k] += R[i, k] * D[3 + i, 3 + j] * R[j, k]
    for i in range(len(stiff)):
        most = max(stiff[i], m.hold[i])  # a ball turns on its point, and the hold alone resists
        stiff[i] = 1 / np.sqrt(most) if most > 0 else 1.0


@compiled
@lean
def sheet_twist(m: Elastic, p: int, q: Float, v: Float) -> None:
    """Write into ``v`` (6,) the twist of sheet p's body b against its body a, under ``q`` (6J,)."""
    u0 = u1 = u2 = w0 = w1 = w2 = 0.0
    for side in range(2):
        body = m.b[p] if side == 0 else m.a[p]
        if body < 0:
            continue
        sign = 1.0 if side == 0 else -1.0
        arm, own = m.arm_b[p] if side == 0 else m.arm_a[p], q[6 * body : 6 * body + 6]
        x, y, z = sign * own[3], sign * own[4], sign * own[5]
        u0 += sign * own[0] + y * arm[2] - z * arm[1]
        u1 += sign * own[1] + z * arm[0] - x * arm[2]
        u2 += sign * own[2] + x * arm[1] - y * arm[0]
        w0 += x
        w1 += y
        w2 += z
    R = m.axes[p]
    for i in range(3):
        v[i] = R[i, 0] * u0 + R[i, 1] * u1 + R[i, 2] * u2
        v[i + 3] = R[i, 0] * w0 + R[i, 1] * w1 + R[i, 2] * w2


@compiled
@lean
def add_wrench(m: Elastic, p: int, F: Float, factor: float, r: Float) -> None:
    """Add to ``r`` (6J,) ``factor`` times sheet p's wrench ``F`` (6,) on body b, and its opposite on body a."""
    R = m.axes[p]
    f0 = factor * (R[0, 0] * F[0] + R[1, 0] * F[1] + R[2, 0] * F[2])
    f1 = factor * (R[0, 1] * F[0] + R[1, 1] * F[1] + R[2, 1] * F[2])
    f2 = factor * (R[0, 2] * F[0] + R[1, 2] * F[1] + R[2, 2] * F[2])
    t0 = factor * (R[0, 0] * F[3] + R[1, 0] * F[4] + R[2, 0] * F[5])
    t1 = factor * (R[0, 1] * F[3] + R[1, 1] * F[4] + R[2, 1] * F[5])
    t2 = factor * (R[0, 2] * F[3] + R[1, 2] * F[4] + R[2, 2] * F[5])
    for side in range(2):
        body = m.b[p] if side == 0 else m.a[p]
        if body < 0:
            continue
        sign = 1.0 if side == 0 else -1.0
        arm, own = m.arm_b[p] if side == 0 else m.arm_a[p], r[6 * body : 6 * body + 6]
        own[0] += sign * f0
        own[1] += sign * f1
        own[2] += sign * f2
        own[3] += sign * (t0 + arm[1] * f2 - arm[2] * f1)
        own[4] += sign * (t1 + arm[2] * f0 - arm[0] * f2)
        own[5] += sign * (t2 + arm[0] * f1 - arm[1] * f0)


@compiled
@lean
@fused
def add_stiffness(
    m: Elastic, p: int, K: Float, drag: float, at_a: int, at_b: int, A: Float, X: Float, Y: Float
) -> None:
    """Add [Tb, -Ta]ᵀ (K + ``drag`` · bonded) [Tb, -Ta] of sheet p to a matrix ``A``.

    The rows and columns of its bodies begin at ``at_a`` and ``at_b`` there, negative for a fixed one, and are
    multiplied by ``unit``: turns and shifts of small bodies have stiffnesses of other orders. ``X``, ``Y`` (6, 6) are
    scratch.
    """
    R, a, b = m.axes[p], m.a[p], m.b[p]
    for i in range(6):
        for j in range(6):
            X[i, j] = K[p, i, j] + drag * m.bonded[p, i, j]
    for half in range(0, 6, 3):  # Y = Rᵀ X, and X = Y R
        for i in range(3):
            one, two, three = R[0, i], R[1, i], R[2, i]
            for j in range(6):
                Y[half + i, j] = one * X[half, j] + two * X[half + 1, j] + three * X[half + 2, j]
    for i in range(6):
        for half in range(0, 6, 3):
            one, two, three = Y[i, half], Y[i, half + 1], Y[i, half + 2]
            for j in range(3):
                X[i, half + j] = one * R[0, j] + two * R[1, j] + three * R[2, j]
    if at_b >= 0:
        shift_columns(X, m.arm_b[p], m.unit[6 * b : 6 * b + 6], Y)
        add_shifted_rows(Y, m.arm_b[p], m.unit[6 * b : 6 * b + 6], 1.0, A, at_b, at_b)
        if at_a >= 0:
            add_shifted_rows(Y, m.arm_a[p], m.unit[6 * a : 6 * a + 6], -1.0, A, at_a, at_b)
    if at_a >= 0:
        shift_columns(X, m.arm_a[p], m.unit[6 * a : 6 * a + 6], Y)
        add_shifted_rows(Y, m.arm_a[p], m.unit[6 * a : 6 * a + 6], 1.0, A, at_a, at_a)
        if at_b >= 0:
            add_shifted_rows(Y, m.arm_b[p], m.unit[6 * b : 6 * b + 6], -1.0, A, at_b, at_a)


@compiled
@lean
@fused
def shift_columns(X: Float, arm: Float, unit: Float, Y: Float) -> None:
    """Write into ``Y`` (6, 6) ``X`` (6, 6) times a body's shift by an ``arm`` (3,), columns in its ``unit`` (6,)."""
    x, y, z = arm[0], arm[1], arm[2]
    for i in range(6):
        one, two, three = X[i, 0], X[i, 1], X[i, 2]
        Y[i, 0], Y[i, 1], Y[i, 2] = one * unit[0], two * unit[1], three * unit[2]
        Y[i, 3] = (X[i, 3] + y * three - z * two) * unit[3]
        Y[i, 4] = (X[i, 4] + z * one - x * three) * unit[4]
        Y[i, 5] = (X[i, 5] + x * two - y * one) * unit[5]


@compiled
@lean
@fused
def add_shifted_rows(Y: Float, arm: Float, unit: Float, sign: float, A: Float, row: int, column: int) -> None:
    """Add ``sign`` times a body's transposed shift times ``Y`` (6, 6), rows in its ``unit`` (6,), to part of ``A``."""
    x, y, z = arm[0], arm[1], arm[2]
    u0, u1, u2 = sign * unit[0], sign * unit[1], sign * unit[2]
    u3, u4, u5 = sign * unit[3], sign * unit[4], sign * unit[5]
    for j in range(6):
        one, two, three = Y[0, j], Y[1, j], Y[2, j]
        A[row, column + j] += u0 * one
        A[row + 1, column + j] += u1 * two
        A[row + 2, column + j] += u2 * three
        A[row + 3, column + j] += u3 * (Y[3, j] + y * three - z * two)
        A[row + 4, column + j] += u4 * (Y[4, j] + z * one - x * three)
        A[row + 5, column + j] += u5 * (Y[5, j] + x * two - y * one)
