"""Contacts of balls, capsules, ellipsoids and sides of cylinders with sharp edges and corners of another body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from holdfast.base.arrays import Int
from holdfast.base.rounding import COORDINATES
from holdfast.contacts.ellipsoids import PlacedEllipsoid, meet
from holdfast.contacts.swept import Meeting, Swept
from holdfast.geometry.surface import Surface
from holdfast.native import core


def on_edges(
    one: Swept | PlacedEllipsoid,
    surface: Surface,
    edges: Int,
    *,
    gap: float,
    depth: float,
    cos_twist: float,
    cos_side: float,
) -> Iterator[Meeting]:
    """Yield where a round body touches ``edges`` (n,) of a closed ``surface``; normals point into the surface.

    The tolerances are those of ``meeting``. An edge is touched at a point only if it is nearer there than the two faces
    beside it, and a corner only if it is nearer than all edges that meet there.
    """
    ends = surface.vertices[surface.topology.edges[edges]]
    wide = one.extent + gap
    box = [one.centre - wide, one.centre + wide]
    near = ((ends.min(1) <= box[1]) & (ends.max(1) >= box[0])).all(1)
    if isinstance(
        one, PlacedEllipsoid
    ):  # the exact contact is iterative, so edges that are too far are ruled out first
        apart = one.least_apart(ends)
        near &= (apart <= gap) & (apart >= -depth)
    for edge, (start, stop) in zip(edges[near].tolist(), ends[near], strict=True):
        two = Swept((start + stop) / 2, (stop - start) / 2, 0.0, flat=False)
        found = meet(one, two, gap=gap, depth=depth, cos_twist=cos_twist, cos_side=cos_side)
        if found is not None and _is_nearest(surface, edge, found):
            # a face beside the edge may be tangent to the round body
            yield found._replace(bend=min(found.bend, one.flattest(found.normal)))


def _is_nearest(surface: Surface, edge: int, found: Meeting) -> bool:
    """Tell whether nothing beside the edge, or around its end, is nearer than the contact that was found."""
    topology, away = surface.topology, -found.normal
    ends = topology.edges[edge]
    place = found.ends[1].mean(0)
    for k in range(2):
        corner, along = surface.vertices[ends[k]], surface.vertices[ends[1 - k]] - surface.vertices[ends[k]]
        if float((place - corner) @ along) <= COORDINATES * float(along @ along):
            around = topology.neighbours[topology.starts[ends[k]] : topology.starts[ends[k] + 1]]
            arms = surface.vertices[around] - corner
            return bool((arms @ away <= COORDINATES * np.linalg.norm(arms, axis=1)).all())
    beside = topology.sides[edge]
    outward = core.outward_of(np.ascontiguousarray(surface.vertices), surface.faces[beside], surface.normals[beside])
    across = outward[topology.of_face[beside] == edge]
    return bool((across @ away >= -COORDINATES).all())
