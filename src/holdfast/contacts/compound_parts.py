"""Parts of compounds: the part on which a contact lies, its material, and what is hidden inside other parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from holdfast.base.arrays import Float, Int
from holdfast.base.ranges import COORDINATES
from holdfast.contacts.interface import Patch
from holdfast.geometry import polygon as flat
from holdfast.geometry.distance import distance_to_surface, winding_number
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound

ALIKE = 0.9  # cosine of the largest angle between a patch and the triangles on which it lies

Materials = tuple[str | None, str | None]


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
    deep = [(winding_number(middles, one) > 0.5) & (distance_to_surface(middles, one) > least) for one in others]
    free = ~np.any(deep, axis=0)
    found: list[tuple[float, float]] = []
    for (start, stop), is_free in zip(spans.tolist(), free, strict=True):
        if is_free and found and found[-1][1] == start:
            found[-1] = (found[-1][0], stop)
        elif is_free:
            found.append((start, stop))
    return found


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


def by_material(a: Body, b: Body, patches: Sequence[Patch], gap: float) -> dict[Materials, list[Patch]]:
    """Return the patches between two bodies by pairs of materials.

    A patch on parts of several materials is cut along their borders; a line or a point belongs to the part that is
    nearest to its middle. ``gap`` [m] is how far from a patch the surfaces may lie.
    """
    found: dict[Materials, list[Patch]] = {}
    for patch in patches:
        for of_a, piece in _cut(patch, a, gap):
            for of_b, rest in _cut(piece, b, gap):
                found.setdefault((of_a, of_b), []).append(rest)
    return found


def _cut(patch: Patch, body: Body, gap: float) -> list[tuple[str | None, Patch]]:
    """Return a patch in pieces that lie on parts of one material each, with these materials."""
    known = body.materials
    if len(set(known)) == 1 or not isinstance(body.shape, Compound):
        return [(known[0], patch)]
    names = list(dict.fromkeys(known))
    number = np.array([names.index(name) for name in known])[body.shape.part_of]
    surface = body.surface_world
    if patch.kind != "face":
        return [(_nearest(body, patch), patch)]
    heights = (surface.vertices[surface.faces] - patch.polygon[0]) @ patch.normal
    level = np.abs(heights).min(1) <= 2 * gap + (max(map(abs, patch.separation)) if patch.separation else 0.0)
    near = np.flatnonzero(level & (np.abs(surface.normals @ patch.normal) > ALIKE))  # on either side of it
    whole, cut = flat.shapely_polygon(patch.rings), []
    for k in np.unique(number[near]).tolist():
        triangles = (surface.vertices[surface.faces[near[number[near] == k]]] - patch.polygon[0]) @ patch.frame.T
        cut.append((k, shapely.union_all(shapely.polygons(triangles)).intersection(whole)))
    cut = [(k, piece) for k, piece in cut if piece.area > COORDINATES * whole.area]
    if len(cut) < 2:
        return [(names[cut[0][0]] if cut else _nearest(body, patch), patch)]
    return [(names[k], part) for k, piece in cut for part in _patches(patch, piece, COORDINATES * whole.area)]


def _nearest(body: Body, patch: Patch) -> str | None:
    """Return the material of the part that is nearest to the middle of a patch."""
    return body.materials[int(nearest_part(body, patch.centroid[None])[0])]


def _patches(patch: Patch, piece: shapely.Geometry, least: float) -> list[Patch]:
    """Return the polygons of a piece that are larger than ``least`` [m²] as patches."""
    found = [rings for rings in flat.rings_of(piece, 0.0, 0.0) if flat.shapely_polygon(rings).area > least]
    return [replace(patch, polygon=patch.lifted(r[0]), holes=tuple(map(patch.lifted, r[1:]))) for r in found]
