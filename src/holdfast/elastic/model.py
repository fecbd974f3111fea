"""The elastic model of an assembly on plain arrays: bodies, flat sheets of nodes between them, and their units.

Units inside: forces in total weights, lengths in assembly sizes, displacements and clearances in weight per mean
stiffness. On ideal faces the law is positively homogeneous, so the absolute stiffness drops out; else stiffness and
clearance count by their product over the weight only.

Nodes that lie in one plane with one normal form a sheet: their displacements are those of a single twist (6,) of b
against a, in the sheet's own axes (normal, t1, t2) and about its own origin, and so are their forces a single wrench.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dgetrf, dgetrs
from scipy.sparse.linalg import splu

from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.native import core


class Runs(NamedTuple):
    """R runs of a few nodes each, that lie together, of P sheets: where none of them presses, none is looked at.

    Those of sheet p are ``first[p]`` to ``first[p + 1] - 1``, and run k has nodes ``node[k]`` to ``node[k + 1] - 1``;
    ``box`` (R, 5): their least and largest x, least and largest y, and least clearance.
    """

    first: Int
    node: Int
    box: Float

    @classmethod
    def of(cls, first: Int, x: Float, y: Float, apart: Float) -> Runs:
        """Cut the sheets with nodes from ``first`` (P + 1,) on into runs."""
        return cls(*core.cut(first, x, y, apart))


class Elastic(NamedTuple):
    """P sheets of I nodes between J bodies, in the units of this module.

    ``first`` (P + 1,) where each sheet's nodes begin; ``x``, ``y`` (I,) along its tangents; ``k`` (I,) stiffness;
    ``apart`` (I,) clearance; ``mu`` (P,); ``rho`` tangential over normal stiffness; ``a``, ``b`` (P,) bodies (FIXED:
    -1); ``axes`` (P, 3, 3) normal and tangents of each sheet, as rows along the bodies' axes, which all bodies share;
    ``arm_a``, ``arm_b`` (P, 3) from the centre of a body to the origin of the sheet; ``wrench`` (6J,) what acts besides
    the contacts; ``scale`` (6J,) brings every body's equilibrium to order one; ``bonded`` (P, 6, 6) the stiffness with
    all nodes stuck, and ``unit`` (6J,) what brings that of every displacement to one; ``runs`` of the nodes; ``hold``
    (6J,) the stiffness of a regularisation spring of every body in its place, zero unless there are motions that no
    contact resists (``with_springs``); ``still`` (6J,) the stiffness with which bonds hold each body to the world, zero
    but on ice (law.hpp).
    """

    first: Int
    x: Float
    y: Float
    k: Float
    apart: Float
    mu: Float
    rho: float
    a: Int
    b: Int
    axes: Float
    arm_a: Float
    arm_b: Float
    wrench: Float
    scale: Float
    bonded: Float
    unit: Float
    runs: Runs
    hold: Float
    still: Float


Matrix = Any  # an array, or one of scipy.sparse where that is large

# Largest resistance that counts as none, where that of bonded contacts is of order one; a regularisation spring has it
NO_RESISTANCE = 1e-9
WEAKEST_SPRING = 1e-11  # the same where bodies move far, so that the springs carry next to nothing there, too
MOST_DENSE = 90  # displacements up to which dense elimination is faster, in compiled code and in SciPy
LEAST_PIVOT = 0.01  # share of the largest entry in its column from which one on the diagonal is taken as pivot
NEAR_SINGULAR = 1e-12  # added to the diagonal so that a singular stiffness can be factored, in the same units


def unresisted_motion(m: Elastic, K: Float) -> Float:
    """How far each body (J,) moves in a motion (largest: 1) that the stiffness ``K`` (P, 6, 6) does not resist.

    Zero for all bodies if every motion is resisted. By inverse iteration from a fixed random start, so that of several
    such motions a general combination is found; each body's rows and columns in units of its own bonded contacts and
    size.
    """
    n, size = len(m.wrench), m.scale[::6] / m.scale[3::6]
    softest = m.unit.reshape(-1, 6)[:, :3].min(1)  # that of the direction in which contacts are firmest
    unit = (softest[:, None] * np.stack([np.ones_like(size), 1 / size], 1).repeat(3, axis=1)).ravel()
    (rows, columns), values = np.empty((2, 144 * len(m.a)), dtype=np.int64), np.empty(144 * len(m.a))
    count = core.write_entries(m._replace(unit=unit), K, rows, columns, values)
    A, solve = _factored(rows[:count], columns[:count], values[:count], n)
    x = _start(n)
    for _ in range(3):
        x = solve(x)
        x /= np.abs(x).max()
    if np.abs(np.asarray(A @ x)).max() > NO_RESISTANCE:
        return np.zeros(n // 6)
    return np.asarray(np.abs(x).reshape(-1, 6).max(1))


@lru_cache
def _start(n: int) -> Float:
    return frozen(np.random.default_rng(0).normal(size=n))


def _factored(rows: Int, columns: Int, values: Float, n: int) -> tuple[Matrix, Callable[[Float], Float]]:
    """Return the matrix (n, n) of these entries, summed where they meet, and what solves it; dense if it is small."""
    if n <= MOST_DENSE:
        A = np.bincount(n * rows + columns, values, n * n).reshape(n, n)
        return A, solver(A, NEAR_SINGULAR)
    B = sparse.csc_matrix((values, (rows, columns)), shape=(n, n))
    # whatever slips, rows and columns have the same places
    order = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": LEAST_PIVOT, "options": {"SymmetricMode": True}}
    return B, solver(B, NEAR_SINGULAR, **order)


def solver(A: Matrix, shift: float, **order: Any) -> Callable[[Float], Float]:  # noqa: ANN401 - what splu takes
    """Return what solves for a matrix (n, n), dense or sparse, with ``shift`` added to its diagonal."""
    n = A.shape[0]
    if isinstance(A, np.ndarray):
        lu, pivots, _ = dgetrf(A + shift * np.eye(n))
        return lambda x: dgetrs(lu, pivots, x)[0]
    return splu(A.tocsc() + shift * sparse.eye(n, format="csc"), **order).solve


def with_springs(m: Elastic, bodies: Bool | None = None, stiffness: float = NO_RESISTANCE) -> Elastic:
    """The model with regularisation springs on ``bodies`` (J,): motions that no contact resists get a stiffness.

    None stands for all bodies. The springs are too soft to carry anything: what they would carry counts as not
    balanced, and a path ends where it begins to matter (stepper.hpp). Its unit lies midway between the firmest and the
    softest contact of a body: of a body that rests on a point and leans with a face, a hold measured by the face would
    carry part of the weight, and one measured by the point would be lost in rounding.
    """
    soft, firm = np.full(len(m.scale) // 6, np.inf), np.zeros(len(m.scale) // 6)
    stiff = m.bonded[:, range(3), range(3)].max(1, initial=0.0)
    for ends in (m.a, m.b):
        free = ends >= 0
        np.minimum.at(soft, ends[free], stiff[free])
        np.maximum.at(firm, ends[free], stiff[free])
    size = m.scale[::6] / m.scale[3::6]
    each = stiffness * np.sqrt(np.where(np.isfinite(soft), soft, 0.0) * firm)
    if bodies is not None:
        each[~bodies] = 0.0
    hold = (each[:, None] * np.stack([np.ones_like(size), size**2], 1)).repeat(3, axis=1).ravel()
    own = m._replace(hold=np.maximum(hold, m.hold), unit=np.empty_like(m.unit))
    core.set_units(own, own.unit)
    return own
