"""Enumeration of the feasible cuts of the contact interface graph (Sec. V-C1).

A feasible cut is a connected set of movable bodies whose complement, which includes the fixed node, is connected too.
Every cut is found exactly once, and no branch of the search ends without a cut. Form-closed sets are not excluded: all
their toppling axes come out as blocked, so excluding them could save time but could not change an answer.
"""

from __future__ import annotations

from collections.abc import Sequence

from holdfast.base.errors import SolverError, message


def neighbour_masks(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Return, for each of the nodes 0..count-1, the bit mask of its neighbours."""
    masks = [0] * count
    for a, b in edges:
        if a != b:
            masks[a] |= 1 << b
            masks[b] |= 1 << a
    return masks


def feasible_cuts(count: int, edges: Sequence[tuple[int, int]], *, limit: int) -> list[int]:
    """Return the bit masks of all feasible cuts of a connected graph on nodes 0..count-1. The last node is fixed.

    The search grows a set of bodies from its lowest-numbered body. Each step either adds one neighbour, together with
    everything that this would separate from the fixed node, or excludes the neighbour for good. Every branch ends in a
    cut, so the work is polynomial per cut. The number of cuts is exponential at worst; more than ``limit`` raise
    SolverError.
    """
    masks = neighbour_masks(count, edges)
    fixed = 1 << (count - 1)
    everything = (1 << count) - 1
    cuts: list[int] = []
    for lowest in range(count - 1):
        shut_out = fixed | ((1 << lowest) - 1)
        first = _closed(1 << lowest, masks, fixed, everything)
        stack = [] if first & shut_out else [(first, shut_out)]
        while stack:
            inside, outside = stack.pop()
            candidates = _border(inside, masks) & ~inside & ~outside
            if not candidates:
                cuts.append(inside)
                if len(cuts) > limit:
                    raise _too_many(limit, count - 1)
                continue
            chosen = candidates & -candidates
            stack.append((inside, outside | chosen))
            grown = _closed(inside | chosen, masks, fixed, everything)
            if not grown & outside:
                stack.append((grown, outside))
    return cuts


def _border(group: int, masks: Sequence[int]) -> int:
    border = 0
    while group:
        low = group & -group
        border |= masks[low.bit_length() - 1]
        group ^= low
    return border


def _closed(inside: int, masks: Sequence[int], fixed: int, everything: int) -> int:
    """Return ``inside`` together with all nodes that it separates from the fixed node, as a bit mask."""
    reached = frontier = fixed
    while frontier:
        frontier = _border(frontier, masks) & ~reached & ~inside
        reached |= frontier
    return everything & ~reached


def _too_many(limit: int, bodies: int) -> SolverError:
    problem = f"{bodies} movable bodies have more than {limit:,} feasible cuts, and their number grows exponentially"
    remedy = (
        "declare heavy bodies immobile with Graph(immobile_above=kg) or fixed=True, assess a part of the scene, "
        "allow more with Graph(max_cuts=...), or use engine 'limit', whose work grows slowly"
    )
    return SolverError(message("engine graph", problem, remedy))
