"""Motions that no contact resists, found by inverse iteration, and a faint hold that resists them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dgetrf, dgetrs
from scipy.sparse.linalg import splu

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.elastic.frames import set_units, twist_matrices
from holdfast.elastic.model import Elastic

NO_RESISTANCE = 1e-9  # largest resistance that counts as none, where that of bonded contacts is of order one
FAINT_HOLD = 1e-9  # stiffness of the faint hold of a body, in units of its contacts and size
FAINTEST = 1e-11  # the same where bodies move far, so that the hold carries next to nothing there, too
DENSE = 90  # displacements up to which dense elimination is faster than that of a sparse matrix
NEAR_SINGULAR = 1e-12  # added to the diagonal so that a singular stiffness can be factored, in the same units


def _blocks(twists: tuple[Float, Float], K: Float) -> Float:
    """The 6x6 blocks of every sheet's pairs of bodies (bb, ba, ab, aa), row by row, as ``_pattern`` has them.

    ``twists`` are those of ``twist_matrices``.
    """
    Ta, Tb = twists
    X, Y, to_b, to_a = K @ Tb, K @ Ta, Tb.transpose(0, 2, 1), Ta.transpose(0, 2, 1)
    return np.stack([to_b @ X, -(to_b @ Y), -(to_a @ X), to_a @ Y], 1)


def _pattern(m: Elastic) -> tuple[Bool, Int, Int]:
    """Which entries of ``_blocks`` belong to free bodies, and the rows and columns of those."""
    ends = np.stack([np.stack([m.b, m.b, m.a, m.a], 1), np.stack([m.b, m.a, m.b, m.a], 1)], 2)
    rows = (6 * ends[:, :, 0, None, None] + np.arange(6)[:, None] + np.zeros((1, 6), int)).ravel()
    columns = (6 * ends[:, :, 1, None, None] + np.arange(6) + np.zeros((6, 1), int)).ravel()
    kept = np.repeat((ends >= 0).all(2).ravel(), 36)
    return kept, rows[kept], columns[kept]


def unresisted_motion(m: Elastic, K: Float) -> Float:
    """How far each body (J,) moves in a motion (largest: 1) that the stiffness ``K`` (P, 6, 6) does not resist.

    Zero for all bodies if every motion is resisted. By inverse iteration from a fixed random start, so that of several
    such motions a general combination is found; each body's rows and columns in units of its own bonded contacts and
    size.
    """
    n = len(m.wrench)
    kept, rows, columns = _pattern(m)
    twists = twist_matrices(m)
    on = (rows == columns) & (rows % 6 < 3)
    firmest = np.bincount(rows[on], _blocks(twists, m.bonded).ravel()[kept][on], n)
    size = m.scale[::6] / m.scale[3::6]
    unit = np.repeat(np.sqrt(firmest.reshape(-1, 6).max(1)), 6) * np.stack([np.ones_like(size), size], 1).repeat(3)
    blocks = _blocks(twists, K)
    scaled = blocks.ravel()[kept] / (unit[rows] * unit[columns])
    A, solve = _factored(rows, columns, scaled, n)
    x = np.random.default_rng(0).normal(size=n)
    for _ in range(3):
        x = solve(x)
        x /= np.abs(x).max()
    if np.abs(np.asarray(A @ x)).max() > NO_RESISTANCE:
        return np.zeros(n // 6)
    return np.asarray(np.abs(x).reshape(-1, 6).max(1))


def _factored(rows: Int, columns: Int, values: Float, n: int) -> tuple[Any, Callable[[Float], Float]]:
    """Return the matrix (n, n) of these entries, summed where they meet, and what solves it; dense if it is small."""
    if n <= DENSE:
        A = np.bincount(n * rows + columns, values, n * n).reshape(n, n)
        lu, order, _ = dgetrf(A + NEAR_SINGULAR * np.eye(n))
        return A, lambda x: dgetrs(lu, order, x)[0]
    B = sparse.csc_matrix((values, (rows, columns)), shape=(n, n))
    return B, splu(B + NEAR_SINGULAR * sparse.eye(n, format="csc")).solve


def held(m: Elastic, bodies: Bool | None = None, faint: float = FAINT_HOLD) -> Elastic:
    """The model with a ``faint`` hold of ``bodies`` (J,), so that motions that no contact resists have a stiffness.

    All bodies are held if None. The hold is too faint to carry anything: what it would carry counts as not balanced,
    and a path ends where it begins to matter (stepper.py). Its unit lies midway between the firmest and the softest
    contact of a body: of a body that rests on a point and leans with a face, a hold measured by the face would carry
    part of the weight, and one measured by the point would be lost in rounding.
    """
    soft, firm = np.full(len(m.scale) // 6, np.inf), np.zeros(len(m.scale) // 6)
    stiff = m.bonded[:, range(3), range(3)].max(1, initial=0.0)
    for ends in (m.a, m.b):
        free = ends >= 0
        np.minimum.at(soft, ends[free], stiff[free])
        np.maximum.at(firm, ends[free], stiff[free])
    size = m.scale[::6] / m.scale[3::6]
    each = faint * np.sqrt(np.where(np.isfinite(soft), soft, 0.0) * firm)
    if bodies is not None:
        each[~bodies] = 0.0
    hold = (each[:, None] * np.stack([np.ones_like(size), size**2], 1)).repeat(3, axis=1).ravel()
    own = m._replace(hold=np.maximum(hold, m.hold), unit=np.empty_like(m.unit))
    set_units(own)
    return own


@compiled
@lean
def elastic_size(m: Elastic, q: Float, load: Float) -> float:
    """The largest displacement at rest, q (n,), of the bodies that no hold keeps or that the ``load`` (n,) acts on.

    A ball sinks a thousand times as deep into its point as boxes into each other, and says nothing about them.
    """
    every, found = 0.0, 0.0
    for body in range(len(q) // 6):
        far, counts = 0.0, False
        for i in range(6 * body, 6 * body + 6):
            far = max(far, abs(q[i]))
            counts = counts or m.hold[i] == 0.0 or load[i] != 0.0
        every = max(every, far)
        if counts:
            found = max(found, far)
    return max(found if found > 0.0 else every, 1e-300)
