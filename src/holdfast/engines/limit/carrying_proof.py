"""Proof that a load is carried: contact forces that balance exactly and lie in their friction cones.

A solver's forces balance up to a residual and may leave their cones by as much. They are brought into balance
(balance.py), up to what rounding leaves; what is left is balanced exactly by a change of forces that is bounded at
every node. The room that the cones then lack is made up by mixing: for f at the factor s and interior forces f0 at the
factor s0, (1 - θ) f + θ f0 balance the factor (1 - θ) s + θ s0, and the room of a node in its cone is concave.

The interior forces are deep in their cones: the usual ones, brought into balance and into their cones in turn, or the
deepest ones by a program. They also prove that an equilibrium exists where the program for the forces at rest was not
solved well enough to tell (``proved_rest``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.conic.solve import ConeKind, ConeProgram, solve
from holdfast.engines.forces import FrictionCone
from holdfast.engines.limit.balance import DOWN, UP, Balance, Equilibrium, usual_forces
from holdfast.engines.rest import Rest, contact_forces
from holdfast.engines.verdict import Status, Verdict

TOLERANCE = 1e-4  # what is found is brought into balance and proved afterwards
# Largest number of rounds that bring forces into balance and into their cones; each costs far less than a program
ROUNDS = 10
# Room inside its cone, as a share of its usual force, that a node is given in a round, and that suffices
AIM, ENOUGH = 0.5, 0.1
BEYOND = 1.6  # a node is given this multiple of what it lacks, which takes fewer rounds
DEAD = 1e-3  # share of its usual force below which a node counts as one that cannot press


def interior_forces(
    equilibrium: Equilibrium, wrench: Float, mu: Float, tau: Float, load: Float | None = None
) -> tuple[Float, float, Float]:
    """Return forces (3I,) [N] deep in their cones that about balance ``wrench`` (6J,), and what else there is to know.

    With a ``load`` (6J,) they balance the wrench and some factor >= 0 of the load. Each node gets at least the same
    share of its usual normal force ``tau`` (I,) [N] as room in its cone, and that share is as large as possible. Nodes
    that cannot press at all are left out. Also returns the factor, and ``tau`` with 0 for the nodes left out.
    """
    forces, factor, least = _widest(equilibrium, wrench, mu, tau, load, each=False)
    if least.min(initial=1.0) > DEAD:
        return forces, factor, tau
    most = _widest(equilibrium, wrench, mu, tau, load, each=True)[2]
    alive = np.where(most > DEAD, tau, 0.0)
    if not alive.any():
        return np.zeros(len(forces)), 0.0, alive
    forces, factor, _ = _widest(equilibrium, wrench, mu, alive, load, each=False)
    return forces, factor, alive


def pressed_forces(balance: Balance, wrench: Float, mu: Float, tau: Float) -> Float | None:
    """Return forces (3I,) [N] in their cones that about balance ``wrench`` (6J,), close to the usual ones, if found.

    From the usual normal forces ``tau`` (I,) [N], they are brought into balance and back into their cones in turn.
    Every node has at least a share ENOUGH of its usual force as room in the end. Returns None if some have less.
    """
    forces = np.zeros((len(tau), 3))
    forces[:, 0] = tau
    rough = np.where(mu > 0, mu, 1.0)
    for _ in range(ROUNDS):
        left = balance.equilibrium.G @ forces.ravel() + wrench
        forces = forces - balance.forces_for(left[:, None]).reshape(-1, 3)
        along = np.hypot(forces[:, 1], forces[:, 2]) / rough
        room = (forces[:, 0] - along) / tau
        if room.min() >= ENOUGH:
            return forces.ravel()
        lacking = BEYOND * np.maximum(AIM - room, 0.0) * tau
        shrunk = np.minimum(lacking / 2, along)
        forces[:, 0] += lacking - shrunk
        forces[:, 1:] *= (1 - np.divide(shrunk, along, out=np.zeros(len(along)), where=along > 0))[:, None]
    return None


def _widest(
    equilibrium: Equilibrium, wrench: Float, mu: Float, tau: Float, load: Float | None, *, each: bool
) -> tuple[Float, float, Float]:
    """Max t, or with ``each`` max Σ t_i: G f + w + s w_e = 0, room of node i >= t_i tau_i, 0 <= t_i <= 1, s >= 0.

    The room of a node is f_n - |f_t| / μ. Forces are in units of ``tau``, equations in units of their largest entry.
    """
    pressing = np.flatnonzero(tau > 0)
    count = len(pressing)
    mu, tangent = mu[pressing], np.minimum(mu[pressing], 1.0)
    scale = tau[pressing, None] * np.column_stack([np.ones(count), tangent, tangent])
    columns = (3 * pressing[:, None] + np.arange(3)).ravel()
    G = sparse.csc_matrix(sparse.csc_matrix(equilibrium.G)[:, columns] @ sparse.diags(scale.ravel()))
    largest = abs(G).max(axis=1).toarray().ravel()
    rows = largest > 0
    unit = sparse.csr_matrix(sparse.diags(1 / np.where(rows, largest, 1.0)))[rows]
    pushed = np.zeros((len(wrench), 0))
    if load is not None:  # of the size 1 in scaled equations
        pushed = np.asarray(load[:, None] / float(np.max(np.abs(np.asarray(unit @ load)), initial=1e-300)))
    shares, factors = count if each else 1, pushed.shape[1]
    balance = sparse.hstack([unit @ G, sparse.csr_matrix((int(rows.sum()), shares)), sparse.csr_matrix(unit @ pushed)])
    cap = sparse.hstack([sparse.csr_matrix((shares, 3 * count)), sparse.eye(shares, shares + factors)])
    positive = sparse.hstack([sparse.csr_matrix((shares + factors, 3 * count)), -sparse.eye(shares + factors)])
    inside = np.ones((count, 3))
    inside[:, 1:] = np.divide(tangent, mu, out=np.ones(count), where=mu > 0)[:, None]
    taken = (np.ones(count), (3 * np.arange(count), np.arange(count) if each else np.zeros(count, dtype=int)))
    room = sparse.hstack([-sparse.diags(inside.ravel()), sparse.csr_matrix(taken, shape=(3 * count, shares + factors))])
    A = sparse.csc_matrix(sparse.vstack([balance, cap, positive, room]))
    b = np.concatenate([-(unit @ wrench), np.ones(shares), np.zeros(shares + factors + 3 * count)])
    q = np.concatenate([np.zeros(3 * count), -np.ones(shares), np.zeros(factors)])
    first: tuple[tuple[ConeKind, int], ...] = (("zero", int(rows.sum())), ("nonnegative", 2 * shares + factors))
    cones: tuple[tuple[ConeKind, int], ...] = (*first, *((("second_order", 3),) * count))
    found = solve(ConeProgram(sparse.csc_matrix((len(q), len(q))), q, A, b, cones), tolerance=TOLERANCE).x
    found = np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)
    forces = np.zeros((len(tau), 3))
    forces[pressing] = scale * found[: 3 * count].reshape(-1, 3)
    given = np.zeros(len(tau))
    given[pressing] = found[3 * count : 3 * count + shares]
    used = 0.0 if load is None else max(float(found[-1]), 0.0) * float(np.abs(pushed).max()) / float(np.abs(load).max())
    return forces.ravel(), used, given


DEEP = 0.02  # room, in usual normal forces, that makes forces a good reference
POOR = 1e-4  # share of a factor lost by mixing above which a reference for this very load is sought
LARGEST = 4_500  # equations of rest; twice as many would take minutes and gigabytes
PRESSING = 1e-7  # share of the largest force of a ray below which a node does not press in it


@dataclass(frozen=True, eq=False)
class InteriorForces:
    """Forces inside the cones that balance a load at one ``factor``, and the ``room`` (I,) [N] of each node.

    ``forces`` (3I,) [N] balance the load but for what ``balance`` takes away; ``room`` is proved to remain then.
    """

    balance: Balance
    room: Float
    factor: float
    forces: Float

    @property
    def slope(self) -> Float:
        """The sum of these (6J,) times |w| bounds 1/s for the factors s of a wrench w up to which it is carried."""
        return self.balance.slope(self.room)

    @property
    def partial(self) -> bool:
        """Whether some nodes have no force, so that forces which need them cannot be mixed with these."""
        return bool((self.room <= 0).any())


class Mixture(NamedTuple):
    """Contact ``forces`` (3I,) [N] that balance the ``factor`` of a load, up to rounding."""

    forces: Float
    factor: float


@dataclass(frozen=True, eq=False)
class CarryingProof:
    """Lower bounds of the largest factors of loads on one assembly under ``wrench`` (6J,).

    ``resting`` (3I,) [N] are contact forces at rest, and ``tau`` (I,) [N] the usual normal force of each node.
    """

    equilibrium: Equilibrium
    cone: FrictionCone
    mu: Float
    wrench: Float
    resting: Float
    tau: Float

    @cached_property
    def reference(self) -> InteriorForces | None:
        """Forces inside all cones at the factor 0, or None if no such forces are proved to exist.

        They are the forces at rest if these are inside all cones, else such forces are sought: by a program where there
        are none close to the usual ones. An assembly for which the proof would take more memory than all else has none.
        """
        if len(self.wrench) > LARGEST:
            return None
        found = self._if_deep_inside(self.resting)
        if found is None and self.balance is not None:
            found = self._if_deep_inside(pressed_forces(self.balance, self.wrench, self.mu, self.tau))
        if found is None:
            inside = interior_forces(self.equilibrium, self.wrench, self.mu, self.tau)
            found = self._if_proved_inside(*inside, np.zeros(len(self.wrench)))
        return found

    def _if_deep_inside(self, forces: Float | None) -> InteriorForces | None:
        """Return forces (3I,) as a reference at the factor 0, if there are any and all nodes have much room."""
        if forces is None:
            return None
        found = self._if_proved_inside(forces, 0.0, self.tau, np.zeros(len(self.wrench)))
        return found if found is not None and (found.room >= DEEP * self.tau).all() else None

    @cached_property
    def balance(self) -> Balance | None:
        """The corrections of forces at all nodes, if they are proved and take no more memory than all else."""
        return None if len(self.wrench) > LARGEST else Balance.of(self.equilibrium, self.mu, self.tau)

    def lower(self, forces: Float, factors: Float, loads: Float) -> Float:
        """Return factors (k,) at which the loads (6J, k) are carried for certain, 0 where nothing is proved.

        ``forces`` (3I, k) [N] and ``factors`` (k,) are those of a solver; they may be wrong.
        """
        reference = self.reference
        sound = np.isfinite(forces).all(0) & np.isfinite(factors) & (factors > 0)
        if reference is None or not sound.any():
            return np.zeros(len(factors))
        forces, factors = np.where(sound, forces, 0.0), np.where(sound, factors, 0.0)
        found = self._factors_by_mixing(reference, forces, factors, loads)
        if reference.partial:
            for k in np.flatnonzero(sound & (found < (1 - POOR) * factors)):
                own = self._reference_for(loads[:, k])
                if own is not None:
                    one = slice(k, k + 1)
                    found[one] = np.maximum(
                        found[one], self._factors_by_mixing(own, forces[:, one], factors[one], loads[:, one])
                    )
        return found

    def _factors_by_mixing(self, reference: InteriorForces, forces: Float, factors: Float, loads: Float) -> Float:
        """Return the factors (k,) that forces are proved to carry when they are mixed with those of the reference."""
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            forces, change = reference.balance.balanced(forces, self.wrench, loads, factors)
            short = self._lacking(forces, change)
            share = np.where(short > 0, short / (short + reference.room[:, None]), 0.0).max(0, initial=0.0) * UP
            found = ((1 - share) * factors * DOWN + share * reference.factor) * DOWN
        return np.where(np.isfinite(found) & (share < 1), found, 0.0)

    def mixtures(self, forces: Float, factor: float, load: Float) -> Iterator[tuple[Mixture, Mixture, float]]:
        """Yield forces (3I,) brought into balance at a ``factor`` of a load (6J,), and interior ones to mix them with.

        The third value is the share of the interior forces with which all nodes are within their cones.
        """
        references = [self.reference] if self.reference is not None else []
        if not references or references[0].partial:
            references += [found for found in [self._reference_for(load)] if found is not None]
        for reference in references:
            balanced, change = reference.balance.balanced(
                forces[:, None], self.wrench, load[:, None], np.array([factor])
            )
            short = self._lacking(balanced, change)[:, 0]
            share = np.divide(short, short + reference.room, out=np.zeros(len(short)), where=short > 0).max(initial=0.0)
            yield Mixture(balanced[:, 0], factor), Mixture(reference.forces, reference.factor), float(share)

    def _reference_for(self, load: Float) -> InteriorForces | None:
        """Return forces inside all cones that balance some factor of this very load, if any are proved to exist."""
        return self._if_proved_inside(*interior_forces(self.equilibrium, self.wrench, self.mu, self.tau, load), load)

    def endless(self, forces: Float, load: Float) -> tuple[float, Float | None]:
        """Return a factor up to which one load (6J,) is carried if ``forces`` (3I,) [N] balance it: inf if they do.

        What lacks at some nodes is taken from the interior forces at rest, so that the factor is finite. Where nothing
        lacks, the ``slope`` (6J,) of LoadLimit is returned, too.
        """
        normal = forces.reshape(-1, 3)[:, 0]
        pressing = np.where(normal > PRESSING * normal.max(initial=0.0), normal, 0.0)
        if self.reference is None or not (np.isfinite(forces).all() and pressing.any()):
            return 0.0, None
        # Nodes in one line balance no torque about it, not even what rounding leaves; all nodes balance that then
        balance = Balance.of(self.equilibrium, self.mu, pressing) or self.reference.balance
        nothing = np.zeros(len(self.wrench))
        found, change = balance.balanced(forces[:, None], nothing, load[:, None], np.ones(1))
        short = self._lacking(found, change)[:, 0]
        if not np.isfinite(change).all():
            return 0.0, None
        lacking = short > 0
        if lacking.any():
            return float((self.reference.room[lacking] / short[lacking]).min()) * DOWN, None
        return np.inf, balance.slope(-short)

    def _lacking(self, forces: Float, change: Float) -> Float:
        """Return what every node (I, k) lacks, or less than 0: the change that balances exactly, less the room."""
        force = forces.reshape(len(self.mu), 3, -1).transpose(0, 2, 1)
        with np.errstate(invalid="ignore"):
            lacking = change - self.cone.room(self.mu, force)
        return np.where(np.isnan(lacking), np.inf, lacking)

    def _if_proved_inside(self, forces: Float, factor: float, tau: Float, load: Float) -> InteriorForces | None:
        """Return forces (3I,) as a reference, if all nodes with a usual force ``tau`` (I,) are proved to have room."""
        balance = self.balance if tau is self.tau else Balance.of(self.equilibrium, self.mu, tau)
        if balance is None:
            return None
        forces, change = balance.balanced(forces[:, None], self.wrench, load[:, None], np.array([factor]))
        room = -self._lacking(forces, change)[:, 0]
        alive = tau > 0
        found = InteriorForces(balance, np.where(alive, room, 0.0), factor, forces[:, 0])
        return found if (room[alive] > 0).all() else None


def proved_rest(assembly: Assembly, rest: Rest, wrench: Float, cone: FrictionCone) -> Rest:
    """Return ``rest`` with contact forces that are proved to balance ``wrench`` (6J,), if it has none but some exist.

    Bodies that bear a million times their own weight defeat units of force that fit the weights.
    """
    if rest.verdict.status is not Status.UNDECIDED or assembly.hanging or not len(rest.nodes):
        return rest
    equilibrium = Equilibrium.of(assembly, rest.nodes)
    doubtful = rest
    for _ in range(3):  # each in units of the forces of the round before
        tau = usual_forces(assembly, doubtful)
        carried = CarryingProof(equilibrium, cone, rest.nodes.mu, wrench, doubtful.forces.ravel(), tau)
        if carried.reference is not None:
            forces = carried.reference.forces.reshape(-1, 3)
            verdict = Verdict(
                status=Status.STABLE,
                reason="contact forces balance every body",
                equilibrium_exists=True,
                forces=contact_forces(assembly, rest.nodes, forces),
                residual=0.0,
            )
            return Rest(rest.nodes, forces, verdict)
        guess = interior_forces(equilibrium, wrench, rest.nodes.mu, tau)[0]
        doubtful = replace(doubtful, forces=guess.reshape(-1, 3))
    return rest
