"""The cone program of limit analysis, which is set up once and then solved for many loads."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.base.entries import Entries, together
from holdfast.conic.solve import ConeProgram, Outcome, Prepared
from holdfast.engines.cones import FrictionCone, size_of
from holdfast.engines.limit.rounding import Equilibrium, Scales

# Tolerance of the duality gap and of feasibility, in the units of ``Scales``: what is found is proved afterwards, and
# the closer it balances the more of it
TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Solved:
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

    def maximise(self, load: Float, around: float | None = None) -> Solved:
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
        return Solved(solution.outcome, forces, float(solution.x[-1]) / size, motion, solution.residual)
