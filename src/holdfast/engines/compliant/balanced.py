"""Which bodies at rest are only balanced: some motion of theirs is resisted by no contact, to first order.

A ball, a cube on its edge, a body on ice and a box whose centre of mass lies exactly over the edge of its support have
such motions. They slide or turn nowhere at contacts that have to press, and close none of the others, pressed or not: a
cylinder that lies between two walls without any clearance rolls neither way. Which contacts have to press is decided by
the forces of least sum that balance the weights, and not by elastic ones: those also press a box against a flush
neighbour, because what it stands on yields by a hair, and the friction there seems to hold it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import (
    ContactNodes,
    dense_by_bodies,
    equilibrium_blocks,
    equilibrium_operator,
)
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import cross
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.elastic.model import MOST_DENSE, Matrix, solver
from holdfast.engines.forces import NO_FORCE, force_program, lighter_share
from holdfast.engines.rest import corner_nodes
from holdfast.geometry.hull import convex_hull

NEAR_SINGULAR = 1e-14  # added to the diagonal so that a singular matrix can be factored, where others are of order one
NOT_MOVED = 1e-6  # velocity, relative to that of the fastest body, up to which a node or a body does not move
OPENS = 1e-4  # how fast a node opens at least, in the same units, in a motion that opens it
MUCH = 0.3  # what a contact carries, relative to that which carries most of a body, above which it counts beside that
BORDER = 0.05  # how near, relative to the size of a contact, a force acts to its border that may really act on it
MOST_NODES = 1000  # largest number of nodes of a dense matrix


@dataclass(frozen=True, eq=False)
class Neutral:
    """The motions (6J,) that no contact resists: F c for ``motions`` F (6J, d) and all c with ``rates`` (n, d) c >= 0.

    They are in ``units`` (6J,) of each body's size, and ``bodies`` (J,) tells which bodies take part in any.
    """

    bodies: Bool
    motions: Float
    rates: Float
    units: Float

    def named(self, assembly: Assembly) -> tuple[str, ...]:
        """Return the names of ``bodies``."""
        return tuple(body.name for body, one in zip(assembly.movable, self.bodies, strict=True) if one)

    def gained(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n) [N, N m], gain power in such a motion: the least of them moves it."""
        along = self.motions.T @ (self.units[:, None] * W)
        along /= np.maximum(np.abs(self.units[:, None] * W).max(axis=0, initial=0.0), 1e-300)
        gained = np.asarray((np.abs(along) > NOT_MOVED).any(axis=0))
        if len(self.rates):
            for k in np.flatnonzero(gained):
                # the largest gain @ c over all c in a box of side 2 with rates c >= 0
                gain = along[:, k]
                unit = np.eye(len(gain))
                A = sparse.csc_matrix(np.vstack([-self.rates, unit, -unit]))
                b = np.concatenate([np.zeros(len(self.rates)), np.ones(2 * len(gain))])
                P = sparse.csc_matrix((len(gain), len(gain)))
                found = solve(ConeProgram(P, -gain, A, b, (("nonnegative", len(b)),)))
                gained[k] = found.outcome is not Outcome.SOLVED or gain @ found.x > NOT_MOVED
        return gained


def on_an_edge(assembly: Assembly, nodes: ContactNodes, forces: Float, wrench: Float) -> Bool:
    """Tell which bodies (J,) may rest on an edge of the contact that carries most of them, and on nothing else.

    ``forces`` (I, 3) [N] at the nodes balance ``wrench`` (6J,) [N, N m]. If contacts that carry less than MUCH of that
    did nothing, the one that carries most would have to take a force near its border. One that presses everywhere by
    itself is far from that.
    """
    found, world = np.zeros(len(assembly.movable), dtype=bool), nodes.world(forces)
    total = np.bincount(nodes.interface, forces[:, 0], len(assembly.interfaces))
    least = np.full(len(total), np.inf)
    np.minimum.at(least, nodes.interface, forces[:, 0])
    thin = np.array([one.area == 0 for one in assembly.interfaces], dtype=bool)
    touched = np.array(assembly.ends, dtype=np.int64).ravel()  # of interface k: 2k and 2k + 1
    order = np.lexsort((-total.repeat(2), touched))
    bodies, begin = np.unique(touched[order], return_index=True)
    carries = order[begin] // 2  # that which carries most of each body, the first of equals
    doubtful = (bodies >= 0) & (thin[carries] | (least[carries] <= NO_FORCE * total[carries]))
    for k, most in zip(bodies[doubtful].tolist(), carries[doubtful].tolist(), strict=True):
        own = assembly.interfaces_of[k]
        force, moment = np.array(wrench[6 * k : 6 * k + 3]), np.array(wrench[6 * k + 3 : 6 * k + 6])
        for number in own:
            if number != most and total[number] > MUCH * total[most]:
                at = slice(*nodes.spans[number : number + 2])
                sign = np.where(nodes.b[at] == k, 1.0, -1.0)[:, None]
                force += (sign * world[at]).sum(axis=0)
                moment += (sign * cross(nodes.points[at] - assembly.com[k], world[at])).sum(axis=0)
        at = slice(*nodes.spans[most : most + 2])
        found[k] = _near_border(nodes.points[at] - assembly.com[k], nodes.axes[at.start], force, moment)
    return found


