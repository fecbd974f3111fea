"""Overlaps, their depths, and distances of solids, computed independently of the search for contact patches."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from typing import Literal

import manifold3d
import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.progress import reported
from holdfast.base.public import Record
from holdfast.contacts.neighbours import NearPair, in_order, near_pairs
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry.distance import distance_to_surface, winding_number
from holdfast.geometry.hull import search_tree
from holdfast.geometry.solid import closed_solid
from holdfast.geometry.surface import Surface
from holdfast.native import core
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

MOST_DISTANCES = 3_000_000  # largest number of distances from corners to triangles; they take about 1 s
MOST_ANGLES = 5_000_000  # largest number of solid angles; they take about 0.25 s
# directions that are tried as ways out of a solid that is not convex, and equal steps on each; each takes a millisecond
MOST_WAYS = 60
ALIKE = 0.97  # cosine of the angle up to which a direction is one that was tried already
NEARLY = 1e-3  # relative error of a way out that is found by trying
SHRUNK = 1e-7  # share by which the second of two solids is shrunk
ROUNDING = 1e-9  # relative error of volumes and of supports

FAR_BEYOND = 150  # [tolerances, by default 1/1000 of the size each] deeper overlaps cannot be settled
MISPLACED = "correct the poses: is the origin of a shape in its middle, and not at its foot?"


class Overlap(Record):
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
    near: Sequence[NearPair] | None = None,
) -> tuple[Overlap, ...]:
    """Find the pairs of bodies, not both fixed, that overlap by more than their gap, with or without contacts.

    Between the bodies named in ``same``, overlaps are taken from ``known``. With ``drawn``, the triangles count as the
    true surfaces, so that sagittas and uncertain rotations do not widen the gap. ``near`` can pass the other pairs, at
    least all whose boxes meet, as ``neighbours`` yields them.
    """
    near = near_pairs(scene, tolerances, 0.0, same) if near is None else near
    solids: dict[int, manifold3d.Manifold | None] = {}
    found = {overlap.bodies: overlap for overlap in known if all(name in same for name in overlap.bodies)}
    limits = [one.limits.base if drawn else one.limits.own.gap for one in near]
    deep_enough = [pair for pair in zip(near, limits, strict=True) if pair[0].shared >= pair[1]]
    for (a, b, *_), tolerance in reported("overlaps", deep_enough):
        for body in (a, b):
            if id(body) not in solids:
                solids[id(body)] = solid_of(body)
        solid_a, solid_b = solids[id(a)], solids[id(b)]
        estimated = solid_a is None or solid_b is None
        if solid_a is None or solid_b is None:
            depth = max(_deepest(a, b), _deepest(b, a))
        else:
            parts = (solid_a ^ _shrunk(solid_b)).decompose()
            deep = [part for part in parts if _least(part, a.reduced_world, b.reduced_world) > tolerance]
            depth = max((_way_out(_surface(part), solid_a, solid_b) for part in deep), default=0.0)
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
    pairs = core.near_boxes(near, near, low[around], high[around], 0, search)
    return float(np.sqrt(core.nearest_of_pairs(near, triangles[around], pairs))) if len(pairs) else np.inf


def _shrunk(solid: manifold3d.Manifold) -> manifold3d.Manifold:
    """Return a solid that is a little smaller: faces that lie on each other would share parts without a volume."""
    low, high = np.array(solid.bounding_box()).reshape(2, 3)
    middle = (low + high) / 2
    return solid.translate(-middle).scale(np.full(3, 1 - SHRUNK)).translate(middle)


def _convex(solid: manifold3d.Manifold) -> bool:
    return float(solid.hull().volume()) <= (1 + ROUNDING) * float(solid.volume())


def _surface(solid: manifold3d.Manifold) -> Surface:
    mesh = solid.to_mesh64()
    return Surface(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64))


def _least(part: manifold3d.Manifold, a: Surface, b: Surface) -> float:
    """Return a lower bound of the way out of the ``part`` that two solids share [m].

    It is how deep a corner of the part is in either, or the middle of a convex part, as of a rod through a foil; and at
    least the mean thickness, twice the volume over the area: where sides are flush, all corners are on both surfaces.
    """
    points = _surface(part).vertices
    low, high = points.min(0), points.max(0)
    points = np.vstack([points, points.mean(0)]) if _convex(part) else points
    far, deepest = float(np.linalg.norm(high - low)), 2 * float(part.volume()) / float(part.surface_area())
    for surface in (a, b):
        corners = surface.vertices[surface.faces]
        close = ((corners.max(1) >= low - far) & (corners.min(1) <= high + far)).all(1)
        nearby = Surface(surface.vertices, surface.faces[close] if close.any() else surface.faces)
        some = points[:: -max(1, len(points) * len(nearby.faces) // MOST_DISTANCES)]
        deepest = max(deepest, float(distance_to_surface(some, nearby).max()))
    return deepest


def _way_out(part: Surface, a: manifold3d.Manifold, b: manifold3d.Manifold) -> float:
    """Return how far one of two solids must be moved to leave the other where they share a ``part`` [m].

    It is that of their hulls, exact for convex solids, or else a shorter one along a normal of the part, which then
    counts alone.
    """
    found = _apart(_surface(a.hull()), _surface(b.hull()))
    if _convex(a) and _convex(b):
        return found
    normals = np.unique(np.round(part.normals, 6), axis=0)
    ways = np.vstack([normals, -normals])
    lengths = np.ptp(part.vertices @ ways.T, axis=0)
    tried: list[Float] = []
    for k in np.argsort(lengths, kind="stable").tolist():
        if lengths[k] >= found or len(tried) >= MOST_WAYS:
            break
        if not any(float(way @ ways[k]) > ALIKE for way in tried):
            tried.append(ways[k])
            found = min(found, _length(ways[k], float(lengths[k]), part, a, b, found))
    return found


def _length(
    way: Float, length: float, part: Surface, a: manifold3d.Manifold, b: manifold3d.Manifold, most: float
) -> float:
    """Return how far b must go along ``way`` (3,) to leave a where they share a ``part`` [m]; from ``most`` on, any.

    It goes by ``length`` [m] at first, and then on by the extent of what is still shared near the part. A grain deep in
    a rock would take thousands of such steps, so they double from MOST_WAYS on, and the last one is halved again.
    """
    low, high = part.vertices.min(0), part.vertices.max(0)

    def shared(length: float) -> float:
        left = [_surface(solid).vertices for solid in (a ^ _shrunk(b.translate(length * way))).decompose()]
        near = [own for own in left if (own.max(0) >= low - length).all() and (own.min(0) <= high + length).all()]
        further = max((float(np.ptp(own @ way)) for own in near), default=0.0)
        return further if further > NEARLY * length else 0.0

    steps, short = 0, length
    while length < most and (further := shared(length)):
        steps += 1
        short, length = length, length + further * 2.0 ** max(steps - MOST_WAYS, 0)
    while steps > MOST_WAYS and length - short > NEARLY * length:
        middle = (short + length) / 2
        short, length = (middle, length) if shared(middle) else (short, middle)
    return length


def _apart(one: Surface, other: Surface) -> float:
    """Return the least translation [m] that separates two convex solids which overlap.

    It is the distance of 0 from the boundary of the hull of all differences of their points. A polytope inside that
    hull is extended where it is nearest to 0 until its nearest face is one of the hull (van den Bergen 2001).
    """

    def farthest(ways: Float) -> Float:
        ends = (one.vertices @ ways.T).argmax(0), (other.vertices @ ways.T).argmin(0)
        return np.asarray(one.vertices[ends[0]] - other.vertices[ends[1]])

    axes: Float = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    known = farthest(np.vstack([axes, one.normals[:MOST_WAYS], -other.normals[:MOST_WAYS]]))
    while True:
        from scipy.spatial import ConvexHull  # only here, as it takes long to import

        faces = ConvexHull(known, qhull_options="QJ Pp").equations
        faces = faces[np.argsort(-faces[:, 3])[:MOST_WAYS]]
        beyond = farthest(faces[:, :3])
        depth = max(float(-faces[0, 3]), 0.0)
        if float(beyond[0] @ faces[0, :3]) - depth <= NEARLY**2 * depth + ROUNDING * float(np.abs(known).max()):
            return depth
        known = np.vstack([known, beyond])
