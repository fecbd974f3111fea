"""Convex outlines of bodies, for bounds on how near and how deep in each other bodies are at many poses at once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.rigid import transform
from holdfast.geometry.hull import hull_facets, qhull
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Shape
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.shapes import Sphere

ROUND = 1e-5  # [rad] angle between triangles of the hull below which they are one facet
LIKE = 1e-6  # relative difference of volume up to which a solid counts as its own convex hull
FACETS = 24  # number of the largest facets of a hull along whose normals distances are bounded
STEPS, SHRINKS = 24, 0.85  # number of steps of the centre of a ball, and the ratio of their lengths
MOST = 4_000_000  # number of products that are held at a time
AXES = np.vstack([np.eye(3), -np.eye(3)])


@dataclass(frozen=True, eq=False)
class PartHull:
    """The convex hull of a body or of one of its parts, in the frame of the body.

    It holds all points within ``radius`` [m] of the hull of ``corners`` (V, 3); the radius is 0 but for a ball, which
    has one corner. Points x are inside if n · x + d <= 0 for all ``planes`` (F, 4), rows (n, d); ``flat`` (f, 4) are
    those on which triangles lie that represent no curved surface. ``solid`` tells whether the part fills its hull.
    ``unbounded`` marks a half space, whose hull is all below the plane z = 0.
    """

    corners: Float
    planes: Float
    flat: Float = field(default_factory=lambda: np.zeros((0, 4)))
    radius: float = 0.0
    solid: bool = False
    unbounded: bool = False

    @classmethod
    def of(cls, surface: Surface, pose: Float | None = None, radius: float = 0.0) -> PartHull:
        """Return the outline of a part with this ``surface`` at ``pose`` (4, 4); of a ball ``radius`` [m] is known.

        Without volume, a hull is known by its corners alone.
        """
        vertices = surface.vertices if pose is None else transform(pose, surface.vertices)
        if surface.thickness <= LIKE * surface.diagonal:
            return cls(vertices, np.zeros((0, 4)))
        hull = qhull(vertices)
        x, y, z = np.moveaxis((vertices - vertices.mean(0))[surface.faces], 1, 0)
        volume = float((np.cross(x, y) * z).sum()) / 6
        solid = surface.oriented and surface.topology.closed and abs(volume - hull.volume) <= LIKE * hull.volume
        planes = np.unique(np.round(hull.equations, 12), axis=0)
        if radius:
            centre = np.zeros((1, 3)) if pose is None else pose[None, :3, 3]
            return cls(centre, planes, radius=radius, solid=solid)
        normals = surface.normals if pose is None else surface.normals @ pose[:3, :3].T
        own = np.unique(np.round(normals[~surface.curved], 6), axis=0)
        even = (np.abs(planes[:, None, :3] - own).max(2) <= ROUND).any(1)
        return cls(vertices[np.unique(hull.simplices)], planes, planes[even], solid=solid)

    @cached_property
    def middle(self) -> Float:
        """The middle (3,) [m] of the box around the hull; of a half space, its origin."""
        return np.asarray((self.corners.min(0) + self.corners.max(0)) / 2)

    @cached_property
    def reach(self) -> float:
        """The largest distance [m] of a point of the hull from its middle."""
        return (
            np.inf if self.unbounded else float(np.linalg.norm(self.corners - self.middle, axis=1).max() + self.radius)
        )

    @cached_property
    def facets(self) -> list[tuple[Float, Float]]:
        """The faces of the hull: outward normals (3,) and corners (k, 3)."""
        if self.unbounded or len(self.corners) < 4 or not len(self.planes):
            return []
        return [(normal, self.corners[corners]) for normal, corners in hull_facets(self.corners, ROUND)]

    @property
    def flat_facets(self) -> list[tuple[Float, Float]]:
        """The flat faces of the hull that represent no curved surface."""
        return [(n, corners) for n, corners in self.facets if (np.abs(self.flat[:, :3] - n).max(1) <= 2 * ROUND).any()]

    @cached_property
    def directions(self) -> Float:
        """Unit vectors (m, 3) along which distances from the hull are bounded."""
        if self.unbounded:
            return np.array([[0.0, 0.0, 1.0]])
        largest = sorted(self.facets, key=lambda facet: -float(np.linalg.norm(np.ptp(facet[1], axis=0))))
        return np.vstack([AXES, *(normal[None] for normal, _ in largest[:FACETS])])

    def extent(self, directions: Float) -> Float:
        """Return how far the hull reaches along ``directions`` (..., 3), from the origin of its frame."""
        return np.asarray((directions @ self.corners.T).max(-1) + self.radius * np.linalg.norm(directions, axis=-1))


def outlines_of(body: Body) -> tuple[PartHull, ...]:
    """Return the outlines of the parts of a body."""
    if isinstance(body.shape, HalfSpace):
        return (PartHull(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0, 0.0]]), solid=True, unbounded=True),)
    if isinstance(body.shape, Compound):
        return tuple(_outline(part.shape, part.pose) for part in body.shape.parts)
    return (_outline(body.shape),)


def _outline(shape: Shape, pose: Float | None = None) -> PartHull:
    return PartHull.of(shape.surface, pose, shape.radius if isinstance(shape, Sphere) else 0.0)


def separation(one: PartHull, poses: Float, other: PartHull, others: Float, reach: float) -> Float:
    """Return lower bounds (n,) [m] of the distance of two bodies at ``poses`` and ``others`` (n, 4, 4).

    They are sharp only where they matter: bounds above ``reach`` [m] may be anything above it. Negative bounds say that
    the hulls may meet.
    """
    if one.unbounded:
        one, poses, other, others = other, others, one, poses
    bound = np.linalg.norm(_placed(poses, one.middle) - _placed(others, other.middle), axis=1) - one.reach - other.reach
    near = np.flatnonzero(bound <= reach)
    room = max(1, MOST // (40 * max(len(one.corners), len(other.corners))))
    for start in range(0, len(near), room):
        rows = near[start : start + room]
        bound[rows] = np.maximum(bound[rows], _along_directions(one, poses[rows], other, others[rows]))
    return np.asarray(bound)


def shared_ball(one: PartHull, poses: Float, other: PartHull, others: Float) -> Float:
    """Return the radius (n,) [m] of a large ball that lies in both of two solid bodies; not positive if none was found.

    From the middle of the smaller body on, the centre of the ball moves away from the plane that limits it most.
    """
    if one.reach > other.reach:
        one, poses, other, others = other, others, one, poses
    if not (one.solid and other.solid):
        return np.zeros(len(poses))
    found = np.zeros(len(poses))
    room = max(1, MOST // (len(one.planes) + len(other.planes)))
    for start in range(0, len(poses), room):
        rows = slice(start, start + room)
        relative = np.linalg.inv(others[rows]) @ poses[rows]
        found[rows] = _largest_ball(one, relative, other)
    return found


def _largest_ball(one: PartHull, relative: Float, other: PartHull) -> Float:
    """Return the radius (n,) [m] of a ball in two convex bodies, ``one`` at ``relative`` (n, 4, 4) to ``other``."""
    turned, moved = relative[:, :3, :3], relative[:, :3, 3]
    normals = one.planes[:, :3] @ np.swapaxes(turned, 1, 2)  # of both bodies, in the frame of the other one
    offsets = one.planes[:, 3] - (normals @ moved[:, :, None])[..., 0]
    normals = np.concatenate(
        [normals, np.broadcast_to(other.planes[:, :3], (len(moved), *other.planes[:, :3].shape))], 1
    )
    offsets = np.concatenate([offsets, np.broadcast_to(other.planes[:, 3], (len(moved), len(other.planes)))], 1)
    centres, best, step = _placed(relative, one.middle), np.full(len(moved), -np.inf), one.reach / 2
    for _ in range(STEPS):
        room = -((normals @ centres[:, :, None])[..., 0] + offsets)
        nearest = room.argmin(1)
        best = np.maximum(best, np.take_along_axis(room, nearest[:, None], 1)[:, 0])
        centres = centres - step * np.take_along_axis(normals, nearest[:, None, None], 1)[:, 0]
        step *= SHRINKS
    return best


def _placed(poses: Float, point: Float) -> Float:
    return np.asarray(poses[:, :3, :3] @ point + poses[:, :3, 3])


def _along_directions(one: PartHull, poses: Float, other: PartHull, others: Float) -> Float:
    """Return the largest gap (n,) [m] between two hulls along any of their directions, in the frame of ``other``."""
    relative = np.linalg.inv(others) @ poses
    turned, moved = relative[:, :3, :3], relative[:, :3, 3]

    def gap(directions: Float, own: Float, its: Float) -> Float:
        """Return the gaps (n,) along directions (n, m, 3) from ``other`` to ``one``, which extend so far along them."""
        return np.asarray(((directions @ moved[:, :, None])[..., 0] - own - its).max(1))

    outward = other.directions[None]
    best = gap(outward, one.extent(-outward @ turned), other.extent(outward))
    if other.unbounded:
        return best
    inward = -one.directions @ np.swapaxes(turned, 1, 2)
    best = np.maximum(best, gap(inward, one.extent(one.directions), other.extent(inward)))
    apart = _placed(relative, one.middle) - other.middle
    along = [apart]
    for axes in (np.broadcast_to(np.eye(3), turned.shape), turned):  # beside the axes of either body, as of a cylinder
        share = np.swapaxes(axes, 1, 2) @ apart[:, :, None]
        along += [apart - share[:, k] * axes[:, :, k] for k in range(3)]
    unit = np.stack(along, axis=1)
    unit /= np.maximum(np.linalg.norm(unit, axis=2, keepdims=True), 1e-300)
    return np.maximum(best, gap(unit, one.extent(-unit @ turned), other.extent(unit)))
