"""Whether what presses a contact has gathered on few of its nodes, as under a body about to tip over a corner or a rim.

Few nodes say little about what the contact would hold: two nodes on a round rim resist a twist by their distance, a
point of the rim does not. Nor do twice as many nodes tell, as long as the force gathers on as few of them.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.compiled import compiled
from holdfast.elastic.law import Elastic, sheet_twist
from holdfast.engines.compliant.places import Places

FEW = 12.0  # nodes that share the force of a contact, (sum f)² / sum f², below which it has gathered
EDGE = 5.5  # the same on a rectangle: about six nodes share it along an edge, and tell where a body tips over that
SPREAD = 0.5  # of the contact's nodes, which must be more: a ball has one node anyway
COUNTS = 1e-3  # of the largest force on either body, which a contact must carry to count


def gathered(places: Places, m: Elastic, q: Float) -> Bool:
    """Tell for displacements q (k, 6J) of a model on ``places`` whether any contact that counts has gathered."""
    nodes = places.nodes
    if not len(nodes):
        return np.zeros(len(q), dtype=bool)
    count = int(nodes.interface[-1]) + 1
    few = np.where(places.rectangular[:count], min(EDGE, FEW), FEW)
    most = np.minimum(few, SPREAD * np.bincount(nodes.interface, minlength=count))
    return _gathered(m, nodes.interface[places.sheets.first[:-1]], most, count, np.ascontiguousarray(q))


@compiled
def _gathered(m: Elastic, of: Int, most: Float, count: int, q: Float) -> Bool:
    """``gathered``, for the sheets ``of`` (P,) the contacts; fewer nodes than ``most`` (count,) are few."""
    found = np.zeros(len(q), dtype=np.bool_)
    bodies = q.shape[1] // 6
    ends = np.empty((count, 2), dtype=np.int64)
    for p in range(len(of)):
        ends[of[p], 0], ends[of[p], 1] = m.a[p], m.b[p]
    v = np.empty(6)
    for row in range(len(q)):
        total, squares, largest = np.zeros(count), np.zeros(count), np.zeros(bodies)
        for p in range(len(of)):
            sheet_twist(m, p, q[row], v)
            for i in range(m.first[p], m.first[p + 1]):
                f = m.k[i] * max(0.0, m.x[i] * v[5] - m.y[i] * v[4] - v[0] - m.apart[i])
                total[of[p]] += f
                squares[of[p]] += f * f
        for c in range(count):
            for body in ends[c]:
                if body >= 0:
                    largest[body] = max(largest[body], total[c])
        for c in range(count):
            most_there = total[c]
            least_there = np.inf
            for body in ends[c]:
                if body >= 0:
                    least_there = min(least_there, largest[body])
            if most_there > COUNTS * least_there and total[c] ** 2 < most[c] * squares[c]:
                found[row] = True
    return found
