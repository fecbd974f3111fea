"""Pairs of nearby faces of two bodies, cached from step to step until the bodies have moved too far."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.contacts.search_mesh import near_faces
from holdfast.native import core
from holdfast.settling.moved_surfaces import Posed

GREATEST = 50.0  # [margins] pairs that were searched up to a larger distance are too many to be reused


class FacePairs:
    """A cache of pairs of faces of two bodies that may be near each other.

    It holds the pairs whose boxes came within twice the requested distance, that distance, and the relative
    pose. Until the bodies have moved by the difference, no other pair can be within the requested distance.
    """

    def __init__(self) -> None:
        self._pairs, self._searched = np.empty((0, 2), dtype=np.int64), -1.0
        self._place = np.eye(4)

    def within(self, a: Posed, b: Posed, margin: float) -> Int:
        """Return the pairs (m, 2) of faces whose boxes come within ``margin`` [m] and that do not face away."""
        place = np.linalg.inv(a.body.pose) @ b.body.pose
        needed = margin + _way(self._place, place, b)
        if not needed <= self._searched <= GREATEST * margin:
            self._searched, self._place = 2 * margin, place
            self._pairs = near_faces(a.mesh, b.mesh, self._searched)
        of_a, of_b = ((mesh.low, mesh.high, mesh.normals) for mesh in (a.mesh, b.mesh))
        return core.facing_near(self._pairs, *of_a, *of_b, margin)


def _way(before: Float, after: Float, body: Posed) -> float:
    """Return an upper bound [m] of the motion of any point of a body from pose ``before`` (4, 4) to ``after``."""
    change = after - before
    at_centre = change[:3, :3] @ body.start.com_body + change[:3, 3]
    return float(np.linalg.norm(at_centre) + body.radius * np.linalg.norm(change[:3, :3], 2))
