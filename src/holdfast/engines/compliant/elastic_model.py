"""The elastic model of an assembly on the places of its contacts, in the units of ``elastic/model.py``.

Places are nodes, and the flat sheets that they form. They depend on neither stiffness, flatness nor weight, so all
grids on the same nodes share them.

Displacements and loads are along the assembly's own axes, and all numbers are rounded to ``core.BITS`` digits: where a
load path branches, as under a symmetric push, the last digits decide which way it goes, and they would depend on the
world's axes and on the units of length.

The stiffness of contacts per area is one number for all of them, or one for each pair of bodies or of materials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.memory import Same
from holdfast.base.rigid import snapped
from holdfast.elastic.model import Elastic, Runs
from holdfast.engines.imperfect import RandomFaces
from holdfast.engines.mechanism import Kinematics, relative_velocity
from holdfast.native import core
from holdfast.scene.friction import check_known, number_between

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


Stiffness: TypeAlias = float | Mapping[tuple[str, str], float] | None

WHAT = "Compliant: stiffness"  # in error messages


def check_stiffness(assembly: Assembly, stiffness: Stiffness) -> None:
    """Raise SceneError if ``stiffness`` names something that is neither a body nor a material.

    What counts are the names of the whole: if ``assembly`` is a part of a larger one, the names in ``absent`` are
    known, too. Bodies need not touch.
    """
    if isinstance(stiffness, Mapping):
        known = {*assembly.absent, *assembly.scene.names}
        check_known(stiffness, known, WHAT)


ROUGHEST = 1e3  # flatness, in compressions under the weight, beyond which bodies rest on three nodes of a patch anyway


@dataclass(frozen=True, eq=False)
class Springs:
    """The springs of the contacts and the number of their nodes.

    ``nodes`` is the number of nodes along each side of a square patch, ``ratio`` the tangential over the normal
    stiffness, and ``stiffness`` [N/m³] the normal stiffness per area, given as to engine ``Compliant``. ``faces`` are
    the faces where they are not ideal.
    """

    nodes: int
    ratio: float = 1.0
    stiffness: Stiffness = None
    faces: RandomFaces | None = None

    def model(self, places: Places, wrench: Float) -> Elastic:
        """Return the elastic model of an assembly on these ``places`` under ``wrench`` (6J,) [N, N m].

        If there are ``faces``, clearances are at most ROUGHEST times the compression that the weight would cause on all
        contacts together.
        """
        assembly, sheets = places.assembly, places.sheets
        stiffness = np.ones(len(assembly.interfaces))  # per area, relative to that of interfaces that are not named
        if isinstance(self.stiffness, Mapping):
            materials = assembly.scene.materials
            named = [number_between(self.stiffness, *each.bodies, materials) for each in assembly.interfaces]
            stiffness = np.array([1.0 if value is None else value for value in named])
        if self.faces is None:
            return elastic_model(places, wrench, self.ratio, stiffness)
        refuse_joined(assembly, "imperfect faces", "leave out tension and cohesion, or imperfect=")
        stiffness = stiffness * self.faces.stiffness(assembly)
        total = float(stiffness[sheets.owner] @ sheets.weights)
        most = ROUGHEST * force_unit(assembly, wrench) / max(total, 1e-300)
        softened = min(1.0, most / max(self.faces.imperfect.flatness, 1e-300))
        apart = softened * self.faces.clearances(assembly, self.nodes**2)
        return elastic_model(places, wrench, self.ratio, stiffness, apart)


def force_unit(assembly: Assembly, wrench: Float) -> float:
    """Return the unit of force [N]: the total weight or, for a weightless assembly, the largest entry of ``wrench``."""
    return assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0


def own_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of forces and torques [N, N m] to the model's axes and units of length, rounded."""
    own = ((rows * assembly.levers).reshape(-1, 3) @ assembly.axes.T).reshape(-1, len(assembly.movable), 6)
    return snapped(own, np.abs(own).max(2, keepdims=True), core.BITS).reshape(rows.shape)


def world_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of displacements or motions in the model's axes and units of length to the world's."""
    return (rows.reshape(-1, 3) @ assembly.axes).reshape(rows.shape) * assembly.levers


def motion_row(assembly: Assembly, twists: Float) -> Float:
    """Convert the twists (J, 6) of a motion to a row (6J,) in the model's axes and units of length."""
    return (twists.reshape(-1, 3) @ assembly.axes.T).ravel() / assembly.levers


def elastic_model(
    places: Places, wrench: Float, ratio: float = 1.0, stiffness: Float | None = None, apart: Float | None = None
) -> Elastic:
    """Return the elastic model of an assembly on these ``places`` under ``wrench`` (6J,) [N, N m].

    The stiffness of a node is the ``stiffness`` per area (interfaces,) [N/m³] of its interface, 1 unless given, times
    the node's tributary area. ``apart`` (I,) [m] is the clearance of each node, 0 unless given. A node with tension
    presses from the outset as much as it can be pulled, against that pull, and stays elastic until it is pulled so.
    """
    assembly, sheets = places.assembly, places.sheets
    k = sheets.weights if stiffness is None else sheets.weights * stiffness[sheets.owner]
    total = max(float(k.sum()), 1e-300)
    k = k / total
    clear = np.zeros(len(k))
    if apart is not None:
        clear = apart * (total / force_unit(assembly, wrench))
    if sheets.pull.any():
        clear = clear - sheets.pull / (force_unit(assembly, wrench) * k)
    if clear.any():
        clear = snapped(clear, np.abs(clear).max(initial=0.0), core.BITS)
    scale = assembly.equation_scale / assembly.levers
    model = Elastic(
        sheets.first,
        sheets.x,
        sheets.y,
        snapped(k, k, core.BITS),
        clear,
        sheets.mu,
        float(ratio),
        sheets.a,
        sheets.b,
        sheets.axes,
        sheets.arm_a,
        sheets.arm_b,
        own_rows(assembly, wrench[None] / force_unit(assembly, wrench))[0],
        snapped(scale, scale, core.BITS),
        np.zeros((len(sheets.a), 6, 6)),
        np.ones(6 * len(assembly.movable)),
        Runs.of(sheets.first, sheets.x, sheets.y, clear),
        np.zeros(6 * len(assembly.movable)),
        np.zeros(6 * len(assembly.movable)),
    )
    core.bond(model, model.bonded, model.still)
    core.set_units(model, model.unit)
    if sheets.pull.any():
        # what nodes press at no displacement, which is their pull, to the last digit
        ends = model.first[:-1]
        fn, g1, g2 = (
            np.add.reduceat(each * model.k * model.apart, ends) for each in (np.ones_like(model.x), model.y, -model.x)
        )
        wrenches = np.zeros((len(model.a), 6))
        wrenches[:, 0], wrenches[:, 4], wrenches[:, 5] = fn, g1, g2
        core.add_wrenches(model, wrenches, model.wrench)
    return model
