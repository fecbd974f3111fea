"""Faces of two bodies that come near each other, kept from step to step until the bodies have moved too far."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.compiled import compiled, dot3, lean
from holdfast.contacts.skin import near_faces
from holdfast.settling.moved_surfaces import Posed

SPARE = 1.0  # margins: how much farther than asked for pairs of faces are looked for, so that they serve longer
GREATEST = 50.0  # margins: pairs that were looked for farther away than this are too many to go through
ROUND = 1.1  # of the motion of two bodies: what it uses up of the spare distance
AWAY = 0.3  # cosine of the angle between the normals of faces of which neither has a part that touches the other


class FacePairs:
    """Pairs of faces of two bodies that may come near, with how far they reach and where the second body was then.

    They are those whose boxes come within a distance that is larger than asked for. Until the second body has moved by
    the difference, seen from the first, no other pair can come within what was asked for.
    """

    def __init__(self) -> None:
        self._pairs, self._reach = np.empty((0, 2), dtype=np.int64), -1.0
        self._place = np.eye(4)

    def within(self, a: Posed, b: Posed, margin: float) -> Int:
        """Return the pairs (m, 2) of faces whose boxes come within ``margin`` [m] and that do not face away."""
        place = np.linalg.inv(a.body.pose) @ b.body.pose
        needed = margin + ROUND * _way(self._place, place, b)
        if not needed <= self._reach <= GREATEST * margin:
            self._reach, self._place = (1 + SPARE) * margin, place
            self._pairs = near_faces(a.skin, b.skin, self._reach)
        out = np.empty_like(self._pairs)
        of_a, of_b = a.skin, b.skin
        boxes = (of_a.low, of_a.high, of_b.low, of_b.high)
        return out[: _facing_near(self._pairs, *boxes, of_a.normals, of_b.normals, margin, AWAY, out)]


def _way(before: Float, after: Float, body: Posed) -> float:
    """Return how far a point of a body can have moved at most [m] from pose ``before`` (4, 4) to ``after``."""
    change = after - before
    at_centre = change[:3, :3] @ body.start.com_body + change[:3, 3]
    return float(np.linalg.norm(at_centre) + body.radius * np.linalg.norm(change[:3, :3], 2))


@compiled
@lean
def _facing_near(
    pairs: Int,
    low_a: Float,
    high_a: Float,
    low_b: Float,
    high_b: Float,
    normals_a: Float,
    normals_b: Float,
    margin: float,
    away: float,
    out: Int,
) -> int:
    """Write those of ``pairs`` (m, 2) to ``out`` (m, 2) with near boxes and suitable normals; returns how many."""
    count = 0
    for pair in range(len(pairs)):
        i, j = pairs[pair, 0], pairs[pair, 1]
        near = True
        for k in range(3):
            near = near and low_b[j, k] <= high_a[i, k] + margin and high_b[j, k] >= low_a[i, k] - margin
        if near and dot3(normals_a[i], normals_b[j]) < away:
            out[count, 0] = i
            out[count, 1] = j
            count += 1
    return count
