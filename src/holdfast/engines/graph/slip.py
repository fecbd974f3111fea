"""Slip at a contact node and through the assembly (eq. 14-22), in compiled functions.

The contact force is the one on the RECEIVING body, along its inward normal. Seen from the other body, both the force
and the frame are reversed. The components of the force therefore stay the same and only the push changes sign: an arc
from the receiving body back to the other has capacity R_k(f, -e).
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled, lean

DISCRIMINANT = 1e-9  # relative |d| below which the push counts as parallel to the side of the cone
ON_CONE = 1e-7  # c0 over (mu f_n)² below which c0 counts as 0: it is solver noise, and R depends on its square root


@compiled
@lean
def node_slip(fn: float, f1: float, f2: float, mu: float, en: float, e1: float, e2: float) -> float:
    """Return R_k, the largest s >= 0 with |f_t + s e_t| <= mu (f_n + s e_n), or inf if every s >= 0 satisfies this.

    The force is (fn, f1, f2) [N] and the unit push (en, e1, e2), both along (normal, t1, t2). With
    c0 = mu² f_n² - |f_t|², b = mu² f_n e_n - f_t·e_t and d = mu² e_n² - |e_t|², R_k is the first root of
    c0 + 2 b s + d s² = 0 on the upper half of the cone (f_n + s e_n >= 0). This form has no cancellation and keeps the
    sign of e_n (eq. 19 prints |e_n|). It also works for a force that solver noise puts slightly outside the cone.
    """
    et2 = e1 * e1 + e2 * e2
    if mu == 0.0:
        if et2 > DISCRIMINANT:
            return 0.0
        return np.inf if en >= 0.0 else max(fn, 0.0) / -en
    fn = max(fn, 0.0)
    c0 = mu * mu * fn * fn - f1 * f1 - f2 * f2
    if c0 <= ON_CONE * mu * mu * fn * fn:
        c0 = 0.0
    b = mu * mu * fn * en - f1 * e1 - f2 * e2
    d = mu * mu * en * en - et2
    if abs(d) <= DISCRIMINANT * (mu * mu * en * en + et2):
        d = 0.0
    n = np.sqrt(max(b * b - d * c0, 0.0))
    if d < 0.0 and b > 0.0:
        return float((b + n) / -d)
    if d < 0.0 or en < 0.0:
        return c0 / (n - b) if n > b else 0.0
    return np.inf


@compiled
def arc_capacities(forces: Float, axes: Float, mu: Float, owner: Int, count: int, direction: Float) -> Float:
    """Return the capacity (count, 2) [N] of every interface for a push along ``direction`` (3,) (eq. 21).

    Column 0 is the capacity from body a to body b, column 1 that from b to a. ``forces`` (I, 3) [N] are local, ``axes``
    (I, 3, 3) are the frames of the nodes, and ``owner`` (I,) is the interface of each node.
    """
    capacity = np.zeros((count, 2))
    for i in range(len(forces)):
        en = 0.0
        e1 = 0.0
        e2 = 0.0
        for k in range(3):
            en += axes[i, 0, k] * direction[k]
            e1 += axes[i, 1, k] * direction[k]
            e2 += axes[i, 2, k] * direction[k]
        capacity[owner[i], 0] += node_slip(forces[i, 0], forces[i, 1], forces[i, 2], mu[i], en, e1, e2)
        capacity[owner[i], 1] += node_slip(forces[i, 0], forces[i, 1], forces[i, 2], mu[i], -en, -e1, -e2)
    return capacity


@compiled
def max_flow(tails: Int, heads: Int, capacity: Float, source: int, sink: int, count: int) -> tuple[float, Bool]:
    """Return the maximum flow from source to sink, and which nodes (count,) are on the source's side of a minimum cut.

    ``capacity`` (arcs, 2) is that from tail to head and that from head to tail. The first pass uses unbounded arcs
    alone: a path of these means an unbounded flow. The second pass takes shortest augmenting paths, and counts the
    capacity of an unbounded arc as more than that of all finite arcs together.
    """
    total = 0.0
    for i in range(len(tails)):
        for way in range(2):
            if np.isfinite(capacity[i, way]):
                total += capacity[i, way]
    residual = capacity.copy()
    for unbounded_only in (True, False):
        if not unbounded_only:
            for i in range(len(tails)):
                for way in range(2):
                    residual[i, way] = capacity[i, way] if np.isfinite(capacity[i, way]) else 1.0 + total
        flow = 0.0
        tiny = 1e-12 * total
        while True:
            parent = np.full(count, -1, dtype=np.int64)
            parent[source] = -2
            queue = np.empty(count, dtype=np.int64)
            queue[0] = source
            first, last = 0, 1
            while first < last and parent[sink] == -1:
                node = queue[first]
                first += 1
                for i in range(len(tails)):
                    for way in range(2):
                        tail = tails[i] if way == 0 else heads[i]
                        head = heads[i] if way == 0 else tails[i]
                        if tail != node or parent[head] != -1:
                            continue
                        room = residual[i, way]
                        if (unbounded_only and np.isfinite(room)) or room <= tiny:
                            continue
                        parent[head] = 2 * i + way
                        queue[last] = head
                        last += 1
            if parent[sink] == -1:
                break
            if unbounded_only:
                return np.inf, parent != -1
            bottleneck = np.inf
            node = sink
            while node != source:
                i, way = parent[node] // 2, parent[node] % 2
                bottleneck = min(bottleneck, residual[i, way])
                node = tails[i] if way == 0 else heads[i]
            node = sink
            while node != source:
                i, way = parent[node] // 2, parent[node] % 2
                residual[i, way] -= bottleneck
                residual[i, 1 - way] += bottleneck
                node = tails[i] if way == 0 else heads[i]
            flow += bottleneck
    return flow, parent != -1


@compiled
def slip_many(
    forces: Float,
    axes: Float,
    mu: Float,
    owner: Int,
    tails: Int,
    heads: Int,
    count: int,
    sources: Int,
    directions: Float,
) -> tuple[Float, Bool]:
    """Return R_slip (n,) [N] and which nodes slide (n, count), for n pushes (eq. 22).

    Push k acts on body ``sources[k]`` along ``directions[k]`` (3,). Bodies are the nodes 0..count-2 of the graph, and
    the fixed node is count-1. The other arguments are those of ``arc_capacities`` and ``max_flow``.
    """
    strength = np.empty(len(sources))
    side = np.zeros((len(sources), count), dtype=np.bool_)
    for q in range(len(sources)):
        capacity = arc_capacities(forces, axes, mu, owner, len(tails), directions[q])
        strength[q], reached = max_flow(tails, heads, capacity, sources[q], count - 1, count)
        if np.isfinite(strength[q]):
            side[q] = reached
    return strength, side
