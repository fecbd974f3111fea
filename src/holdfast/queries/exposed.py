"""Find the cells of a body's surface that its contacts cover; nobody can push there."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool
from holdfast.contacts.interface import Patch
from holdfast.geometry.cells import Cells
from holdfast.geometry.polygon import inside, shapely_polygon


def covered(cells: Cells, patches: list[Patch], gap: float) -> Bool:
    """Tell for each of the C cells whether its point lies on a contact face: a boolean array (C,).

    A point lies on a face patch if it is within ``gap`` [m] of the patch's plane and inside its outline, and if the
    cell is roughly parallel to the patch. Contacts along lines and at points cover nothing.
    """
    result = np.zeros(len(cells.points), dtype=bool)
    for patch in patches:
        if patch.kind != "face":
            continue
        arm = cells.points - patch.polygon[0]
        near = (np.abs(arm @ patch.normal) <= gap) & (np.abs(cells.normals @ patch.normal) > 0.9)
        if near.any():
            result[near] |= inside(shapely_polygon(patch.rings), arm[near] @ patch.frame.T)
    return result
