"""Contact forces well inside their friction cones: what forces on the border of their cones are mixed with."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float
from holdfast.conic.program import ConeKind, ConeProgram
from holdfast.conic.solve import solve
from holdfast.engines.limit.balance import Balance
from holdfast.engines.limit.rounding import Equilibrium

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
    pushed = np.zeros((len(wrench), 0)) if load is None else _sized(load, unit)
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


def _sized(load: Float, unit: sparse.csr_matrix) -> Float:
    """Return a load (6J,) as a column (6J, 1) of the size 1 in scaled equations."""
    return np.asarray(load[:, None] / float(np.max(np.abs(np.asarray(unit @ load)), initial=1e-300)))
