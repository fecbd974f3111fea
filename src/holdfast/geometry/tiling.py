"""Recognition of convex polygons that a few pieces tile, such as the overlap of two faces of two triangles each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float
from holdfast.native import core

FEW = 16  # largest number of pieces


def tiled(pieces: Sequence[Sequence[Float]], tolerance: float) -> Float | None:
    """Return the convex polygon (k, 2), counter-clockwise, that ``pieces`` [outline (n, 2), holes ...] tile, or None.

    The pieces tile their convex hull if all of them are convex and without holes, no two overlap by more than
    ``tolerance``, and their areas add up to that of the hull, up to a strip of that width along its boundary.
    """
    if len(pieces) > FEW or any(len(rings) > 1 for rings in pieces):
        return None
    corners = np.ascontiguousarray(np.vstack([rings[0] for rings in pieces]))
    ends = np.cumsum([len(rings[0]) for rings in pieces])
    hull = core.tiled_hull(corners, ends, np.lexsort(corners.T[::-1]), tolerance)
    return hull if len(hull) > 2 else None
