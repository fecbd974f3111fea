"""Whether a state of rest leans on the number of nodes, seen from the friction that it has in reserve.

Where nothing slips, elastic contacts come to rest exactly where forces on the nodes balance all bodies, and nodes lie
within the patches: more of them carry more, and few are no danger. Where contacts slip, it depends on which do and how
far they are pressed, and few nodes may hold what more would let go. Goodman and Bray's 16 blocks that topple on the
steps of a slope rest from tan φ = 0.769 on with 7 nodes a side, 0.775 with 11, 0.781 with 25, and 0.7855 by hand.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holdfast.elastic.outcome import RestOutcome
from holdfast.engines.compliant.grid import FINER, Grid
from holdfast.engines.compliant.rest_verdict import at_rest, balanced_forces, not_at_rest
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status, Verdict

# Share of all friction without which an assembly that rests counts as far from its limit: on the usual nodes; halved
# each time on twice as many. On 7, 14 and 28 nodes a side 16 blocks on a slope rest with 0.0215, 0.0105 and 0.005 less
# than they need by hand, and five blocks with 0.0197, 0.0132 and 0.0105, and 0.0053 on 56.
AMPLE = 0.1
KEPT = 0.9  # of the reserve on half as many nodes: where as much is left, nodes hardly matter
SLIGHT = 1e-5  # share of all friction below which nothing is in reserve
FINELY = 1.05  # ratio of the shares between which a reserve is known
PATIENCE = 300  # steps of Newton's method after which rest on less friction is not sought any longer
MOST_NODES = 50_000  # of a grid on which rest is sought once more


def overruled(grid: Grid, refinements: int) -> Verdict | None:
    """Return the verdict that takes the place of rest on ``grid``, or None if rest does not lean on its nodes.

    It does not if the assembly rests without the share AMPLE of its friction, which is mostly one step of Newton's
    method away. Else twice the nodes are asked, up to ``refinements`` times: on them it has to come to rest, and to do
    so without half of that share, or without most of the share that it could do without before. Springs of imperfect
    faces are a sample, and nodes that are given were chosen: both are left alone.
    """
    if grid.springs.faces is not None or grid.places.given is not None or not refinements:
        return None
    if _without(grid, AMPLE) is RestOutcome.RESTS:
        return None
    reserve = ample = AMPLE
    for _ in range(refinements):
        if FINER**2 * len(grid.nodes) > MOST_NODES:
            break
        coarse, grid, ample = grid, grid.finer, ample / FINER
        if at_rest(grid) is None:
            return _fewer_hold(coarse, grid)
        if _without(grid, ample) is RestOutcome.RESTS:
            return None
        reserve = _reserve(coarse, reserve)
        if KEPT * reserve < ample and _without(grid, KEPT * reserve) is RestOutcome.RESTS:
            return None
    return _leans(f"it is so near its limit that more than {grid.springs.nodes} nodes a side may let it go")


def _reserve(grid: Grid, most: float) -> float:
    """Return a share of all friction, up to ``most``, without which an assembly at rest on ``grid`` gives way.

    It is hardly more than the least such share. Where a search for rest comes to no end, it may have been more.
    """
    rests, above, gives = SLIGHT, most, most
    while above > FINELY * rests:
        share = float(np.sqrt(above * rests))
        found = _without(grid, share)
        if found is RestOutcome.RESTS:
            rests = share
        else:
            above = share
            gives = share if found is RestOutcome.DRIFTS else gives
    return gives


def _without(grid: Grid, share: float) -> RestOutcome:
    """Say how the search for rest ends without this share of all friction, beginning at rest with all of it."""
    system, q = grid.system.slippery(1 - share), grid.settled.q
    if grid.hold is None and system.balances(np.zeros((1, len(q))), np.zeros(1), q[None])[0]:
        return RestOutcome.RESTS
    found = system.come_to_rest(near=q, most=PATIENCE)
    if found.outcome is RestOutcome.RESTS and balanced_forces(replace(grid, system=system), found.q) is None:
        return RestOutcome.DRIFTS  # the regularisation spring carries
    return found.outcome


def _fewer_hold(coarse: Grid, fine: Grid) -> Verdict:
    """Return the verdict on an assembly that rests on a grid and not on a finer one."""
    few, many = coarse.springs.nodes, fine.springs.nodes
    if fine.settled.outcome is not RestOutcome.DRIFTS:
        return _leans(f"on {many} nodes a side no rest is found, as it is on {few}")
    found = not_at_rest(fine)
    return replace(found, reason=f"on {many} nodes a side {found.reason}; {few} nodes a side would hold it")


def _leans(why: str) -> Verdict:
    found = undecided(f"elastic contacts with friction come to rest, but that leans on the number of nodes: {why}")
    return replace(found, status=Status.UNDECIDED, equilibrium_exists=True)
