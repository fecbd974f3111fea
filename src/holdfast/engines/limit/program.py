"""The cone program of limit analysis, which is set up once and then solved for many loads."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import ConeSolution, Prepared
from holdfast.engines.cones import FrictionCone
from holdfast.engines.forces import force_program

TOLERANCE = 1e-9  # tolerance of the duality gap and of feasibility, in units of the total weight


@dataclass(frozen=True, eq=False)
class LoadProgram:
    """The program max s  s.t.  G f + ``wrench`` + s w = 0, f in the friction cones of ``nodes``, for any load w.

    ``wrench`` (6J,) is in [N, N m]. In the program, forces are in units of the total weight, and the equilibrium of
    each body in units of its own weight and size. The object is safe for several threads: each call uses a solver of
    its own, an idle one or a new one. A solution depends on its load alone, to the last digit, and not on the loads
    that the solver had before.
    """

    assembly: Assembly
    nodes: ContactNodes
    wrench: Float
    cone: FrictionCone
    _idle: deque[Prepared] = field(default_factory=deque, init=False, repr=False)

    @cached_property
    def cone_program(self) -> ConeProgram:
        """The cone program in the variables (f, s). The last column of A holds the load in all equilibrium rows."""
        base, G = force_program(self.assembly, self.nodes, self.wrench, self.cone)
        rows = G.shape[0]
        column = sparse.csc_matrix((np.ones(rows), (np.arange(rows), np.zeros(rows, int))), (base.A.shape[0], 1))
        A = sparse.csc_matrix(sparse.hstack([base.A, column]))
        count = A.shape[1]
        return ConeProgram(
            sparse.csc_matrix((count, count)), np.append(np.zeros(count - 1), -1.0), A, base.b, base.cones
        )

    def maximise(self, load: Float) -> ConeSolution:
        """Solve the program for one ``load`` (6J,) in the program's units; ``x`` of the solution is (f, s)."""
        entries = self.cone_program.A.nnz
        try:
            prepared = self._idle.pop()
        except IndexError:
            prepared = Prepared(self.cone_program, tolerance=TOLERANCE)
        prepared.change(np.arange(entries - len(load), entries), load)
        solution = prepared.solve()
        self._idle.append(prepared)
        return solution
