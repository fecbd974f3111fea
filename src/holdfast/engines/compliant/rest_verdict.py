"""Whether an assembly comes to rest on elastic contacts, with evidence for either answer."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, wrenches_of
from holdfast.base.arrays import Bool, Float
from holdfast.elastic.outcome import RestOutcome
from holdfast.elastic.system import Settled
from holdfast.engines.answers import balanced_in_verdict
from holdfast.engines.compliant.balanced import on_an_edge
from holdfast.engines.compliant.elastic_model import world_rows
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.places import Places
from holdfast.engines.compliant.unstiff import unstiff_at
from holdfast.engines.mechanism import Kinematics, Mechanism, describe, modes_of, relative_velocity
from holdfast.engines.rest import contact_forces, doubt_of, find_rest, undecided
from holdfast.engines.verdict import Status, Verdict
from holdfast.native import core

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

    def with_balanced(self, names: tuple[str, ...]) -> Verdict:
        """Return the verdict, which says that the bodies of these names are only balanced."""
        return replace(self.verdict, reason=self.verdict.reason + balanced_in_verdict(names), balanced=names)


def at_rest(grid: Grid) -> AtRest | None:
    """Return the verdict on a grid that has come to rest, or None if it has not or if its forces balance badly.

    What a regularisation spring carries counts as unbalanced.
    """
    end = grid.settled
    found = balanced_forces(grid, end.q) if end.outcome is RestOutcome.RESTS else None
    if found is None:
        return None
    unstiff = unstiff_at(grid.system.model, end.q, core.SPRING_SHARE if grid.hold is not None else BALANCED_EACH)
    verdict = _stands(grid.assembly, grid.nodes, *found)
    return AtRest(verdict, unstiff, on_an_edge(grid.assembly, grid.nodes, found[0], grid.wrench))


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
        found, sharp = _drifts(grid, end, assembly, exists=certain.equilibrium_exists), assembly.sharpened
        if found.status is Status.UNDECIDED and sharp is not assembly:
            firm = Grid.of(sharp, grid.wrench, grid.springs).settled  # sharp contacts push back wherever they may
            if firm.outcome is RestOutcome.DRIFTS:
                return _drifts(grid, firm, sharp, exists=certain.equilibrium_exists)
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


def _stands(assembly: Assembly, nodes: ContactNodes, forces: Float, residual: float) -> Verdict:
    verdict = Verdict(status=Status.STABLE, reason=RESTS, equilibrium_exists=True)
    return verdict.with_evidence(lambda: contact_forces(assembly, nodes, forces), lambda: residual, lambda: False)


def motion_of(assembly: Assembly, nodes: ContactNodes, twists: Float) -> Mechanism:
    """Return the mechanism of a motion ``twists`` (J, 6) on elastic contacts, which has no dilatancy."""
    velocity = relative_velocity(nodes, assembly.com, twists)
    mode = modes_of(assembly, nodes, twists[None], velocity[None], dual=False)[0]
    return describe(Kinematics.of(assembly, nodes), twists, mode, dual=False)


def _drifts(grid: Grid, end: Settled, known: Assembly, *, exists: bool | None) -> Verdict:
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
