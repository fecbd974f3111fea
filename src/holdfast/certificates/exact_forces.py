"""Contact forces that balance exactly, from forces that balance up to rounding.

Every body gets a correction at some of its nodes that cancels what is left on it to the last digit, in rational
arithmetic. The bodies come in an order in which those at the other side of these nodes are corrected later, or fixed.
The corrections are as small as the rounding, so that forces with some room in their cones stay inside.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from scipy import linalg

from holdfast.base.arrays import Float
from holdfast.certificates.verify_certificate import cross, dot, plus, unbraked

SINGULAR = 1e-9  # relative size of a pivot below which forces at the nodes cannot balance every wrench on a body
LEAST = 1e-3  # share of the largest force with which a node counts at least where those are chosen that are changed

Vector = tuple[Fraction, ...]
NONE: Vector = (Fraction(0),) * 3


def exact(values: Sequence[float] | Float) -> Vector:
    """Return the numbers that the shortest decimals of these floats stand for."""
    return tuple(Fraction(repr(float(value))) for value in values)


@dataclass(frozen=True)
class ExactContacts:
    """The points of contact in exact numbers: bodies ``a`` and ``b`` (-1: fixed), place, normal and friction of each.

    ``centres`` are the centres of mass of the bodies, by number.
    """

    centres: Sequence[Vector]
    a: Sequence[int]
    b: Sequence[int]
    points: Sequence[Vector]
    normals: Sequence[Vector]
    mu: Sequence[Fraction]

    def not_braking(self, twists: Sequence[tuple[Vector, Vector]]) -> bool:
        """Tell whether no contact force can brake a motion of the bodies: (velocity, angular velocity) of each."""
        for a, b, point, normal, mu in zip(self.a, self.b, self.points, self.normals, self.mu, strict=True):
            u = NONE
            for body, sign in ((a, -1), (b, 1)):
                if body >= 0:
                    velocity, turn = twists[body]
                    u = plus(u, plus(velocity, cross(turn, plus(point, self.centres[body], -1))), sign)
            if not unbraked(u, normal, mu):
                return False
        return True

    def balanced(
        self, forces: Sequence[Vector], wrenches: Sequence[Vector]
    ) -> tuple[list[Vector], dict[int, Vector]] | None:
        """Return forces like these that balance the ``wrenches`` (6 numbers a body) exactly; None if they cannot.

        Bodies that are only balanced, as a ball is, are held: also returns the faint wrench that each of them needs.
        """
        forces, left = list(forces), [tuple(wrench) for wrench in wrenches]
        for k, force in enumerate(forces):
            self._act(k, force, left)
        holds: dict[int, Vector] = {}
        for support in reversed(self._supported):
            changes = support.cancelling(left, [float(dot(forces[k], self.normals[k])) for k in support.nodes])
            if changes is None:
                return None
            for k, change in changes:
                forces[k] = plus(forces[k], change)
                self._act(k, change, left)
            for body in support.bodies:
                if any(left[body]):
                    holds[body] = tuple(-x for x in left[body])
        return forces, holds

    def _act(self, k: int, force: Vector, left: list[Vector]) -> None:
        """Add a force at one node to what is ``left`` on the two bodies there."""
        for body, sign in ((self.a[k], -1), (self.b[k], 1)):
            if body >= 0:
                left[body] = plus(left[body], self._acting(k, body, force), sign)

    def _acting(self, k: int, body: int, force: Vector) -> Vector:
        return (*force, *cross(plus(self.points[k], self.centres[body], -1), force))

    @cached_property
    def _supported(self) -> list[_HeldBodies]:
        """The bodies in an order in which each is held by those before it and the fixed ones.

        Bodies that hold each other alone come together, and those that are only balanced come when nothing else is
        left.
        """
        found: list[_HeldBodies] = []
        before, left = {-1}, list(range(len(self.centres)))
        while left:
            single: list[_HeldBodies] = []
            for body in left:
                single.append(self._held_by([body], before))
                if single[-1].firm:
                    break
            else:
                together = self._held_by(left, before | set(left))
                single.append(together if together.firm else next((one for one in single if one.nodes), single[0]))
            found.append(single[-1])
            before |= set(found[-1].bodies)
            left = [body for body in left if body not in before]
        return found

    def _held_by(self, bodies: list[int], others: Collection[int]) -> _HeldBodies:
        """Return what forces at the nodes between some bodies and the others do to these bodies."""
        nodes = [
            k
            for k, (a, b) in enumerate(zip(self.a, self.b, strict=True))
            if (a in bodies and b in others) or (b in bodies and a in others)
        ]
        columns = []
        for k in nodes:
            for axis in range(3):
                unit = tuple(Fraction(int(i == axis)) for i in range(3))
                column: list[Fraction] = []
                for body in bodies:
                    way = (self.b[k] == body) - (self.a[k] == body)
                    column += [way * x for x in self._acting(k, body, unit)] if way else [Fraction(0)] * 6
                columns.append(column)
        return _HeldBodies(bodies, nodes, columns)


@dataclass(frozen=True)
class _HeldBodies:
    """Some bodies and the ``nodes`` at which they are held, by number.

    Each of the ``columns``, three a node, is what a unit force along an axis does to the bodies: six numbers each.
    """

    bodies: list[int]
    nodes: list[int]
    columns: list[list[Fraction]]

    @cached_property
    def firm(self) -> bool:
        """Whether forces at the nodes balance every wrench on the bodies."""
        return len(self._chosen(np.ones(len(self.nodes)))) == 6 * len(self.bodies)

    @cached_property
    def _scaled(self) -> Float:
        """The columns as floating-point numbers, with forces and torques of one size."""
        A = np.array(self.columns, dtype=np.float64).T
        levers = A.reshape(len(self.bodies), 2, 3, -1)
        levers[:, 1] /= max(float(np.abs(levers[:, 1]).max()), 1e-300)
        return A

    def _chosen(self, room: Float) -> list[int]:
        """Return the numbers of columns by which wrenches on the bodies are balanced, best where there is ``room``."""
        return _independent(self._scaled * np.repeat(room, 3)) if self.nodes else []

    def cancelling(self, left: Sequence[Vector], pressing: Sequence[float]) -> list[tuple[int, Vector]] | None:
        """Return changes of the forces at some of the nodes that cancel what is ``left`` on the bodies.

        Nodes that are ``pressing`` [N] most are changed. Where the columns are too few, as many of the numbers are
        cancelled as there are columns.
        """
        right = [-x for body in self.bodies for x in left[body]]
        room = np.maximum(np.array(pressing) / max([*pressing, 1e-300]), LEAST)
        chosen = self._chosen(room) if any(right) else []
        if not chosen:
            return []
        columns = [self.columns[c] for c in chosen]
        rows = list(range(len(right)))
        if len(chosen) < len(right):
            rows = sorted(_independent(np.array(columns, dtype=np.float64)))
        solution = _solved([[column[row] for column in columns] for row in rows], [right[row] for row in rows])
        if solution is None:
            return None
        changes: dict[int, list[Fraction]] = {}
        for c, value in zip(chosen, solution, strict=True):
            changes.setdefault(self.nodes[c // 3], [Fraction(0)] * 3)[c % 3] += value
        return [(k, tuple(change)) for k, change in changes.items()]


def _independent(A: Float) -> list[int]:
    """Return the numbers of columns of ``A`` that are independent, as many as there are; the first differ most."""
    _, R, order = linalg.qr(A, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    return order[: int((pivots > SINGULAR * pivots[0]).sum())].tolist()  # type: ignore[no-any-return]


def _solved(rows: list[list[Fraction]], right: list[Fraction]) -> list[Fraction] | None:
    """Solve a small square system exactly (Gauss); None if it is singular."""
    n = len(rows)
    M = [[*row, value] for row, value in zip(rows, right, strict=True)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(M[i][k]))
        if not M[pivot][k]:
            return None
        M[k], M[pivot] = M[pivot], M[k]
        for i in range(k + 1, n):
            factor = M[i][k] / M[k][k]
            if factor:
                M[i] = [x - factor * y for x, y in zip(M[i], M[k], strict=True)]
    found = [Fraction(0)] * n
    for k in reversed(range(n)):
        found[k] = (M[k][n] - sum(M[k][i] * found[i] for i in range(k + 1, n))) / M[k][k]
    return found
