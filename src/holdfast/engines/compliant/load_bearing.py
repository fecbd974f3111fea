"""Whether the bodies that pass a load on carry it alone, while all others get out of their way without any force.

Where a load is so large that no weight counts beside it, most bodies of a pile carry nothing: bodies that lean under
the load push them aside, and nothing brings them back. In a search for rest of all bodies together each of them is free
to float. Here only the bodies between the load and its supports are to come to rest, as if no others touched them, and
the others only have to be able to leave.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order

from holdfast.base.arrays import Bool, Float
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.elastic.model import WEAKEST_SPRING, Elastic, Runs, with_springs
from holdfast.elastic.system import RestOutcome, System
from holdfast.native import core

HUGE = 10.0  # a weight is expected not to count any more beside a load of this many times its size
PATIENCE = 1000  # largest number of Newton steps in the search for rest
ALONE = 1e-6  # share of a load that springs may carry where contacts are to balance it alone
BALANCED = 1e-7  # share of such a load that may remain unbalanced
AGAINST = 1e-6  # a load is passed on at a contact if the cosine between it and the normal is above this
ROOM = 0.5  # share of the clearance, wanted at all contacts, that the program must leave


@dataclass(frozen=True, eq=False)
class LoadBearing:
    """The bodies of a ``model`` at ``rest`` (n,) that carry loads without its weight.

    What was found for the same bodies is kept.
    """

    model: Elastic
    rest: Float
    _leave: dict[bytes, bool] = field(default_factory=dict, init=False, repr=False)

    def balance(self, load: Float) -> bool:
        """Tell whether elastic contacts balance a ``load`` (n,) alone, in the model's units.

        False where that was not found: not all loads that are balanced are balanced by so few bodies.
        """
        carry = self._between(load)
        if not carry.any() or carry.all():
            return False
        few = with_springs(_restricted(self.model, carry, load / np.abs(load).max()), stiffness=WEAKEST_SPRING)
        if not len(few.a):  # there is nothing against it
            return False
        if not rests_alone(System.of(few), PATIENCE):
            return False
        key = carry.tobytes()
        if key not in self._leave:
            self._leave[key] = _may_leave(self.model, carry)
        return self._leave[key]

    def weight(self, load: Float) -> float:
        """Return what counts beside a ``load`` (n,), in the model's unit of force.

        That is the weight of the bodies that pass the load on, and all that others press on them at rest; or the whole
        weight, which is the unit, where no such bodies were found.
        """
        m, carry = self.model, self._between(load)
        if not carry.any() or carry.all():
            return 1.0
        own = np.linalg.norm(m.wrench.reshape(-1, 6)[carry, :3], axis=1).sum()
        others = (carry[m.a] != carry[m.b]) & (m.a >= 0) & (m.b >= 0)
        return float(own + self._pressed[others].sum()) or 1.0

    @cached_property
    def _pressed(self) -> Float:
        """The sum of the forces at rest at the nodes of each sheet (P,)."""
        m, forces = self.model, np.zeros((len(self.model.k), 3))
        core.node_forces(m, self.rest, forces)
        sheet = np.repeat(np.arange(len(m.a)), np.diff(m.first))
        return np.bincount(sheet, np.linalg.norm(forces, axis=1), len(m.a)).astype(np.float64)

    def _between(self, load: Float) -> Bool:
        """Return which bodies (J,) the force of the ``load`` is passed on to, from contact to contact against it.

        No body where several are loaded, or one by a torque alone.
        """
        m, loaded = self.model, np.flatnonzero(np.abs(load).reshape(-1, 6).max(1))
        carry = np.zeros(len(load) // 6, dtype=bool)
        force = load.reshape(-1, 6)[loaded, :3]
        if len(loaded) != 1 or not force.any():
            return carry
        along = m.axes[:, 0] @ (force[0] / np.linalg.norm(force[0]))  # normals lead from body a to body b
        on = (np.abs(along) > AGAINST) & (m.a >= 0) & (m.b >= 0)
        before, behind = np.where(along > 0, (m.a, m.b), (m.b, m.a))[:, on]
        passes = sparse.csr_matrix((np.ones(len(before)), (before, behind)), shape=(len(carry), len(carry)))
        carry[breadth_first_order(passes, loaded[0], return_predecessors=False)] = True
        return carry


def rests_alone(system: System, most: int) -> bool:
    """Tell whether contacts come to rest under a load, scaled to order one, with no other wrench on the bodies.

    Each body hangs on a very soft spring (``hold``), which must end up carrying next to nothing. A search for rest
    gives up after ``most`` steps of Newton's method.
    """
    model = system.model
    end = system.come_to_rest(most=most, exact=BALANCED * float(model.scale.min()))
    carried = np.abs(model.hold * end.q).max(initial=0.0)
    return end.outcome is RestOutcome.RESTS and bool(carried <= ALONE)


def _restricted(m: Elastic, carry: Bool, load: Float) -> Elastic:
    """Return the model of the bodies that ``carry`` (J,) under ``load`` (n,) alone, with the contacts among them."""
    stays = np.append(carry, True)  # index -1: fixed
    among = np.flatnonzero(stays[m.a] & stays[m.b])
    number = np.append(np.cumsum(carry) - 1, -1)
    counts = np.diff(m.first)[among]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    nodes = np.repeat(m.first[among] - first[:-1], counts) + np.arange(first[-1])
    x, y, flat, rows = m.x[nodes], m.y[nodes], np.zeros(len(nodes)), np.repeat(carry, 6)
    return m._replace(
        first=first,
        x=x,
        y=y,
        k=m.k[nodes],
        apart=flat,  # clearances are nothing beside a large load
        mu=m.mu[among],
        a=number[m.a[among]],
        b=number[m.b[among]],
        axes=m.axes[among],
        arm_a=m.arm_a[among],
        arm_b=m.arm_b[among],
        wrench=load[rows],
        scale=m.scale[rows],
        bonded=m.bonded[among],
        unit=m.unit[rows],
        runs=Runs.of(first, x, y, flat),
        hold=np.zeros(int(rows.sum())),
        still=m.still[rows],
    )


def _may_leave(m: Elastic, carry: Bool) -> bool:
    """Tell whether all bodies that do not ``carry`` (J,) can be shifted so that all of their contacts open.

    They may go as far as they like, so that what the bodies that carry have moved counts for nothing.
    """
    stays = np.append(carry, True)  # index -1: fixed
    opening = np.flatnonzero(~(stays[m.a] & stays[m.b]))
    rows = np.repeat(np.arange(len(opening)), 3)
    to, away = ((3 * (ends[opening, None] % len(stays)) + np.arange(3)).ravel() for ends in (m.b, m.a))
    normals = m.axes[opening, 0].ravel()
    entries = np.concatenate([-normals, normals]), (np.tile(rows, 2), np.concatenate([to, away]))
    A = sparse.csc_matrix(entries, shape=(len(opening), 3 * len(stays)))[:, np.repeat(~stays, 3)]
    program = ConeProgram(  # the shortest shifts that open every contact by one
        P=sparse.eye(A.shape[1], format="csc"),
        q=np.zeros(A.shape[1]),
        A=A,
        b=-np.ones(len(opening)),
        cones=(("nonnegative", len(opening)),),
    )
    found = solve(program)
    return found.outcome is Outcome.SOLVED and bool((-(A @ found.x) > ROOM).all())
