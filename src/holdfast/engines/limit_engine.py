"""Engine ``limit``: limit analysis (limit_state.py), and whether the equilibrium that exists comes about.

The forces of limit analysis need not come about. Engine ``compliant`` tells, so this stands above limit/ and
compliant/, and limit/ knows nothing of compliant/.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator, wrenches_of
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Bool, Float
from holdfast.base.public import Record
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.refinement import REFINEMENTS
from holdfast.engines.cones import EXACT, ConeChoice, FrictionCone
from holdfast.engines.contract import State, Weakest
from holdfast.engines.limit.box_corners import corners_of, weakest
from holdfast.engines.limit.limit_state import CLAIM, NAME, LimitState, balanced_under
from holdfast.engines.rest import Rest
from holdfast.engines.trees.forest import forest_of
from holdfast.engines.trees.tree_state import FIRM
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.hold import held_names

COMES_ABOUT = "an equilibrium exists that needs no self-stress"


class Limit(Record):
    """Static limit analysis over all corners of all patches, which carry whatever the patches can.

    ``cone``: "exact", or a polygon of ``sides`` "inscribed" (cautious) or "circumscribed" (optimistic).
    """

    cone: ConeChoice = "exact"
    sides: int = 8

    name = NAME
    claim = CLAIM
    takes_holds = True

    def __post_init__(self) -> None:
        FrictionCone(self.cone, self.sides)

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> LimitState:
        """Test s = 0 first: an assembly that does not stand must not score because a push would hold it."""
        wrench = assembly.weight_wrench(acceleration)
        if standing is not None:
            wrench = wrench + standing
        return self.on(assembly, wrench)

    def firm(self, assembly: Assembly, wrench: Float) -> tuple[Bool, Verdict]:
        """Which bodies rest as trees; see ``Judging.firm``. Exact cones alone."""
        rests = np.zeros(len(assembly.movable), dtype=bool)
        if self.cone == "exact":
            rests = forest_of(assembly, wrench).decided
        return rests, replace(FIRM, reason=COMES_ABOUT)

    def on(self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None) -> LimitState:
        """The state under ``wrench`` (6J,), on ``nodes`` if given (cautious: corners carry most)."""
        cone = FrictionCone(self.cone, self.sides)
        state = balanced_under(assembly, wrench, nodes, cone)
        return replace(state, rest=_judged(state, assembly, wrench))

    def weakest(
        self,
        assembly: Assembly,
        standing: Float,
        W: Float,
        *,
        masses: Mapping[str, tuple[float, float]],
        coms: Mapping[str, Float],
        prepare: Callable[[Float], State],
        where: str,
    ) -> Weakest:
        """The smallest factor of each column of W over boxes of masses and centres of mass: at one of its corners."""
        return weakest(assembly, prepare, standing, W, corners_of(assembly, masses, coms, where))

    def comes_loose(self, assembly: Assembly, body: str, up: Float) -> bool:
        """Whether no contact can hold ``body``; over the exact cone, for a polygon inside it would prove nothing."""
        return comes_loose(assembly, body, up)


def _judged(state: LimitState, assembly: Assembly, wrench: Float) -> Rest:
    """Return the rest of a state, STABLE only where its forces come about, else UNDECIDED though an equilibrium exists.

    Forces that build up on elastic contacts without any slip do. Where some contacts have to slip, forces in balance
    may press bodies together that nothing presses, and friction with the ground may hold them so, whatever the contacts
    that they need. Then engine ``compliant`` is asked whether contacts come to rest that slip as they are loaded. Holds
    are at will: they exert what leaves contacts well inside their cones.
    """
    rest, holds = state.rest, assembly.scene.holds
    verdict = rest.verdict
    if verdict.status is not Status.STABLE:
        return rest
    needed: bool | None = False
    if verdict.self_stress is not False:
        if holds:
            wrench = _with_holds(state, wrench)
            assembly = replace(assembly, scene=replace(assembly.scene, holds=()))
        found = Compliant().on(assembly, wrench, refinements=REFINEMENTS).verdict()
        needed = {Status.STABLE: False, Status.UNSTABLE: None if holds else True}.get(found.status)
    if needed is False:
        return replace(rest, verdict=replace(verdict, self_stress=False, reason=COMES_ABOUT))
    reason = "an equilibrium exists, but it rests on contacts that would have to be pressed together by something else"
    if needed is None:
        reason = f"an equilibrium exists; whether it needs self-stress was not settled: {found.reason}"
    return replace(rest, verdict=replace(verdict, status=Status.UNDECIDED, self_stress=needed, reason=reason))


def _with_holds(state: LimitState, wrench: Float) -> Float:
    """Return ``wrench`` (6J,) with what holds exert: on bodies that are held, all that contacts do not balance."""
    assembly, own, inside = state.assembly, state.rest.nodes.contacts, state.proofs.resting
    forces = state.rest.forces if inside is None else inside.reshape(-1, 3)
    pressed = with_pull(assembly, wrenches_of(assembly, own, forces[: len(own)]))
    names = held_names(assembly.scene.holds)
    held = np.repeat([body.name in names for body in assembly.movable], 6)
    return np.where(held, -pressed, wrench)


def comes_loose(assembly: Assembly, name: str, up: Float) -> bool:
    """Return True if it is proved that no contact holds the body ``name`` once its weight is supported.

    Suppose that the weight is supported and that an additional force c >= 0 acts along ``up`` (3,) at the centre of
    mass. The contacts of the body then have to balance this force alone. The function returns True if

        G_b f + c (up, 0) = 0,   f in the friction cones,   Σ f_n = 1,   c >= 0

    has no solution. All contact forces on the body are then zero from that moment on, whatever the other bodies do, and
    the body takes none of them along. The nodes are the corners of the patches, which can carry every load that the
    whole patches can carry. A body without contacts is loose.
    """
    k = assembly.index[name]
    every = contact_nodes(assembly, 4, "corners")
    nodes = every.chosen((every.a == k) | (every.b == k))
    if not len(nodes):
        return True
    size = assembly.scene.body(name).size
    G = sparse.csr_matrix(equilibrium_operator(assembly, nodes))[6 * k : 6 * k + 6]
    G = sparse.diags(np.repeat([1.0, 1 / size], 3)) @ G
    C, cones = EXACT.rows(nodes)
    count = 3 * len(nodes)
    pressing = np.zeros((1, count))
    pressing[0, ::3] = 1.0
    lift = np.concatenate([up, np.zeros(4 + C.shape[0])])
    A = sparse.hstack([sparse.vstack([G, sparse.csr_matrix(pressing), C]), sparse.csr_matrix(lift[:, None])])
    A = sparse.csc_matrix(sparse.vstack([A, sparse.csr_matrix(([-1.0], ([0], [count])), shape=(1, count + 1))]))
    b = np.zeros(A.shape[0])
    b[6] = 1.0
    program = ConeProgram(
        sparse.csc_matrix((count + 1, count + 1)),
        np.zeros(count + 1),
        A,
        b,
        (("zero", 7), *cones, ("nonnegative", 1)),
    )
    return solve(program, tolerance=1e-9).outcome is Outcome.INFEASIBLE
