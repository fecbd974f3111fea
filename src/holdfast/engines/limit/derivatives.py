"""Derivatives of the largest factor of one load by friction, masses and centres of mass, all from one solve.

R is the largest s with G f + w_g + s w = 0 and f in the friction cones. For the dual motion y with y·w = 1,

    R = -y·w_g,   u = Gᵀy in the dual cones,   f·u = 0 at the optimum.

Where f and y are unique, the derivative of R is that of the Lagrangian with f and y held (envelope theorem).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, dense_by_bodies, equilibrium_blocks
from holdfast.base.arrays import Bool, Float
from holdfast.engines.answers import Answers
from holdfast.engines.capabilities import Gradient
from holdfast.engines.mechanism import AT_REST, relative_velocity

TIGHT = 1e-4  # share of the largest force or speed within which a node may as well do something else
RANK = 1e-12  # square of the relative size of a change of wrench that counts as none


def gradient(
    assembly: Assembly, nodes: ContactNodes, load: Float, twists: Float, forces: Float, answers: Answers
) -> Gradient:
    """Return the derivatives of the largest factor of one solved load.

    ``twists`` (6J,) is the dual motion that limits the ``load`` (6J,), ``forces`` (I, 3) [N] are those at the limit,
    along the axes of the nodes, and ``answers`` is the table with the one row of this load.
    """
    motion = twists.reshape(-1, 6)
    optimum = _Optimum(assembly, nodes, load, motion, forces)
    weights = assembly.mass[:, None] * assembly.scene.gravity
    return Gradient(
        answers=answers,
        assembly=assembly,
        nodes=nodes,
        forces=nodes.world(forces),
        twists=motion,
        other_forces=optimum.other_forces(),
        other_twists=optimum.other_twists(),
        d_mu=_by_friction(assembly, nodes, motion, forces[:, 0]),
        d_mass=-motion[:, :3] @ assembly.scene.gravity,
        d_com=-np.cross(weights, motion[:, 3:]),
    )


def _by_friction(assembly: Assembly, nodes: ContactNodes, motion: Float, normal: Float) -> dict[tuple[str, str], float]:
    """Return dR/dμ for every pair of bodies: the sum of |u_t| f_n over its nodes.

    |u_t| is the multiplier of the friction limit of a node.
    """
    slip = np.linalg.norm(relative_velocity(nodes, assembly.com, motion)[:, 1:], axis=1)
    found = dict.fromkeys((interface.bodies for interface in assembly.interfaces), 0.0)
    for k, share in zip(nodes.interface, slip * np.maximum(normal, 0), strict=True):
        found[assembly.interfaces[k].bodies] += float(share)
    return found


@dataclass(frozen=True, eq=False)
class _Optimum:
    """The forces (I, 3) [N], along the axes of the nodes, and the ``motion`` (J, 6) of one load (6J,) at its limit.

    A node is open (no force), sticks (no motion), or slides (the force keeps its direction). Where it is within TIGHT
    of being another of these, the forces are free to be both, and the motion, too.
    """

    assembly: Assembly
    nodes: ContactNodes
    load: Float
    motion: Float
    forces: Float

    @cached_property
    def velocity(self) -> Float:
        """The relative velocities (I, 3) of the nodes along their axes, relative to the fastest."""
        u = relative_velocity(self.nodes, self.assembly.com, self.motion)
        return np.asarray(u / max(float(np.abs(u).max(initial=0.0)), 1e-300))

    @cached_property
    def usual(self) -> float:
        """The largest force at a node [N]."""
        return max(float(np.abs(self.forces).max(initial=0.0)), 1e-300)

    @cached_property
    def open(self) -> Bool:
        """Which nodes (I,) surely open, and so carry nothing: they part faster than friction lifts them."""
        normal, sliding = self.velocity[:, 0], np.linalg.norm(self.velocity[:, 1:], axis=1)
        return np.asarray((normal - self.nodes.mu * sliding > TIGHT) & (self.forces[:, 0] <= TIGHT * self.usual))

    @cached_property
    def sticks(self) -> Bool:
        """Which nodes (I,) surely stick: they do not move, and their force is inside the cone."""
        room = self.nodes.mu * self.forces[:, 0] - np.linalg.norm(self.forces[:, 1:], axis=1)
        still = np.abs(self.velocity).max(axis=1) <= TIGHT
        return np.asarray(still & (room > TIGHT * np.maximum(self.nodes.mu * self.forces[:, 0], TIGHT * self.usual)))

    @cached_property
    def slides(self) -> Bool:
        """Which nodes (I,) surely slide or, without friction, are pressed."""
        moves = np.abs(self.velocity).max(axis=1) > TIGHT
        return np.asarray((moves | (self.nodes.mu == 0)) & (self.forces[:, 0] > TIGHT * self.usual) & ~self.open)

    @cached_property
    def operator(self) -> Float:
        """G (6J, I, 3), with torques in units of force by the size of the assembly."""
        count = len(self.assembly.movable)
        blocks = equilibrium_blocks(self.assembly, self.nodes)
        G = dense_by_bodies(count, self.nodes, blocks).reshape(6 * count, len(self.nodes), 3)
        return np.asarray(self.assembly.levers[:, None, None] * G)

    def along(self, force: bool) -> Float:
        """Return unit vectors (I, 3) of the forces of the nodes or, if not ``force``, across them in the plane."""
        f, mu = self.forces, self.nodes.mu
        sliding = np.linalg.norm(f[:, 1:], axis=1)
        way = np.divide(f[:, 1:], sliding[:, None], out=np.zeros((len(f), 2)), where=sliding[:, None] > 0)
        if not force:
            return np.column_stack([np.zeros(len(f)), -way[:, 1], way[:, 0]]) * (mu > 0)[:, None]
        return np.column_stack([np.ones(len(f)), mu[:, None] * way])

    def other_forces(self) -> Float:
        """Return forces (m, I, 3) [N], world axes, of nodes that move, which can be added to those at the limit."""
        free = np.where(self.nodes.mu[:, None] > 0, np.ones((len(self.nodes), 3)), [1.0, 0.0, 0.0])
        moves = np.abs(self.velocity).max(axis=1, initial=0.0) > AT_REST
        moves = np.isin(self.nodes.interface, self.nodes.interface[moves])  # all of the patch counts
        rest = (self.operator * free)[:, ~moves & ~self.open].reshape(len(self.load), -1)
        values, vectors = np.linalg.eigh(rest @ rest.T)
        across = vectors[
            :, values <= RANK * max(float(values.max(initial=0.0)), 1.0)
        ]  # what those at rest cannot balance
        turned = moves & ~self.open & ~self.slides
        columns = [np.einsum("rik,ik->ri", self.operator, self.along(force=True))[:, moves & self.slides]]
        columns += [self.operator[:, turned, k] * free[turned, k] for k in range(3)]
        reduced = across.T @ np.hstack(columns)
        if not reduced.size:
            return np.zeros((0, len(self.nodes), 3))
        null = _null(reduced)
        found, first = np.zeros((null.shape[1], len(self.nodes), 3)), int((moves & self.slides).sum())
        found[:, moves & self.slides] = null[:first].T[:, :, None] * self.along(force=True)[moves & self.slides]
        found[:, turned] = null[first:].T.reshape(null.shape[1], 3, int(turned.sum())).swapaxes(1, 2) * free[turned]
        found *= self.usual / np.maximum(np.abs(found).max(axis=(1, 2), initial=0.0), 1e-300)[:, None, None]
        return np.asarray(np.einsum("mik,ikx->mix", found, self.nodes.axes))

    def other_twists(self) -> Float:
        """Return motions (m, J, 6) that can be added to the one at the limit, as fast as it."""
        tied = self.sticks & (self.nodes.mu > 0)
        columns = [self.operator[:, tied].reshape(len(self.load), -1)]
        slides = ~tied & ~self.open & (self.forces[:, 0] > TIGHT * self.usual)
        columns += [np.einsum("rik,ik->ri", self.operator, self.along(way))[:, slides] for way in (True, False)]
        held = np.hstack([*columns, (self.assembly.levers * self.load / np.abs(self.load).max())[:, None]])
        null = _null(held.T).T * self.assembly.levers
        fast = np.abs(relative_velocity(self.nodes, self.assembly.com, self.motion)).max(initial=0.0)
        found = null.reshape(-1, *self.motion.shape)
        speed = np.abs(relative_velocity(self.nodes, self.assembly.com, found)).max(axis=(1, 2), initial=0.0)
        return np.asarray(found * (fast / np.maximum(speed, 1e-300))[:, None, None])


def _null(matrix: Float) -> Float:
    """Return an orthonormal basis (n, m) of the vectors that ``matrix`` (k, n) maps to 0."""
    _, values, rows = np.linalg.svd(matrix, full_matrices=True)
    rank = int((values > np.sqrt(RANK) * max(float(values.max(initial=0.0)), 1e-300)).sum())
    return np.asarray(rows[rank:].T)
