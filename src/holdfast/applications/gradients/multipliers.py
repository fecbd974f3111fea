"""Derivatives of the largest factor from the multipliers of its optimum, without another solve (envelope theorem).

R is the largest s with G f + w_g + s w = 0 and f in the friction cones. With the forces f and the dual motion y of its
optimum, y·w = 1, the derivative is that of the Lagrangian with f and y held:

    dR = -Σ [turn·(F x u) + dp·(F x Δω)] - Σ dc·(W x ω) - R y·dw + Σ dμ |F_t·u_t| / μ

for the forces F (world axes) at nodes p with the relative velocity u and spin Δω, and the weights W at the centres c.
It is linear in f and in y, so what other optimal forces or motions change is computed in the same way. Where forces and
motion of an optimum are unique, the factor is differentiable. Where some forces can be added to them without changing
the factor, it is not, unless they change no derivative; the same holds for motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.applications.gradients.parameters import Parameters
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import dense_by_bodies, equilibrium_blocks
from holdfast.assembly.node_motion import NodeMotion, node_motion
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.ranges import SUM
from holdfast.base.rigid import cross
from holdfast.engines.contract import Gradient
from holdfast.engines.mechanism import AT_REST, relative_velocity
from holdfast.queries.request import quiet

TIGHT = 1e-4  # share of the largest force or speed within which a node may as well do something else
NO_EFFECT = 1e-9  # share of a contact in the derivative, relative to the factor, below which it counts as none
KINK = 1e-5  # share of the factor by which alternatives have to differ to count as a kink


@dataclass(frozen=True, eq=False)
class OtherOptima:
    """Which other forces and motions are an ``optimum`` of one ``load`` (6J,), too.

    A node is open (no force), sticks (no motion), or slides (the force keeps its direction). Where it is within TIGHT
    of being another of these, the forces are free to be both, and the motion, too.
    """

    optimum: Gradient
    load: Float

    @cached_property
    def mu(self) -> Float:
        """The coefficients of friction (I,) of the nodes."""
        return self.optimum.nodes.mu

    @cached_property
    def forces(self) -> Float:
        """The forces (I, 3) along the axes of the nodes, relative to the largest."""
        local = np.einsum("ikx,ix->ik", self.optimum.nodes.axes, self.optimum.forces)
        return np.asarray(local / self.largest)

    @property
    def largest(self) -> float:
        """The largest force at a node [N]."""
        return max(float(np.abs(self.optimum.forces).max(initial=0.0)), 1e-300)

    @cached_property
    def velocity(self) -> Float:
        """The relative velocities (I, 3) of the nodes along their axes, relative to the fastest."""
        u = relative_velocity(self.optimum.nodes, self.optimum.assembly.com, self.optimum.twists)
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
        assembly, nodes = self.optimum.assembly, self.optimum.nodes
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

    @cached_property
    def other_forces(self) -> Float:
        """The forces (m, I, 3) [N], world axes, of contacts that move, which can be added to those at the limit."""
        interface = self.optimum.nodes.interface
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
        others, first = np.zeros((null.shape[1], len(self.mu), 3)), int(slides.sum())
        others[:, slides] = null[:first].T[:, :, None] * self.along[slides]
        each = null[first:].T.reshape(null.shape[1], 3, int(turned.sum()))
        others[:, turned] = each.swapaxes(1, 2) * free[turned]
        others *= self.largest / np.maximum(np.abs(others).max(axis=(1, 2), initial=0.0), 1e-300)[:, None, None]
        return np.asarray(np.einsum("mik,ikx->mix", others, self.optimum.nodes.axes))

    @cached_property
    def other_twists(self) -> Float:
        """The motions (m, J, 6) that can be added to the one at the limit, as fast as it."""
        assembly = self.optimum.assembly
        tied = self.sticks & (self.mu > 0)
        slides = ~tied & ~self.open & self.pressed
        columns = [self.operator[:, tied].reshape(len(self.load), -1)]
        columns += [np.einsum("rik,ik->ri", self.operator, way)[:, slides] for way in (self.along, self.across)]
        load = assembly.levers * self.load
        others = _null(np.hstack([*columns, load[:, None] / np.abs(load).max()]).T).T * assembly.levers
        others = others.reshape(-1, *self.optimum.twists.shape)
        sizes = 1 / assembly.levers.reshape(-1, 6)  # of turns, as what rolls has no speed at its contacts
        speed = np.abs(others * sizes).max(axis=(1, 2), initial=0.0)
        return np.asarray(others * (np.abs(self.optimum.twists * sizes).max() / speed)[:, None, None])


def _null(matrix: Float) -> Float:
    """Return an orthonormal basis (n, m) of the vectors that ``matrix`` (k, n) maps to 0."""
    _, values, rows = np.linalg.svd(matrix, full_matrices=True)
    rank = int((values > np.sqrt(SUM) * float(values.max(initial=0.0))).sum())
    return np.asarray(rows[rank:].T)


Motions = dict[tuple[bytes, tuple[str, str]], NodeMotion]  # by the places of nodes and the pair of bodies


@dataclass(frozen=True, eq=False)
class Multipliers:
    """The derivatives of one ``row`` by ``parameters`` from the multipliers of its ``optimum`` and of the ``others``.

    How the nodes of each pair of bodies move with the bodies is found once for all rows: ``motions`` keeps it.
    """

    parameters: Parameters
    motions: Motions
    optimum: Gradient
    row: int
    others: OtherOptima

    def slopes(self) -> tuple[Float, Bool]:
        """Return the derivatives (P,) of the row, and which of them are kinks."""
        forces, twists = self.optimum.forces, self.optimum.twists
        value = self.of(forces, twists, 0.5, loads=True)
        others = [self.of(forces, twists, 1.0) - self.of(forces, twists, 0.0)]  # flush edges
        others += [self.of(other, twists, 0.5) for other in self.others.other_forces]
        others += [self.of(forces, other, 0.5, loads=True) for other in self.others.other_twists]
        limit = KINK * self.factor / self.parameters.units
        return value, self.changed | (np.abs(others) > limit).any(axis=0)

    def motion_of(self, pair: tuple[str, str], numbers: Int) -> NodeMotion:
        """Return how the nodes with these ``numbers`` (n,), all of one pair of bodies, move with the poses of both."""
        points, normals = self.optimum.nodes.points[numbers], self.optimum.nodes.normals[numbers]
        key = points.tobytes(), pair
        if key not in self.motions:
            contacts = [one for one in self.optimum.assembly.interfaces if one.bodies == pair]
            with quiet():
                self.motions[key] = node_motion(self.parameters.assembly, contacts, points, normals)
        return self.motions[key]

    @property
    def factor(self) -> float:
        """The answer of the row."""
        return float(self.optimum.answers.force[0])

    @cached_property
    def _pairs(self) -> dict[tuple[str, str], Int]:
        """The numbers of the nodes of each pair of bodies that move relative to each other and press on each other."""
        nodes, optimum = self.optimum.nodes, self.optimum
        u, spin = self._relative(optimum.twists)
        speed = np.linalg.norm(u, axis=1) + optimum.assembly.size * np.linalg.norm(spin, axis=1)
        pressed = np.linalg.norm(optimum.forces, axis=1)
        for other in self.others.other_forces:
            pressed = np.maximum(pressed, np.linalg.norm(other, axis=1))
        for other in self.others.other_twists:
            u, spin = self._relative(other)
            speed = np.maximum(speed, np.linalg.norm(u, axis=1) + optimum.assembly.size * np.linalg.norm(spin, axis=1))
        acts = speed * pressed > NO_EFFECT * self.factor
        pairs = [one.bodies for one in optimum.assembly.interfaces]
        chosen = dict.fromkeys(pairs[k] for k in dict.fromkeys(nodes.interface[acts].tolist()))
        return {pair: np.flatnonzero([pairs[k] == pair for k in nodes.interface.tolist()]) for pair in chosen}

    @cached_property
    def changed(self) -> Bool:
        """By which parameters (P,) a node appears or is gone."""
        total = np.zeros(len(self.parameters.every))
        for pair, numbers in self._pairs.items():
            motion = self.motion_of(pair, numbers)
            for name in pair if motion.changed.any() else ():
                of_pair = np.zeros_like(total)
                self.parameters.add_pose(of_pair, name, motion.changed.astype(np.float64), motion.origin)
                total += np.abs(of_pair)  # of two pairs, none cancels the other
        return total > 0

    def of(self, forces: Float, twists: Float, share: float, *, loads: bool = False) -> Float:
        """Return the derivatives (P,) with these multipliers, (I, 3) and (J, 6), with ``loads`` those of loads, too.

        Where edges are flush, ``share`` says how much they move with the one body or the other.
        """
        nodes = self.optimum.nodes
        total = np.zeros(len(self.parameters.every))
        u, spin = self._relative(twists)
        torque, push = cross(forces, u), cross(forces, spin)
        for pair, numbers in self._pairs.items():
            motion = self.motion_of(pair, numbers)
            weight = np.array([1 - share, share])
            second = -np.einsum("s,snik,ni->k", weight, motion.turn, torque[numbers])
            second -= np.einsum("s,snik,ni->k", weight, motion.shift, push[numbers])
            arms = nodes.points[numbers] - motion.origin
            whole = -np.concatenate([push[numbers].sum(0), (torque[numbers] + cross(arms, push[numbers])).sum(0)])
            for name, slope in zip(pair, (whole - second, second), strict=True):
                self.parameters.add_pose(total, name, slope, motion.origin)
        normal = (forces * nodes.normals).sum(axis=1)
        across = u - (u * nodes.normals).sum(axis=1)[:, None] * nodes.normals
        rubbing = -np.divide((forces * across).sum(1), nodes.mu, out=np.zeros(len(nodes)), where=nodes.mu > 0)
        slopes = np.where(nodes.mu > 0, rubbing, np.linalg.norm(across, axis=1) * normal)
        each = np.bincount(nodes.interface, slopes, len(self.optimum.assembly.interfaces))
        for interface, slope in zip(self.optimum.assembly.interfaces, each.tolist(), strict=True):
            self.parameters.add(total, "friction", interface.bodies, slope)
        if loads:
            add_loads(total, self.parameters, self.row, self.optimum.assembly, self.factor, twists)
        return total

    def _relative(self, twists: Float) -> tuple[Float, Float]:
        """Return the velocities and the spins (I, 3) of the second bodies relative to the first, world axes."""
        nodes, com = self.optimum.nodes, self.optimum.assembly.com
        every, centres = np.vstack([twists, np.zeros((1, 6))]), np.vstack([com, np.zeros((1, 3))])  # FIXED is -1
        at = [every[k, :3] + cross(every[k, 3:], nodes.points - centres[k]) for k in (nodes.a, nodes.b)]
        return at[1] - at[0], every[nodes.b, 3:] - every[nodes.a, 3:]


def add_loads(total: Float, parameters: Parameters, row: int, assembly: Assembly, factor: float, twists: Float) -> None:
    """Add the derivatives of weights and loads of a row to ``total`` (P,).

    ``twists`` (J, 6) is the motion of each movable body of ``assembly`` about its centre of mass, in which the load has
    the power 1.
    """
    for body, mass, twist in zip(assembly.movable, assembly.mass, twists, strict=True):
        force = mass * parameters.pull + factor * parameters.inertia(body.name, row)
        parameters.add_pose(total, body.name, np.pad(-cross(force, twist[3:]), (0, 3)), body.com_world)
        parameters.add(total, "mass", (body.name,), -float(twist[:3] @ force) / mass)
    push = parameters.push(row)
    if push is not None:
        pushed, point, way = push
        twist = twists[assembly.index[pushed.name]]
        by_way = -factor * (twist[:3] + cross(twist[3:], point - pushed.com_world))
        by_point = -factor * cross(way, twist[3:])
        turned = np.concatenate([by_point, cross(way, by_way)])  # the direction turns with the body
        parameters.add_pose(total, pushed.name, turned, point)
        across = by_way - (by_way @ way) * way
        parameters.add(total, "push", (pushed.name,), np.concatenate([by_point, across]))
