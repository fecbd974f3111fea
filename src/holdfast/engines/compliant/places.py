"""Where an assembly's contacts lie: nodes, and the flat sheets that they form.

Nothing here depends on how stiff or how flat the contacts are, nor on the weight, so all grids on the same nodes share
it.

Bodies' displacements are along the assembly's own axes, and all numbers of sheets are rounded to ``core.BITS`` digits:
where a load path branches, as under a symmetric push, the last digits decide which way it goes, and they would depend
on the world's axes and on the units of length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.memory import Same
from holdfast.engines.mechanism import Kinematics, relative_velocity
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


SEVERAL = 8  # motions from which on a matrix pays for velocities at the nodes


@dataclass(frozen=True, eq=False)
class Places:
    """Where contact nodes of an assembly lie, and what follows from it.

    There are ``side`` along each side of a square patch, but ``more`` at the ``contacts`` of these numbers; or they are
    those that are ``given``.
    """

    assembly: Assembly
    side: int = 0
    contacts: tuple[int, ...] = ()
    more: int = 0
    given: ContactNodes | None = None

    @classmethod
    def at(cls, assembly: Assembly, nodes: ContactNodes) -> Places:
        """Return the places of these ``nodes``."""
        return cls(assembly, given=nodes)

    @classmethod
    def of(cls, assembly: Assembly, side: int) -> Places:
        """Return the nodes of an assembly, ``side`` along each side of a square patch; they are kept with it."""
        key = ("places", Same(assembly), side)
        return assembly.memory.recalled(key, len(assembly.movable), lambda: cls(assembly, side))

    @classmethod
    def with_more(cls, assembly: Assembly, side: int, contacts: Int, more: int) -> Places:
        """Return the nodes as ``of`` does, but ``more`` along each side at these ``contacts``, by number."""
        return cls(assembly, side, tuple(contacts.tolist()), more)

    @cached_property
    def nodes(self) -> ContactNodes:
        """The nodes."""
        if self.given is not None:
            return self.given
        counts = np.full(len(self.assembly.interfaces), self.side**2)
        counts[list(self.contacts)] = self.more**2
        return contact_nodes(self.assembly, counts, "quadrature")

    @cached_property
    def sheets(self) -> Sheets:
        """The nodes as flat sheets. Where only some contacts have more, all others are as without."""
        assembly = self.assembly
        if not self.contacts:
            return sheets_of(self.nodes, assembly.com, assembly.axes, assembly.size)
        usual, parts, last = Places.of(assembly, self.side).sheets, [], 0
        for contact in self.contacts:
            parts += [usual.between(last, contact), self._finer(contact)]
            last = contact + 1
        return Sheets.joined([*parts, usual.between(last, len(assembly.interfaces))])

    def _finer(self, contact: int) -> Sheets:
        """The sheets of one of the contacts that have more nodes, kept with the assembly."""
        assembly = self.assembly

        def make() -> Sheets:
            return Places.at(assembly, contact_nodes(assembly, self.more**2, "quadrature", among=[contact])).sheets

        return assembly.memory.recalled(("sheets", Same(assembly), contact, self.more), 1, make)

    @cached_property
    def rectangular(self) -> Bool:
        """Tell which of the assembly's interfaces are a single rectangle."""
        return np.array(
            [len(i.patches) == 1 and i.patches[0].rectangular for i in self.assembly.interfaces], dtype=bool
        )

    def velocities(self, twists: Float) -> Float:
        """Return the relative velocities (k, I, 3) at the nodes for ``twists`` (k, 6J), world axes.

        The matrix that maps twists to them is set up where they are many.
        """
        count = len(twists)
        if count < SEVERAL:
            return relative_velocity(self.nodes, self.assembly.com, twists.reshape(count, -1, 6))
        return np.asarray((self._relative @ twists.T).T.reshape(count, len(self.nodes), 3))

    @cached_property
    def _relative(self) -> sparse.csr_matrix:
        """Gᵀ (3I, 6J), which maps twists to relative velocities at the nodes."""
        return sparse.csr_matrix(equilibrium_operator(self.assembly, self.nodes).T)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The bodies and contact nodes that all mechanisms on these nodes share."""
        return Kinematics.of(self.assembly, self.nodes)
