"""Whether an assembly comes to rest on elastic contacts, with evidence for either answer.

All of the weight of a box may be concentrated at an edge, and the next nodes just touch without any force. Taken for
pressed, these resist every turn, although one to the outside only opens them. So nodes whose force is nothing but
rounding count as open (``unstiff_at``). Whether the least push moves such a body is another question (balanced.py).

Whether rest leans on the number of nodes is seen from the friction that it has in reserve. Where nothing slips, elastic
contacts come to rest exactly where forces on the nodes balance all bodies, and nodes lie within the patches: more of
them carry more, and few are no danger. Where contacts slip, it depends on which do and how far they are pressed, and
few nodes may hold what more would let go. Goodman and Bray's 16 blocks that topple on the steps of a slope rest from
tan φ = 0.769 on with 7 nodes a side, 0.775 with 11, 0.781 with 25, and 0.7855 by hand.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, wrenches_of
from holdfast.base.arrays import Bool, Float
from holdfast.elastic.model import Elastic, unresisted_motion
from holdfast.elastic.system import RestOutcome, RestSearch
from holdfast.engines.compliant.balanced import on_an_edge
from holdfast.engines.compliant.elastic_model import Places, world_rows
from holdfast.engines.compliant.grid import FINER, Grid
from holdfast.engines.mechanism import Kinematics, Mechanism, describe, modes_of, relative_velocity
from holdfast.engines.rest import contact_forces, doubt_of, find_rest, undecided
from holdfast.engines.verdict import Status, Verdict
from holdfast.native import core

TAKEN_ALONG = 1e-3  # displacement, relative to the largest in a motion, above which a body takes part in the motion


def unstiff_at(m: Elastic, q: Float, rounding: float) -> Bool:
    """Return which bodies (J,) meet no stiffness in some motion at rest ``q`` (6J,) as long as no node begins to press.

    Forces of nodes up to ``rounding``, as a share of the largest on each of the bodies that touch there, count as none.
    """
    K = np.empty_like(m.bonded)
    firm = m._replace(apart=core.without_touching(m, q, rounding))
    core.evaluate(firm, 1.0, q, np.zeros(len(q)), K)
    return np.asarray(unresisted_motion(m, K) > TAKEN_ALONG)


BALANCED = 1e-8  # largest equilibrium error of a state of rest, relative to the total weight
RESTS = "every body comes to rest, held by the forces at its contacts"
BALANCED_EACH = 1e-7  # largest equilibrium error of a state of rest, relative to each body's own weight


class AtRest(NamedTuple):
    """The verdict on an assembly that rests, and what it says of bodies (J,) that may be only balanced.

    ``unstiff`` are those that have to be held for load paths to begin, and ``on_an_edge`` those that may rest on the
    edge of a contact alone.
    """

    verdict: Verdict
    unstiff: Bool
    on_an_edge: Bool


def at_rest(grid: Grid) -> AtRest | None:
    """Return the verdict on a grid that has come to rest, or None if it has not or if its forces balance badly.

    What a regularisation spring carries counts as unbalanced.
    """
    end = grid.settled
    found = balanced_forces(grid, end.q) if end.outcome is RestOutcome.RESTS else None
    if found is None:
        return None
    unstiff = unstiff_at(grid.system.model, end.q, core.SPRING_SHARE if grid.hold is not None else BALANCED_EACH)
    assembly, nodes, (forces, residual) = grid.assembly, grid.nodes, found
    verdict = Verdict(status=Status.STABLE, reason=RESTS, equilibrium_exists=True)
    verdict = verdict.with_evidence(lambda: contact_forces(assembly, nodes, forces), lambda: residual, lambda: False)
    return AtRest(verdict, unstiff, on_an_edge(assembly, nodes, forces, grid.wrench))


def balanced_forces(grid: Grid, q: Float, load: Float | float = 0.0) -> tuple[Float, float] | None:
    """Return the contact forces (I, 3) [N] at displacements q (6J,) of the model, and their equilibrium error.

    They balance a ``load`` (6J,) [N, N m] beside what acts at rest. The error is relative to the total weight. None if
    they balance badly; what a regularisation spring carries counts as unbalanced.
    """
    forces = np.zeros((len(grid.nodes), 3))
    core.node_forces(grid.system.model, q, forces)
    if grid.nodes.pull.any():  # exactly as the model has it, which is rounded
        model = grid.system.model
        forces[:, 0] += model.k * model.apart + grid.nodes.pull / grid.unit
    forces *= grid.unit
    total, each = unbalanced(grid.places, forces, grid.wrench + load)
    most, most_each = (core.SPRING_SHARE, core.SPRING_SHARE) if grid.hold is not None else (BALANCED, BALANCED_EACH)
    return None if total > most or each > most_each else (forces, total)


def not_at_rest(grid: Grid) -> Verdict:
    """Return the verdict on a grid for which ``at_rest`` returned None.

    Where the search found neither rest nor a drift, limit analysis may prove a fall; else it is not known.
    """
    assembly, end = grid.assembly, grid.settled
    certain = find_rest(assembly, grid.wrench).verdict
    if certain.status is Status.UNSTABLE:
        return certain
    if end.outcome is RestOutcome.DRIFTS:
        found, sharp = _drift_verdict(grid, end, assembly, exists=certain.equilibrium_exists), assembly.sharpened
        if found.status is Status.UNDECIDED and sharp is not assembly:
            firm = Grid.of(sharp, grid.wrench, grid.springs).settled  # sharp contacts push back wherever they may
            if firm.outcome is RestOutcome.DRIFTS:
                return _drift_verdict(grid, firm, sharp, exists=certain.equilibrium_exists)
        return found
    tried = f"Newton's method with ever less drag came to no end ({end.steps} steps, drag {end.drag:.0e})"
    return undecided(f"{tried}; limit analysis: {certain.reason}")


def unbalanced(places: Places, forces: Float, wrench: Float) -> tuple[float, float]:
    """Return the equilibrium error of local contact ``forces`` (I, 3) [N] under ``wrench`` (6J,) [N, N m].

    The first value is relative to the total weight, the second to each body's own weight.
    """
    assembly = places.assembly
    own = forces - np.outer(places.nodes.pull, [1.0, 0.0, 0.0])
    left = wrenches_of(assembly, places.nodes, own) + wrench
    weight = assembly.weight or float(np.abs(wrench).max(initial=0.0)) or 1.0
    total = float(np.abs(left * assembly.levers).max(initial=0.0)) / weight
    return total, float(np.abs(left * assembly.equation_scale).max(initial=0.0)) / weight


def motion_of(assembly: Assembly, nodes: ContactNodes, twists: Float) -> Mechanism:
    """Return the mechanism of a motion ``twists`` (J, 6) on elastic contacts, which has no dilatancy."""
    velocity = relative_velocity(nodes, assembly.com, twists)
    mode = modes_of(assembly, nodes, twists[None], velocity[None], dual=False)[0]
    return describe(Kinematics.of(assembly, nodes), twists, mode, dual=False)


def _drift_verdict(grid: Grid, end: RestSearch, known: Assembly, *, exists: bool | None) -> Verdict:
    """Return the verdict that follows from the drift at the ``end`` of a search for rest on the contacts ``known``."""
    assembly = grid.assembly
    mechanism = motion_of(assembly, grid.nodes, world_rows(assembly, end.drift[None]).reshape(-1, 6))
    doubt = doubt_of(known, mechanism.twists)
    if doubt:
        return undecided(f"the contacts found do not bring it to rest, but {doubt}", mechanism=mechanism)
    more = ", although an equilibrium exists: nothing presses the contacts that it needs" if exists else ""
    reason = f"elastic contacts do not come to rest{more}; a steady drift remains: {mechanism.text}"
    return Verdict(
        status=Status.UNSTABLE,
        reason=reason,
        equilibrium_exists=exists,
        self_stress=True if exists else None,
        mechanism=mechanism,
    )


AMPLE = 0.1  # share of all friction without which an assembly that rests is far from its limit
# Share of the reserve that twice the nodes have to keep. Errors that fall in proportion to the step leave half at the
# limit itself. On 7 and 14 nodes a side 16 blocks on a slope rest with 0.0215 and 0.0105 less friction than they need
# by hand, but five with 0.0197 and 0.0132: two thirds.
KEPT = 0.7
SLIGHT = 1e-5  # share of all friction below which nothing is in reserve
FINELY = 1.05  # ratio of the shares between which a reserve is known
PATIENCE = 300  # steps of Newton's method after which rest on less friction is not sought any longer
MOST_NODES = 50_000  # of a grid on which rest is sought once more


def overruled(grid: Grid, refinements: int) -> Verdict | None:
    """Return the verdict that takes the place of rest on ``grid``, or None if rest does not lean on its nodes.

    It does not if the assembly rests without the share AMPLE of its friction, which is mostly one step of Newton's
    method away. Else it has to come to rest on twice the nodes a side, too, and to keep KEPT of its reserve there.
    Springs of imperfect faces are a sample, and nodes that are given were chosen: both are left alone.
    """
    if grid.springs.faces is not None or grid.places.given is not None or not refinements:
        return None
    if _rest_with_less_friction(grid, AMPLE) is RestOutcome.RESTS:
        return None
    nodes = grid.springs.nodes
    if FINER**2 * len(grid.nodes) <= MOST_NODES:
        if at_rest(grid.finer) is None:
            few, many = grid.springs.nodes, grid.finer.springs.nodes
            if grid.finer.settled.outcome is not RestOutcome.DRIFTS:
                return _leans_on_nodes(f"on {many} nodes a side no rest is found, as it is on {few}")
            found = not_at_rest(grid.finer)
            return replace(found, reason=f"on {many} nodes a side {found.reason}; {few} nodes a side would hold it")
        if _rest_with_less_friction(grid.finer, KEPT * _friction_in_reserve(grid)) is RestOutcome.RESTS:
            return None
        nodes = grid.finer.springs.nodes
    return _leans_on_nodes(f"it is so near its limit that more than {nodes} nodes a side may let it go")


def _friction_in_reserve(grid: Grid) -> float:
    """Return the least share of all friction, up to AMPLE, without which an assembly at rest on ``grid`` drifts.

    It is up to FINELY times as large as that. A search for rest that comes to no end does not count as a drift.
    """
    holds, gives = SLIGHT, AMPLE
    while gives > FINELY * holds:
        share = float(np.sqrt(gives * holds))
        if _rest_with_less_friction(grid, share) is RestOutcome.DRIFTS:
            gives = share
        else:
            holds = share
    return gives


def _rest_with_less_friction(grid: Grid, share: float) -> RestOutcome:
    """Say how the search for rest ends without this share of all friction, beginning at rest with all of it."""
    system, q = grid.system.slippery(1 - share), grid.settled.q
    if grid.hold is None and system.rest_near(q) is not None:
        return RestOutcome.RESTS
    found = system.come_to_rest(near=q, most=PATIENCE)
    if found.outcome is RestOutcome.RESTS and balanced_forces(replace(grid, system=system), found.q) is None:
        return RestOutcome.DRIFTS  # the regularisation spring carries
    return found.outcome


def _leans_on_nodes(why: str) -> Verdict:
    found = undecided(f"every body comes to rest, but that leans on the number of nodes: {why}")
    return replace(found, status=Status.UNDECIDED, equilibrium_exists=True)
