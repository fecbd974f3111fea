"""The least forces and moments with which hands keep bodies in place: one cone program for all of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.public import Record, column
from holdfast.base.text import listed
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.engines.forces import EXACT, scaled_operator, scaled_wrench
from holdfast.engines.rest import corner_nodes

NOTHING = 1e-9  # share of the total weight: the tolerance of the solver


class HandHold(Record):
    """The least that a hand must do to hold one body where it is, while everything else stands.

    ``force`` (3,) [N] acts at the body's centre of mass, together with ``moment`` (3,) [N m], in the world frame. They
    are the ones with the least sum of their lengths over all bodies that are held, a moment counting as a force with
    the lever of the body's size: no hand does with less of both. ``prop`` says that this is falsework, which the hands
    of the question are too few for.
    """

    body: str
    force: Float = column("3")
    moment: Float = column("3")
    prop: bool = False

    @property
    def text(self) -> str:
        """The body with the lengths of force and moment."""
        force, moment = (float(np.linalg.norm(each)) for each in (self.force, self.moment))
        return f"{'prop' if self.prop else 'hold'} {self.body} with {force:.3g} N and {moment:.3g} N m"


def handled(holds: Sequence[HandHold], hands: int) -> list[str]:
    """Return a cell of a table for what is held in a step, if there are any ``hands``."""
    return [listed([hold.text for hold in holds])] if hands else []


def hands_column(hands: int) -> tuple[str, ...]:
    """Return the title of the column of ``handled``."""
    return ("hands then",) if hands else ()


def least_holds(assembly: Assembly, bodies: Sequence[str]) -> tuple[HandHold, ...] | None:
    """Return the least holds of some movable bodies with which contact forces balance the weights; None if none do.

    min Σ |F_b| + |M_b| / size_b   s.t.   G f + w + Σ (F_b, M_b) = 0,  f in the friction cones
    """
    if not bodies:
        return ()
    nodes = corner_nodes(assembly)
    wrench = nodes.under(assembly.weight_wrench())
    C, cones = EXACT.rows(nodes)
    rows, forces, count = len(wrench), 3 * len(nodes), len(bodies)
    scale = nodes.scaled(assembly.equation_scale)
    sizes = [assembly.scene.body(name).size for name in bodies]
    place = np.array([6 * assembly.index[name] for name in bodies])[:, None] + np.arange(6)
    lever = np.column_stack([np.ones((count, 3)), np.repeat(sizes, 3).reshape(-1, 3)]).ravel()
    hands = sparse.csr_matrix((scale[place.ravel()] * lever, (place.ravel(), np.arange(6 * count))), (rows, 6 * count))
    lengths = sparse.csr_matrix((rows, 2 * count))
    balance = sparse.hstack([scaled_operator(assembly, nodes), hands, lengths])
    friction = sparse.hstack([C, sparse.csr_matrix((C.shape[0], 8 * count))])
    part = np.arange(2 * count)
    columns = np.column_stack([6 * count + part, 3 * part, 3 * part + 1, 3 * part + 2]).ravel() + forces
    norms = sparse.csr_matrix((-np.ones(8 * count), (np.arange(8 * count), columns)), (8 * count, forces + 8 * count))
    A = sparse.csc_matrix(sparse.vstack([balance, friction, norms]))
    b = np.concatenate([-scaled_wrench(assembly, nodes, wrench), np.zeros(C.shape[0] + 8 * count)])
    q = np.concatenate([np.zeros(forces + 6 * count), np.ones(2 * count)])
    P = sparse.csc_matrix((len(q), len(q)))
    found = solve(ConeProgram(P, q, A, b, (("zero", rows), *cones, *((("second_order", 4),) * (2 * count)))))
    if found.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return None
    hands_do = found.x[forces : forces + 6 * count]
    hands_do[np.abs(hands_do) < NOTHING] = 0.0
    wrenches = (assembly.weight * lever * hands_do).reshape(-1, 6)
    return tuple(HandHold(name, each[:3], each[3:]) for name, each in zip(bodies, wrenches, strict=True))
