"""Which bodies at rest are only balanced: some motion of theirs is resisted by no contact.

A ball, a cube on its edge and a body on ice have such motions, whatever happens at the rim of their contacts. A box
whose centre of mass lies exactly over the edge of its support has one, too, but for a kink of the law: all of its
weight is concentrated at the edge, and the next nodes just touch without any force. Taken for pressed, these resist
every turn, although one to the outside only opens them. So nodes whose force is nothing but rounding count as open, and
a motion that nothing else resists counts if it presses none of them. Where it would press one, as a cylinder that lies
between two walls without any clearance does when it rolls either way, the least push meets resistance; but at the state
of rest itself it may still have no stiffness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from holdfast.base.arrays import Bool, Float, Int
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import Outcome, solve
from holdfast.elastic.law import evaluate
from holdfast.elastic.model import Elastic
from holdfast.elastic.sparse import NO_RESISTANCE, resistance, unresisted_motion

TAKEN_ALONG = 1e-3  # displacement, relative to the largest in a motion, above which a body takes part in the motion
OPENS = 1e-4  # how far a node opens at least, relative to the largest displacement, in a motion that opens it
NOT_PRESSED = 1e-6  # how far a node may be pressed in a motion that neither presses nor opens it, in the same units


class Free(NamedTuple):
    """Bodies at rest that some motions of theirs meet no stiffness in.

    ``unstiff`` (J,) tells which have such a motion as long as no node begins to press; ``balanced`` (J,), which of
    them have one in which none begins to.
    """

    unstiff: Bool
    balanced: Bool


def free_at(m: Elastic, q: Float, rounding: float) -> Free:
    """Return the bodies that are free at the state of rest ``q`` (6J,).

    Forces of nodes up to ``rounding``, as a share of the largest on each of the bodies that touch there, count as none.
    """
    pressed = _pressed(m, q)
    touching = _touching(m, pressed, rounding)
    K = np.empty_like(m.bonded)
    firm = m._replace(apart=np.where(touching, m.apart + 2 * np.abs(pressed) + 1, m.apart))
    evaluate(firm, 1.0, q, np.zeros(len(q)), K, np.zeros(6), np.zeros(6))
    moved = unresisted_motion(m, K) > TAKEN_ALONG
    sheet = _sheets(m)
    nodes = np.flatnonzero(touching & (_with_fixed(moved)[m.a] | _with_fixed(moved)[m.b])[sheet])
    if not len(nodes):
        return Free(moved, moved)
    balanced = moved.copy()
    joined = np.zeros(len(m.a), dtype=bool)
    joined[sheet[touching | (pressed > 0)]] = True
    for bodies in _parts(m, moved, joined):
        inside = np.isin(m.a, bodies) | np.isin(m.b, bodies)
        own = nodes[inside[sheet[nodes]]]
        if len(own):
            balanced[bodies] = _not_pressing(m, K, bodies, own)
    return Free(moved, balanced)


def _pressed(m: Elastic, q: Float) -> Float:
    """How far each node (I,) is pressed under ``q`` (6J,), negative where it is open."""
    ends = np.vstack([q.reshape(-1, 6), np.zeros(6)])  # index -1: fixed
    shift, turn = np.zeros((2, len(m.a), 3))
    for bodies, arm, sign in ((m.b, m.arm_b, 1.0), (m.a, m.arm_a, -1.0)):
        shift += sign * (ends[bodies, :3] + np.cross(ends[bodies, 3:], arm))
        turn += sign * ends[bodies, 3:]
    shift, turn = (np.einsum("pij,pj->pi", m.axes, one)[_sheets(m)] for one in (shift, turn))
    return np.asarray(m.x * turn[:, 2] - m.y * turn[:, 1] - shift[:, 0] - m.apart)


def _sheets(m: Elastic) -> Int:
    """Return the sheet (I,) of each node."""
    return np.repeat(np.arange(len(m.a)), np.diff(m.first))


def _with_fixed(moved: Bool) -> Bool:
    return np.append(moved, False)  # index -1: fixed


def _touching(m: Elastic, pressed: Float, rounding: float) -> Bool:
    """Tell at which nodes (I,) two bodies just touch: more or less pressed, by rounding alone."""
    sheet, largest = _sheets(m), np.zeros(len(m.wrench) // 6 + 1)
    for bodies in (m.a, m.b):
        np.maximum.at(largest, bodies[sheet], m.k * pressed)
    largest[-1] = np.inf
    return np.asarray(m.k * np.abs(pressed) <= rounding * np.minimum(largest[m.a], largest[m.b])[sheet])


def _parts(m: Elastic, moved: Bool, joined: Bool) -> list[Int]:
    """Return the bodies that are ``moved`` (J,), part by part: those that ``joined`` (P,) sheets lie between."""
    numbers = np.flatnonzero(moved)
    between = joined & _with_fixed(moved)[m.a] & _with_fixed(moved)[m.b]
    ends = np.searchsorted(numbers, m.a[between]), np.searchsorted(numbers, m.b[between])
    graph = sparse.csr_matrix((np.ones(len(ends[0])), ends), shape=(len(numbers), len(numbers)))
    count, part = connected_components(graph, directed=False)
    return [numbers[part == k] for k in range(count)]


def _not_pressing(m: Elastic, K: Float, bodies: Int, nodes: Int) -> Bool:
    """Tell which of some ``bodies`` (k,) move without any resistance of ``K`` and without pressing these ``nodes``.

    The motions that press none make up a cone. A single one of them opens every node that any of them opens; all
    bodies that take part in any move in some motion that neither opens nor presses the others.
    """
    A, unit = resistance(m, K)
    columns = (6 * bodies[:, None] + np.arange(6)).ravel()
    own = A[:, columns]
    block = own[np.flatnonzero(own.getnnz(axis=1))].toarray()
    free = _null(np.vstack([block, np.zeros((1, len(columns)))]), NO_RESISTANCE * np.sqrt(len(block) + 1))
    opening = (_opening(m, nodes) @ sparse.diags(unit)).tocsc()[:, columns].toarray()
    opening /= np.abs(opening).max(axis=1, keepdims=True)
    rates = opening @ free
    open_ = _opened(rates)
    if open_ is None:
        return np.ones(len(bodies), dtype=bool)
    motions = free @ _null(np.vstack([rates[~open_], np.zeros((1, rates.shape[1]))]), NOT_PRESSED)
    return np.asarray(np.abs(motions).max(axis=1, initial=0.0).reshape(-1, 6).max(axis=1) > TAKEN_ALONG)


def _null(A: Float, least: float) -> Float:
    """Return a basis (n, d) of what ``A`` (m, n) makes shorter than ``least`` times its length."""
    _, values, rows = np.linalg.svd(A, full_matrices=True)
    return np.asarray(rows[int((values > least).sum()) :].T)


def _opening(m: Elastic, nodes: Int) -> sparse.csr_matrix:
    """Return the matrix (k, 6J) that says how fast each of these ``nodes`` (k,) opens in a motion of the bodies."""
    sheet = _sheets(m)[nodes]
    normal, x, y = m.axes[sheet, 0], m.x[nodes][:, None], m.y[nodes][:, None]
    turned = y * m.axes[sheet, 1] - x * m.axes[sheet, 2]
    rows, columns, values = [], [], []
    for bodies, arm, sign in ((m.b, m.arm_b, 1.0), (m.a, m.arm_a, -1.0)):
        at = np.flatnonzero(bodies[sheet] >= 0)
        own = sign * np.hstack([normal, np.cross(arm[sheet], normal) + turned])[at]
        rows.append(np.repeat(at, 6))
        columns.append((6 * bodies[sheet[at], None] + np.arange(6)).ravel())
        values.append(own.ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(entries, shape=(len(nodes), len(m.wrench)))


def _opened(rates: Float) -> Bool | None:
    """Tell which nodes (k,) can be opened while none is pressed, by combining motions with ``rates`` (k, d).

    None where that was not found out. The rates are those at which each of the motions opens the nodes.
    """
    nodes, count = rates.shape
    if not count:
        return np.zeros(nodes, dtype=bool)
    opened, moved = np.eye(nodes, count + nodes, count), np.eye(count, count + nodes)
    A = np.vstack([np.hstack([-rates, np.eye(nodes)]), opened, -opened, moved, -moved])
    program = ConeProgram(  # every node opens by up to OPENS, and all together by as much as can be
        P=sparse.csc_matrix((A.shape[1], A.shape[1])),
        q=np.concatenate([np.zeros(count), -np.ones(nodes)]),
        A=sparse.csc_matrix(A),
        b=np.concatenate([np.zeros(nodes), np.full(nodes, OPENS), np.zeros(nodes), np.ones(2 * count)]),
        cones=(("nonnegative", A.shape[0]),),
    )
    found = solve(program)
    return np.asarray(found.x[count:] > OPENS / 2) if found.outcome is Outcome.SOLVED else None