def _near_border(points: Float, axes: Float, force: Float, moment: Float) -> bool:
    """Tell whether the line of action of a force meets the plane of ``points`` (n, 3) near the border of their hull."""
    middle, along = points.mean(axis=0), float(axes[0] @ force)
    if abs(along) <= NO_FORCE * np.linalg.norm(force):
        return False
    start = cross(force, moment) / (force @ force)
    meets = start + force * float(axes[0] @ (middle - start)) / along
    flat, place = (points - middle) @ axes[1:].T, (meets - middle) @ axes[1:].T
    size = float(np.ptp(flat, axis=0).max())
    corners = convex_hull(flat, NOT_MOVED * size) if len(flat) > 2 else flat
    if len(corners) < 3:
        return bool(np.linalg.norm(place - flat, axis=1).min() <= size / 2)
    sides = np.roll(corners, -1, axis=0) - corners
    inside = (sides[:, 0] * (place - corners)[:, 1] - sides[:, 1] * (place - corners)[:, 0]) / np.hypot(*sides.T)
    return bool(abs(inside.min()) <= BORDER * size)


def neutral_at(assembly: Assembly, wrench: Float) -> Neutral | None:
    """Return the motions that no contact resists under ``wrench`` (6J,) [N, N m]; None if that was not found out."""
    nodes, count = corner_nodes(assembly), len(assembly.movable)
    program = force_program(assembly, nodes, nodes.under(wrench))
    least = np.zeros(3 * len(nodes))  # contacts press where the sum of all normal forces is the least
    least[::3] = 1.0
    found = solve(replace(program, P=sparse.csc_matrix(program.P.shape), q=least))
    if found.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return None
    pressed = (found.x[::3] > NO_FORCE * lighter_share(assembly, nodes)) | (nodes.pull > 0)
    units = np.repeat(np.array([(1.0, 1 / body.size) for body in assembly.movable]), 3, axis=1).ravel()
    gather = _motions_of(assembly, nodes, units)
    held = np.repeat(pressed, 3)
    held[1::3] &= nodes.mu > 0
    held[2::3] &= nodes.mu > 0
    resisted, opening = gather[held], gather[::3][~pressed]
    columns = np.repeat(_free(resisted), 6)
    motions, rates = np.zeros((6 * count, 0)), np.zeros((0, 0))
    if columns.any():
        free = _null(resisted[:, columns])
        opening = opening[:, columns]
        rates = opening[_used(opening)] @ free
        rates = rates[(np.abs(rates) > NOT_MOVED).any(axis=1)]
        open_ = _opened(rates)
        if open_ is None:
            return None
        motions = np.zeros((6 * count, free.shape[1]))
        motions[columns] = free
        moved = motions @ _null(rates[~open_])
    else:
        moved = motions
    bodies = np.abs(moved).max(axis=1, initial=0.0).reshape(-1, 6).max(axis=1) > NOT_MOVED
    return Neutral(bodies, motions, rates, units)


def _motions_of(assembly: Assembly, nodes: ContactNodes, units: Float) -> Matrix:
    """Return how nodes move (3I, 6J) as bodies do, in ``units`` (6J,): dense if it is small, as SciPy is slow then."""
    if len(units) > MOST_DENSE or len(nodes) > MOST_NODES:
        return sparse.csr_matrix(equilibrium_operator(assembly, nodes).T @ sparse.diags(units))
    blocks = equilibrium_blocks(assembly, nodes)
    return np.ascontiguousarray(dense_by_bodies(len(assembly.movable), nodes, blocks).T) * units


def _used(A: Matrix) -> Int:
    """Return the numbers of the rows of ``A`` with any entries."""
    return np.flatnonzero(A.any(axis=1) if isinstance(A, np.ndarray) else A.getnnz(axis=1))


def _free(resisted: Matrix) -> Bool:
    """Tell which bodies (J,) take part in motions that no row of ``resisted`` (m, 6J) resists, by inverse iteration."""
    square = resisted.T @ resisted
    solve_near = solver(square, NEAR_SINGULAR)
    x = np.random.default_rng(0).normal(size=square.shape[0])  # the same each time, and along no axis
    for _ in range(3):
        x = solve_near(x)
        x /= np.abs(x).max()
    if np.abs(resisted @ x).max(initial=0.0) > NOT_MOVED:
        return np.zeros(len(x) // 6, dtype=bool)
    return np.asarray(np.abs(x).reshape(-1, 6).max(axis=1) > NOT_MOVED)


def _null(A: Matrix) -> Float:
    """Return a basis (n, d) of what ``A`` (m, n) makes shorter than NOT_MOVED times its length."""
    used = A[_used(A)]
    dense = used if isinstance(used, np.ndarray) else used.toarray()
    _, values, rows = np.linalg.svd(np.vstack([dense, np.zeros((1, A.shape[1]))]), full_matrices=True)
    return np.asarray(rows[int((values > NOT_MOVED).sum()) :].T)


def _opened(rates: Float) -> Bool | None:
    """Tell which nodes (n,) are opened by some motion that presses none of them, all by a single one.

    None where that was not found out. ``rates`` (n, d) are those at which each of d motions opens the nodes.
    """
    nodes, count = rates.shape
    if not nodes or not count:
        return np.zeros(nodes, dtype=bool)
    opened, moved = sparse.eye(nodes, count + nodes, count), sparse.eye(count, count + nodes)
    A = sparse.vstack([sparse.hstack([sparse.csr_matrix(-rates), sparse.eye(nodes)]), opened, -opened, moved, -moved])
    program = ConeProgram(  # every node opens by up to OPENS, and all together by as much as can be
        P=sparse.csc_matrix((A.shape[1], A.shape[1])),
        q=np.concatenate([np.zeros(count), -np.ones(nodes)]),
        A=sparse.csc_matrix(A),
        b=np.concatenate([np.zeros(nodes), np.full(nodes, OPENS), np.zeros(nodes), np.ones(2 * count)]),
        cones=(("nonnegative", A.shape[0]),),
    )
    found = solve(program)
    return np.asarray(found.x[count:] > OPENS / 2) if found.outcome is Outcome.SOLVED else None
