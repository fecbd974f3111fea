"""The elastic model of an assembly: its contact nodes as sheets, in the units of ``elastic/law.py``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float, Int
from holdfast.elastic.law import Elastic, bond

Stiffness: TypeAlias = float | Mapping[tuple[str, str], float] | None

FLAT = 1e-9  # distance of a sheet's nodes from its plane, at most, over the assembly's size


@dataclass(frozen=True, eq=False)
class Springs:
    """What contacts are made of.

    ``nodes`` along each side of a square patch; ``ratio`` of tangential over normal stiffness; ``stiffness`` [N/m³] as
    engine Compliant takes it.
    """

    nodes: int
    ratio: float = 1.0
    stiffness: Stiffness = None

    def finer(self, times: int) -> Springs:
        """The same with ``times`` as many nodes along each side."""
        return replace(self, nodes=times * self.nodes)


def force_unit(assembly: Assembly, wrench: Float) -> float:
    """[N] total weight; of weightless assemblies the largest force that acts."""
    return assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0


def levers(assembly: Assembly) -> Float:
    """(6J,) factors that make torques forces: by the assembly's size."""
    return np.tile(np.repeat([1.0, 1 / assembly.size], 3), len(assembly.movable))


def elastic_model(
    assembly: Assembly, nodes: ContactNodes, wrench: Float, ratio: float = 1.0, stiffness: Stiffness = None
) -> Elastic:
    """The model of an assembly under ``wrench`` (6J,) with stiffness by tributary area."""
    first = _sheets(nodes, FLAT * assembly.size)
    start = first[:-1]
    count = len(start)
    sheet = np.repeat(np.arange(count), np.diff(first))
    share = np.add.reduceat(nodes.points, start, axis=0) if count else np.empty((0, 3))
    origin = share / np.diff(first)[:, None]
    axes = nodes.axes[start]
    local = np.einsum("ikx,ix->ik", axes[sheet], nodes.points - origin[sheet]) / assembly.size
    k = nodes.weights * _stiffness_of(assembly, stiffness)[nodes.interface]
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
    )
    bond(model)
    return model


def _sheets(nodes: ContactNodes, flat: float) -> Int:
    """(P + 1,) where the sheets begin: runs of nodes of one interface with one normal in one plane."""
    if not len(nodes):
        return np.zeros(1, dtype=np.int64)
    steps = np.einsum("ix,ix->i", nodes.points[1:] - nodes.points[:-1], nodes.normals[1:])
    turns = np.abs(nodes.axes[1:] - nodes.axes[:-1]).max((1, 2))
    breaks = (nodes.interface[1:] != nodes.interface[:-1]) | (turns > 1e-12) | (np.abs(steps) > flat)
    return np.concatenate([[0], np.flatnonzero(breaks) + 1, [len(nodes)]]).astype(np.int64)


def _stiffness_of(assembly: Assembly, stiffness: Stiffness) -> Float:
    """(interfaces,) stiffness per area over that of interfaces that are not named."""
    if stiffness is None or not isinstance(stiffness, Mapping):
        return np.ones(len(assembly.interfaces))
    by_pair = {frozenset(pair): float(value) for pair, value in stiffness.items()}
    return np.array([by_pair.get(frozenset(i.bodies), 1.0) for i in assembly.interfaces])


def _sheet_from_body(assembly: Assembly, axes: Float, origin: Float, body: Int) -> Float:
    """(P, 6, 6): twists about centres of mass, rotations times size, to twists along ``axes`` about ``origin``."""
    T = np.zeros((len(body), 6, 6))
    free = np.flatnonzero(body != FIXED)
    arm = (origin[free] - assembly.com[body[free]]) / assembly.size
    R = axes[free]
    T[free, :3, :3] = T[free, 3:, 3:] = R
    T[free, :3, 3:] = np.cross(arm[:, None], R)  # R (ω x arm) = (arm x R) ω, row by row
    return T
