"""Contact forces at rest from the quadratic program of eq. 8-11, with the exact friction cone.

Friction cones are rows of a cone program: exact, or polygons inside or around it.

Some contacts can carry self-stress, that is forces that balance each other without any load (``clampable``). The forces
on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie on one side of
a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others one-sided: a stack of
boxes is peeled from its corners, in a hundredth of the time that a program takes. What is left may be clamped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import (
    ContactNodes,
    entries_by_bodies,
    equilibrium_blocks,
    equilibrium_operator,
)
from holdfast.base.arrays import Bool, Float, checked_whole, checked_word
from holdfast.base.entries import Entries, diagonal, together
from holdfast.base.ranges import UNIT
from holdfast.conic.solve import ConeKind, ConeProgram, ConeSolution, Outcome, solve
from holdfast.native import core

ROUNDING = 18 * UNIT  # of the terms in the distance of a force from the border of its cone: fewer operations than that
ConeChoice = Literal["exact", "inscribed", "circumscribed"]

MOST_SIDES = 1_000  # largest number of sides of a polygon that stands for the cone


@dataclass(frozen=True)
class FrictionCone:
    """How |f_t| <= μ f_n is stated: the exact cone, or a polygon of ``sides`` inside it (cautious) or around it."""

    kind: ConeChoice = "exact"
    sides: int = 8

    def __post_init__(self) -> None:
        checked_word(self.kind, get_args(ConeChoice), "cone")
        checked_whole(self.sides, "cone: sides", 3, MOST_SIDES)

    def entries(self, nodes: ContactNodes) -> tuple[Entries, tuple[tuple[ConeKind, int], ...]]:
        """Entries of C (m, 3I), and cones, such that -C f in the cones states friction at every node.

        In order: f_t = 0 of nodes without friction, f_n >= 0 of those, then the cones (μ f_n, f_t) of the others. The
        rows of a node with μ > 1 are divided by μ, so that no entry is large. All entries of a row are of one node; m
        is the size of all cones.
        """
        smooth, rough = np.flatnonzero(nodes.mu == 0), np.flatnonzero(nodes.mu > 0)
        single = np.concatenate([np.sort(np.r_[3 * smooth + 1, 3 * smooth + 2]), 3 * smooth])  # -1 in a row each
        free: list[tuple[ConeKind, int]] = [("zero", 2 * len(smooth)), ("nonnegative", len(smooth))]
        if self.kind == "exact":
            scale = np.ones((len(rough), 3)) / np.maximum(nodes.mu[rough], 1.0)[:, None]
            scale[:, 0] = np.minimum(nodes.mu[rough], 1.0)
            held: list[tuple[ConeKind, int]] = [("second_order", 3)] * len(rough)
            columns = np.concatenate([single, (3 * rough[:, None] + np.arange(3)).ravel()])
            found = Entries(np.arange(len(columns)), columns, -np.append(np.ones(len(single)), scale.ravel()))
        else:
            held = [("nonnegative", self.sides * len(rough))]
            none = Entries(np.arange(len(single)), single, -np.ones(len(single)))
            angle = 2 * np.pi * np.arange(self.sides) / self.sides
            shrink = np.cos(np.pi / self.sides) if self.kind == "inscribed" else 1.0
            block = np.empty((len(rough), self.sides, 3))
            block[:, :, 0] = -shrink * nodes.mu[rough][:, None]
            block[:, :, 1], block[:, :, 2] = np.cos(angle), np.sin(angle)
            block /= np.maximum(nodes.mu[rough], 1.0)[:, None, None]
            numbers = np.broadcast_to(np.arange(len(rough) * self.sides)[:, None], (len(rough) * self.sides, 3))
            places = np.broadcast_to(3 * rough[:, None, None] + np.arange(3), block.shape)
            found = together(none, Entries(numbers.ravel(), places.ravel(), block.ravel()).below(len(single)))
        return found, tuple((kind, size) for kind, size in (*free, *held) if size)

    def rows(self, nodes: ContactNodes) -> tuple[sparse.csr_matrix, tuple[tuple[ConeKind, int], ...]]:
        """C (m, 3I) and the cones, as ``entries`` has them."""
        found, cones = self.entries(nodes)
        return sparse.csr_matrix(found.matrix((size_of(cones), 3 * len(nodes)))), cones

    @property
    def corner(self) -> float:
        """The largest |f_t| / (μ f_n) that it allows."""
        return 1 / np.cos(np.pi / self.sides) if self.kind == "circumscribed" else 1.0

    def resistance(self, mu: Float, sliding: Float) -> Float:
        """(I, k) the most that friction at f_n = 1 can do against sliding velocities (I, k, 2): μ |u_t|.

        It is that at a corner for a polygon; around the cone, no less than that of the cone.
        """
        speed = np.hypot(sliding[..., 0], sliding[..., 1])
        if self.kind != "exact":
            angle = 2 * np.pi * (np.arange(self.sides) + 0.5) / self.sides
            corners = self.corner * np.array([np.cos(angle), np.sin(angle)])
            furthest = (sliding @ corners).max(-1, initial=0)
            speed = furthest if self.kind == "inscribed" else np.maximum(furthest, speed)
        return np.asarray(mu[:, None] * speed)

    def room(self, mu: Float, forces: Float) -> Float:
        """Return (I, k) how far forces (I, k, 3) are inside: f_n - |f_t| / μ, and never more than is certain.

        It is negative outside. A node without friction has to have f_t = 0. Room is concave, and room of a sum is at
        least the sum of the rooms. An inscribed polygon counts with the exact cone around it.
        """
        normal, sliding = forces[..., 0], forces[..., 1:]
        with np.errstate(divide="ignore", over="ignore"):
            inverse = np.where(mu > 0, 1 / np.where(mu > 0, mu, 1.0), 0.0)[:, None]
            along = np.hypot(sliding[..., 0], sliding[..., 1]) * inverse
        unknown = ROUNDING * (np.abs(normal) + along)
        if self.kind == "exact":
            return np.asarray(normal - along - unknown)
        angle = 2 * np.pi * np.arange(self.sides) / self.sides
        widest = (sliding @ np.array([np.cos(angle), np.sin(angle)])).max(-1, initial=0) * inverse
        if self.kind == "circumscribed":
            return np.asarray(normal - widest - unknown)
        return np.asarray(np.minimum(normal * np.cos(np.pi / self.sides) - widest, normal - along) - unknown)


def size_of(cones: Sequence[tuple[ConeKind, int]]) -> int:
    """Return the number of rows that ``cones`` take."""
    return sum(size for _, size in cones)


EXACT = FrictionCone()


ACCEPTED_RESIDUAL = 1e-7  # largest equilibrium error of accepted forces, relative to each body's own weight
NO_FORCE = 1e-6  # normal force below which a node counts as unloaded, relative to the weight of its lighter body


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """The outcome of the force program: contact forces, or the motion that proves that there are none.

    ``forces`` (I, 3) [N] are along the local axes (normal, t1, t2) of each node, or None. ``twists`` (J, 6) are those
    of the certificate of infeasibility, or None. ``residual`` is recomputed from the program's data: it is the larger
    of the equilibrium error, relative to each body's own weight, and the cone violation, relative to the total weight.

    ``dilatancy`` is the largest normal force that the associated flow of the program's friction law adds at a node,
    relative to the weight of the node's lighter body. If it is 0, the forces are also those of elastic contacts with
    plain Coulomb friction, so no self-stress is needed.
    """

    outcome: Outcome
    forces: Float | None
    twists: Float | None
    residual: float
    dilatancy: float
    iterations: int


def force_program(assembly: Assembly, nodes: ContactNodes, wrench: Float, cone: FrictionCone = EXACT) -> ConeProgram:
    """Set up min ½ Σ |f_i|²/w_i  s.t.  G f + wrench = 0, f in the friction cones (eq. 8-11).

    Forces are in units of the total weight, and each body's equilibrium in units of its own weight and size. The first
    6J rows are the equilibrium, the others the friction cones (``FrictionCone.rows``). ``wrench`` (6J,) is in [N, N m].
    """
    count, (friction, cones) = len(wrench), cone.entries(nodes)
    scale = nodes.scaled(assembly.equation_scale)
    balance = entries_by_bodies(nodes, equilibrium_blocks(assembly, nodes)).scaled(scale).stored
    b = np.zeros(count + size_of(cones))
    b[:count] = -scaled_wrench(assembly, nodes, wrench)
    share = nodes.weights / nodes.weights.mean() if len(nodes) else nodes.weights
    A = together(balance, friction.stored.below(count)).matrix((len(b), 3 * len(nodes)))
    P = diagonal(np.repeat(1 / share, 3))
    return ConeProgram(P, np.zeros(A.shape[1]), A, b, (("zero", count), *cones))


def scaled_operator(assembly: Assembly, nodes: ContactNodes) -> sparse.csc_matrix:
    """Return G with the rows of every body in units of its own weight and size, so that all are of order one."""
    scaled = equilibrium_operator(assembly, nodes)
    scaled.data *= nodes.scaled(assembly.equation_scale)[scaled.indices]
    scaled.eliminate_zeros()
    return scaled


def scaled_wrench(assembly: Assembly, nodes: ContactNodes, wrench: Float) -> Float:
    """Return ``wrench`` (6J,) in the units that ``scaled_operator`` gives to forces in units of the total weight."""
    return nodes.scaled(assembly.equation_scale) * wrench / assembly.weight


def solve_forces(
    assembly: Assembly,
    nodes: ContactNodes,
    wrench: Float,
    *,
    tolerance: float = 1e-10,
    cone: FrictionCone = EXACT,
) -> ForceSolution:
    """Find contact forces that balance ``wrench`` (6J,) [N, N m], or a motion that proves that there are none."""
    program = force_program(assembly, nodes, wrench, cone)
    solution = solve(program, tolerance=tolerance)
    if solution.outcome is Outcome.INFEASIBLE:
        twists = (nodes.scaled(assembly.equation_scale) * solution.z[: len(wrench)]).reshape(-1, 6)
        return ForceSolution(solution.outcome, None, twists, np.inf, 0.0, solution.iterations)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return ForceSolution(solution.outcome, None, None, np.inf, 0.0, solution.iterations)
    forces = solution.x.reshape(-1, 3)
    return ForceSolution(
        solution.outcome,
        forces * assembly.weight,
        None,
        solution.residual,
        _dilatancy(assembly, nodes, solution) if cone.kind == "exact" else np.inf,
        solution.iterations,
    )


def lighter_share(assembly: Assembly, nodes: ContactNodes) -> Float:
    """Return (I,) the mass of the lighter body of each node over the total mass: the scale of forces at that node."""
    mass = np.append(assembly.mass, np.full(1 + nodes.fasteners, np.inf))  # FIXED is -1
    return np.asarray(np.minimum(mass[nodes.a], mass[nodes.b]) / assembly.mass.sum())


def _dilatancy(assembly: Assembly, nodes: ContactNodes, solution: ConeSolution) -> float:
    """Return the largest normal force that slip adds at a loaded contact, relative to its lighter body's weight."""
    rough = np.flatnonzero(nodes.mu > 0)
    if not len(rough):
        return 0.0
    share = (nodes.weights / nodes.weights.mean())[rough]
    light = lighter_share(assembly, nodes)[rough]
    opening = np.maximum(np.minimum(nodes.mu[rough], 1.0) * solution.z[-3 * len(rough) :].reshape(-1, 3)[:, 0], 0)
    pressed = (solution.x.reshape(-1, 3)[rough, 0] > NO_FORCE * light) & (rough < len(nodes.contacts))
    return float((share * opening / light)[pressed].max(initial=0.0))


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


