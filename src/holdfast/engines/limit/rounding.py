"""The equilibrium operator with bounds of what rounding may have done to its products.

The exact operator G is that of the points and axes of the nodes and of the centres of mass as the double-precision
numbers that they are. Its stored entries, and all sums of products, differ from it by rounding. For a sum of n products
computed in any order, |computed - exact| <= γ Σ |a||b| with γ = n u / (1 - n u) and u = 2⁻⁵³ (Higham, Accuracy and
Stability of Numerical Algorithms, chapter 3). The entries themselves are off by at most 4 u times the sums of absolute
products that they are computed from, which ``magnitude`` holds.

``Scales`` are units of forces and equations in which the numbers are of order one, whatever the masses and sizes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import (
    ContactNodes,
    arms,
    asked_of,
    by_bodies,
    dense_by_bodies,
    equilibrium_blocks,
)
from holdfast.base.arrays import Float
from holdfast.base.ranges import UNIT
from holdfast.engines.forces import lighter_share
from holdfast.engines.rest import Rest

SPARE = 6  # roundings of entries, of absolute values and of the bounds themselves, in u
LEAST = 1e-290  # covers underflow: products smaller than the normal range lose more than u of themselves
EXTENDED = np.finfo(np.longdouble).nmant in (63, 112)  # whether numpy has a precision beyond double, of IEEE kind
DENSE = 16_384  # entries up to which a dense matrix multiplies faster than a sparse one
UP, DOWN = 1 + 8 * UNIT, 1 - 8 * UNIT  # factors that outweigh the rounding of the last few operations

Matrix = Float | sparse.csr_matrix


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """The operator G (6J, 3I) of an assembly, its transpose ``gather``, and bounds of their rounding.

    ``magnitude`` (6J, 3I) is zero only where G is zero exactly. ``unknown`` (6J, 3I) bounds the errors of the entries
    of G and of products with them; ``spread`` (3I, 6J) does so for the transpose.
    """

    nodes: ContactNodes
    com: Float
    G: Matrix
    gather: Matrix
    magnitude: Matrix
    unknown: Matrix
    spread: Matrix

    @classmethod
    def of(cls, assembly: Assembly, nodes: ContactNodes) -> Equilibrium:
        """Return the operator of these nodes."""
        bodies = len(assembly.movable) + nodes.fasteners
        # H is G with absolute values of all factors, zero only where G is; that of holds is exact as it is stored
        own = nodes.contacts
        magnitudes = np.empty((len(own), 3, 2, 6))
        magnitudes[:, :, :, :3] = np.abs(own.axes)[:, :, None]
        fx, fy, fz = np.moveaxis(np.abs(own.axes), 2, 0)
        for side, body in enumerate((own.b, own.a)):
            x, y, z = np.abs(arms(assembly, own, body)).T[:, :, None]
            magnitudes[:, :, side, 3], magnitudes[:, :, side, 4] = y * fz + z * fy, z * fx + x * fz
            magnitudes[:, :, side, 5] = x * fy + y * fx
        blocks = equilibrium_blocks(assembly, nodes)
        sizes = asked_of(nodes, np.concatenate([magnitudes, np.abs(nodes.blocks)]))
        G: Matrix
        H: Matrix
        if 18 * bodies * len(nodes) <= DENSE:
            G, H = dense_by_bodies(bodies, nodes, blocks), dense_by_bodies(bodies, nodes, sizes)
        else:
            G, H = (sparse.csr_matrix(by_bodies(bodies, nodes, each)) for each in (blocks, sizes))
            H.eliminate_zeros()
        most = np.count_nonzero(H, axis=1) if isinstance(H, np.ndarray) else np.diff(H.indptr)
        terms = max(int(most.max(initial=0)), 12) + 2
        return cls(nodes, assembly.com, G, _turned(G), H, gamma(terms) * H, _turned(gamma(12) * H))

    def velocities(self, motions: Float) -> tuple[Float, Float]:
        """Return Gᵀ y (3I, k) for motions y (6J, k), and bounds (3I, k) of their errors.

        Motions in extended precision (EXTENDED) are multiplied in it.
        """
        if motions.dtype == np.longdouble:
            gather, spread = self._extended
            return np.asarray(gather @ motions), np.asarray(spread @ np.abs(motions)) + LEAST
        return np.asarray(self.gather @ motions), np.asarray(self.spread @ np.abs(motions)) + LEAST

    @cached_property
    def _extended(self) -> tuple[Any, Any]:
        """The transpose of G (3I, 6J) and the bounds of its products in extended precision."""
        own, bodies = self.nodes.contacts, len(self.com) + self.nodes.fasteners
        count, held = len(self.nodes), np.arange(len(own), len(self.nodes))
        axes = own.axes.astype(np.longdouble)
        G, H = np.zeros((2, count, 3, bodies + 1, 6), dtype=np.longdouble)  # FIXED is -1, the last one
        for side, body in enumerate((self.nodes.b[held], self.nodes.a[held])):
            G[held, :, body] += self.nodes.blocks[:, :, side]
            H[held, :, body] += np.abs(self.nodes.blocks[:, :, side])
        for body, sign in ((own.b, 1), (own.a, -1)):
            com = np.vstack([self.com, np.zeros((1, 3))])[body].astype(np.longdouble)
            arm = (own.points.astype(np.longdouble) - com)[:, None]
            size = np.abs(arm)
            around = [
                size[..., k - 2] * np.abs(axes[..., k - 1]) + size[..., k - 1] * np.abs(axes[..., k - 2])
                for k in range(3)
            ]
            node = np.arange(len(own))
            G[node, :, body] += sign * np.concatenate([axes, np.cross(arm, axes)], axis=2)
            H[node, :, body] += np.concatenate([np.abs(axes), np.stack(around, axis=2)], axis=2)
        if self.nodes.asked is not None:
            for m in (G, H):
                m[:, :, : len(self.com)] *= self.nodes.asked.reshape(-1, 6)
        unit = np.finfo(np.longdouble).eps
        gather, spread = (m[:, :, :bodies].reshape(3 * count, 6 * bodies) for m in (G, H))
        return gather, gamma(12) / UNIT * unit * spread

    def imbalance(self, forces: Float, wrench: Float, loads: Float, factors: Float) -> tuple[Float, Float]:
        """Return G f + w + s w_e (6J, k), and bounds of the errors.

        The forces f are (3I, k), the wrench w (6J,), the loads w_e (6J, k) and the factors s (k,).
        """
        pushed, found = factors * loads, np.asarray(self.G @ forces)
        size = np.abs(wrench)[:, None] + np.abs(pushed) + np.abs(found)
        return found + (wrench[:, None] + pushed), np.asarray(self.unknown @ np.abs(forces)) + gamma(4) * size + LEAST


def inner(a: Float, b: Float) -> tuple[Float, Float]:
    """Return the inner products (k,) of the columns of a and b (n, k) or (n, 1), and bounds of their errors."""
    products = a * b
    unit = float(np.finfo(products.dtype).eps)
    return products.sum(0), gamma(len(a)) / UNIT * unit * np.abs(products).sum(0) + LEAST


def gamma(terms: int) -> float:
    """Return a bound of γ for sums of this many products, with some roundings to spare."""
    return (terms + SPARE) * UNIT * 1.01


def _turned(matrix: Matrix) -> Matrix:
    """Return the transpose, by rows."""
    return np.ascontiguousarray(matrix.T) if isinstance(matrix, np.ndarray) else sparse.csr_matrix(matrix.T)


LIGHT = 0.25  # share of the weight of a node's lighter body that counts as its usual force, if it rests on nothing


@dataclass(frozen=True, eq=False)
class Scales:
    """Units of contact forces, ``force`` (3I,) [N], and of motions, ``motion`` (6J,).

    Forces are in units of the usual normal force of their node, times μ along the surface where μ < 1. An equation is
    multiplied by its unit of motion: its largest terms are then of order one.
    """

    force: Float
    motion: Float

    @classmethod
    def of(cls, equilibrium: Equilibrium, mu: Float, tau: Float) -> Scales:
        """Return the units for nodes with usual normal forces ``tau`` (I,) [N].

        They are 0 for forces that have to be 0 and for equations that none of the others enters.
        """
        force = np.repeat(tau, 3)
        force.reshape(-1, 3)[:, 1:] *= np.minimum(mu, 1.0)[:, None]
        H = equilibrium.magnitude
        squares = H * H if isinstance(H, np.ndarray) else H.multiply(H)
        size = np.sqrt(np.asarray(squares @ (force * force)).ravel())
        return cls(force, np.divide(1.0, size, out=np.zeros(len(size)), where=size > 0))


def usual_forces(assembly: Assembly, rest: Rest) -> Float:
    """Return the usual normal force (I,) [N] of every node: that at rest on its interface, or a share of a weight.

    Nodes of holds have their own.
    """
    nodes, owner = rest.nodes.contacts, rest.nodes.contacts.interface
    count = np.maximum(np.bincount(owner), 1)
    resting = np.bincount(owner, np.maximum(rest.forces[: len(nodes), 0], 0.0)) / count
    own = LIGHT * lighter_share(assembly, nodes) * assembly.weight
    return np.concatenate([np.maximum(resting[owner], own / count[owner]), rest.nodes.usual])
