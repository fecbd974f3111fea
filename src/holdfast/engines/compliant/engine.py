"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.base.arrays import Bool, Float, Int, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.elastic import path
from holdfast.elastic import resting as rest
from holdfast.elastic.law import Elastic
from holdfast.elastic.linear import SparseSolver, Work, make_work
from holdfast.engines.answers import Answers, Bound, Claim
from holdfast.engines.compliant.interpolated import UNKNOWN, survey
from holdfast.engines.compliant.model import Stiffness, elastic_model, force_unit, levers
from holdfast.engines.compliant.verdict import judged, settled
from holdfast.engines.contract import EXACT, Accuracy, ForcesOnly, Within
from holdfast.engines.mechanism import Kinematics, Mechanism, describe, modes_of
from holdfast.engines.rest import find_rest
from holdfast.engines.verdict import Status, Verdict

DENSE = 150  # unknowns up to which dense elimination in compiled code is faster than sparse LU
FEWEST = 2  # nodes along a side
FINER = 2  # times as many nodes along a side for the discretisation estimate
SAFETY = 2.0  # errors fall at least in proportion to the nodes' distance
FLOOR = 2e-3  # relative: what it is at least
LARGE = 0.05  # a relative change above which the path on the finer nodes is followed as a whole
COARSE = 0.02  # one of the whole path above which the answer is that of the finer nodes
REFINEMENTS = 3  # times that nodes are made finer, at most
MOST_NODES = 20_000  # of all contacts together, up to which they are
COLUMNS = 8  # a thread, at least
ACCURACY = 2e-4  # relative, of a peak found by verdicts
ROUGH = 5e-3  # the same where verdicts close to the peak were not to be had
MOST_VERDICTS = 40
MOST_UNDECIDED = 8  # of them, each of which takes long
MOST_ABOVE = 10.0  # times the load that a path reached, up to which a load is sought under which the bodies move
WHERE = (0.5, 0.25, 0.75, 0.1, 0.9)  # between a load that holds and one that moves, tried in turn
CHUNK = 64  # motions described at a time
MANY = 40  # columns on one body from which on it pays to interpolate
KINDS = {path.PEAK: Status.FINITE, path.ENDLESS: Status.INFINITE, path.LOST: Status.UNDECIDED}


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
        wrench = wrench if standing is None else wrench + standing
        return replace(self.on(assembly, wrench), refinements=REFINEMENTS)

    def on(self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None) -> CompliantState:
        """The state under ``wrench`` (6J,), on ``nodes`` of one's own choice if given; they are not made finer."""
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

    def in_threads(self, count: int, run: Callable[[slice, Work], None]) -> None:
        """Run over slices of ``count`` columns, each in a thread with room of its own: compiled loops hold no lock."""
        threads = min(os.cpu_count() or 1, count // COLUMNS)
        if threads < 2:
            run(slice(0, count), self.work)
            return
        ends = np.linspace(0, count, threads + 1).astype(int).tolist()
        parts = [slice(a, b) for a, b in pairwise(ends)]
        with ThreadPoolExecutor(threads) as pool:
            rooms = [make_work(self.model, dense=True) for _ in parts]
            list(pool.map(run, parts, rooms))  # raises what a thread raised


@dataclass(frozen=True, eq=False)
class Paths:
    """The load paths of k columns.

    ``kind`` (k,), ``peak`` (k,) of s, ``last`` s (residual strength), how far the peak may be above (``short``), the
    linear systems solved (``solves``); ``below`` (k,) the peak less the discretisation estimate, 0 until it is known; q
    at the peak, ``motion`` at the end, ``plane`` across which the peak was found (k, 6J); ``cut`` (k, 6J), or (k, 0) if
    not wanted: peak / peak' = cut · load' [load in W's units] to first order.
    """

    kind: Int
    peak: Float
    last: Float
    short: Float
    solves: Float
    below: Float
    q: Float
    motion: Float
    plane: Float
    cut: Float

    @property
    def factor(self) -> Float:
        """The peak, inf where the path is endless, 0 where it was lost."""
        return np.where(self.kind == path.PEAK, self.peak, np.where(self.kind == path.ENDLESS, np.inf, 0.0))

    @property
    def lower(self) -> Float:
        """``below``, inf where the path is endless."""
        return np.where(self.kind == path.ENDLESS, np.inf, self.below)

    def chosen(self, keep: Bool) -> Paths:
        """Copies of some of them."""
        return Paths(*(getattr(self, f.name)[keep] for f in fields(Paths)))

    def enter(self, at: Int, others: Paths) -> None:
        """Put ``others`` in the places ``at``."""
        for f in fields(Paths):
            getattr(self, f.name)[at] = getattr(others, f.name)


def _joined(parts: list[Paths]) -> Paths:
    """All paths, in the order of the parts."""
    return Paths(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Paths)))


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of k columns: ``kind`` of path.py, factors and their lower bounds, and as in Answers."""

    kind: Int
    factor: Float
    lower: Float
    mechanisms: list[Mechanism | None]
    solved: Bool
    error: Float


@dataclass(frozen=True, eq=False)
class CompliantState:
    """Engine ``compliant`` with the assembly at rest: from ``start`` (6J,) every load path begins.

    Where nodes are too coarse for an answer it is taken from finer ones, ``refinements`` times at most.
    """

    engine: Compliant
    assembly: Assembly
    wrench: Float
    nodes: ContactNodes
    system: System | None
    rest: Verdict
    start: Float | None = None
    refinements: int = 0

    def verdict(self) -> Verdict:
        """Whether the assembly comes to rest."""
        return self.rest

    @property
    def notes(self) -> tuple[str, ...]:
        """None: what the answers rest on is their claim."""
        return ()

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """For each column of W (6J, n) the peak of its load path; ``lower`` is that less the discretisation estimate.

        ``Within`` a gap MANY columns on one body are interpolated between paths (interpolated.py) with expected errors
        of at most that: ``lower`` then also lies below what the stated error allows.
        With ``ForcesOnly`` ``lower`` is 0, and no finer nodes are needed.
        """
        count, bounds = W.shape[1], not isinstance(accuracy, ForcesOnly)
        known: dict[str, Any] = {"engine": self.engine.name, "claim": self.engine.claim, "verdict": self.rest}
        known["lower_bound"] = Bound.ESTIMATED if bounds else Bound.NONE
        if self.rest.status is not Status.STABLE:
            return Answers.not_standing(count, **known)
        loaded = np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)
        factor, lower, upper = np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf)
        status = [Status.INFINITE] * count
        told: list[Mechanism | None] = [None] * count
        solved, error = np.ones(count, dtype=bool), np.zeros(count)
        if len(loaded):
            asked = W[:, loaded]
            bodies = np.flatnonzero((asked != 0).reshape(-1, 6, len(loaded)).any((1, 2)))
            if isinstance(accuracy, Within) and len(loaded) >= MANY and len(bodies) == 1:
                answers = self._surveyed(asked, 6 * int(bodies[0]), accuracy.gap)
            else:
                answers = self._each(asked, bounds=bounds)
            factor[loaded], lower[loaded] = answers.factor, answers.lower
            solved[loaded], error[loaded] = answers.solved, answers.error
            for k, column in enumerate(loaded.tolist()):
                told[column], status[column] = answers.mechanisms[k], KINDS[int(answers.kind[k])]
        known |= {"lower": lower, "upper": upper, "solved": solved, "error": error}
        return Answers.of(force=factor, status=status, mechanism=told, **known)

    def _each(self, W: Float, *, bounds: bool) -> Known:
        """Every column of W (6J, k) along its own path."""
        paths = self.answered(W, bounds=bounds)
        told = self._told(paths)
        solved, error = np.ones(len(told), dtype=bool), np.zeros(len(told))
        return Known(paths.kind, paths.factor, paths.lower, told, solved, error)

    def _told(self, paths: Paths) -> list[Mechanism | None]:
        """What gives way at the end of each path."""
        told: list[Mechanism | None] = [None] * len(paths.kind)
        finite = np.flatnonzero(paths.kind == path.PEAK)
        for k, mechanism in zip(finite.tolist(), self.mechanisms(paths.motion[finite]), strict=True):
            told[k] = mechanism
        return told

    def _surveyed(self, W: Float, first: int, gap: float) -> Known:
        """Columns W (6J, k) that load one body, at rows ``first`` to ``first + 6``: few paths, the rest between."""
        known: list[Paths] = []
        order: list[Int] = []

        told: list[Mechanism | None] = []
        numbers: dict[tuple[str, ...], int] = {}

        def follow(indices: Int) -> tuple[Int, Float, Float, Int]:
            paths = self.answered(W[:, indices], cuts=True)
            known.append(paths)
            order.append(indices)
            with np.errstate(divide="ignore"):
                value = np.where(paths.kind == path.PEAK, 1 / paths.peak, 0.0)
            fresh = self._told(paths)
            told.extend(fresh)
            motion = [-1 if m is None else numbers.setdefault((m.mode, *m.moving), len(numbers)) for m in fresh]
            return paths.kind, value, value[:, None] * paths.cut[:, first : first + 6], np.array(motion)

        found = survey(np.ascontiguousarray(W[first : first + 6].T), follow, gap)
        between = np.flatnonzero(found.kind == UNKNOWN)
        done = np.concatenate(order)
        place = np.zeros(W.shape[1], dtype=np.int64)
        place[done] = np.arange(len(done))
        paths = _joined(known)
        peak, below = paths.factor, paths.lower
        kind, factor, lower = paths.kind[place], peak[place], below[place]
        mechanisms = [told[k] for k in place]
        corner, nearest = place[found.corner[between]], np.argmax(found.share[between], axis=1)
        error, solved = np.zeros(len(place)), np.ones(len(place), dtype=bool)
        error[between], solved[between] = found.error[between], False
        kind[between] = path.PEAK
        factor[between] = 1 / found.value[between]
        with np.errstate(invalid="ignore"):  # what is infinite is no corner
            share = (below / peak)[corner].min(1)
        lower[between] = factor[between] * np.maximum(1 - error[between], 0.0) * share
        for k, column in enumerate(between.tolist()):
            mechanisms[column] = told[corner[k, nearest[k]]]
        return Known(kind, factor, lower, mechanisms, solved, error)

    def paths(self, W: Float, *, cuts: bool = False) -> Paths:
        """Follow the load paths of columns W (6J, k), none of them zero; ``cuts``: say how peaks answer to loads."""
        shape = (W.shape[1], len(self.wrench))
        cut = np.zeros(shape if cuts else (len(W.T), 0))
        q, motion, plane, told = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros((shape[0], 8))
        if self.system is not None and self.start is not None:
            m, work, sparse = self.system.model, self.system.work, self.system.sparse
            loads = self._loads(W)
            if sparse is None:

                def follow(part: slice, work: Work) -> None:
                    assert self.start is not None
                    into = q[part], motion[part], plane[part], cut[part], told[part]
                    path.follow_dense(m, work, self.start, loads[part], *into)

                self.system.in_threads(shape[0], follow)
            else:
                for k in range(shape[0]):
                    path.follow(m, work, self.start, loads[k], q[k], motion[k], plane[k], cut[k], told[k], sparse)
        kind = told[:, path.KIND].astype(np.int64)
        if cuts:
            cut *= levers(self.assembly) / force_unit(self.assembly, self.wrench)
        return Paths(kind, told[:, 1], told[:, 2], told[:, 3], told[:, 4], np.zeros(shape[0]), q, motion, plane, cut)

    def _by_verdicts(self, W: Float, paths: Paths) -> None:
        """Where a path was lost, close in on its peak by whether the assembly comes to rest under weight and load.

        From the highest load that the path did reach, upwards. The highest load that holds is entered in ``paths`` if
        under one hardly larger (ACCURACY, at most ROUGH) the bodies move: they drift, or there is no equilibrium.
        """
        if self.system is None or self.start is None:
            return
        model, work, sparse = self.system.model, self.system.work, self.system.sparse
        loads = self._loads(W)
        for k in np.flatnonzero(paths.kind == path.LOST).tolist():
            held, step, moves, passed, undecided = float(paths.peak[k]), 1e-4, np.inf, 0, 0
            for _ in range(MOST_VERDICTS):
                if not held > 0 or (np.isinf(moves) and step > MOST_ABOVE) or moves - held <= ACCURACY * held:
                    break
                if undecided == MOST_UNDECIDED:
                    break
                share = WHERE[passed % len(WHERE)]
                s = held + share * (moves - held) if np.isfinite(moves) else held * (1 + step)
                end = settled(model._replace(wrench=model.wrench + s * loads[k]), work, sparse, near=paths.q[k])
                passed = passed + 1 if end.how == rest.LOST else 0
                if end.how == rest.REST:
                    held = s
                    paths.q[k] = end.q
                elif end.how == rest.DRIFT:
                    moves = s
                    paths.motion[k] = end.drift
                elif find_rest(self.assembly, self.wrench + s * W[:, k]).verdict.status is Status.UNSTABLE:
                    moves, passed = s, 0  # no equilibrium at all
                else:
                    undecided += 1
                if np.isfinite(moves) and passed == (2 if moves - held <= ROUGH * held else len(WHERE)):
                    break
                step *= 4
            if held > 0 and moves - held <= ROUGH * held:
                paths.kind[k], paths.peak[k], paths.short[k] = path.PEAK, held, moves - held

    def _loads(self, W: Float) -> Float:
        """(k, 6J) in the units of the model."""
        return np.ascontiguousarray((W.T * levers(self.assembly)) / force_unit(self.assembly, self.wrench))

    def answered(self, W: Float, *, cuts: bool = False, bounds: bool = True) -> Paths:
        """Paths of columns W (6J, k), on nodes that are fine enough for each, with lower bounds; or without both."""
        paths = self.paths(W, cuts=cuts)
        self._by_verdicts(W, paths)
        if bounds:
            self._bound(W, paths, cuts=cuts)
        return paths

    def _bound(self, W: Float, paths: Paths, *, cuts: bool) -> None:
        """Enter ``below`` of paths: the peak less SAFETY times the discretisation estimate, and less FLOOR at least.

        The estimate is the change of the load when the displacement of the peak is taken up by FINER times as many
        nodes each way. Where it is not found or comes out large, it is the change of the whole path on those nodes (all
        of the peak where they find none); and where that is more than COARSE, their path is the answer, if they may.
        """
        peaked = np.flatnonzero(paths.kind == path.PEAK)
        peak = paths.peak[peaked]
        finer = self._at_peaks(self._loads(W[:, peaked]), peak, paths.q[peaked], paths.plane[peaked])
        unsure = np.flatnonzero((finer < 0) | (np.abs(finer - peak) > LARGE * peak))
        taken = np.zeros(len(peaked), dtype=bool)
        if len(unsure):
            asked = W[:, peaked[unsure]]
            again = self._fine.paths(asked, cuts=cuts)
            self._fine._by_verdicts(asked, again)
            finer[unsure] = again.factor
            if self._refines:
                coarse = (again.kind == path.PEAK) & (np.abs(again.peak - peak[unsure]) > COARSE * peak[unsure])
                better = again.chosen(coarse)
                self._fine._bound(asked[:, coarse], better, cuts=cuts)
                taken[unsure] = coarse
                paths.enter(peaked[taken], better)
        change = np.where(finer < peak, peak - finer, np.minimum(finer, 2 * peak) - peak)
        below = np.maximum(peak - SAFETY * change - FLOOR * peak, 0.0)
        paths.below[peaked[~taken]] = below[~taken]

    @property
    def _refines(self) -> bool:
        return self.refinements > 0 and FINER**2 * len(self.nodes) <= MOST_NODES

    def _at_peaks(self, loads: Float, s: Float, q: Float, plane: Float) -> Float:
        """The loads (k,) at the displacements of peaks (s, q) on the finer nodes, -1 where not found."""
        found = np.full(len(s), -1.0)
        system = self._fine.system
        if system is not None and system.sparse is None:

            def again(part: slice, work: Work) -> None:
                path.again_dense(system.model, work, loads[part], s[part], q[part], plane[part], found[part])

            system.in_threads(len(s), again)
        elif system is not None:
            for k in range(len(s)):
                found[k] = path.again(system.model, system.work, loads[k], s[k], q[k], plane[k], system.sparse)
        return found

    @cached_property
    def _fine(self) -> CompliantState:
        """The same on more nodes."""
        engine = replace(self.engine, nodes=FINER * self.engine.nodes)
        return replace(engine.on(self.assembly, self.wrench), refinements=self.refinements - 1)

    def mechanisms(self, motions: Float) -> list[Mechanism]:
        """The mechanisms of motions (k, 6J) in the units of the model."""
        found: list[Mechanism] = []
        gather = self._gather
        for first in range(0, len(motions), CHUNK):
            twists = motions[first : first + CHUNK] * levers(self.assembly)
            velocities = (gather @ twists.T).T.reshape(len(twists), len(self.nodes), 3)
            modes = modes_of(velocities, np.zeros(len(self.nodes)))
            found += [
                describe(self.kinematics, t.reshape(-1, 6), mode, dual=False)
                for t, mode in zip(twists, modes, strict=True)
            ]
        return found

    @cached_property
    def kinematics(self) -> Kinematics:
        """What all mechanisms of this state share."""
        return Kinematics.of(self.assembly, self.nodes)

    @cached_property
    def _gather(self) -> sparse.csr_matrix:
        """Gᵀ (3I, 6J): twists to relative velocities at the nodes."""
        return sparse.csr_matrix(equilibrium_operator(self.assembly, self.nodes).T)
