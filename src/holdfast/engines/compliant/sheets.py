"""The flat sheets that contact nodes form, in the units of ``elastic/model.py``.

Bodies' displacements are along the assembly's own axes, and all numbers are rounded to BITS digits: where a load path
branches, as under a symmetric push, the last digits decide which way it goes, and they would depend on the world's axes
and on the units of length.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, lean
from holdfast.base.rigid import snapped_number

BITS = 30  # binary digits of the model's numbers, each relative to those of the same sheet or body
FLAT = 1e-9  # largest distance of a sheet's nodes from its plane, relative to the assembly's size
TURNED = 1e-12  # largest difference of an entry of the axes of a sheet's nodes


class Sheets(NamedTuple):
    """The P flat sheets of the I nodes of an assembly.

    Nodes ``first[p]`` to ``first[p + 1] - 1`` belong to sheet p and have the places ``x`` and ``y`` (I,) in its plane,
    in sizes of the assembly, the ``weights`` (I,) [m²], and the ``pull`` (I,) [N] of tension. It belongs to one
    ``interface`` (P,) and lies between bodies ``a`` and ``b`` (P,). Its ``axes`` (P, 3, 3), normal and tangents, and
    the arms ``arm_a`` and ``arm_b`` (P, 3) from their centres of mass to its origin are along the assembly's own axes;
    arms are in sizes of the assembly, and zero of fixed bodies.
    """

    first: Int
    x: Float
    y: Float
    weights: Float
    pull: Float
    interface: Int
    mu: Float
    a: Int
    b: Int
    axes: Float
    arm_a: Float
    arm_b: Float

    @property
    def owner(self) -> Int:
        """The interface (I,) of every node, by number."""
        return np.repeat(self.interface, np.diff(self.first))

    @classmethod
    def joined(cls, parts: Sequence[Sheets]) -> Sheets:
        """Return the sheets of all ``parts``, one after another."""
        ends = np.cumsum([0, *(part.first[-1] for part in parts)])
        first = [end + part.first[:-1] for end, part in zip(ends, parts, strict=False)]
        others = (np.concatenate(column) for column in zip(*(part[1:] for part in parts), strict=True))
        return cls(np.concatenate([*first, ends[-1:]]), *others)

    def between(self, start: int, stop: int) -> Sheets:
        """Return the sheets of the interfaces from number ``start`` to ``stop`` - 1."""
        begin, end = np.searchsorted(self.interface, [start, stop])
        first = self.first[begin : end + 1]
        nodes, sheets = slice(first[0], first[-1]), slice(begin, end)
        of_nodes, of_sheets = (column[nodes] for column in self[1:5]), (column[sheets] for column in self[5:])
        return Sheets._make((first - first[0], *of_nodes, *of_sheets))


def sheets_of(nodes: ContactNodes, com: Float, axes: Float, size: float) -> Sheets:
    """Return the sheets of the ``nodes`` of an assembly with these centres of mass ``com`` (J, 3) [m].

    ``axes`` (3, 3) are the assembly's own axes, as rows, and ``size`` [m] is its size. A sheet is a run of nodes of one
    interface that have the same axes and lie in one plane.
    """
    first = _begins(nodes.points, nodes.axes, nodes.interface, FLAT * size)
    start = first[:-1]
    a, b = nodes.a[start], nodes.b[start]
    x, y = np.empty((2, len(nodes)))
    own, arm_a, arm_b = np.empty((len(start), 3, 3)), np.zeros((len(start), 3)), np.zeros((len(start), 3))
    _place(nodes.points, nodes.axes, first, a, b, com, axes, size, x, y, own, arm_a, arm_b)
    each = nodes.weights, nodes.pull
    return Sheets(first, x, y, *each, nodes.interface[start], nodes.mu[start], a, b, own, arm_a, arm_b)


@compiled
def _begins(points: Float, axes: Float, interface: Int, flat: float) -> Int:
    """Return the numbers (P + 1,) of the nodes at which the P sheets begin, and the number of nodes."""
    count = 0
    found = np.empty(len(points) + 1, dtype=np.int64)
    for i in range(len(points)):
        begins = i == 0 or interface[i] != interface[i - 1]
        if not begins:
            step, turn = 0.0, 0.0
            for k in range(3):
                step += (points[i, k] - points[i - 1, k]) * axes[i, 0, k]
                for row in range(3):
                    turn = max(turn, abs(axes[i, row, k] - axes[i - 1, row, k]))
            begins = turn > TURNED or abs(step) > flat
        if begins:
            found[count] = i
            count += 1
    found[count] = len(points)
    return found[: count + 1].copy()


@compiled
@lean
def _place(
    points: Float,
    axes: Float,
    first: Int,
    a: Int,
    b: Int,
    com: Float,
    own: Float,
    size: float,
    x: Float,
    y: Float,
    turned: Float,
    arm_a: Float,
    arm_b: Float,
) -> None:
    """Write the places ``x``, ``y`` of all nodes, and axes (``turned``) and arms of all sheets, as ``Sheets`` has them.

    Arms of fixed bodies remain as they are.
    """
    for p in range(len(a)):
        begin, end = first[p], first[p + 1]
        c0 = c1 = c2 = 0.0
        for i in range(begin, end):
            c0 += points[i, 0]
            c1 += points[i, 1]
            c2 += points[i, 2]
        c0, c1, c2 = c0 / (end - begin), c1 / (end - begin), c2 / (end - begin)
        R, most = axes[begin], 0.0
        for i in range(begin, end):
            d0, d1, d2 = points[i, 0] - c0, points[i, 1] - c1, points[i, 2] - c2
            x[i] = (R[1, 0] * d0 + R[1, 1] * d1 + R[1, 2] * d2) / size
            y[i] = (R[2, 0] * d0 + R[2, 1] * d1 + R[2, 2] * d2) / size
            most = max(most, abs(x[i]), abs(y[i]))
        for i in range(begin, end):
            x[i], y[i] = snapped_number(x[i], most, BITS), snapped_number(y[i], most, BITS)
        for row in range(3):
            for k in range(3):
                along = R[row, 0] * own[k, 0] + R[row, 1] * own[k, 1] + R[row, 2] * own[k, 2]
                turned[p, row, k] = snapped_number(along, 1.0, BITS)
        for body, arm in ((a[p], arm_a[p]), (b[p], arm_b[p])):
            if body < 0:
                continue
            d0, d1, d2, most = c0 - com[body, 0], c1 - com[body, 1], c2 - com[body, 2], 0.0
            for k in range(3):
                arm[k] = (d0 * own[k, 0] + d1 * own[k, 1] + d2 * own[k, 2]) / size
                most = max(most, abs(arm[k]))
            for k in range(3):
                arm[k] = snapped_number(arm[k], most, BITS)
