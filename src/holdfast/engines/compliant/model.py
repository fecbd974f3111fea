"""The elastic model of an assembly: its contact nodes grouped into flat sheets, in the units of ``elastic/law.py``."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.elastic.law import Elastic, bond
from holdfast.engines.compliant.stiffness import Stiffness, stiffness_of

FLAT = 1e-9  # largest distance of a sheet's nodes from its plane, relative to the assembly's size


@dataclass(frozen=True, eq=False)
class Springs:
    """The springs of the contacts and the number of their nodes.

    ``nodes`` is the number of nodes along each side of a square patch, ``ratio`` the tangential over the normal
    stiffness, and ``stiffness`` [N/m³] the normal stiffness per area, given as to engine ``Compliant``.
    """

    nodes: int
    ratio: float = 1.0
    stiffness: Stiffness = None

    def finer(self, times: int) -> Springs:
        """Return the same springs with ``times`` as many nodes along each side."""
        return replace(self, nodes=times * self.nodes)


def force_unit(assembly: Assembly, wrench: Float) -> float:
    """Return the unit of force [N]: the total weight or, for a weightless assembly, the largest entry of ``wrench``."""
    return assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0


def levers(assembly: Assembly) -> Float:
    """Return the factors (6J,) that turn torques into forces by dividing them by the assembly's size."""
    return np.tile(np.repeat([1.0, 1 / assembly.size], 3), len(assembly.movable))


def elastic_model(
    assembly: Assembly, nodes: ContactNodes, wrench: Float, ratio: float = 1.0, stiffness: Stiffness = None
) -> Elastic:
    """Return the elastic model of an assembly under ``wrench`` (6J,) [N, N m].

    The stiffness of a node is the stiffness per area of its interface times the node's tributary area.
    """
    first = _sheets(nodes, FLAT * assembly.size)
    start = first[:-1]
    count = len(start)
    sheet = np.repeat(np.arange(count), np.diff(first))
    share = np.add.reduceat(nodes.points, start, axis=0) if count else np.empty((0, 3))
    origin = share / np.diff(first)[:, None]
    axes = nodes.axes[start]
    local = np.einsum("ikx,ix->ik", axes[sheet], nodes.points - origin[sheet]) / assembly.size
    k = nodes.weights * stiffness_of(assembly, stiffness)[nodes.interface]
    k = k / max(float(k.sum()), 1e-300)
    a, b = nodes.a[start], nodes.b[start]
    model = Elastic(
        first,
        np.ascontiguousarray(local[:, 1]),
        np.ascontiguousarray(local[:, 2]),
        k,
        np.ascontiguousarray(nodes.mu[start]),
        float(ratio),
        np.ascontiguousarray(a),
        np.ascontiguousarray(b),
        _sheet_from_body(assembly, axes, origin, a),
        _sheet_from_body(assembly, axes, origin, b),
        levers(assembly) * wrench / force_unit(assembly, wrench),
        assembly.equation_scale / levers(assembly),
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

    The body's twist is about its centre of mass along the world axes, with rotations multiplied by the assembly's size.
    The sheet's twist is about ``origin`` along ``axes``. Matrices of fixed bodies are zero.
    """
    T = np.zeros((len(body), 6, 6))
    free = np.flatnonzero(body != FIXED)
    arm = (origin[free] - assembly.com[body[free]]) / assembly.size
    R = axes[free]
    T[free, :3, :3] = T[free, 3:, 3:] = R
    T[free, :3, 3:] = np.cross(arm[:, None], R)  # R (ω x arm) = (arm x R) ω, row by row
    return T
