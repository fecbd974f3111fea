"""Whether what presses a contact is concentrated on few of its nodes, as under a body that tips over a corner.

Few nodes say little about what the contact would hold: two nodes on a round rim resist a twist by their distance, a
point of the rim does not. Nor do twice as many nodes tell, as long as the force gathers on as few of them.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.elastic.model import Elastic
from holdfast.engines.compliant.places import Places
from holdfast.native import core

FEW = 12.0  # a contact's force is concentrated if fewer nodes share it, counted by (sum f)² / sum f²
EDGE = 5.5  # the same on a rectangle, where the six or so nodes along an edge still show where a body tips over it
SPREAD = 0.5  # share of the contact's nodes that must be more than these: a ball has one node anyway


def concentrated(places: Places, m: Elastic, q: Float) -> Bool:
    """Tell which contacts (k, interfaces) are concentrated, and count, at displacements q (k, 6J) of a model."""
    nodes, found = places.nodes, np.zeros((len(q), len(places.assembly.interfaces)), dtype=bool)
    first = np.flatnonzero(np.diff(nodes.interface, prepend=-1))  # node of each contact that has any
    few = np.where(places.rectangular[nodes.interface[first]], min(EDGE, FEW), FEW)
    most = np.minimum(few, SPREAD * np.diff(first, append=len(nodes)))
    ends = np.append(first, len(nodes))
    those = np.zeros((len(q), len(first)), dtype=bool)
    core.concentrated(m, ends, nodes.a[first], nodes.b[first], most, np.ascontiguousarray(q), those)
    found[:, nodes.interface[first]] = those
    return found
