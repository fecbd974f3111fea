"""Closed-form contacts of cuboids that are flush or certainly apart, for all pairs of a scene at once.

Most bodies of pallets, shelves and walls are boxes, and most pairs of nearby boxes are of one of two kinds, for which
the contact is known without searching triangles, edges and corners:

- ``APART``: they are more than the gap apart along the normal of a face; or their edges are parallel and they overlap
  along one axis at most, as boxes that meet at an edge or a corner do. Such boxes could only touch at a sharp rim,
  which is not a contact.
- ``FLUSH``: a face of each lies in one plane, up to rounding, and the plane separates them. The contact is the
  intersection of the two rectangles. All other faces are perpendicular to the plane or beyond the gap, so that the
  patch accounts for all edges and corners (flush.py).

All other pairs are left to the search through triangles (``detect.find_patches``), which finds the same contacts for
these two kinds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.rounding import COORDINATES
from holdfast.contacts.flush import WIDE
from holdfast.contacts.interface import Patch
from holdfast.geometry.cuboid import Cuboid
from holdfast.native import core

OTHER, APART, FLUSH = 0, 1, 2  # how two cuboids lie; no amounts
SAME = 1e-3  # relative to the negligible width: corners that are closer are merged


class Near(NamedTuple):
    """Two cuboids whose bounding boxes are near each other; all lengths are in metres.

    Surfaces touch up to ``gap`` apart. ``size`` is that of the smaller body, and contacts narrower than ``negligible``
    are rounding.
    """

    a: Cuboid
    b: Cuboid
    gap: float
    size: float
    negligible: float


def patches_of(pairs: Sequence[Near]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair, with normals into the second body; None if triangles have to be searched."""
    if not pairs:
        return []
    known = {id(body): body for near in pairs for body in (near.a, near.b)}
    number_of = {key: k for k, key in enumerate(known)}
    bodies = np.array([np.vstack([body.centre, body.axes, body.half]) for body in known.values()])
    ends = np.array([(number_of[id(near.a)], number_of[id(near.b)]) for near in pairs])
    kinds, axes = _kinds(bodies[ends[:, 0]], bodies[ends[:, 1]], np.array([near[2:] for near in pairs]))
    found: list[tuple[Patch, ...] | None] = [() if kind == APART else None for kind in kinds.tolist()]
    flush = np.flatnonzero(kinds == FLUSH)
    same = np.array([SAME * pairs[k].negligible for k in flush.tolist()])
    counts, corners, planes = core.flush_faces(bodies, ends[flush], axes[flush], same)
    for k, number in enumerate(flush.tolist()):
        if counts[k] > 2:
            low, high = planes[k, 3:].tolist()
            patch = Patch(corners[k, : counts[k]].copy(), planes[k, :3].copy(), (), (low, high))
            found[number] = (patch,) if patch.width > pairs[number].negligible else None
    return found


def _kinds(a: Float, b: Float, limits: Float) -> tuple[Int, Int]:
    """Classify pairs of cuboids ``a`` and ``b`` (m, 5, 3) as OTHER, APART or FLUSH (m,).

    The rows of a cuboid are its centre, its three axes and its half lengths. ``limits`` (m, 3) are gap, size and
    negligible width. Also returns the axis of each body (m, 2) along which flush bodies touch; whether their rectangles
    intersect is not tested. Sums are over three numbers, so that rounding in a pair does not depend on other pairs.
    """
    gap, size, negligible = limits.T
    tiny = COORDINATES * size
    half_a, half_b, arm = a[:, 4], b[:, 4], (b[:, 0] - a[:, 0])[:, None]
    slopes = np.abs((a[:, 1:4, None] * b[:, None, 1:4]).sum(3))  # (m, axes of a, axes of b)
    overlap = half_a + (slopes * half_b[:, None]).sum(2) - np.abs((a[:, 1:4] * arm).sum(2))  # along the axes of a
    back = half_b + (slopes * half_a[:, :, None]).sum(1) - np.abs((b[:, 1:4] * arm).sum(2))
    leaning = np.sort(slopes, axis=2)[:, :, 1]  # 0 if an axis of a is parallel to one of b
    nearest = slopes.argmax(2)
    thickness = 2 * np.minimum(half_a, np.take_along_axis(half_b, nearest, axis=1))
    level = (leaning <= COORDINATES) & (np.abs(overlap) <= tiny[:, None]) & (thickness > (gap + tiny)[:, None])
    beside = (overlap <= negligible[:, None] / 4).sum(1)
    off, longest = leaning.max(1), np.maximum(half_a, half_b).max(1)
    parallel = (off <= COORDINATES) & (off * longest < negligible / 16)
    beyond = np.minimum(overlap, back).min(1) < -gap - tiny
    flush = (beside == 1) & level.any(1) & (gap >= WIDE * size)
    kinds = np.where(beyond | ((beside > 1) & parallel), APART, np.where(flush, FLUSH, OTHER))
    along = level.argmax(1)
    return kinds, np.column_stack([along, nearest[np.arange(len(a)), along]])
