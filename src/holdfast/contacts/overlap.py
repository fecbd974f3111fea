"""Overlaps, their depths, and distances of solids, computed independently of the search for contact patches."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np

from holdfast.base.archive import archived
from holdfast.base.progress import reported
from holdfast.base.values import Value
from holdfast.contacts.detect import in_order, neighbours
from holdfast.contacts.search_mesh import near_boxes
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry.distance import distance_to_surface, nearest_of, winding_number
from holdfast.geometry.solid import closed_solid
from holdfast.geometry.spatial import search_tree
from holdfast.geometry.way_out import way_out
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

MOST_ANGLES = 5_000_000  # largest number of solid angles; they take about 0.25 s

FAR_BEYOND = 150  # [tolerances, by default 1/1000 of the size each] deeper overlaps cannot be settled
MISPLACED = "correct the poses: is the origin of a shape in its middle, and not at its foot?"


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Overlap(Value):
    """Two bodies that share volume.

    ``depth`` [m] is the way out: the least translation that separates the two, and where they overlap at several
    places, the longest of the ways out of one place. ``tolerance`` [m] is the gap of the pair. An overlap of up to
    twice the tolerance is a "warning"; a larger one is an "error" of the poses or the meshes. ``estimated`` is True if
    a surface is not closed, in which case the depth is that of the deepest vertex.
    """

    bodies: tuple[str, str]
    depth: float
    tolerance: float
    estimated: bool = False

    @property
    def text(self) -> str:
        """The overlap in words, with what to do about it."""
        about = "about " if self.estimated else ""
        remedy = MISPLACED if self.misplaced else "settle, or correct the poses"
        return (
            f"{self.bodies[0]} and {self.bodies[1]} overlap by {about}{self.depth * 1e3:.3g} mm, more than their "
            f"tolerance of {self.tolerance * 1e3:.2g} mm, so what they carry there is not known: {remedy}"
        )

    @property
    def misplaced(self) -> bool:
        """Whether the overlap is so deep that a pose is wrong, and not only inexact."""
        return self.depth > FAR_BEYOND * self.tolerance

    @property
    def severity(self) -> Literal["warning", "error"]:
        """The severity of the overlap, by its depth relative to the tolerance."""
        return "warning" if self.depth <= 2 * self.tolerance else "error"


def solid_of(body: Body) -> manifold3d.Manifold | None:
    """Return the body as a closed solid in the world frame, or None if its surface is not closed."""
    surface = body.reduced_world
    return closed_solid(surface.vertices, surface.faces)


def find_overlaps(
    scene: Scene,
    tolerances: Tolerances,
    known: Collection[Overlap] = (),
    same: Collection[str] = (),
    *,
    drawn: bool = False,
    near: Sequence[tuple[Body, Body]] | None = None,
) -> tuple[Overlap, ...]:
    """Find the pairs of bodies, not both fixed, that overlap by more than their gap, with or without contacts.

    Between the bodies named in ``same``, overlaps are taken from ``known``. With ``drawn``, the triangles count as the
    true surfaces, so that sagittas and uncertain rotations do not widen the gap. ``near`` can pass the other pairs, at
    least all whose boxes meet, as ``neighbours`` yields them.
    """
    solids: dict[int, manifold3d.Manifold | None] = {}
    found = {overlap.bodies: overlap for overlap in known if all(name in same for name in overlap.bodies)}
    for a, b in reported("overlaps", list(neighbours(scene, 0.0, same)) if near is None else near):
        shared = float((np.minimum(a.box[1], b.box[1]) - np.maximum(a.box[0], b.box[0])).min())
        if shared < 0:
            continue
        one, other = scene.body(a.name), scene.body(b.name)
        tolerance = tolerances.base(one, other) if drawn else tolerances.between(one, other).gap
        if shared < tolerance:
            continue
        for body in (a, b):
            if id(body) not in solids:
                solids[id(body)] = solid_of(body)
        solid_a, solid_b = solids[id(a)], solids[id(b)]
        estimated = solid_a is None or solid_b is None
        if solid_a is None or solid_b is None:
            depth = max(_deepest(a, b), _deepest(b, a))
        else:
            depth = way_out(solid_a, solid_b, a.reduced_world, b.reduced_world, enough=tolerance)
        pair = (a.name, b.name)
        if depth > tolerance and (pair not in found or depth > found[pair].depth):
            found[pair] = Overlap(pair, depth, tolerance, estimated)
    return tuple(in_order(found, scene).values())


def _deepest(a: Body, b: Body) -> float:
    """Return how deep the deepest corner of a lies inside b [m] by winding number, for surfaces that are not closed."""
    corners = a.surface_world.vertices
    near = corners[((corners >= b.box[0]) & (corners <= b.box[1])).all(1)]
    surface = b.surface_world
    near = near[:: max(1, len(near) * len(surface.faces) // MOST_ANGLES)]
    if not len(near) or not surface.oriented:
        return 0.0
    inside = near[winding_number(near, surface) > 0.5]
    return float(distance_to_surface(inside, surface).max()) if len(inside) else 0.0


def distance(a: Body, b: Body, search: float) -> float | None:
    """Return the smallest distance of two bodies [m], 0 if they meet, or None if it is larger than ``search`` [m].

    The distance is exact for closed surfaces. If a surface is open, it is the smallest distance from a corner of either
    body to the other, which may be too large.
    """
    corners = search_tree(b.surface_world.vertices).query(a.surface_world.vertices)[0]
    limit = min(search, 1.001 * float(np.min(corners)) + 1e-9 * min(a.size, b.size))  # an upper bound of the distance
    solid_a, solid_b = solid_of(a), solid_of(b)
    if solid_a is not None and solid_b is not None:
        gap = float(solid_a.min_gap(solid_b, limit))
    else:
        gap = min(_corner_distance(a, b, limit), _corner_distance(b, a, limit))
    return gap if gap < search else None


def nearest_outside(bodies: Sequence[Body], group: Collection[str]) -> tuple[str, str, float] | None:
    """Return the names of a body in ``group`` and of the nearest body outside, and their distance [m]; None if none."""
    within = np.array([body.name in group for body in bodies])
    low, high = np.array([body.box for body in bodies]).swapaxes(0, 1)
    best: tuple[str, str, float] | None = None
    limit = np.inf
    inside, outside = np.flatnonzero(within), np.flatnonzero(~within)
    apart = np.maximum(low[inside][:, None] - high[outside], low[outside] - high[inside][:, None])
    least = np.linalg.norm(np.maximum(apart, 0), axis=2).ravel()
    for k in np.argsort(least, kind="stable").tolist():
        if least[k] > limit:
            break
        a, b = bodies[inside[k // len(outside)]], bodies[outside[k % len(outside)]]
        found = distance(a, b, 1.001 * limit)
        if found is not None and (best is None or found < best[2]):
            best, limit = (a.name, b.name, found), found
    return best


def _corner_distance(a: Body, b: Body, search: float) -> float:
    """Return the smallest distance from a corner of a to b [m], or inf if it is larger than ``search`` [m]."""
    surface, corners = b.surface_world, a.surface_world.vertices
    triangles = surface.vertices[surface.faces]
    low, high = triangles.min(1), triangles.max(1)
    near = corners[((corners >= low.min(0) - search) & (corners <= high.max(0) + search)).all(1)]
    around = np.flatnonzero(((high >= corners.min(0) - search) & (low <= corners.max(0) + search)).all(1))
    if not len(near) or not len(around):
        return np.inf
    around = around[np.argsort(low[around, 0], kind="stable")]
    pairs = near_boxes(near, near, low[around], high[around], 0, search)
    return float(np.sqrt(nearest_of(near, triangles[around], pairs))) if len(pairs) else np.inf
