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
from holdfast.assembly.on_surface import check_on_surface, not_pressing
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import cross, tangents
from holdfast.base.text import quoted
from holdfast.scene.hold import AnyHold, Bounds, Grip, Hold, hold_ends

ENDLESS = (np.inf, ((-np.inf, np.inf),) * 3)  # bounds of as much as is needed
USUAL = 0.25  # share of the weight of the body held that counts as the usual force of what has no bound


@dataclass(frozen=True, eq=False)
class HoldData:
    """What belongs to the K nodes of holds on some of the J movable bodies, with F fasteners numbered from J.

    ``blocks`` (K, 3, 2, 6) are the wrenches of a unit force along each axis of such a node, on its body b and on its
    fastener a. ``owner`` (F,) is the body of each fastener and ``amounts`` (6F,) the right-hand side of its equations.
    ``constant`` (6J,) are wrenches that holds exert in any case, and ``usual`` (K,) [N] the usual normal forces.
    ``counted`` (6J,) is 0 for equations that are left out, else 1.
    """

    blocks: Float
    owner: Int
    amounts: Float
    constant: Float
    usual: Float
    counted: Float


class HeldNodes(ContactNodes):
    """Contact nodes, and after them the K nodes of holds, with their ``data``."""

    data: HoldData

    @property
    def fasteners(self) -> int:
        """The number F of fasteners."""
        return len(self.data.owner)

    @property
    def counted(self) -> Float:
        """Which equations (6J,) of bodies count, 1 or 0."""
        return self.data.counted

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
        return np.concatenate([self.counted * (wrench + self.data.constant), -self.data.amounts])

    def beside(self, columns: Float) -> Float:
        """Return loads (6J, ...) on bodies, where they count, with none on fasteners: (6(J + F), ...)."""
        on_bodies = (columns.T * self.counted).T
        return np.concatenate([on_bodies, np.zeros((6 * self.fasteners, *columns.shape[1:]))])

    def scaled(self, scale: Float) -> Float:
        """Return scales (6J,) of bodies, and for each fastener that of forces on its body: (6(J + F),)."""
        return np.concatenate([scale, np.repeat(scale[6 * self.data.owner], 6)])


def with_holds(assembly: Assembly, nodes: ContactNodes) -> ContactNodes:
    """Return contact nodes together with those of the holds of the scene, if there are any."""
    holds = assembly.scene.holds
    if not holds:
        return nodes
    both = hold_ends(holds, assembly.index, FIXED)
    made = [_Making(assembly, hold, *ends) for hold, ends in zip(holds, both, strict=True)]
    K = sum(len(one.mu) for one in made)
    counts = [one.fasteners for one in made]
    first = len(assembly.movable) + np.cumsum([0, *counts[:-1]])
    owner = np.repeat([one.body for one in made], counts).astype(np.int64)
    constant, counted = np.zeros((len(assembly.movable), 6)), np.ones((len(assembly.movable), 6))
    for one in made:
        constant[one.body] += one.constant[0]
        if one.other != FIXED:
            constant[one.other] += one.constant[1]
        counted[one.body, 3:] *= not one.turns
    body = np.concatenate([np.array(one.on, dtype=np.int64) for one in made])
    at = np.concatenate([one.ends(start) for start, one in zip(first.tolist(), made, strict=True)])
    weights = np.full(K, float(nodes.weights.mean()) if len(nodes) else 1.0)
    return HeldNodes(
        points=np.concatenate([nodes.points, np.zeros((K, 3))]),
        axes=np.concatenate([nodes.axes, np.tile(np.eye(3), (K, 1, 1))]),
        mu=np.concatenate([nodes.mu, *(one.mu for one in made)]),
        weights=np.concatenate([nodes.weights, weights]),
        interface=np.concatenate([nodes.interface, np.full(K, len(assembly.interfaces), dtype=np.int64)]),
        a=np.concatenate([nodes.a, at]),
        b=np.concatenate([nodes.b, body]),
        pull=np.concatenate([nodes.pull, np.zeros(K)]),
        data=HoldData(
            blocks=np.array([block for one in made for block in one.blocks]).reshape(K, 3, 2, 6),
            owner=owner,
            amounts=np.concatenate([[*one.given, *[0.0] * (-len(one.given) % 6)] for one in made]),
            constant=constant.ravel(),
            usual=np.concatenate([np.array(one.usual, dtype=np.float64) for one in made]),
            counted=counted.ravel(),
        ),
    )


