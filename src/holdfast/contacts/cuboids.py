"""Closed-form contacts of cuboids that are flush or certainly apart, for all pairs of a scene at once.

Most bodies of pallets, shelves and walls are boxes, and most pairs of nearby boxes are of one of two kinds, for which
the contact is known without searching triangles, edges and corners:

- ``APART``: they are more than the gap apart along the normal of a face; or their edges are parallel and they overlap
  along one axis at most, as boxes that meet at an edge or a corner do. Such boxes could only touch at a sharp rim,
  which is not a contact.
- ``FLUSH``: a face of each lies in one plane, up to rounding, and the plane separates them. The contact is the
  intersection of the two rectangles. All other faces are perpendicular to the plane or beyond the gap, so that the
  patch accounts for all edges and corners.

All other pairs are left to the search through triangles (``detect.find_patches``), which finds the same contacts for
these two kinds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import frozen
from holdfast.base.rounding import COORDINATES
from holdfast.base.values import made
from holdfast.contacts.interface import Patch
from holdfast.geometry.cuboid import Cuboid
from holdfast.native import core

WIDE = 1e-6  # least gap, relative to the size of the smaller body, at which rounding cannot decide what touches


class Cuboids(NamedTuple):
    """Two cuboids whose bounding boxes are near each other; all lengths are in metres.

    Surfaces touch up to ``gap`` apart. ``size`` is that of the smaller body, and contacts narrower than ``negligible``
    are rounding.
    """

    a: Cuboid
    b: Cuboid
    gap: float
    size: float
    negligible: float


def patches_of(pairs: Sequence[Cuboids]) -> list[tuple[Patch, ...] | None]:
    """Return the patches of each pair, with normals into the second body; None if triangles have to be searched."""
    if not pairs:
        return []
    known = {id(body): body for near in pairs for body in (near.a, near.b)}
    number_of = {key: k for k, key in enumerate(known)}
    bodies = np.array([body.rows for body in known.values()])
    ends = np.array([(number_of[id(near.a)], number_of[id(near.b)]) for near in pairs])
    limits = np.array([near[2:] for near in pairs])
    counts, corners, planes, tangents = core.cuboid_contacts(bodies, ends, limits, COORDINATES, WIDE)
    several = counts.tolist()
    found: list[tuple[Patch, ...] | None] = [() if count < 0 else None for count in several]
    for count in {count for count in several if count > 2}:
        chosen = [k for k, each in enumerate(several) if each == count]
        at = slice(None) if len(chosen) == len(several) else chosen
        polygons, frames = frozen(corners[at, :count]), frozen(tangents[at])
        normals, separations = frozen(planes[at, :3]), planes[at, 3:].tolist()
        rings = frozen((polygons - polygons[:, :1]) @ frames.transpose(0, 2, 1))
        moments, widths = core.measures_of(rings)
        frozen(moments)
        for k, (number, width) in enumerate(zip(chosen, widths.tolist(), strict=True)):
            if width > pairs[number].negligible:
                low, high = separations[k]
                patch = made(
                    Patch,
                    polygon=polygons[k],
                    normal=normals[k],
                    holes=(),
                    separation=(low, high),
                    breadth=0.0,
                    inset=np.inf,
                    spots=None,
                    frame=frames[k],
                    rings=(rings[k],),
                    moments=moments[k],
                    width=width,
                )
                found[number] = (patch,)
    return found
