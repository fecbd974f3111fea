"""Feasible cuts of the contact interface graph (Sec. V-C1), each exactly once and never a dead end.

A cut is a connected set of movable bodies whose complement, fixed node included, is connected too. Form-closed sets
are not sorted out: their toppling axes all come out as blocked, so the test could save time but not change an answer.
"""

from __future__ import annotations

from collections.abc import Sequence

from holdfast.base.errors import SolverError, message


def neighbour_masks(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Bit masks of the neighbours of nodes 0..count-1."""
    masks = [0] * count
    for a, b in edges:
        if a != b:
            masks[a] |= 1 << b
            masks[b] |= 1 << a
    return masks


def feasible_cuts(count: int, edges: Sequence[tuple[int, int]], *, limit: int) -> list[int]:
    """Bit masks of all feasible cuts of a connected graph on 0..count-1 whose last node is the fixed one.

    Grows a set from its lowest body: each step takes one neighbour in, together with everything this would separate
    from the fixed node, or shuts it out for good. Every branch ends in a cut, so the work is polynomial per cut; their
    number is exponential at worst, and more than ``limit`` raise SolverError.
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
    """``inside`` with all that it separates from the fixed node."""
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