@dataclass
class _Making:
    """The nodes of one hold while they are made; equations are numbered from 0, six to a fastener.

    Wrenches are (2, 6): on the body, and on the body that holds it.
    """

    assembly: Assembly
    hold: AnyHold
    body: int
    other: int
    mu: list[float] = field(default_factory=list)
    blocks: list[Float] = field(default_factory=list)
    usual: list[float] = field(default_factory=list)
    on: list[int] = field(default_factory=list)
    at: list[int | None] = field(default_factory=list)
    given: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.unit = float(self.assembly.mass[self.body] * np.linalg.norm(self.assembly.scene.gravity))
        self.constant, self.turns = np.zeros((2, 6)), False  # whether it bears any moment
        if isinstance(self.hold, Grip):
            self._grip(self.hold)
        else:
            self._hold(self.hold)

    @property
    def fasteners(self) -> int:
        return -(-len(self.given) // 6)

    def ends(self, first: int) -> Int:
        """Return the bodies a of the nodes, with fasteners numbered from ``first``."""
        return np.array([self.other if at is None else first + at for at in self.at], dtype=np.int64)

    def _push(self, point: Float, way: Float) -> Float:
        """Return the wrenches of a unit force along ``way`` (3,) at ``point`` (3,), world frame."""
        com = self.assembly.com
        ends = ((self.body, 1.0), (self.other, 0.0 if self.other == FIXED else -1.0))
        return np.array([sign * np.concatenate([way, cross(point - com[k], way)]) for k, sign in ends])

    def _hold(self, hold: Hold) -> None:
        size = self.assembly.movable[self.body].size
        axes = hold.frame[:3, :3].T
        pushes = [self._push(hold.frame[:3, 3], axis) for axis in axes]
        opposite = np.array([[1.0], [0.0 if self.other == FIXED else -1.0]])
        turns = [opposite * np.concatenate([np.zeros(3), size * axis]) for axis in axes]
        self._bounded(hold.forces, pushes, 1.0)
        if hold.moments in ENDLESS and self.other == FIXED:
            self.turns = True
        else:
            self._bounded(hold.moments, turns, size)

    def _bounded(self, bounds: Bounds, wrenches: list[Float], size: float) -> None:
        """Take forces along three unit ``wrenches`` (2, 6), within bounds that are larger by a factor ``size``."""
        if isinstance(bounds, float) and np.isfinite(bounds):
            self._ball(bounds / size, wrenches)
            return
        ranges = [(-bounds, bounds)] * 3 if isinstance(bounds, float) else bounds
        for (low, high), wrench in zip(ranges, wrenches, strict=True):
            self._axis(low / size, high / size, wrench)

    def _axis(self, low: float, high: float, wrench: Float) -> None:
        if np.isfinite([low, high]).all() and low < high and 0 in (low, high):  # none is the usual force: no border
            (row,), usual = self._equations(high - low), min(high - low, USUAL * self.unit)
            self._node(0.0, [wrench if low == 0 else -wrench, None, None], {0: {row: 1.0}}, usual)
            self._node(0.0, [None, None, None], {0: {row: 1.0}}, high - low)
            return
        if np.isfinite([low, high]).all():
            self.constant = self.constant + (low + high) / 2 * wrench
            half = (high - low) / 2
            if half > 0:
                (row,) = self._equations(self.unit)
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
        same, whole = self._equations(0.0, self.unit)
        self._node(1.0, [None, x, y], {0: {same: 1.0}}, min(radius, USUAL * self.unit))
        self._node(radius / self.unit, [None, None, z], {0: {whole: 1.0}, 1: {same: -1.0}}, self.unit)

    def _grip(self, grip: Grip) -> None:
        where = f"grip of {quoted(grip.body)}"
        check_on_surface(self.assembly, grip.body, grip.points, where)
        for k in not_pressing(self.assembly, grip.body, grip.points, grip.normals).tolist():
            way = np.array2string(grip.normals[k], precision=4, separator=", ")
            remedy = "needs normals into the body, against those of its faces there, give or take 30°"
            raise SceneError(message(where, f"normal {k}, {way}, does not press on the body", remedy))
        for point, normal, most in zip(grip.points, grip.normals, grip.force, strict=True):
            pushes = [self._push(point, way) for way in (normal, *tangents(normal))]
            self.constant = self.constant - grip.pull / len(grip.points) * pushes[0]
            if most == 0:
                continue
            usual = min(most, USUAL * self.unit)
            if not np.isfinite(most):
                self._node(grip.mu, pushes, {}, usual)
                continue
            (row,) = self._equations(most)
            self._node(grip.mu, pushes, {0: {row: 1.0}}, usual)
            self._node(0.0, [None, None, None], {0: {row: 1.0}}, most)

    def _equations(self, *amounts: float) -> list[int]:
        """Return the numbers of new equations with these right-hand sides, and room for two more on their fastener."""
        if 6 - len(self.given) % 6 < len(amounts) + 3 * (self.other != FIXED):
            self.given += [0.0] * (-len(self.given) % 6)
        self.given += amounts
        return list(range(len(self.given) - len(amounts), len(self.given)))

    def _node(
        self, mu: float, wrenches: Iterable[Float | None], entries: dict[int, dict[int, float]], usual: float
    ) -> None:
        """Add a node: the wrench on the body of a unit force along each axis, and its entries in equations.

        A node has no more than two ends. Where one is a fastener, the body that holds gets a force that another
        equation of the fastener makes equal.
        """
        block, copies = np.zeros((3, 2, 6)), []
        rows = [row for entry in entries.values() for row in entry]
        fastener = rows[0] // 6 if rows else None
        for axis, entry in entries.items():
            for row, value in entry.items():
                block[axis, 1, row % 6] = value
        for axis, wrench in enumerate(wrenches):
            if wrench is None:
                continue
            block[axis, 0] = wrench[0]
            if fastener is None:
                block[axis, 1] = wrench[1]
            elif self.other != FIXED:
                self.given.append(0.0)
                row = (len(self.given) - 1) % 6
                block[axis, 1, row] = 1.0
                for sign in (1.0, -1.0)[: 2 if axis else 1]:
                    copy = np.zeros((3, 2, 6))
                    copy[0, 0], copy[0, 1, row] = sign * wrench[1], -sign
                    copies.append(copy)
        self._add(mu, block, usual, self.body, fastener)
        for copy in copies:
            self._add(0.0, copy, usual, self.other, fastener)

    def _add(self, mu: float, block: Float, usual: float, body: int, fastener: int | None) -> None:
        self.mu.append(mu)
        self.blocks.append(block)
        self.usual.append(usual)
        self.on.append(body)
        self.at.append(fastener)
