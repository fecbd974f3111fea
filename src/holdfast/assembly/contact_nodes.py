"""Compute the contact nodes of an assembly and the equilibrium operator G."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.axes import contact_axes
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.base.entries import Entries
from holdfast.base.public import Record, column
from holdfast.base.rigid import cross
from holdfast.contacts.interface import Patch
from holdfast.contacts.patch_nodes import Sampling, nodes_of
from holdfast.contacts.spots import corrected
from holdfast.native import core


class ContactNodes(Record):
    """The I contact nodes of an assembly; contact forces act at the nodes.

    The force at node i is (f_n, f_t1, f_t2) along the rows of ``axes[i]``. It acts on body b, and its negative acts on
    body a. ``points`` (I, 3) [m] are in the world frame. ``axes`` (I, 3, 3) holds the rows normal (pointing into b), t1
    and t2. ``mu`` (I,) are the friction coefficients, ``weights`` (I,) the tributary areas [m²] and ``interface`` (I,)
    the index of each node's interface. ``a`` and ``b`` (I,) are body numbers, FIXED for fixed bodies. ``pull`` (I,) [N]
    is what the tension of each node's face can pull there: friction is at most μ (f_n + pull), and f_n >= -pull. Forces
    of programs and models are those of the plain cone, f_n + pull beside f_t; only answers show f_n itself.
    """

    points: Float = column("I 3")
    axes: Float = column("I 3 3")
    mu: Float = column("I")
    weights: Float = column("I")
    interface: Int = column("I")
    a: Int = column("I")
    b: Int = column("I")
    pull: Float = column("I")

    @property
    def normals(self) -> Float:
        """The contact normals (I, 3), which point into body b."""
        return np.asarray(self.axes[:, 0])

    def __len__(self) -> int:
        return len(self.points)

    # The following are those of an assembly without holds; with holds they are overridden (hold_nodes.py).

    @property
    def fasteners(self) -> int:
        """The number F of fasteners, which have six equations each like the J bodies, after those."""
        return 0

    @property
    def counted(self) -> Float | None:
        """Which equations (6J,) of bodies count, 1 or 0: none in which a hold is as strong as needed; None for all."""
        return None

    @property
    def contacts(self) -> ContactNodes:
        """The nodes of contacts without those of holds, which are all where nothing is held."""
        return self

    @property
    def blocks(self) -> Float:
        """The wrenches (K, 3, 2, 6) of the K nodes of holds, here none."""
        return _NO_BLOCKS

    @property
    def usual(self) -> Float:
        """The usual normal forces (K,) [N] of the nodes of holds, here none."""
        return _EMPTY

    def under(self, wrench: Float) -> Float:
        """Return ``wrench`` (6J,) with what holds exert in any case, and the equations of fasteners: (6(J + F),)."""
        return wrench

    def beside(self, columns: Float) -> Float:
        """Return columns (6J, ...) of bodies with zeros for fasteners: (6(J + F), ...)."""
        return columns

    def moving(self, twists: Float) -> Float:
        """Return motions (..., 6J) of bodies without what holds forbid that are as strong as needed."""
        return twists if self.counted is None else twists * self.counted

    def scaled(self, scale: Float) -> Float:
        """Return scales (6J,) of bodies, and for each fastener that of forces on its body: (6(J + F),)."""
        return scale

    def world(self, forces: Float) -> Float:
        """Convert forces (I, 3) from the axes of their nodes to the world axes."""
        return np.asarray(np.einsum("ik,ikx->ix", forces, self.axes))

    def chosen(self, keep: Bool) -> ContactNodes:
        """Return only the nodes for which ``keep`` (I,) is true."""
        return ContactNodes(*(entries[keep] for entries in self.columns))

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """All fields, each with a row for every node."""
        return self.points, self.axes, self.mu, self.weights, self.interface, self.a, self.b, self.pull

    @cached_property
    def spans(self) -> Int:
        """The index (interfaces + 1,) at which the nodes of each interface begin; nodes are ordered by interface."""
        return frozen(np.searchsorted(self.interface, np.arange(self.interface.max(initial=-1) + 2)))


_EMPTY, _NONE = frozen(np.empty(0)), np.empty(0, dtype=np.int64)
_NO_BLOCKS = frozen(np.empty((0, 3, 2, 6)))
NO_NODES = ContactNodes(_EMPTY.reshape(0, 3), _EMPTY.reshape(0, 3, 3), _EMPTY, _EMPTY, _NONE, _NONE, _NONE, _EMPTY)


def joined_nodes(parts: Sequence[ContactNodes], interfaces: Sequence[int], bodies: Sequence[int]) -> ContactNodes:
    """Return the nodes of several groups of bodies as those of one group.

    ``interfaces`` and ``bodies`` count those of each group; their numbers run on from group to group.
    """
    first, body = np.cumsum([0, *interfaces[:-1]]), np.cumsum([0, *bodies[:-1]])
    moved = [
        replace(
            part,
            interface=part.interface + start,
            a=np.where(part.a < 0, FIXED, part.a + k),
            b=np.where(part.b < 0, FIXED, part.b + k),
        )
        for part, start, k in zip(parts, first, body, strict=True)
    ]
    return ContactNodes(*(np.concatenate(entries) for entries in zip(*(each.columns for each in moved), strict=True)))


def reordered_nodes(nodes: ContactNodes, bodies: Int, interfaces: Int) -> ContactNodes:
    """Return the nodes with other numbers for bodies and interfaces, in the order of the new numbers of interfaces.

    ``bodies`` (J,) and ``interfaces`` hold the new number of each.
    """
    renumbered = interfaces[nodes.interface]
    a, b = (np.where(end < 0, FIXED, bodies[end]) for end in (nodes.a, nodes.b))
    moved = replace(nodes, interface=renumbered, a=a, b=b)
    return ContactNodes(*(entries[np.argsort(renumbered, kind="stable")] for entries in moved.columns))


def contact_nodes(
    assembly: Assembly, count: int | Int, sampling: Sampling, seed: int = 0, among: Sequence[int] | None = None
) -> ContactNodes:
    """Return the contact nodes of the assembly, with ``count`` nodes for each interface.

    ``count`` is one number, or one for each interface. With ``among``, only the interfaces with these numbers get
    nodes. ``seed`` is the random seed of the sampling "paper".
    """
    strengths = strengths_of(assembly)
    counts = np.broadcast_to(count, len(assembly.interfaces)).tolist()
    chosen = list(range(len(counts)) if among is None else among)
    interfaces, seeds = [assembly.interfaces[k] for k in chosen], [seed + k for k in chosen]
    samples = nodes_of(interfaces, [counts[k] for k in chosen], sampling, seeds)
    patches = [
        (number, patch) for number, interface in zip(chosen, interfaces, strict=True) for patch in interface.patches
    ]
    points, weights = (
        [nodes for of_interface in samples for nodes, _ in of_interface],
        [areas for of_interface in samples for _, areas in of_interface],
    )
    if not points:
        return NO_NODES
    sizes = [len(nodes) for nodes in points]
    axes = assembly.patch_axes
    if among is not None:
        begins = np.cumsum([0, *(len(interface.patches) for interface in assembly.interfaces)])
        axes = np.concatenate([axes[begins[number] : begins[number + 1]] for number in chosen])
    axes = np.repeat(axes, sizes, axis=0)
    pull = np.zeros(len(axes))
    for k, (first, (number, patch)) in enumerate(zip(np.cumsum([0, *sizes[:-1]]).tolist(), patches, strict=True)):
        here = slice(first, first + sizes[k])
        if patch.bent:
            axes[here] = contact_axes(assembly.axes, patch.normals_at(points[k]))
        if strengths[number].tension > 0:
            pull[here] = _pull(patch, points[k], weights[k], strengths[number].tension)
    interface_of = np.repeat([number for number, _ in patches], sizes)
    a, b = np.ascontiguousarray(np.array(assembly.ends, dtype=np.int64)[interface_of].T)
    return ContactNodes(
        np.vstack(points),
        axes,
        np.array(assembly.mu)[interface_of],
        np.concatenate(weights),
        interface_of,
        a,
        b,
        pull,
    )


def _pull(patch: Patch, nodes: Float, areas: Float, tension: float) -> Float:
    """Return the shares (n,) [N] of nodes with tributary ``areas`` (n,) in the pull of a patch, about its centroid."""
    if not tension * patch.area > 0:
        return np.zeros(len(nodes))
    shares, scale = areas * (patch.area / areas.sum()), max(float(np.ptp(nodes, axis=0).max()), 1e-300)
    if patch.bent:
        return np.asarray(tension * shares)
    basis = np.vstack([np.ones(len(nodes)), (nodes - patch.centroid).T / scale])
    wanted = patch.area * np.array([1.0, 0.0, 0.0, 0.0])
    return np.asarray(tension * corrected(shares, basis, wanted, (4, 1)))


def equilibrium_operator(assembly: Assembly, nodes: ContactNodes) -> sparse.csc_matrix:
    """Return the equilibrium matrix G (6J, 3I), which maps contact forces to body wrenches (eq. 2-3).

    The forces are (f_n, f_t1, f_t2) at the nodes. The wrenches are (force [N], torque [N m] about the centre of mass),
    along the world axes.
    """
    return by_bodies(len(assembly.movable) + nodes.fasteners, nodes, equilibrium_blocks(assembly, nodes))


def equilibrium_blocks(assembly: Assembly, nodes: ContactNodes) -> Float:
    """Return the wrenches (I, 3, 2, 6) of a unit force along each axis of a node, on body b first, then on body a."""
    contacts = nodes.contacts
    blocks = np.empty((len(nodes), 3, 2, 6))
    blocks[len(contacts) :] = nodes.blocks
    for side, (body, sign) in enumerate(((contacts.b, 1.0), (contacts.a, -1.0))):
        force = sign * contacts.axes
        blocks[: len(contacts), :, side, :3] = force
        blocks[: len(contacts), :, side, 3:] = cross(arms(assembly, contacts, body)[:, None], force)
    return counted_part(nodes, blocks)


def counted_part(nodes: ContactNodes, blocks: Float) -> Float:
    """Return ``blocks`` (I, 3, 2, 6) with 0 in the equations that do not count."""
    if nodes.counted is not None:
        every = np.vstack([nodes.counted.reshape(-1, 6), np.ones((nodes.fasteners + 1, 6))])  # FIXED is -1
        blocks *= every[np.stack([nodes.b, nodes.a], axis=1)][:, None]
    return blocks


def wrenches_of(assembly: Assembly, nodes: ContactNodes, forces: Float) -> Float:
    """Return the wrenches (6J,) of local contact ``forces`` (I, 3) [N] on the bodies: G f, without the matrix G."""
    a, b, forces = np.ascontiguousarray(nodes.a), np.ascontiguousarray(nodes.b), np.ascontiguousarray(forces)
    return core.node_wrenches(nodes.points, nodes.axes, a, b, assembly.com, forces)


def held_velocity(nodes: ContactNodes, motion: Float) -> Float:
    """Return the velocity (K, 3) at the nodes of holds, along the axes of their forces, in a motion (J + F, 6)."""
    first = len(nodes.contacts)
    ends = np.stack([motion[nodes.b[first:]], motion[nodes.a[first:]]], axis=1)  # FIXED has no entries
    return np.asarray(np.einsum("kisj,ksj->ki", nodes.blocks, ends))


def arms(assembly: Assembly, nodes: ContactNodes, body: Int) -> Float:
    """Return the arms (I, 3) [m] of the nodes about the centres of mass of bodies ``body`` (I,); 0 for fixed ones."""
    free = body >= 0
    return np.asarray(np.where(free[:, None], nodes.points - assembly.com[np.where(free, body, 0)], 0.0))


def by_bodies(count: int, nodes: ContactNodes, blocks: Float) -> sparse.csc_matrix:
    """Return the matrix (6J, 3I) of ``blocks`` (I, 3, 2, 6) from ``equilibrium_blocks``; ``count`` is J."""
    found, width = entries_by_bodies(nodes, blocks), 3 * len(nodes)
    starts = np.concatenate([[0], np.cumsum(np.bincount(found.columns, minlength=width))])
    return sparse.csc_matrix((found.values, found.rows, starts), shape=(6 * count, width))


def entries_by_bodies(nodes: ContactNodes, blocks: Float) -> Entries:
    """Return the entries of the matrix of ``by_bodies``, with explicit zeros, sorted by column and then by row.

    Fixed bodies have no rows.
    """
    bodies = np.stack([nodes.b, nodes.a], axis=1)
    later = bodies[:, 0] > bodies[:, 1]  # exchange the two bodies, so that rows are in order
    bodies = np.where(later[:, None], bodies[:, ::-1], bodies)
    blocks = np.where(later[:, None, None, None], blocks[:, :, ::-1], blocks)
    kept = np.broadcast_to((bodies >= 0)[:, None, :, None], blocks.shape)
    rows = np.broadcast_to(6 * bodies[:, None, :, None] + np.arange(6), blocks.shape)
    columns = np.broadcast_to(np.arange(3 * len(nodes)).reshape(-1, 3)[:, :, None, None], blocks.shape)
    return Entries(rows[kept], columns[kept], blocks[kept])


def dense_by_bodies(count: int, nodes: ContactNodes, blocks: Float) -> Float:
    """Return the matrix (6J, 3I) from forces at nodes to wrenches on bodies, dense; see ``by_bodies``.

    ``blocks`` (I, 3, 2, 6) are the wrenches of unit forces at each node on its bodies b and a; ``count`` is J.
    """
    found = np.zeros((count + 1, 6, len(nodes), 3))  # the last row collects fixed bodies, whose number FIXED is -1
    node = np.arange(len(nodes))
    for side, body in enumerate((nodes.b, nodes.a)):
        found[body, :, node] = blocks[:, :, side].transpose(0, 2, 1)
    return found[:count].reshape(6 * count, 3 * len(nodes))
