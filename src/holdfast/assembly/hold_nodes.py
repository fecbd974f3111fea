"""Holds as nodes with friction cones: every bounded set of forces becomes a cone once its bound is a force, too.

A force along an axis between -r and r is the tangential force of a node whose normal force is a given number c and
whose coefficient is r / c. The normal force of that node acts on no body. An equation of its own sets it to c: one of
the six equations of a *fastener*, which stands beside those of the bodies as if it were one more body. The power of c
along the motion of a fastener is then what the hold can do against a motion, so whatever is proved of cones and bodies,
by forces or by motions, holds for bounded sets as it stands.

Where a hold bears any moment, the three equations of moments of its body say nothing, and are left out. Other axes
without bounds are two cones against each other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import cross, tangents
from holdfast.scene.hold import AnyHold, Bounds, Grip, Hold

ENDLESS = (np.inf, ((-np.inf, np.inf),) * 3)  # bounds of as much as is needed
USUAL = 0.25  # share of the weight of the body held that counts as the usual force of what has no bound


@dataclass(frozen=True, eq=False)
class HoldData:
    """What belongs to the K nodes of holds on some of the J movable bodies, with F fasteners numbered from J.

    ``blocks`` (K, 3, 2, 6) are the wrenches of a unit force along each axis of such a node, on its body b and on its
    fastener a. ``owner`` (F,) is the body of each fastener and ``amounts`` (6F,) the right-hand side of its equations.
    ``constant`` (6J,) are wrenches that holds exert in any case, and ``usual`` (K,) [N] the usual normal forces.
    ``asked`` (6J,) is 0 for equations that are left out, else 1.
    """

    blocks: Float
    owner: Int
    amounts: Float
    constant: Float
    usual: Float
    asked: Float


@dataclass(frozen=True, eq=False, repr=False)
class HeldNodes(ContactNodes):
    """Contact nodes, and after them the K nodes of holds, with their ``data``."""

    data: HoldData

    @property
    def fasteners(self) -> int:
        """The number F of fasteners."""
        return len(self.data.owner)

    @property
    def asked(self) -> Float:
        """Which equations (6J,) of bodies count, 1 or 0."""
        return self.data.asked

    @property
    def blocks(self) -> Float:
        """The wrenches (K, 3, 2, 6) of the nodes of holds."""
        return self.data.blocks

    @property
    def usual(self) -> Float:
        """The usual normal forces (K,) [N] of the nodes of holds."""
        return self.data.usual

    @cached_property
    def contacts(self) -> ContactNodes:
        """The nodes of contacts alone."""
        return self.chosen(np.arange(len(self)) < len(self) - len(self.blocks))

    def under(self, wrench: Float) -> Float:
        """Return ``wrench`` (6J,) with what holds exert in any case, and the equations of fasteners: (6(J + F),)."""
        return np.concatenate([self.asked * (wrench + self.data.constant), -self.data.amounts])

    def beside(self, columns: Float) -> Float:
        """Return loads (6J, ...) on bodies, where they count, with none on fasteners: (6(J + F), ...)."""
        own = (columns.T * self.asked).T
        return np.concatenate([own, np.zeros((6 * self.fasteners, *columns.shape[1:]))])

    def scaled(self, scale: Float) -> Float:
        """Return scales (6J,) of bodies, and for each fastener that of forces on its body: (6(J + F),)."""
        return np.concatenate([scale, np.repeat(scale[6 * self.data.owner], 6)])


def with_holds(assembly: Assembly, nodes: ContactNodes) -> ContactNodes:
    """Return contact nodes together with those of the holds of the scene, if there are any."""
    holds = assembly.scene.holds
    if not holds:
        return nodes
    made = [_Making(assembly, hold) for hold in holds]
    K = sum(len(one.mu) for one in made)
    counts = [one.fasteners for one in made]
    first = len(assembly.movable) + np.cumsum([0, *counts[:-1]])
    owner = np.repeat([one.body for one in made], counts).astype(np.int64)
    constant, asked = np.zeros((len(assembly.movable), 6)), np.ones((len(assembly.movable), 6))
    for one in made:
        constant[one.body] += one.constant
        asked[one.body, 3:] *= not one.turns
    body = np.repeat([one.body for one in made], [len(one.mu) for one in made]).astype(np.int64)
    at = np.concatenate([start + np.array(one.at, dtype=np.int64) for start, one in zip(first, made, strict=True)])
    held = np.concatenate([np.array(one.equations, dtype=bool) for one in made])
    weights = np.full(K, float(nodes.weights.mean()) if len(nodes) else 1.0)
    return HeldNodes(
        points=np.concatenate([nodes.points, np.zeros((K, 3))]),
        axes=np.concatenate([nodes.axes, np.tile(np.eye(3), (K, 1, 1))]),
        mu=np.concatenate([nodes.mu, *(one.mu for one in made)]),
        weights=np.concatenate([nodes.weights, weights]),
        interface=np.concatenate([nodes.interface, np.full(K, len(assembly.interfaces), dtype=np.int64)]),
        a=np.concatenate([nodes.a, np.where(held, at, FIXED)]),
        b=np.concatenate([nodes.b, body]),
        pull=np.concatenate([nodes.pull, np.zeros(K)]),
        data=HoldData(
            blocks=np.array([block for one in made for block in one.blocks]).reshape(K, 3, 2, 6),
            owner=owner,
            amounts=np.concatenate([one.amounts for one in made]),
            constant=constant.ravel(),
            usual=np.concatenate([np.array(one.usual, dtype=np.float64) for one in made]),
            asked=asked.ravel(),
        ),
    )


@dataclass
class _Making:
    """The nodes of one hold while they are made; equations are numbered from 0, six to a fastener."""

    assembly: Assembly
    hold: AnyHold
    mu: list[float] = field(default_factory=list)
    blocks: list[Float] = field(default_factory=list)
    usual: list[float] = field(default_factory=list)
    equations: list[bool] = field(default_factory=list)
    at: list[int] = field(default_factory=list)
    given: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.body = self.assembly.index[self.hold.body]
        self.unit = float(self.assembly.mass[self.body] * np.linalg.norm(self.assembly.scene.gravity))
        self.constant, self.turns = np.zeros(6), False  # whether it bears any moment
        if isinstance(self.hold, Grip):
            self._grip(self.hold)
        else:
            self._hold(self.hold)

    @property
    def fasteners(self) -> int:
        return -(-len(self.given) // 6)

    @property
    def amounts(self) -> Float:
        return np.concatenate([self.given, np.zeros(6 * self.fasteners - len(self.given))])

    def _hold(self, hold: Hold) -> None:
        size = self.assembly.movable[self.body].size
        axes, arm = hold.frame[:3, :3].T, hold.frame[:3, 3] - self.assembly.com[self.body]
        pushes = [np.concatenate([axis, cross(arm, axis)]) for axis in axes]
        turns = [np.concatenate([np.zeros(3), size * axis]) for axis in axes]
        self._bounded(hold.forces, pushes, 1.0)
        if hold.moments in ENDLESS:
            self.turns = True
        else:
            self._bounded(hold.moments, turns, size)

    def _bounded(self, bounds: Bounds, wrenches: list[Float], size: float) -> None:
        """Take forces along three unit ``wrenches`` (6,), within bounds that are larger by a factor ``size``."""
        if isinstance(bounds, float) and np.isfinite(bounds):
            self._ball(bounds / size, wrenches)
            return
        ranges = [(-bounds, bounds)] * 3 if isinstance(bounds, float) else bounds
        for (low, high), wrench in zip(ranges, wrenches, strict=True):
            self._axis(low / size, high / size, wrench)

    def _axis(self, low: float, high: float, wrench: Float) -> None:
        if np.isfinite([low, high]).all() and low < high and 0 in (low, high):  # none is the usual force: no border
            row, usual = self._equation(high - low), min(high - low, USUAL * self.unit)
            self._node(0.0, [wrench if low == 0 else -wrench, None, None], {0: {row: 1.0}}, usual)
            self._node(0.0, [None, None, None], {0: {row: 1.0}}, high - low)
            return
        if np.isfinite([low, high]).all():
            self.constant = self.constant + (low + high) / 2 * wrench
            half = (high - low) / 2
            if half > 0:
                row = self._equation(self.unit)
                self._node(half / self.unit, [None, wrench, None], {0: {row: 1.0}}, self.unit)
            return
        for end, sign in ((low, 1.0), (high, -1.0)):
            if np.isfinite(end):
                self.constant = self.constant + end * wrench
            if np.isfinite(end) or not np.isfinite([low, high]).any():
                self._node(0.0, [sign * wrench, None, None], {}, USUAL * self.unit)

    def _ball(self, radius: float, wrenches: list[Float]) -> None:
        """|(x, y)| <= u, and |(u, z)| <= radius."""
        if radius == 0:
            return
        x, y, z = wrenches
        same, whole = self._equation(0.0), self._equation(self.unit)
        self._node(1.0, [None, x, y], {0: {same: 1.0}}, min(radius, USUAL * self.unit))
        self._node(radius / self.unit, [None, None, z], {0: {whole: 1.0}, 1: {same: -1.0}}, self.unit)

    def _grip(self, grip: Grip) -> None:
        com = self.assembly.com[self.body]
        for point, normal, most in zip(grip.points, grip.normals, grip.force, strict=True):
            pushes = [np.concatenate([way, cross(point - com, way)]) for way in (normal, *tangents(normal))]
            self.constant = self.constant - grip.pull / len(grip.points) * pushes[0]
            if most == 0:
                continue
            usual = min(most, USUAL * self.unit)
            if not np.isfinite(most):
                self._node(grip.mu, pushes, {}, usual)
                continue
            row = self._equation(most)
            self._node(grip.mu, pushes, {0: {row: 1.0}}, usual)
            self._node(0.0, [None, None, None], {0: {row: 1.0}}, most)

    def _equation(self, amount: float) -> int:
        self.given.append(amount)
        return len(self.given) - 1

    def _node(
        self, mu: float, wrenches: Iterable[Float | None], entries: dict[int, dict[int, float]], usual: float
    ) -> None:
        """Add a node: the wrench on the body of a unit force along each axis, and its entries in equations."""
        block = np.zeros((3, 2, 6))
        for axis, wrench in enumerate(wrenches):
            if wrench is not None:
                block[axis, 0] = wrench
        rows = [row for entry in entries.values() for row in entry]
        fastener = rows[0] // 6 if rows else 0
        for axis, entry in entries.items():
            for row, value in entry.items():
                block[axis, 1, row - 6 * fastener] = value
        self.mu.append(mu)
        self.blocks.append(block)
        self.usual.append(usual)
        self.equations.append(bool(rows))
        self.at.append(fastener)
