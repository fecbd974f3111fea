"""Solution of cone programs with Clarabel. The residual of every solution is computed from the original data."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal, NamedTuple

import clarabel
import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float, Int
from holdfast.base.progress import left_if_stopped

ConeKind = Literal["zero", "nonnegative", "second_order"]


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """The cone program: minimise ½ xᵀP x + qᵀx  subject to  A x + s = b,  s in the product of ``cones``.

    P (n, n) is symmetric, q is (n,), A is (m, n) and b is (m,). Each cone is a pair (kind, dimension), in the order of
    the rows of A.
    """

    P: sparse.csc_matrix
    q: Float
    A: sparse.csc_matrix
    b: Float
    cones: tuple[tuple[ConeKind, int], ...]


LARGEST = 1e100  # numbers up to this can be squared and multiplied by data without overflow
LONG = 20_000  # with more entries in A a solve may take over 0.1 s, so Ctrl-C does not wait for it


class Outcome(Enum):
    """The way in which a solve ended. The value of each member says what it means."""

    SOLVED = "solved to full accuracy"
    ALMOST_SOLVED = "solved to reduced accuracy: check the residual"
    INFEASIBLE = "no feasible point, proved by a dual certificate"
    UNBOUNDED = "the objective falls without bound, proved by a ray"
    LIMIT = "stopped at the iteration or time limit: no answer"
    TROUBLE = "numerical trouble in the solver: no answer"


_OUTCOMES = {
    "Solved": Outcome.SOLVED,
    "AlmostSolved": Outcome.ALMOST_SOLVED,
    "PrimalInfeasible": Outcome.INFEASIBLE,
    "AlmostPrimalInfeasible": Outcome.INFEASIBLE,
    "DualInfeasible": Outcome.UNBOUNDED,
    "AlmostDualInfeasible": Outcome.UNBOUNDED,
    "MaxIterations": Outcome.LIMIT,
    "MaxTime": Outcome.LIMIT,
}


@dataclass(frozen=True, eq=False)
class ConeSolution:
    """The solution of a cone program: the primal x (n,) and the dual z (m,).

    ``residual`` is the largest violation of the cones by b - A x, which the caller has to judge. If the outcome is
    INFEASIBLE, z is the certificate: Aᵀz = 0, bᵀz < 0 and z in the dual cones. If it is UNBOUNDED, x is the ray.
    """

    outcome: Outcome
    x: Float
    z: Float
    residual: float
    iterations: int


class Prepared:
    """A program that is set up once in the solver and solved several times.

    Between solves, the stored entries of A and the linear cost q may be changed; the sparsity pattern of A stays.
    """

    def __init__(self, program: ConeProgram, *, tolerance: float = 1e-10, max_iterations: int = 200) -> None:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_iter = max_iterations
        settings.max_threads = 1  # with one thread, the summation order and the last digits are the same in every run
        settings.presolve_enable = False  # the solver accepts new entries only without presolve
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        cones = [_CONES[kind](size) for kind, size in program.cones]
        self._program = program
        self._changed = False
        self._rows = _StoredEntries.of(program)
        self._long = self._program.A.nnz > LONG
        P = program.P
        if (P.indices > np.repeat(np.arange(P.shape[1]), np.diff(P.indptr))).any():
            P = sparse.triu(P, format="csc")
        self._solver = clarabel.DefaultSolver(P, program.q, self._program.A, program.b, cones, settings)

    def change(self, entries: Int, values: Float) -> None:
        """Set stored entries of A to ``values`` (k,); ``entries`` (k,) are their positions in ``A.data``."""
        if not self._changed:  # do not change the caller's program
            self._program, self._changed = replace(self._program, A=self._program.A.copy()), True
        self._program.A.data[entries] = values
        self._solver.update(A=(entries, values))

    def aim(self, q: Float) -> None:
        """Set the linear cost q (n,)."""
        self._solver.update(q=q)

    def solve(self) -> ConeSolution:
        """Solve the program with its current entries."""
        answer = left_if_stopped(self._solver.solve) if self._long else self._solver.solve()
        outcome = _OUTCOMES.get(str(answer.status), Outcome.TROUBLE)
        x, z = np.array(answer.x), np.array(answer.z)
        if outcome is not Outcome.SOLVED:
            x, z = _within_numbers(x), _within_numbers(z)
        return ConeSolution(outcome, x, z, violation(self._program, x, self._rows), int(answer.iterations))


def solve(program: ConeProgram, *, tolerance: float = 1e-10, max_iterations: int = 200) -> ConeSolution:
    """Solve ``program`` once.

    ``tolerance`` is that of the duality gap and of feasibility, both relative and absolute, so the data should be
    scaled to order one.
    """
    return Prepared(program, tolerance=tolerance, max_iterations=max_iterations).solve()


def _within_numbers(values: Float) -> Float:
    """Return ``values``, scaled down to LARGEST if they are larger; the length of a certificate does not matter."""
    largest = float(np.abs(values).max(initial=0.0))
    return values * (LARGEST / largest) if LARGEST < largest < np.inf else values


_CONES = {
    "zero": clarabel.ZeroConeT,
    "nonnegative": clarabel.NonnegativeConeT,
    "second_order": clarabel.SecondOrderConeT,
}


class _StoredEntries(NamedTuple):
    """The positions (nnz,) of the entries of A and the runs of cones, to check solutions while the entries change."""

    rows: Int
    columns: Int
    runs: list[tuple[str, int, int]]

    @classmethod
    def of(cls, program: ConeProgram) -> _StoredEntries:
        A = program.A
        columns = np.repeat(np.arange(A.shape[1]), np.diff(A.indptr))
        return cls(A.indices.astype(np.int64), columns, cone_runs(program))


def violation(program: ConeProgram, x: Float, known: _StoredEntries | None = None) -> float:
    """Return the largest violation of the cones by b - A x.

    ``known`` can pass ``_StoredEntries.of(program)``, to avoid computing it again.
    """
    if not np.abs(x).max(initial=0.0) <= LARGEST:  # the solver diverged, and products with x may overflow
        return np.inf
    places = _StoredEntries.of(program) if known is None else known
    # SciPy's product takes three times as long
    slack = program.b - np.bincount(places.rows, program.A.data * x[places.columns], len(program.b))
    worst, row = 0.0, 0
    for kind, size, count in places.runs:
        block = slack[row : row + size * count]
        row += size * count
        if not len(block):
            continue
        if kind == "zero":
            worst = max(worst, float(block.max()), float(-block.min()))
        elif kind == "nonnegative":
            worst = max(worst, float(-block.min()))
        else:
            block = block.reshape(count, size)
            length = np.hypot(block[:, 1], block[:, 2]) if size == 3 else np.sqrt((block[:, 1:] ** 2).sum(1))
            worst = max(worst, float((length - block[:, 0]).max()))
    return worst


def cone_runs(program: ConeProgram) -> list[tuple[str, int, int]]:
    """Return the runs of consecutive cones of the same kind and size, as (kind, size, number of cones)."""
    runs: list[tuple[str, int, int]] = []
    for kind, size in program.cones:
        if runs and runs[-1][:2] == (kind, size):
            runs[-1] = (kind, size, runs[-1][2] + 1)
        else:
            runs.append((kind, size, 1))
    return runs
