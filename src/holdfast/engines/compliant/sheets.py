"""The flat sheets that contact nodes form, in the units of ``elastic/model.py``.

Bodies' displacements are along the assembly's own axes, and all numbers are rounded to ``core.BITS`` digits: where a
load path branches, as under a symmetric push, the last digits decide which way it goes, and they would depend on the
world's axes and on the units of length.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.native import core

FLAT = 1e-9  # largest distance of a sheet's nodes from its plane, relative to the assembly's size


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
    first = core.sheets_begin(nodes.points, nodes.axes, nodes.interface, FLAT * size)
    start = first[:-1]
    a, b = nodes.a[start], nodes.b[start]
    x, y = np.empty((2, len(nodes)))
    own, arm_a, arm_b = np.empty((len(start), 3, 3)), np.zeros((len(start), 3)), np.zeros((len(start), 3))
    core.place_sheets(nodes.points, nodes.axes, first, a, b, com, axes, size, x, y, own, arm_a, arm_b)
    each = nodes.weights, nodes.pull
    return Sheets(first, x, y, *each, nodes.interface[start], nodes.mu[start], a, b, own, arm_a, arm_b)
