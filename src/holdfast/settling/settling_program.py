"""One small motion of all bodies of a group as a cone program."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import tangents
from holdfast.conic.solve import ConeKind, ConeProgram, Outcome, solve

GIVING = 1e4  # [weights of the heaviest body] force at which an overlap that cannot be removed yields
TOLERANCE = 1e-11  # of the cone program
ROUGHLY = 1e-8  # the same for steps that the next step corrects
ROUNDS = 8  # largest number of solutions of one step; after each, violated contacts are added to the program
VIOLATED = 1e-4  # relative to the unit of length: smaller violations do not count
LEFT = 1e-2  # relative to the unit of length: smaller violations are left to the next step
SOON = 0.3  # relative to the unit of length: contacts that would be farther apart are added only when violated
MORE = 3  # number of contacts of a pair of bodies that are added at a time


@dataclass(frozen=True, eq=False)
class StepContacts:
    """All near points of a group.

    ``ends`` (n, 2) are the numbers of the two bodies; numbers from ``movable`` on are fixed bodies. ``points`` and
    ``normals`` (n, 3), ``gaps`` and ``chosen`` (n,) are as in ``Near``, and ``mu`` (n,) are the friction coefficients.
    """

    ends: Int
    movable: int
    points: Float
    normals: Float
    gaps: Float
    mu: Float
    chosen: Bool

    def only(self, which: Bool) -> StepContacts:
        """Return those contacts for which ``which`` (n,) is true."""
        return StepContacts(self.ends[which], self.movable, *(column[which] for column in self._columns))

    def with_(self, others: StepContacts) -> StepContacts:
        """Return these contacts together with ``others`` of the same bodies."""
        both = (np.concatenate(two) for two in zip(self._columns, others._columns, strict=True))
        return StepContacts(np.concatenate([self.ends, others.ends]), self.movable, *both)

    @property
    def _columns(self) -> tuple[NDArray[Any], ...]:
        return self.points, self.normals, self.gaps, self.mu, self.chosen

    def __len__(self) -> int:
        return len(self.gaps)


def relative_motion(contacts: StepContacts, centres: Float, levers: Float, directions: Float) -> sparse.csr_matrix:
    """Return the operator (n, 6J) from motions to the relative displacement of the second body along ``directions``.

    ``directions`` (n, 3) are unit vectors, one for each contact. The motion of a body is the displacement (3,) of its
    centre of mass, one of ``centres`` (J, 3), and its rotation (3,) times its lever, one of ``levers`` (J,).
    """
    rows, columns, entries = [], [], []
    for side, sign in ((contacts.ends[:, 0], -1.0), (contacts.ends[:, 1], 1.0)):
        number = np.flatnonzero(side < contacts.movable)
        body = side[number]
        arm = np.cross(contacts.points[number] - centres[body], directions[number]) / levers[body, None]
        rows.append(np.repeat(number, 6))
        columns.append((6 * body[:, None] + np.arange(6)).ravel())
        entries.append(sign * np.hstack([directions[number], arm]).ravel())
    shape = (len(contacts), 6 * len(centres))
    data = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_matrix(sparse.coo_matrix(data, shape=shape))


def step_program(
    contacts: StepContacts, centres: Float, levers: Float, metric: Float, pull: Float, giving: float | None
) -> ConeProgram:
    """Set up min ½ v'Mv - f'v  s.t.  g + n·v >= μ |t·v| at every contact (Anitescu 2006).

    v (6J,) are the motions as in ``relative_motion``, ``metric`` (J, 6) is the diagonal of M, ``pull`` (6J,) is f.
    Lengths are in any one unit. With ``giving``, every contact may yield, so that there is always a solution: n further
    variables s >= 0 are added to the left-hand sides, each with the cost ``giving`` times the largest entry of M.
    """
    J, n, mu = len(centres), len(contacts), contacts.mu
    rough = mu > 0
    away = relative_motion(contacts, centres, levers, contacts.normals)
    blocks = [-away[~rough]]
    b = [contacts.gaps[~rough]]
    cones: list[tuple[ConeKind, int]] = [("nonnegative", int((~rough).sum()))]
    count = int(rough.sum())
    if count:
        sliding = [relative_motion(contacts, centres, levers, t)[rough] for t in tangents(contacts.normals)]
        scale = sparse.diags(mu[rough])
        stacked = sparse.vstack([-away[rough], *(-(scale @ slide) for slide in sliding)]).tocsr()
        blocks.append(stacked[np.arange(3 * count).reshape(3, count).T.ravel()])
        b.append(np.column_stack([contacts.gaps[rough], np.zeros((count, 2))]).ravel())
        cones += [("second_order", 3)] * count
    A = sparse.csr_matrix(sparse.vstack(blocks))
    diagonal, q = metric.ravel(), -pull
    if giving is not None:
        place = np.concatenate([np.arange(n - count), n - count + 3 * np.arange(count)])
        slack = sparse.csr_matrix((-np.ones(n), (place, np.arange(n))), shape=(A.shape[0], n))
        below = sparse.csr_matrix((-np.ones(n), (np.arange(n), 6 * J + np.arange(n))), shape=(n, 6 * J + n))
        A = sparse.csr_matrix(sparse.vstack([sparse.hstack([A, slack]), below]))
        b.append(np.zeros(n))
        cones.append(("nonnegative", n))
        diagonal = np.concatenate([diagonal, np.zeros(n)])
        q = np.concatenate([q, np.full(n, giving * float(np.abs(metric).max()))])
    kept = tuple(cone for cone in cones if cone[1])
    return ConeProgram(sparse.diags(diagonal, format="csc"), q, sparse.csc_matrix(A), np.concatenate(b), kept)


def small_motion(
    contacts: StepContacts,
    centres: Float,
    levers: Float,
    metric: Float,
    pull: Float,
    *,
    unit: float,
    friction: bool,
    before: Float | None = None,
    giving: float | None = None,
) -> tuple[Float | None, int]:
    """Return the motions (J, 6) that solve ``step_program`` with lengths in ``unit`` [m], or None if none is found.

    Also returns the number of contacts in all programs that were solved. The first three numbers of a motion are in
    metres, the others in radians. A free body moves by ``unit`` times the first three entries of ``pull`` (6J,) over
    its mass. If the motions ``before`` (J, 6) of the last step are given, the program is solved less exactly, because
    the next step corrects it, and begins with the contacts that matter if the bodies continue to move like that.
    """
    scaled = replace(contacts, points=contacts.points / unit, gaps=contacts.gaps / unit)
    if not friction:
        scaled = replace(scaled, mu=np.zeros(len(contacts)))
    centres, levers = centres / unit, levers / unit
    active, tolerance, least = contacts.chosen.copy(), TOLERANCE, VIOLATED
    if before is not None:
        tolerance, least = ROUGHLY, LEFT
        going = before / np.array([unit] * 3 + [1.0] * 3)
        active &= _slack(scaled, centres, going) < SOON
        active |= _violated(scaled, centres, going, least)
    solved = 0
    for _ in range(ROUNDS):
        solved += int(active.sum())
        found = _solved(scaled.only(active), centres, levers, metric, pull, tolerance, giving)
        if found is None:
            return None, solved
        motion = found.reshape(-1, 6)
        motion[:, 3:] /= levers[:, None]
        more = _violated(scaled, centres, motion, least) & ~active
        if not more.any():
            break
        active |= more
    motion[:, :3] *= unit
    return motion, solved


def _solved(
    contacts: StepContacts,
    centres: Float,
    levers: Float,
    metric: Float,
    pull: Float,
    tolerance: float,
    giving: float | None,
) -> Float | None:
    """Return the solution (6J,) of ``step_program``, or None.

    If there is no solution, friction is dropped in overlaps, because a body may only be able to leave them sideways. If
    there is still none, contacts may yield.
    """
    smooth = replace(contacts, mu=np.where(contacts.gaps < 0, 0.0, contacts.mu))
    firm = ((contacts, None), (smooth, None), (smooth, GIVING)) if giving is None else ((contacts, giving),)
    for tried, giving in firm:
        answer = solve(step_program(tried, centres, levers, metric, pull, giving), tolerance=tolerance)
        if answer.outcome in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
            return answer.x[: 6 * len(centres)]
    return None


def _moved_apart(contacts: StepContacts, centres: Float, motion: Float) -> Float:
    """Return the relative displacement (n, 3) of the second body at every contact, for motions (J, 6)."""
    fixed = np.zeros((1, 3))  # the motion and the centre of all fixed bodies
    shift, turn = np.concatenate([motion[:, :3], fixed]), np.concatenate([motion[:, 3:], fixed])
    bodies = np.minimum(contacts.ends, len(centres))
    arms = contacts.points[:, None] - np.concatenate([centres, fixed])[bodies]
    moved = shift[bodies] + np.cross(turn[bodies], arms)
    return np.asarray(moved[:, 1] - moved[:, 0])


def slips(contacts: StepContacts, centres: Float, motion: Float) -> tuple[Float, Float]:
    """Return the relative displacements along the normals (n,) and perpendicular to them (n,), for motions (J, 6)."""
    away = _moved_apart(contacts, centres, motion)
    along = (away * contacts.normals).sum(1)
    return along, np.linalg.norm(away - along[:, None] * contacts.normals, axis=1)


def _slack(contacts: StepContacts, centres: Float, motion: Float) -> Float:
    """Return g + n·v - μ |t·v| at every contact (n,), for motions (J, 6)."""
    along, across = slips(contacts, centres, motion)
    return np.asarray(contacts.gaps + along - contacts.mu * across)


def _violated(contacts: StepContacts, centres: Float, motion: Float, least: float) -> Bool:
    """Mark the contacts (n,) that motions (J, 6) violate by more than ``least``, only the worst few of every pair."""
    slack = _slack(contacts, centres, motion)
    worst = np.zeros(len(contacts), dtype=bool)
    order = np.flatnonzero(slack < -least)
    order = order[np.lexsort((slack[order], contacts.ends[order, 1], contacts.ends[order, 0]))]
    if len(order):
        pair = contacts.ends[order]
        begins = np.concatenate([[True], (pair[1:] != pair[:-1]).any(1)])
        rank = np.arange(len(order)) - np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
        worst[order[rank < MORE]] = True
    return worst
