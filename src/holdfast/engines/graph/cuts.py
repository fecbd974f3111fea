"""The contact interface graph (CIG) G, and the enumeration of its feasible cuts C (Sec. V-C1).

A feasible cut c is a connected set of movable bodies whose complement, which includes the fixed node, is connected too.
Every cut is found exactly once, and no branch of the search ends without a cut. Form-closed sets are not excluded: all
their toppling axes come out as blocked, so excluding them could save time but could not change an answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import SolverError, message


@dataclass(frozen=True, eq=False)
class InterfaceGraph:
    """The graph G of an ``assembly`` whose contact forces at rest, ``forces`` (I, 3) [N], are known at ``nodes``.

    Its J + 1 nodes are the movable bodies and the fixed one, J, which ``immobile`` bodies (J,) belong to as well. If
    bodies are ``isolated``, each is a cut of its own. More feasible cuts than ``most`` raise SolverError.
    """

    assembly: Assembly
    nodes: ContactNodes
    forces: Float
    immobile: Bool
    isolated: bool
    most: int

    @cached_property
    def number(self) -> Int:
        """(J,) the number of the node of each movable body."""
        count = len(self.assembly.movable)
        return np.where(self.immobile, count, np.arange(count))

    @cached_property
    def ends(self) -> tuple[Int, Int]:
        """The node numbers of the first and the second body of each interface."""
        count = len(self.assembly.movable)
        ends = np.array(self.assembly.ends, dtype=np.int64).reshape(-1, 2)
        mapped = np.where(ends == FIXED, count, self.number[np.maximum(ends, 0)]) if count else ends
        return np.ascontiguousarray(mapped[:, 0]), np.ascontiguousarray(mapped[:, 1])

    @cached_property
    def cuts(self) -> list[int]:
        """The feasible cuts C, as bit masks over the J movable bodies. Immobile bodies are in none of them."""
        count = len(self.assembly.movable)
        if self.isolated:
            return [1 << k for k in range(count) if not self.immobile[k]]
        mobile = np.flatnonzero(~self.immobile)
        compact = np.full(count + 1, len(mobile))
        compact[mobile] = np.arange(len(mobile))
        edges = [(int(compact[a]), int(compact[b])) for a, b in zip(*self.ends, strict=True)]
        cuts = feasible_cuts(len(mobile) + 1, edges, limit=self.most)
        if len(mobile) == count:
            return cuts
        return [sum(1 << int(mobile[k]) for k in range(len(mobile)) if cut >> k & 1) for cut in cuts]

    def members(self, cut: int) -> Bool:
        """Tell which nodes (J + 1,) are in a cut, given as a bit mask."""
        return np.array([cut >> k & 1 for k in range(len(self.assembly.movable) + 1)], dtype=bool)


def neighbour_masks(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Return, for each of the nodes 0..count-1, the bit mask of its neighbours."""
    masks = [0] * count
    for a, b in edges:
        if a != b:
            masks[a] |= 1 << b
            masks[b] |= 1 << a
    return masks


FEWER = (
    "declare heavy bodies immobile with Graph(immobile_above=kg) or fixed=True, assess a part of the scene, "
    "allow more with Graph(max_cuts=...), or use engine 'limit', whose work grows slowly"
)


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
                    bodies = f"{count - 1} movable bodies"
                    problem = f"{bodies} have more than {limit:,} feasible cuts, and their number grows exponentially"
                    raise SolverError(message("engine graph", problem, FEWER))
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
