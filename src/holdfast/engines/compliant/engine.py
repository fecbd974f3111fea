"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.arrays import Float, Int, checked_number
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.engines.compliant import path
from holdfast.engines.compliant import settle as rest
from holdfast.engines.compliant.law import Elastic, Stiffness, elastic_model, force_unit, levers
from holdfast.engines.compliant.linear import SparseSolver, Work, make_work
from holdfast.engines.compliant.verdict import Settled, judged, settled
from holdfast.engines.contract import Capacity, Claim, Mechanism, Status, Verdict, no_capacity
from holdfast.engines.mechanism import describe, modes_of
from holdfast.engines.rest import find_rest
from holdfast.errors import HoldfastError, message

DENSE = 150  # unknowns up to which dense elimination in compiled code is faster than sparse LU
FEWEST = 2  # nodes along a side
FINER = 3  # times as many nodes along a side in the grid that the discretisation estimate looks at
SAFETY = 1.5  # the estimate is of first order: this much of it is taken
FLOOR = 2e-3  # relative: what it is at least
CHUNK = 64  # motions described at a time


@dataclass(frozen=True)
class Compliant:
    """Elastic contacts without adhesion, Coulomb friction without dilatancy: what comes to rest, and up to which load.

    ``nodes`` along each side of a square patch (others have as many in all); ``stiffness_ratio`` tangential over normal
    stiffness; ``stiffness`` [N/m³] per area: None or a number for equal contacts (it drops out), or one for each pair of
    names, where pairs that are not named have 1.
    """

    nodes: int = 7
    stiffness_ratio: float = 1.0
    stiffness: Stiffness = None

    name = "compliant"
    claim = Claim.HOLDS

    def __post_init__(self) -> None:
        if not isinstance(self.nodes, int | np.integer) or self.nodes < FEWEST:
            problem = f"nodes = {self.nodes!r}"
            raise HoldfastError(message("Compliant", problem, f"needs a whole number of at least {FEWEST}"))
        checked_number(self.stiffness_ratio, "Compliant: stiffness_ratio", above=0)
        named = self.stiffness if hasattr(self.stiffness, "values") else {("", ""): self.stiffness or 1.0}
        for pair, value in named.items():  # type: ignore[union-attr]
            checked_number(value, f"Compliant: stiffness of {pair}" if pair[0] else "Compliant: stiffness", above=0)

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> CompliantState:
        """Let the assembly come to rest: all load paths start there."""
        wrench = assembly.weight_wrench(acceleration)
        if standing is not None:
            wrench = wrench + standing
        nodes = contact_nodes(assembly, self.nodes**2, "quadrature")
        if not assembly.movable or assembly.hanging:
            return CompliantState(
                self, assembly, wrench, nodes, None, find_rest(assembly, wrench, 4, "corners").verdict
            )
        system = System.of(elastic_model(assembly, nodes, wrench, self.stiffness_ratio, self.stiffness))
        end = settled(system.model, system.work, system.sparse)
        verdict = judged(assembly, nodes, wrench, system.model, force_unit(assembly, wrench), end)
        start = end.q if end.how == rest.REST else None
        return CompliantState(self, assembly, wrench, nodes, system, verdict, start)


@dataclass(frozen=True, eq=False)
class System:
    """A model and what solves its linear systems: dense elimination, or ``sparse`` LU."""

    model: Elastic
    work: Work
    sparse: SparseSolver | None

    @classmethod
    def of(cls, model: Elastic) -> System:
        """Dense for few unknowns."""
        sparse = None if len(model.wrench) <= DENSE else SparseSolver(model)
        return cls(model, make_work(model, dense=sparse is None), sparse)


@dataclass(frozen=True, eq=False)
class Paths:
    """The load paths of k columns: ``kind`` (k,), ``peak`` (k,) of s, ``last`` s, how far the peak may be above
    (``short``), the linear systems solved; q at the peak, the motion at the end and the adjoint (k, 6J)."""

    kind: Int
    peak: Float
    last: Float
    short: Float
    solves: Float
    q: Float
    motion: Float
    adjoint: Float


