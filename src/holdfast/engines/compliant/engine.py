"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
from holdfast.engines.compliant.verdict import judged, settled
from holdfast.engines.contract import Capacity, Claim, Mechanism, Status, Verdict, no_capacity
from holdfast.engines.mechanism import describe, modes_of
from holdfast.engines.rest import find_rest
from holdfast.errors import HoldfastError, message

DENSE = 150  # unknowns up to which dense elimination in compiled code is faster than sparse LU
FEWEST = 2  # nodes along a side
FINER = 2  # times as many nodes along a side for the discretisation estimate
SAFETY = 2.0  # errors fall at least in proportion to the nodes' distance
FLOOR = 2e-3  # relative: what it is at least
LARGE = 0.05  # a relative change above which the path on the finer nodes is followed as a whole
ACCURACY = 2e-4  # relative, of a peak found by verdicts
ROUGH = 5e-3  # the same where verdicts close to the peak were not to be had
MOST_VERDICTS = 40
CHUNK = 64  # motions described at a time


@dataclass(frozen=True)
class Compliant:
    """Elastic contacts without adhesion, Coulomb friction without dilatancy: what comes to rest, and up to which load.

    ``nodes`` along each side of a square patch (others have as many in all); ``stiffness_ratio`` tangential over normal
    stiffness; ``stiffness`` [N/m³] per area: None or a number for equal contacts (it drops out), or one for each pair
    of names, where pairs that are not named have 1.
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
        return self.on(assembly, wrench if standing is None else wrench + standing)

    def on(self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None) -> CompliantState:
        """The state under ``wrench`` (6J,), on ``nodes`` of one's own choice if given."""
        if nodes is None:
            nodes = contact_nodes(assembly, self.nodes**2, "quadrature")
        if not assembly.movable or assembly.hanging:
            verdict = find_rest(assembly, wrench).verdict
            return CompliantState(self, assembly, wrench, nodes, None, verdict)
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
    """The load paths of k columns.

    ``kind`` (k,), ``peak`` (k,) of s, ``last`` s (residual strength), how far the peak may be above (``short``), the
    linear systems solved (``solves``); q at the peak, ``motion`` at the end, ``plane`` across which the peak was found
    (k, 6J).
    """

    kind: Int
    peak: Float
    last: Float
    short: Float
    solves: Float
    q: Float
    motion: Float
    plane: Float


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
            self._by_verdicts(W[:, loaded], paths)
            peak, below = self._bounded(W[:, loaded], paths)
            kinds = {path.PEAK: Status.FINITE, path.ENDLESS: Status.INFINITE, path.LOST: Status.UNDECIDED}
            factor[loaded], lower[loaded] = peak, below
            finite = np.flatnonzero(paths.kind == path.PEAK)
            mechanisms = self.mechanisms(paths.motion[finite])
            for k, mechanism in zip(finite.tolist(), mechanisms, strict=True):
                told[loaded[k]] = mechanism
            for k, column in enumerate(loaded.tolist()):
                status[column] = kinds[int(paths.kind[k])]
        return Capacity.told(factor, lower, upper, status, told)

    def paths(self, W: Float) -> Paths:
        """Follow the load paths of columns W (6J, k), none of them zero."""
        shape = (W.shape[1], len(self.wrench))
        q, motion, plane, told = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros((shape[0], 8))
        if self.system is not None and self.start is not None:
            m, work, sparse = self.system.model, self.system.work, self.system.sparse
            loads = self._loads(W)
            if sparse is None:
                path.follow_dense(m, work, self.start, loads, q, motion, plane, told)
            else:
                for k in range(shape[0]):
                    path.follow(m, work, self.start, loads[k], q[k], motion[k], plane[k], told[k], sparse)
        kind = told[:, path.KIND].astype(np.int64)
        return Paths(kind, told[:, 1], told[:, 2], told[:, 3], told[:, 4], q, motion, plane)

    def _by_verdicts(self, W: Float, paths: Paths) -> None:
        """Where a path was lost, close in on its peak by whether the assembly comes to rest under weight and load.

        From the highest load that the path did reach, upwards; the answer is entered in ``paths`` if it moves above.
        """
        if self.system is None or self.start is None:
            return
        model, work, sparse = self.system.model, self.system.work, self.system.sparse
        loads = self._loads(W)
        for k in np.flatnonzero(paths.kind == path.LOST).tolist():
            held, step, moves = float(paths.peak[k]), 1e-4, np.inf
            for _ in range(MOST_VERDICTS):
                s = (held + moves) / 2 if np.isfinite(moves) else held * (1 + step)
                if not held > 0 or (np.isinf(moves) and step > 1) or moves - held <= ACCURACY * held:
                    break
                end = settled(model._replace(wrench=model.wrench + s * loads[k]), work, sparse)
                if end.how == rest.REST:
                    held = s
                elif end.how == rest.DRIFT:
                    moves = s
                    paths.motion[k] = end.drift
                elif np.isfinite(moves):
                    break
                step *= 4
            if held > 0 and moves - held <= ROUGH * held:
                paths.kind[k], paths.peak[k], paths.short[k] = path.PEAK, held, moves - held

    def _loads(self, W: Float) -> Float:
        """(k, 6J) in the units of the model."""
        return np.ascontiguousarray((W.T * levers(self.assembly)) / force_unit(self.assembly, self.wrench))

    def _bounded(self, W: Float, paths: Paths) -> tuple[Float, Float]:
        """Factors, and the same less the discretisation estimate.

        The estimate is SAFETY times the change of the load when the displacement of the peak is taken up by FINER times
        as many nodes each way, and at least FLOOR. Where that is not found, or comes out large, the whole path is
        followed on those nodes; where that fails too, the lower bound is 0.
        """
        peaked = np.flatnonzero(paths.kind == path.PEAK)
        factor = np.where(paths.kind == path.ENDLESS, np.inf, 0.0)
        factor[peaked] = paths.peak[peaked]
        finer = self._at_peaks(self._loads(W[:, peaked]), factor[peaked], paths.q[peaked], paths.plane[peaked])
        unsure = np.flatnonzero((finer < 0) | (np.abs(finer - factor[peaked]) > LARGE * factor[peaked]))
        if len(unsure):
            again = self._fine.paths(W[:, peaked[unsure]])
            whole = np.where(again.kind == path.PEAK, again.peak, np.where(again.kind == path.ENDLESS, np.inf, -1.0))
            finer[unsure] = whole
        known = np.maximum(finer, 0.0)
        fall = np.where(
            known < factor[peaked], factor[peaked] - known, np.minimum(known, 2 * factor[peaked]) - factor[peaked]
        )
        estimate = SAFETY * fall + FLOOR * factor[peaked]
        lower = factor.copy()
        lower[peaked] = np.maximum(factor[peaked] - estimate, 0.0)
        return factor, lower

    def _at_peaks(self, loads: Float, s: Float, q: Float, plane: Float) -> Float:
        """The loads (k,) at the displacements of peaks (s, q) on the finer nodes, -1 where not found."""
        found = np.full(len(s), -1.0)
        system = self._fine.system
        if system is not None and system.sparse is None:
            path.again_dense(system.model, system.work, loads, s, q, plane, found)
        elif system is not None:
            for k in range(len(s)):
                found[k] = path.again(system.model, system.work, loads[k], s[k], q[k], plane[k], system.sparse)
        return found

    @cached_property
    def _fine(self) -> CompliantState:
        """The same on more nodes."""
        engine = replace(self.engine, nodes=FINER * self.engine.nodes)
        return engine.on(self.assembly, self.wrench)

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
