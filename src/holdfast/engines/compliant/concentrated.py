"""Whether what presses a contact is concentrated on few of its nodes, as under a body that tips over a corner.

Few nodes say little about what the contact would hold: two nodes on a round rim resist a twist by their distance, a
point of the rim does not. Nor do twice as many nodes tell, as long as the force gathers on as few of them.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled
from holdfast.elastic.law import node_forces
from holdfast.elastic.model import Elastic
from holdfast.engines.compliant.places import Places

FEW = 12.0  # a contact's force is concentrated if fewer nodes share it, counted by (sum f)² / sum f²
EDGE = 5.5  # the same on a rectangle, where the six or so nodes along an edge still show where a body tips over it
SPREAD = 0.5  # share of the contact's nodes that must be more than these: a ball has one node anyway
COUNTS = 1e-3  # smallest share of the largest force on either body that a contact must carry to count


def concentrated(places: Places, m: Elastic, q: Float) -> Bool:
    """Tell which contacts (k, interfaces) are concentrated, and count, at displacements q (k, 6J) of a model."""
    nodes, found = places.nodes, np.zeros((len(q), len(places.assembly.interfaces)), dtype=bool)
    first = np.flatnonzero(np.diff(nodes.interface, prepend=-1))  # node of each contact that has any
    few = np.where(places.rectangular[nodes.interface[first]], min(EDGE, FEW), FEW)
    most = np.minimum(few, SPREAD * np.diff(first, append=len(nodes)))
    ends = np.append(first, len(nodes))
    found[:, nodes.interface[first]] = _concentrated(
        m, ends, nodes.a[first], nodes.b[first], most, np.ascontiguousarray(q)
    )
    return found


@compiled
def _concentrated(m: Elastic, first: Int, a: Int, b: Int, most: Float, q: Float) -> Bool:
    """``concentrated``, for C contacts of bodies ``a`` and ``b`` (C,): fewer nodes than ``most`` (C,) are few.

    The nodes of contact c are those from ``first[c]`` to ``first[c + 1] - 1``.
    """
    f, count = np.empty((len(m.k), 3)), len(a)
    found = np.zeros((len(q), count), dtype=np.bool_)
    for row in range(len(q)):
        node_forces(m, q[row], f)
        total, squares, largest = np.zeros(count), np.zeros(count), np.zeros(q.shape[1] // 6)
        for c in range(count):
            for i in range(first[c], first[c + 1]):
                total[c] += f[i, 0]
                squares[c] += f[i, 0] ** 2
            for body in (a[c], b[c]):
                if body >= 0:
                    largest[body] = max(largest[body], total[c])
        for c in range(count):
            least = np.inf
            for body in (a[c], b[c]):
                if body >= 0:
                    least = min(least, largest[body])
            if total[c] > COUNTS * least and total[c] ** 2 < most[c] * squares[c]:
                found[row, c] = True
    return found
