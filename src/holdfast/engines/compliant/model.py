"""The elastic model of an assembly: its contact nodes grouped into flat sheets, in the units of ``elastic/law.py``.

Bodies' displacements and loads are along the assembly's own axes, and all numbers are rounded to BITS digits: where a
load path branches, as under a symmetric push, the last digits decide which way it goes, and they would depend on the
world's axes and on the units of length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.base.rigid import snapped
from holdfast.elastic.law import Elastic, bond
from holdfast.engines.compliant.faces import Faces
from holdfast.engines.compliant.stiffness import Stiffness, stiffness_of

BITS = 30  # binary digits of the model's numbers, each relative to those of the same sheet or body
ROUGHEST = 1e3  # flatness, in compressions under the weight, beyond which bodies rest on three nodes of a patch anyway
FLAT = 1e-9  # largest distance of a sheet's nodes from its plane, relative to the assembly's size


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
    faces: Faces | None = None

    def finer(self, times: int) -> Springs:
        """Return the same springs with ``times`` as many nodes along each side."""
        return replace(self, nodes=times * self.nodes)

    def model(self, assembly: Assembly, nodes: ContactNodes, wrench: Float) -> Elastic:
        """Return the elastic model of an assembly on ``nodes`` under ``wrench`` (6J,) [N, N m].

        If there are ``faces``, the nodes are those of this many a side (``contact_nodes``, sampling "quadrature"), and
        clearances are at most ROUGHEST times the compression that the weight would cause on all contacts together.
        """
        stiffness = stiffness_of(assembly, self.stiffness)
        if self.faces is None:
            return elastic_model(assembly, nodes, wrench, self.ratio, stiffness)
        stiffness = stiffness * self.faces.stiffness(assembly)
        most = ROUGHEST * force_unit(assembly, wrench) / max(float(stiffness[nodes.interface] @ nodes.weights), 1e-300)
        softened = min(1.0, most / max(self.faces.imperfect.flatness, 1e-300))
        apart = softened * self.faces.clearances(assembly, self.nodes**2)
        return elastic_model(assembly, nodes, wrench, self.ratio, stiffness, apart)


def force_unit(assembly: Assembly, wrench: Float) -> float:
    """Return the unit of force [N]: the total weight or, for a weightless assembly, the largest entry of ``wrench``."""
    return assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0


def levers(assembly: Assembly) -> Float:
    """Return the factors (6J,) that turn torques into forces by dividing them by the assembly's size."""
    return np.tile(np.repeat([1.0, 1 / assembly.size], 3), len(assembly.movable))


def own_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of forces and torques [N, N m] to the model's axes and units of length, rounded."""
    own = ((rows * levers(assembly)).reshape(-1, 3) @ assembly.axes.T).reshape(-1, len(assembly.movable), 6)
    return snapped(own, np.abs(own).max(2, keepdims=True), BITS).reshape(rows.shape)


def world_rows(assembly: Assembly, rows: Float) -> Float:
    """Convert rows (k, 6J) of displacements or motions in the model's axes and units of length to the world's."""
    return (rows.reshape(-1, 3) @ assembly.axes).reshape(rows.shape) * levers(assembly)


def motion_row(assembly: Assembly, twists: Float) -> Float:
    """Convert the twists (J, 6) of a motion to a row (6J,) in the model's axes and units of length."""
    return (twists.reshape(-1, 3) @ assembly.axes.T).ravel() / levers(assembly)


def elastic_model(
    assembly: Assembly,
    nodes: ContactNodes,
    wrench: Float,
    ratio: float = 1.0,
    stiffness: Float | None = None,
    apart: Float | None = None,
) -> Elastic:
    """Return the elastic model of an assembly under ``wrench`` (6J,) [N, N m].

    The stiffness of a node is the ``stiffness`` per area (interfaces,) [N/m³] of its interface, 1 unless given, times
    the node's tributary area. ``apart`` (I,) [m] is the clearance of each node, 0 unless given.
    """
    first = _sheets(nodes, FLAT * assembly.size)
    start = first[:-1]
    count = len(start)
    sheet = np.repeat(np.arange(count), np.diff(first))
    share = np.add.reduceat(nodes.points, start, axis=0) if count else np.empty((0, 3))
    origin = share / np.diff(first)[:, None]
    axes = nodes.axes[start]
    local = np.einsum("ikx,ix->ik", axes[sheet], nodes.points - origin[sheet]) / assembly.size
    extent = np.maximum.reduceat(np.abs(local).max(1), start) if count else np.empty(0)
    local = snapped(local, extent[sheet, None], BITS)
    k = nodes.weights if stiffness is None else nodes.weights * stiffness[nodes.interface]
    total = max(float(k.sum()), 1e-300)
    k = k / total
    clear = np.zeros(len(k)) if apart is None else apart * (total / force_unit(assembly, wrench))
    a, b = nodes.a[start], nodes.b[start]
    scale = assembly.equation_scale / levers(assembly)
    model = Elastic(
        first,
        np.ascontiguousarray(local[:, 1]),
        np.ascontiguousarray(local[:, 2]),
        snapped(k, k, BITS),
        snapped(clear, np.abs(clear).max(initial=0.0), BITS),
        np.ascontiguousarray(nodes.mu[start]),
        float(ratio),
        np.ascontiguousarray(a),
        np.ascontiguousarray(b),
        _sheet_from_body(assembly, axes, origin, a),
        _sheet_from_body(assembly, axes, origin, b),
        own_rows(assembly, wrench[None] / force_unit(assembly, wrench))[0],
        snapped(scale, scale, BITS),
        np.zeros((count, 6, 6)),
        np.zeros(6 * len(assembly.movable)),
    )
    bond(model)
    return model


def _sheets(nodes: ContactNodes, flat: float) -> Int:
    """Return the numbers (P + 1,) of the nodes at which the P sheets begin, and the number of nodes.

    A sheet is a run of nodes of one interface that have the same axes and lie in one plane.
    """
    if not len(nodes):
        return np.zeros(1, dtype=np.int64)
    steps = np.einsum("ix,ix->i", nodes.points[1:] - nodes.points[:-1], nodes.normals[1:])
    turns = np.abs(nodes.axes[1:] - nodes.axes[:-1]).max((1, 2))
    breaks = (nodes.interface[1:] != nodes.interface[:-1]) | (turns > 1e-12) | (np.abs(steps) > flat)
    return np.concatenate([[0], np.flatnonzero(breaks) + 1, [len(nodes)]]).astype(np.int64)


def _sheet_from_body(assembly: Assembly, axes: Float, origin: Float, body: Int) -> Float:
    """Return the matrices (P, 6, 6) that map the twist of a body to its twist in the frame of each sheet.

    The body's twist is about its centre of mass along the assembly's own axes, with rotations multiplied by the
    assembly's size. The sheet's twist is about ``origin`` along ``axes``. Matrices of fixed bodies are zero.
    """
    T = np.zeros((len(body), 6, 6))
    free = np.flatnonzero(body != FIXED)
    arm = (origin[free] - assembly.com[body[free]]) @ assembly.axes.T / assembly.size
    arm = snapped(arm, np.abs(arm).max(1, initial=0.0)[:, None], BITS)
    R = snapped(axes[free] @ assembly.axes.T, 1.0, BITS)
    T[free, :3, :3] = T[free, 3:, 3:] = R
    T[free, :3, 3:] = np.cross(arm[:, None], R)  # R (ω x arm) = (arm x R) ω, row by row
    return T
