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
    if _without(grid, AMPLE) is RestOutcome.RESTS:
        return None
    nodes = grid.springs.nodes
    if FINER**2 * len(grid.nodes) <= MOST_NODES:
        if at_rest(grid.finer) is None:
            return _fewer_hold(grid, grid.finer)
        if _without(grid.finer, KEPT * _reserve(grid)) is RestOutcome.RESTS:
            return None
        nodes = grid.finer.springs.nodes
    return _leans(f"it is so near its limit that more than {nodes} nodes a side may let it go")


def _reserve(grid: Grid) -> float:
    """Return the least share of all friction, up to AMPLE, without which an assembly at rest on ``grid`` drifts.

    It is up to FINELY times as large as that. A search for rest that comes to no end does not count as a drift.
    """
    holds, gives = SLIGHT, AMPLE
    while gives > FINELY * holds:
        share = float(np.sqrt(gives * holds))
        if _without(grid, share) is RestOutcome.DRIFTS:
            gives = share
        else:
            holds = share
    return gives


def _without(grid: Grid, share: float) -> RestOutcome:
    """Say how the search for rest ends without this share of all friction, beginning at rest with all of it."""
    system, q = grid.system.slippery(1 - share), grid.settled.q
    if grid.hold is None and system.rest_near(q) is not None:
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
    found = undecided(f"every body comes to rest, but that leans on the number of nodes: {why}")
    return replace(found, status=Status.UNDECIDED, equilibrium_exists=True)
