"""Parts of compounds: the part on which a contact lies, and what of a contact is hidden inside other parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rounding import COORDINATES
from holdfast.geometry.cuboid import Cuboid
from holdfast.geometry.distance import distance_to_surface, winding_number
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound


def nearest_part(body: Body, points: Float) -> Int:
    """Return the number (n,) of the part on whose portion of the surface the nearest point to each of ``points`` lies.

    ``points`` (n, 3) [m] are in the world frame. Of two parts at the same distance, the first one counts. A body that
    is not a compound has one part with the number 0.
    """
    if not isinstance(body.shape, Compound):
        return np.zeros(len(points), dtype=np.int64)
    surface, part_of = body.surface_world, body.shape.part_of
    known = np.unique(part_of)
    if len(known) == 1:
        return np.full(len(points), known[0], dtype=np.int64)
    apart = [distance_to_surface(points, replace(surface, faces=surface.faces[part_of == k])) for k in known]
    return np.asarray(known[np.argmin(apart, axis=0)], dtype=np.int64)


def cuboid_towards(body: Body, other: Body, gap: float) -> Cuboid | None:
    """Return the cuboid that a body is within ``gap`` [m] of another one: the body itself, or a part of its compound.

    It is a part if the boxes of all other parts are farther from the box of the other body, so that they cover nothing
    of it there.
    """
    if not isinstance(body.shape, Compound) or len(body.shape.parts) == 1:
        return body.cuboid
    low, high = other.box[0] - gap, other.box[1] + gap
    near = []
    for part in body.shape.parts:
        corners = body.placed(part.placed(part.shape.surface.vertices))
        if (corners.min(0) <= high).all() and (corners.max(0) >= low).all():
            near.append(part)
    local = near[0].shape.surface.cuboid if len(near) == 1 else None
    return body.cuboid if local is None else local.placed(body.pose @ near[0].pose)


def exposed(body: Body, part: int, ends: Float) -> list[tuple[float, float]]:
    """Return the pieces of a point or a line (1 or 2, 3) that do not lie inside parts of a body other than ``part``.

    Each piece is given by the shares of the line's length at which it begins and ends; a point is (0, 0). A piece on
    the surface of another part is not inside it.
    """
    whole = [(0.0, float(len(ends) - 1))]
    if not isinstance(body.shape, Compound):
        return whole
    low, high = ends.min(0), ends.max(0)
    others = []
    for number, other in enumerate(body.shape.parts):
        if number == part:
            continue
        own = other.shape.surface
        surface = Surface(body.placed(other.placed(own.vertices)), own.faces)
        if (surface.vertices.min(0) <= high).all() and (surface.vertices.max(0) >= low).all():
            others.append(surface)
    if not others:
        return whole
    cuts = np.unique(np.concatenate([[0.0], *(_crossings(ends, surface) for surface in others), [whole[0][1]]]))
    spans = np.column_stack([cuts[:-1], cuts[1:]]) if len(ends) > 1 else np.zeros((1, 2))
    middles = ends[0] + np.multiply.outer(spans.mean(1), ends[-1] - ends[0])
    least = COORDINATES * max(body.size, float(np.abs(ends).max()))
    free = ~np.any([_inside(middles, surface, least) for surface in others], axis=0)
    found: list[tuple[float, float]] = []
    for (start, stop), is_free in zip(spans.tolist(), free, strict=True):
        if is_free and found and found[-1][1] == start:
            found[-1] = (found[-1][0], stop)
        elif is_free:
            found.append((start, stop))
    return found


def _inside(points: Float, surface: Surface, least: float) -> Bool:
    """Tell which points (n, 3) lie deeper than ``least`` [m] inside a closed surface."""
    return np.asarray((winding_number(points, surface) > 0.5) & (distance_to_surface(points, surface) > least))


def _crossings(ends: Float, surface: Surface) -> Float:
    """Return shares (n,) of a line (2, 3) at which it crosses planes of nearby triangles, and perhaps the surface."""
    corners = surface.vertices[surface.faces]
    near = ((corners.min(1) <= ends.max(0)) & (corners.max(1) >= ends.min(0))).all(1)
    normals = surface.normals[near]
    slope = normals @ (ends[-1] - ends[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = ((corners[near, 0] - ends[0]) * normals).sum(1) / slope
    # this drops infinities and NaN, where the line is parallel to a plane
    return np.asarray(shares[(shares > 0) & (shares < 1)])
