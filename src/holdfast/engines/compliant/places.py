"""Where an assembly's contacts lie: nodes, and the flat sheets that they form.

Nothing here depends on how stiff or how flat the contacts are, nor on the weight, so all grids on the same nodes share
it. How nodes are grouped: sheets.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.memory import Same
from holdfast.engines.compliant.sheets import Sheets, sheets_of
from holdfast.engines.mechanism import Kinematics, relative_velocity

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
        if not self.contacts:
            return self._sheets
        usual, parts, last = Places.of(self.assembly, self.side).sheets, [], 0
        for contact in self.contacts:
            parts += [usual.between(last, contact), self._finer(contact)]
            last = contact + 1
        return Sheets.joined([*parts, usual.between(last, len(self.assembly.interfaces))])

    def _finer(self, contact: int) -> Sheets:
        """The sheets of one of the contacts that have more nodes, kept with the assembly."""
        assembly = self.assembly

        def make() -> Sheets:
            return Places.at(assembly, contact_nodes(assembly, self.more**2, "quadrature", among=[contact])).sheets

        return assembly.memory.recalled(("sheets", Same(assembly), contact, self.more), 1, make)

    @property
    def _sheets(self) -> Sheets:
        """The sheets of all nodes, placed anew."""
        assembly = self.assembly
        return sheets_of(self.nodes, assembly.com, assembly.axes, assembly.size)

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
