"""What else an optimum may be: other contact forces and other motions with the same factor, by which kinks are found.

Where forces and motion of an optimum are unique, the factor is differentiable. Where some forces can be added to them
without changing the factor, it is not, unless they change no derivative; the same holds for motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.contact_nodes import dense_by_bodies, equilibrium_blocks
from holdfast.base.arrays import Bool, Float
from holdfast.base.rounding import SUM
from holdfast.engines.contract import Gradient
from holdfast.engines.mechanism import AT_REST, relative_velocity

TIGHT = 1e-4  # share of the largest force or speed within which a node may as well do something else


@dataclass(frozen=True, eq=False)
class OtherOptima:
    """What else the optimum ``found`` for one ``load`` (6J,) may be.

    A node is open (no force), sticks (no motion), or slides (the force keeps its direction). Where it is within TIGHT
    of being another of these, the forces are free to be both, and the motion, too.
    """

    found: Gradient
    load: Float

    @cached_property
    def mu(self) -> Float:
        """The coefficients of friction (I,) of the nodes."""
        return self.found.nodes.mu

    @cached_property
    def forces(self) -> Float:
        """The forces (I, 3) along the axes of the nodes, relative to the largest."""
        local = np.einsum("ikx,ix->ik", self.found.nodes.axes, self.found.forces)
        return np.asarray(local / self.largest)

    @property
    def largest(self) -> float:
        """The largest force at a node [N]."""
        return max(float(np.abs(self.found.forces).max(initial=0.0)), 1e-300)

    @cached_property
    def velocity(self) -> Float:
        """The relative velocities (I, 3) of the nodes along their axes, relative to the fastest."""
        u = relative_velocity(self.found.nodes, self.found.assembly.com, self.found.twists)
        return np.asarray(u / max(float(np.abs(u).max(initial=0.0)), 1e-300))

    @cached_property
    def speed(self) -> Float:
        """The largest component (I,) of each velocity."""
        return np.asarray(np.abs(self.velocity).max(axis=1, initial=0.0))

    @cached_property
    def pressed(self) -> Bool:
        """Which nodes (I,) surely press."""
        return np.asarray(self.forces[:, 0] > TIGHT)

    @cached_property
    def open(self) -> Bool:
        """Which nodes (I,) surely open, and so carry nothing: they part faster than friction lifts them."""
        lifted = self.mu * np.linalg.norm(self.velocity[:, 1:], axis=1)
        return np.asarray((self.velocity[:, 0] - lifted > TIGHT) & ~self.pressed)

    @cached_property
    def sticks(self) -> Bool:
        """Which nodes (I,) surely stick: they do not move, and their force is inside the cone."""
        most = self.mu * self.forces[:, 0]
        room = most - np.linalg.norm(self.forces[:, 1:], axis=1)
        return np.asarray((self.speed <= TIGHT) & (room > TIGHT * np.maximum(most, TIGHT)))

    @cached_property
    def operator(self) -> Float:
        """G (6J, I, 3), with torques in units of force by the size of the assembly."""
        assembly, nodes = self.found.assembly, self.found.nodes
        G = dense_by_bodies(len(assembly.movable), nodes, equilibrium_blocks(assembly, nodes))
        return np.asarray(assembly.levers[:, None, None] * G.reshape(len(G), len(nodes), 3))

    @cached_property
    def along(self) -> Float:
        """Vectors (I, 3) along the edges of the cones nearest to the forces."""
        sliding = np.linalg.norm(self.forces[:, 1:], axis=1)[:, None]
        way = np.divide(self.forces[:, 1:], sliding, out=np.zeros((len(self.mu), 2)), where=sliding > 0)
        return np.column_stack([np.ones(len(self.mu)), self.mu[:, None] * way])

    @cached_property
    def across(self) -> Float:
        """Vectors (I, 3) along the surface, across these; 0 without friction, where velocities are free."""
        return np.column_stack([np.zeros(len(self.mu)), -self.along[:, 2], self.along[:, 1]])

    def other_forces(self) -> Float:
        """Return forces (m, I, 3) [N], world axes, of contacts that move, which can be added to those at the limit."""
        interface = self.found.nodes.interface
        moves = np.isin(interface, interface[self.speed > AT_REST])  # all nodes of a contact count
        slides = moves & self.pressed & ~self.open & ((self.speed > TIGHT) | (self.mu == 0))
        turned = moves & ~self.open & ~slides
        free = np.where(self.mu[:, None] > 0, np.ones(3), np.eye(3)[0])
        rest = (self.operator * free)[:, ~moves & ~self.open].reshape(len(self.load), -1)
        values, vectors = np.linalg.eigh(rest @ rest.T)
        left = vectors[:, values <= SUM * max(1.0, float(values.max()))]  # what those at rest cannot balance
        columns = [np.einsum("rik,ik->ri", self.operator, self.along)[:, slides]]
        columns += [self.operator[:, turned, k] * free[turned, k] for k in range(3)]
        null = _null(left.T @ np.hstack(columns))
        found, first = np.zeros((null.shape[1], len(self.mu), 3)), int(slides.sum())
        found[:, slides] = null[:first].T[:, :, None] * self.along[slides]
        each = null[first:].T.reshape(null.shape[1], 3, int(turned.sum()))
        found[:, turned] = each.swapaxes(1, 2) * free[turned]
        found *= self.largest / np.maximum(np.abs(found).max(axis=(1, 2), initial=0.0), 1e-300)[:, None, None]
        return np.asarray(np.einsum("mik,ikx->mix", found, self.found.nodes.axes))

    def other_twists(self) -> Float:
        """Return motions (m, J, 6) that can be added to the one at the limit, as fast as it."""
        assembly = self.found.assembly
        tied = self.sticks & (self.mu > 0)
        slides = ~tied & ~self.open & self.pressed
        columns = [self.operator[:, tied].reshape(len(self.load), -1)]
        columns += [np.einsum("rik,ik->ri", self.operator, way)[:, slides] for way in (self.along, self.across)]
        load = assembly.levers * self.load
        found = _null(np.hstack([*columns, load[:, None] / np.abs(load).max()]).T).T * assembly.levers
        found = found.reshape(-1, *self.found.twists.shape)
        sizes = 1 / assembly.levers.reshape(-1, 6)  # of turns, as what rolls has no speed at its contacts
        speed = np.abs(found * sizes).max(axis=(1, 2), initial=0.0)
        return np.asarray(found * (np.abs(self.found.twists * sizes).max() / speed)[:, None, None])


def _null(matrix: Float) -> Float:
    """Return an orthonormal basis (n, m) of the vectors that ``matrix`` (k, n) maps to 0."""
    _, values, rows = np.linalg.svd(matrix, full_matrices=True)
    rank = int((values > np.sqrt(SUM) * float(values.max(initial=0.0))).sum())
    return np.asarray(rows[rank:].T)
