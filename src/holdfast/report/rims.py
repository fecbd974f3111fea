"""Cells of a map whose middle is covered by a contact, and whose rim shows beside the body that stands there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Int
from holdfast.base.rounding import COORDINATES
from holdfast.geometry.cells import Cells
from holdfast.geometry.polygon import inside, shapely_polygon
from holdfast.geometry.spatial import search_tree
from holdfast.queries.map import RobustnessMap


class Rims(NamedTuple):
    """The ``covered`` cells that show no rim, and the ``triangles`` (T, 3) of the others.

    ``beside`` (T,) is the number of the exposed cell nearest to each of these triangles.
    """

    covered: Cells
    triangles: Int
    beside: Int


def rims_of(result: RobustnessMap, name: str) -> Rims:
    """Divide the covered cells of a body into those that contact faces cover and those that reach beyond them.

    What shows of the latter takes the answer of the nearest exposed cell that faces the same way. A cell without one
    remains covered, and so does one that another body only comes near.
    """
    hidden, shown = result.hidden[name], result.cells[name]
    if not len(hidden.points) or not len(shown.points):
        return Rims(hidden, np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64))
    corners, size = hidden.vertices[hidden.triangles], float(np.sqrt(hidden.areas).mean())
    on_patch, beyond = np.zeros(len(hidden.points), dtype=bool), np.ones(corners.shape[:2], dtype=bool)
    patches = (patch for i in result.assembly.interfaces if name in i.bodies for patch in i.patches)
    for patch in patches:
        if patch.kind != "face" or patch.spots is not None:
            continue
        outline, origin = shapely_polygon(patch.rings), patch.polygon[0]
        level = np.abs((hidden.points - origin) @ patch.normal) < size / 4
        near = level & (np.abs(hidden.normals @ patch.normal) > 0.9)
        on_patch[near] |= inside(outline, (hidden.points[near] - origin) @ patch.frame.T)
        own = near[hidden.cell]
        places = (corners[own] - origin).reshape(-1, 3) @ patch.frame.T
        beyond[own] &= ~inside(outline.buffer(COORDINATES * patch.size), places).reshape(-1, 3)
    turned = result.assembly.size  # distance that a unit difference of normals counts as
    tree = search_tree(np.hstack([shown.points, turned * shown.normals]))
    beside = np.asarray(tree.query(np.hstack([hidden.points, turned * hidden.normals]))[1], dtype=np.int64)
    alike = (shown.normals[beside] * hidden.normals).sum(1) > 0.9
    rim = on_patch & alike & (np.bincount(hidden.cell, beyond.any(1), minlength=len(on_patch)) > 0)
    shows = rim[hidden.cell]
    return Rims(hidden.chosen(~rim), hidden.triangles[shows], beside[hidden.cell[shows]])
