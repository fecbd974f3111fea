"""Answers for solved loads, each with bounds that are proved from what the solver found, and not by what it claims.

The cone program of limit analysis is set up once and then solved for many loads (``LoadProgram``).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float
from holdfast.base.entries import Entries, together
from holdfast.base.progress import answers_in_parallel, free_threads, reported
from holdfast.conic.solve import ConeProgram, Outcome, Prepared
from holdfast.engines.forces import FrictionCone, size_of
from holdfast.engines.limit.balance import Equilibrium, Scales, usual_forces
from holdfast.engines.limit.carrying_proof import CarryingProof, Mixture
from holdfast.engines.limit.repair import MotionRepair
from holdfast.engines.rest import Rest
from holdfast.engines.verdict import Status

# Tolerance of the duality gap and of feasibility, in the units of ``Scales``: what is found is proved afterwards, and
# the closer it balances the more of it
TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class SolvedLoad:
    """What the solver found for one load: ``forces`` (3I,) [N], the ``factor`` of the load, and the ``motion`` (6J,).

    ``residual`` is the largest error of equations and cones, in the units of ``Scales``. If the outcome is UNBOUNDED,
    forces and factor are a ray: contact forces that balance the load alone, ``factor`` times.
    """

    outcome: Outcome
    forces: Float
    factor: float
    motion: Float
    residual: float


@dataclass(frozen=True, eq=False)
class LoadProgram:
    """The program max s  s.t.  G f + ``wrench`` + s w = 0, f in the friction cones of ``nodes``, for any load w.

    ``wrench`` (6J,) is in [N, N m], and ``tolerance`` that of the solver. The object is safe for several threads: each
    call uses a solver of its own, an idle one or a new one. A solution depends on its load alone, to the last digit,
    and not on the loads that the solver had before.
    """

    equilibrium: Equilibrium
    nodes: ContactNodes
    wrench: Float
    cone: FrictionCone
    tau: Float
    tolerance: float = TOLERANCE
    _idle: deque[Prepared] = field(default_factory=deque, init=False, repr=False)

    @cached_property
    def scales(self) -> Scales:
        """The units of the program; no force and no equation is without one."""
        found = Scales.of(self.equilibrium, self.nodes.mu, self.tau)
        force = np.where(found.force > 0, found.force, np.repeat(self.tau, 3))
        return Scales(force, np.where(found.motion > 0, found.motion, 1 / self.tau.max(initial=1e-300)))

    @cached_property
    def cone_program(self) -> ConeProgram:
        """The cone program in the variables (f, s). The last column of A holds the load in all equilibrium rows."""
        force, motion = self.scales.force, self.scales.motion
        rows, count = len(motion), len(force) + 1
        C, cones = self.cone.entries(self.nodes)
        held, mu = size_of(cones), self.nodes.mu
        owner = np.zeros(held, dtype=np.int64)
        owner[C.rows] = C.columns // 3  # all entries of a row belong to one node
        unit = (np.where(mu > 0, np.minimum(mu, 1.0), 1.0) * self.tau)[owner]
        balance = Entries.of(self.equilibrium.G).scaled(motion, force)
        friction = C.stored.scaled(1 / unit, force).below(rows)
        load = Entries(np.arange(rows), np.full(rows, count - 1), np.ones(rows))
        A = together(balance, friction, load).matrix((rows + held, count))
        b = np.concatenate([-motion * self.wrench, np.zeros(held)])
        q = np.append(np.zeros(count - 1), -1.0)
        return ConeProgram(sparse.csc_matrix((count, count)), q, A, b, (("zero", rows), *cones))

    def usual_factor(self, load: Float) -> float:
        """Return the factor at which a load (6J,) is as large as usual forces."""
        return 1 / float(np.abs(self.scales.motion * load).max())

    def maximise(self, load: Float, around: float | None = None) -> SolvedLoad:
        """Solve the program for one ``load`` (6J,) [N, N m], which must not be zero.

        The factor is found to a share of that at which the load is as large as usual forces, or of ``around``.
        """
        size = 1 / (self.usual_factor(load) if around is None else around)
        try:
            prepared = self._idle.pop()
        except IndexError:
            prepared = Prepared(self.cone_program, tolerance=self.tolerance)
        last = np.arange(self.cone_program.A.nnz)[-len(load) :]  # a load is in the last column of A
        prepared.change(last, self.scales.motion * load / size)
        solution = prepared.solve()
        self._idle.append(prepared)
        forces, motion = self.scales.force * solution.x[:-1], self.scales.motion * solution.z[: len(load)]
        return SolvedLoad(solution.outcome, forces, float(solution.x[-1]) / size, motion, solution.residual)


@dataclass(frozen=True, eq=False)
class LoadLimit:
    """The largest ``factor`` of one load, with its bounds ``lower`` and ``upper``, its ``status`` and the evidence.

    Finite: the dual ``twists`` (6J,) of the movable bodies, scaled so that the load does work at unit power, and
    ``proof`` (6J,), the same motion mended (repair.py) so that it proves ``upper`` and a cutting plane for all other
    loads. Where it cannot be mended, ``proof`` is None and ``upper`` infinite. Infinite: the ``ray`` (I, 3) [N], world
    axes: forces on each node's second body that balance the load alone, so that any multiple of it is carried.
    ``certain`` says whether ``lower`` is proved. ``slope`` (6J,): where the ray is proved with room to spare, any
    multiple of the load and of a wrench w with the sum of slope |w| <= 1 is carried together.
    """

    factor: float
    lower: float
    upper: float
    status: Status
    twists: Float | None
    proof: Float | None = None
    ray: Float | None = None
    certain: bool = False
    slope: Float | None = None


MARGIN = 1e-7  # share of an estimated bound by which it is moved outwards, for the error of the solver
ACCEPTED = 1e-6  # largest residual of a solution that counts as an answer, in the units of the program
WIDE = 1e-6  # relative distance of two bounds above which a load is solved again, if that may help
SMALL = 0.1  # factors that are smaller than usual ones by this are found less accurately
CLOSE = 1e-3  # relative distance of two proved bounds that are an answer whatever the residual
LEAST_LOADS = 4  # for each thread: a solver of its own must be worth setting up
FEWEST_NODES = 20  # of a program whose loads threads share: smaller ones are solved in less time than threads wait
SUPPORTED = 1e-5  # largest relative error of a ray that counts as contact forces that balance the load alone

SOLVED = (Outcome.SOLVED, Outcome.ALMOST_SOLVED)


@dataclass(frozen=True, eq=False)
class LoadProofs:
    """Bounds for loads on one assembly under ``wrench`` (6J,), whose contact nodes and forces at rest are ``rest``."""

    assembly: Assembly
    rest: Rest
    wrench: Float
    cone: FrictionCone

    def limits(self, loads: Float) -> list[LoadLimit]:
        """Return the answers for the loads (6J, k), each by a solve of its own; all are proved together."""
        loaded = np.flatnonzero((loads != 0).any(0))
        found = self.judged(self._solutions(loads[:, loaded]), loads[:, loaded])
        answers = [LoadLimit(np.inf, np.inf, np.inf, Status.INFINITE, None, certain=True)] * loads.shape[1]
        for k, answer in zip(loaded, found, strict=True):
            wide = answer.upper - answer.lower > WIDE * answer.upper
            answers[k] = self._better_of_two(answer, loads[:, k]) if wide else answer
        return answers

    def _solutions(self, loads: Float) -> list[SolvedLoad]:
        """What the solver finds for each of the loads (6J, k); many are shared among threads."""
        count = loads.shape[1]
        threads = min(free_threads(), count // LEAST_LOADS)
        if threads < 2 or len(self.rest.nodes) < FEWEST_NODES:
            return [self.program.maximise(loads[:, k]) for k in reported("loads", range(count))]
        return answers_in_parallel("loads", lambda k: self.program.maximise(loads[:, k]), threads, count, count)

    def _better_of_two(self, answer: LoadLimit, load: Float) -> LoadLimit:
        """The answer with the better of its bounds and those of another solve, in units of its factor."""
        usual = self.program.usual_factor(load)
        if answer.status is not Status.FINITE or not 0 < answer.factor < SMALL * usual:
            return answer
        other = self.judged([self.program.maximise(load, answer.factor)], load[:, None])[0]
        if other.status is not Status.FINITE or not other.upper - other.lower < answer.upper - answer.lower:
            return answer
        return other

    def judged(self, solved: Sequence[SolvedLoad], loads: Float) -> list[LoadLimit]:
        """Return the answers for the loads (6J, k) from what the solver found for each of them."""
        answers = [UNKNOWN] * len(solved)
        finite = []
        for k, found in enumerate(solved):
            if found.outcome is Outcome.UNBOUNDED:
                answers[k] = self._endless(found, loads[:, k])
            elif found.outcome in (*SOLVED, Outcome.LIMIT, Outcome.TROUBLE):
                finite.append(k)
        if finite:
            bounded = self._bounded([solved[k] for k in finite], loads[:, finite])
            for k, answer in zip(finite, bounded, strict=True):
                answers[k] = answer
        return answers

    def carried(self, forces: Float, loads: Float) -> Float:
        """Return the factors (k,), up to about 1, at which ``forces`` (3I, k) [N] prove that loads (6J, k) are carried.

        ``forces`` are what a solver found to balance each load at the factor 1. They may be wrong, so less than 1 may
        be proved, and 0 where nothing is.
        """
        return self.carrying.lower(forces, np.ones(loads.shape[1]), loads)

    @cached_property
    def slope(self) -> Float:
        """For any wrench w, 1/R(w) is at most the sum of ``slope`` (6J,) times |w|; 0 where that is not known.

        The interior forces at rest change by less than their room if the wrench is small.
        """
        reference = self.carrying.reference
        return np.zeros(len(self.wrench)) if reference is None else reference.slope

    @property
    def certain(self) -> bool:
        """Whether anything can be proved to be carried: forces inside all friction cones are known."""
        return self.carrying.reference is not None

    @property
    def loose(self) -> Bool:
        """Which bodies (J,) are only balanced, to within rounding; ``lower`` is proved as if they stayed so."""
        reference = self.carrying.reference
        return np.zeros(len(self.wrench) // 6, dtype=bool) if reference is None else reference.balance.loose

    @property
    def resting(self) -> Float | None:
        """Contact forces (3I,) [N] inside all cones that balance the wrench up to rounding, if any are proved."""
        return None if self.carrying.reference is None else self.carrying.reference.forces

    def mixtures(self, load: Float) -> Iterator[tuple[Mixture, Mixture, float]]:
        """Yield what proves that a load (6J,) is carried up to its ``lower``; see ``CarryingProof.mixtures``."""
        solved = self.program.maximise(load)
        if solved.outcome in SOLVED and np.isfinite(solved.forces).all() and solved.factor > 0:
            yield from self.carrying.mixtures(solved.forces, solved.factor, load)

    def _bounded(self, solved: Sequence[SolvedLoad], loads: Float) -> list[LoadLimit]:
        """Bounds from both sides: forces that are brought into balance, and motions brought into the dual cone."""
        forces, motions = np.column_stack([s.forces for s in solved]), np.column_stack([s.motion for s in solved])
        with np.errstate(all="ignore"):
            power = (motions * loads).sum(0)
            twists = motions / power
            primal = np.maximum([s.factor for s in solved], 0.0)
            dual = np.maximum(-(self.wrench @ twists), 0.0)
            estimate = np.maximum(np.minimum(primal, dual) - MARGIN * np.maximum(primal, dual), 0.0)
        lower = self.carrying.lower(forces, primal, loads)
        upper, proofs = self.repair.upper(twists, loads)
        certain = self.certain
        lower = lower if certain else np.where(np.isfinite(estimate), np.minimum(estimate, upper), 0.0)
        known = np.isfinite(primal) & (power > 0) & np.isfinite(twists).all(0)
        accepted = [s.outcome in SOLVED and s.residual <= ACCEPTED for s in solved]
        known &= (upper - lower <= CLOSE * upper) | np.array(accepted)
        factor = np.clip(primal, lower, upper)
        return [
            LoadLimit(
                float(factor[k]),
                float(lower[k]),
                float(upper[k]),
                Status.FINITE,
                twists[:, k],
                proofs[:, k] if np.isfinite(upper[k]) else None,
                certain=certain,
            )
            if known[k]
            else UNKNOWN
            for k in range(len(solved))
        ]

    def _endless(self, found: SolvedLoad, load: Float) -> LoadLimit:
        """The answer of a ray, that is of contact forces that balance the load alone, if they do."""
        if not found.factor > 0 or not np.isfinite(found.forces).all():
            return UNKNOWN
        ray = found.forces / found.factor
        certain = self.certain
        lower, slope = self.carrying.endless(ray, load) if certain else (np.inf, None)
        if not (certain and lower == np.inf) and not self._supports(ray, load):
            return UNKNOWN
        world = self.rest.nodes.world(ray.reshape(-1, 3))
        return LoadLimit(np.inf, lower, np.inf, Status.INFINITE, None, ray=world, certain=certain, slope=slope)

    def _supports(self, ray: Float, load: Float) -> bool:
        """Whether forces (3I,) about balance the load and about lie in the cones."""
        scales = self.program.scales
        left = float(np.abs(scales.motion * (self.equilibrium.G @ ray + load)).max())
        room = self.cone.room(self.rest.nodes.mu, ray.reshape(-1, 1, 3))[:, 0] / scales.force[::3]
        sliding = np.where(self.rest.nodes.mu[:, None] == 0, ray.reshape(-1, 3)[:, 1:] / scales.force[::3, None], 0.0)
        largest = max(float(np.abs(ray / scales.force).max(initial=0)), float(np.abs(scales.motion * load).max()))
        return max(left, float(-room.min(initial=0)), float(np.abs(sliding).max(initial=0))) <= SUPPORTED * largest

    @cached_property
    def program(self) -> LoadProgram:
        """The program, set up once for all loads."""
        return LoadProgram(self.equilibrium, self.rest.nodes, self.wrench, self.cone, self._usual_forces)

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """The equilibrium operator of the nodes at rest, with bounds of rounding."""
        return Equilibrium.of(self.assembly, self.rest.nodes)

    @cached_property
    def _usual_forces(self) -> Float:
        return usual_forces(self.assembly, self.rest)

    @cached_property
    def carrying(self) -> CarryingProof:
        """What proves that loads are carried."""
        resting = self.rest.forces.ravel()
        return CarryingProof(self.equilibrium, self.cone, self.rest.nodes.mu, self.wrench, resting, self._usual_forces)

    @cached_property
    def repair(self) -> MotionRepair:
        """What proves that motions move bodies."""
        motion = self.program.scales.motion
        balance = self.carrying.balance
        return MotionRepair(
            self.equilibrium, self.rest.nodes, self.cone, self.wrench, self._usual_forces, motion, balance
        )


UNKNOWN = LoadLimit(0.0, 0.0, np.inf, Status.UNDECIDED, None, certain=True)
