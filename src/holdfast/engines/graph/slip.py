"""Slip robustness R_slip: maximum flow through the contact interface graph (Sec. V-B), or the least of all its cuts.

A push on one body flows along interfaces to the fixed node, each of which takes what its contacts can still carry; one
maximum flow gives R_slip of all pushes on a body in a direction. For loads on several bodies, as the inertia of all
under an acceleration, every feasible cut is asked (Algorithm 3): R_slip = min over c of C of the capacity that leaves c
over the load in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.graph.cuts import InterfaceGraph
from holdfast.native import core


@dataclass(frozen=True, eq=False)
class Slipping:
    """The slip robustness of a contact interface graph G."""

    G: InterfaceGraph

    def robustness(self, wrenches: Float) -> tuple[Float, Bool]:
        """Return R_slip (n,) and which bodies slide (n, J), for wrenches (n, J, 6).

        Loads that combine forces of different directions raise HoldfastError.
        """
        forces = wrenches[:, :, :3]
        size = np.linalg.norm(forces, axis=2)
        loaded = size > 0
        total = size.sum(1)
        direction = np.divide(forces.sum(1), total[:, None], out=np.zeros((len(total), 3)), where=total[:, None] > 0)
        if (np.abs(np.linalg.norm(direction, axis=1) - 1)[total > 0] > 1e-9).any():
            problem = "a load combines forces of different directions, for which its slip rule is not defined"
            raise HoldfastError(message("engine graph", problem, "use engine 'limit' or 'compliant' for it"))
        single = (loaded.sum(1) == 1) & (not self.G.isolated)
        R_slip = np.full(len(total), np.inf)
        side = np.zeros(loaded.shape, dtype=bool)
        if single.any():
            source = np.argmax(loaded, axis=1)
            R_slip[single], side[single] = self._by_flow(source[single], direction[single])
        for k in np.flatnonzero((total > 0) & ~single):
            R_slip[k], side[k] = self._by_cuts(size[k] / total[k], direction[k])
        return np.divide(R_slip, total, out=np.full(len(total), np.inf), where=total > 0), side

    def _by_flow(self, source: Int, direction: Float) -> tuple[Float, Bool]:
        """Return R_slip (n,) and which bodies slide (n, J), for n pushes on one body each.

        Push k acts on body ``source[k]`` along ``direction[k]`` (3,). One maximum flow is computed for each different
        pair of body and direction.
        """
        G, nodes = self.G, self.G.nodes
        keys = np.column_stack([source, np.round(direction, 9) + 0.0])
        _, first, back = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        side = np.zeros((len(first), len(G.number) + 1), dtype=bool)
        R_slip = core.slip_many(
            G.forces, nodes.axes, nodes.mu, nodes.interface, *G.ends, len(G.number) + 1,
            G.number[source[first]], np.ascontiguousarray(direction[first]), side,
        )  # fmt: skip
        back = back.reshape(-1)
        return np.asarray(R_slip[back]), np.asarray(side[back, :-1])

    def _by_cuts(self, share: Float, direction: Float) -> tuple[float, Bool]:
        """Return R_slip and which bodies slide (J,) for a load on several bodies along one direction (Algorithm 3).

        ``share`` (J,) is the share of the total force that acts on each body.
        """
        nodes, (inside, leaving) = self.G.nodes, self._leaving
        interfaces = len(self.G.assembly.interfaces)
        capacity = core.arc_capacities(self.G.forces, nodes.axes, nodes.mu, nodes.interface, interfaces, direction)
        endless = ~np.isfinite(capacity.ravel())
        out = np.where(leaving @ endless > 0, np.inf, leaving @ np.where(endless, 0.0, capacity.ravel()))
        load = inside @ share
        R_c = np.divide(out, load, out=np.full(len(load), np.inf), where=load > 0)
        best = int(np.argmin(R_c)) if len(R_c) else 0
        if not len(R_c) or np.isinf(R_c[best]):
            return np.inf, np.zeros(len(share), dtype=bool)
        return float(R_c[best]), inside[best] > 0

    @cached_property
    def _leaving(self) -> tuple[Float, Float]:
        """The bodies of every cut (cuts, J), and the arcs that leave it (cuts, 2 x interfaces), as 0 and 1."""
        tails, heads = self.G.ends
        inside = np.array([self.G.members(c) for c in self.G.cuts]).reshape(-1, len(self.G.number) + 1)
        a, b = inside[:, tails], inside[:, heads]
        leaving = np.stack([a & ~b, ~a & b], axis=2).reshape(len(inside), -1)
        return inside[:, :-1].astype(float), leaving.astype(float)
