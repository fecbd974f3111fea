"""Engine ``limit``: limit analysis (limit_state.py), and whether the equilibrium that exists comes about."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, wrenches_of
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Bool, Float
from holdfast.base.public import Record
from holdfast.engines.capabilities import Weakest
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.compliant.refinement import REFINEMENTS
from holdfast.engines.cones import ConeChoice, FrictionCone
from holdfast.engines.contract import State
from holdfast.engines.limit.box_corners import corners_of, weakest
from holdfast.engines.limit.limit_state import CLAIM, NAME, LimitState, balanced_under
from holdfast.engines.limit.loose import comes_loose
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