def self_stressed(assembly: Assembly, nodes: ContactNodes) -> bool | None:
    """Tell whether contacts at ``nodes`` can press each other without any load; None if that is not settled."""
    pressed = self_stressed_nodes(assembly, nodes, EXACT)
    return None if pressed is None else bool(pressed.any())


def self_stressed_nodes(assembly: Assembly, nodes: ContactNodes, cone: FrictionCone) -> Bool | None:
    """Return which nodes (I,) can press without any load (G f = 0, f in the cones), or None if not settled.

    Of nodes that cannot be ruled out body by body the program is max Σ t_i with 0 <= t_i <= f_n,i and
    t_i <= 1. Self-stress forces can be added and scaled, so each t_i is 0 or 1 at the optimum.
    """
    found = clampable(nodes, cone.corner)
    if not found.any():
        return found
    nodes = nodes.chosen(found)
    G = scaled_operator(assembly, nodes)
    C, cones = cone.rows(nodes)
    count = len(nodes)
    normal = sparse.csr_matrix((-np.ones(count), (np.arange(count), 3 * np.arange(count))), (count, 3 * count))
    forces = sparse.vstack([G, C, normal, sparse.csr_matrix((2 * count, 3 * count))])
    eye = sparse.eye(count)
    shares = sparse.vstack([sparse.csr_matrix((G.shape[0] + C.shape[0], count)), eye, eye, -eye])
    A = sparse.csc_matrix(sparse.hstack([forces, shares]))
    b = np.concatenate([np.zeros(G.shape[0] + C.shape[0] + count), np.ones(count), np.zeros(count)])
    q = np.concatenate([np.zeros(3 * count), -np.ones(count)])
    P = sparse.csc_matrix((4 * count, 4 * count))
    program = ConeProgram(P, q, A, b, (("zero", G.shape[0]), *cones, ("nonnegative", 3 * count)))
    solution = solve(program, tolerance=1e-8)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED) or solution.residual > 1e-6:
        return None
    found[found] = solution.x[3 * count :] > 0.5
    return found
