"""An assembly on elastic contacts, each with so many nodes: its state of rest, its load paths and its motions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.base.arrays import Float
from holdfast.elastic.outcome import RestOutcome
from holdfast.elastic.path import PathResult
from holdfast.elastic.system import Settled, System
from holdfast.engines.compliant.model import Springs, elastic_model, force_unit, levers
from holdfast.engines.mechanism import Kinematics, Mechanism, describe, modes_of

FINER = 2  # times as many nodes along a side on the next finer grid
CHUNK = 64  # motions described at a time


@dataclass(frozen=True, eq=False)
class Grid:
    """An assembly under ``wrench`` (6J,) [N, N m] on contact nodes with springs, and how it came to rest there."""

    assembly: Assembly
    wrench: Float
    springs: Springs
    nodes: ContactNodes
    system: System
    settled: Settled

    @classmethod
    def of(cls, assembly: Assembly, wrench: Float, springs: Springs, nodes: ContactNodes | None = None) -> Grid:
        """Let the assembly come to rest on ``nodes``, or on as many along a side as the springs say."""
        if nodes is None:
            nodes = contact_nodes(assembly, springs.nodes**2, "quadrature")
        system = System.of(elastic_model(assembly, nodes, wrench, springs.ratio, springs.stiffness))
        return cls(assembly, wrench, springs, nodes, system, system.come_to_rest())

    @cached_property
    def finer(self) -> Grid:
        """The same with FINER times as many nodes along a side."""
        return Grid.of(self.assembly, self.wrench, self.springs.finer(FINER))

    @property
    def unit(self) -> float:
        """[N] the model's unit of force."""
        return force_unit(self.assembly, self.wrench)

    def loads(self, W: Float) -> Float:
        """Columns W (6J, k) [N, N m] as rows (k, 6J) in the units of the model."""
        return np.ascontiguousarray((W.T * levers(self.assembly)) / self.unit)

    def paths(self, W: Float, *, cuts: bool = False) -> PathResult:
        """The load paths of columns W (6J, k), none of them zero; all lost if the assembly does not rest here.

        ``cuts``: say how peaks answer to loads, in the units of W.
        """
        loads = self.loads(W)
        if self.settled.outcome is not RestOutcome.RESTS:
            return PathResult.lost(*loads.shape, cuts=cuts).sealed()
        found = self.system.paths(self.settled.q, loads, cuts=cuts)
        return found._replace(cut=found.cut * (levers(self.assembly) / self.unit)).sealed() if cuts else found

    def loads_at_peaks(self, W: Float, peaks: PathResult) -> Float:
        """Factors (k,) of columns W (6J, k) at the displacements of peaks on a coarser grid; -1 where none is found."""
        return self.system.loads_at_peaks(self.loads(W), peaks.peak, peaks.q, peaks.plane)

    def mechanisms(self, motions: Float) -> list[Mechanism]:
        """The mechanisms of motions (k, 6J) in the units of the model."""
        found: list[Mechanism] = []
        relative = self._relative
        for first in range(0, len(motions), CHUNK):
            twists = motions[first : first + CHUNK] * levers(self.assembly)
            velocities = (relative @ twists.T).T.reshape(len(twists), len(self.nodes), 3)
            modes = modes_of(velocities, np.zeros(len(self.nodes)))
            found += [
                describe(self.kinematics, t.reshape(-1, 6), mode, dual=False)
                for t, mode in zip(twists, modes, strict=True)
            ]
        return found

    @cached_property
    def kinematics(self) -> Kinematics:
        """What all mechanisms on these nodes share."""
        return Kinematics.of(self.assembly, self.nodes)

    @cached_property
    def _relative(self) -> sparse.csr_matrix:
        """Gᵀ (3I, 6J): twists to relative velocities at the nodes."""
        return sparse.csr_matrix(equilibrium_operator(self.assembly, self.nodes).T)