@dataclass(frozen=True, eq=False)
class CompliantState:
    """Engine ``compliant`` with the assembly at rest: from ``start`` (6J,) every load path begins."""

    engine: Compliant
    assembly: Assembly
    wrench: Float
    nodes: ContactNodes
    system: System | None
    rest: Verdict
    start: Float | None = None

    def verdict(self) -> Verdict:
        """Whether the assembly comes to rest."""
        return self.rest

    @property
    def notes(self) -> tuple[str, ...]:
        """None: what the answers rest on is their claim."""
        return ()

    def load_factor(self, W: Float, gap: float | None = None) -> Capacity:
        """For each column of W (6J, n) the peak of its load path; ``lower`` is that less the discretisation estimate.

        ``gap`` is not used: every column is followed along its own path.
        """
        count = W.shape[1]
        if self.rest.status is not Status.STABLE:
            return no_capacity(count, self.rest)
        loaded = np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)
        factor, lower, upper = np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf)
        status = [Status.INFINITE] * count
        told: list[Mechanism | None] = [None] * count
        if len(loaded):
            paths = self.paths(W[:, loaded])
            peak, below = self._bounded(W[:, loaded], paths)
            kinds = {path.PEAK: Status.FINITE, path.ENDLESS: Status.INFINITE, path.LOST: Status.UNDECIDED}
            factor[loaded], lower[loaded] = peak, below
            finite = np.flatnonzero(paths.kind == path.PEAK)
            mechanisms = self.mechanisms(paths.motion[finite])
            for k, mechanism in zip(finite, mechanisms, strict=True):
                told[loaded[k]] = mechanism
            for k, column in enumerate(loaded):
                status[column] = kinds[int(paths.kind[k])]
        return Capacity.told(factor, lower, upper, status, told)

    def paths(self, W: Float) -> Paths:
        """Follow the load paths of columns W (6J, k), none of them zero."""
        shape = (W.shape[1], len(self.wrench))
        q, motion, adjoint, told = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros((shape[0], 8))
        if self.system is not None and self.start is not None:
            m, work, sparse = self.system.model, self.system.work, self.system.sparse
            loads = self._loads(W)
            if sparse is None:
                path.follow_dense(m, work, self.start, loads, q, motion, adjoint, told)
            else:
                for k in range(shape[0]):
                    path.follow(m, work, self.start, loads[k], q[k], motion[k], adjoint[k], told[k], sparse)
        kind = told[:, path.KIND].astype(np.int64)
        return Paths(kind, told[:, 1], told[:, 2], told[:, 3], told[:, 4], q, motion, adjoint)

    def _loads(self, W: Float) -> Float:
        """(k, 6J) in the units of the model."""
        return np.ascontiguousarray((W.T * levers(self.assembly)) / force_unit(self.assembly, self.wrench))

    def _bounded(self, W: Float, paths: Paths) -> tuple[Float, Float]:
        """Factors, and the same less what a finer grid of nodes and a finer path would take away."""
        finite = paths.kind == path.PEAK
        change = np.zeros(len(finite))
        shown = np.flatnonzero(finite)
        path.missed(
            self._fine,
            self._loads(W[:, shown]),
            paths.peak[shown],
            paths.q[shown],
            paths.adjoint[shown],
            change[: len(shown)],
        )
        factor = np.where(finite, paths.peak, np.where(paths.kind == path.ENDLESS, np.inf, 0.0))
        estimate = np.zeros(len(finite))
        estimate[shown] = SAFETY * np.abs(change[: len(shown)]) + FLOOR * paths.peak[shown]
        return factor, np.maximum(factor - estimate, 0.0)

    @cached_property
    def _fine(self) -> Elastic:
        """The model on a grid that is finer by ``FINER`` each way."""
        nodes = contact_nodes(self.assembly, (FINER * self.engine.nodes) ** 2, "quadrature")
        engine = self.engine
        return elastic_model(self.assembly, nodes, self.wrench, engine.stiffness_ratio, engine.stiffness)

    def mechanisms(self, motions: Float) -> list[Mechanism]:
        """The mechanisms of motions (k, 6J) in the units of the model."""
        found: list[Mechanism] = []
        gather = self._gather
        for first in range(0, len(motions), CHUNK):
            twists = motions[first : first + CHUNK] * levers(self.assembly)
            velocities = (gather @ twists.T).T.reshape(len(twists), len(self.nodes), 3)
            modes = modes_of(velocities, np.zeros(len(self.nodes)))
            found += [
                describe(self.assembly, self.nodes, t.reshape(-1, 6), mode, dual=False)
                for t, mode in zip(twists, modes, strict=True)
            ]
        return found

    @cached_property
    def _gather(self) -> sparse.csr_matrix:
        """Gᵀ (3I, 6J): twists to relative velocities at the nodes."""
        return sparse.csr_matrix(equilibrium_operator(self.assembly, self.nodes).T)
