"""Find level places for an object by its outline seen from above: in corners and beside other bodies.

In a level place, a flat face of the object lies on level tops of the scene, with its bounding rectangle parallel to
them. The rectangle touches the edges of the tops or of other bodies' outlines, or lies midway between edges of a top.
These include a place of the rectangle from which it cannot be pushed left or down without overlap (bottom-left
stability, Chazelle 1983). Stability is checked elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from holdfast.applications.placement.conditions import Approach, allowed_turns
from holdfast.applications.resting_poses import Face
from holdfast.base.arrays import Float
from holdfast.base.progress import keep_to_time
from holdfast.base.rigid import tangents
from holdfast.contacts.overlap import solid_of
from holdfast.geometry.hull import convex_hull, smallest_rectangle
from holdfast.geometry.solid import hull_solid
from holdfast.scene.body import Body

LEVEL = 0.9999  # cosine of the largest angle between the vertical and the normal of a level triangle
STEP = 1e-4  # [m] tops whose heights differ by less count as one level
MOST_FACES = 6  # number of faces of the object that are tried, the steadiest first
SAME = 1e-9  # overlap of outlines that counts as touching
HAIR = 1e-6  # [m] width that a surface seen edge-on is given
LEAST_SUPPORT = 0.6  # smallest share of a face that must lie on the tops
WHOLLY = 0.999  # share of a face above which it counts as lying wholly on the tops
CONVEX = 1e-6  # a body is convex if its volume is smaller than that of its hull by no more than this share
MOST_PLACES = 40_000  # largest number of combinations of coordinates for one face on one level


@dataclass(frozen=True, eq=False)
class Level:
    """The level tops of bodies at one ``height`` [m] along up, and their outline ``top`` seen from above."""

    height: float
    top: shapely.Geometry


@dataclass(frozen=True, eq=False)
class LevelPlace:
    """A level place for an object: its ``pose`` (4, 4) and the ``height`` [m] of the tops on which it lies.

    ``corner`` (2,) [m] is the corner of its rectangle with the smallest coordinates, in the axes of the scene's tops.
    ``support`` is the share of the face that lies on the tops, and ``face`` the rank of the face, from 0 for the best.
    """

    pose: Float
    height: float
    corner: Float
    support: float
    face: int


def frame_of(bodies: Sequence[Body], up: Float) -> Float:
    """Return level axes (2, 3) along the sides of the largest level top of ``bodies``, or any axes without a top."""
    axes, best = np.array(tangents(up)), 0.0
    for body in bodies:
        triangles = _level_triangles(body, up)
        if not len(triangles):
            continue
        flat = triangles.reshape(-1, 3) @ axes.T
        ring = convex_hull(flat, SAME * body.size)
        sides, low, high = smallest_rectangle(ring)
        area = float(np.prod(high - low))
        if area > best * (1 + 1e-6):
            best, found = area, sides @ axes
    if best == 0:
        return axes
    first = found[0] * (1.0 if found[0][np.argmax(np.abs(found[0]))] > 0 else -1.0)
    return np.array([first, np.cross(up, first)])


def levels_of(bodies: Sequence[Body], up: Float, axes: Float) -> list[Level]:
    """Return the level tops of ``bodies``, joined at equal heights, the lowest first."""
    triangles = np.vstack([_level_triangles(body, up) for body in bodies])
    every = (triangles.reshape(-1, 3) @ up).reshape(-1, 3).mean(1)
    order = np.argsort(every, kind="stable")
    cuts = np.flatnonzero(np.diff(every[order]) > STEP) + 1
    found = []
    for group in np.split(order, cuts):
        if len(group):
            whole = shapely.union_all(shapely.polygons(triangles[group] @ axes.T), grid_size=HAIR)
            found.append(Level(float(every[group].mean()), whole))
    return found


def _level_triangles(body: Body, up: Float) -> Float:
    surface = body.reduced_world
    return np.asarray(surface.vertices[surface.faces][surface.normals @ up > LEVEL])


def turns_of(faces: Sequence[Face], approach: Approach, up: Float, axes: Float) -> list[Float]:
    """Return rotations (3, 3) with a face down and its longer side along one of ``axes`` (2, 3), the best faces first.

    Facets of round sides are skipped. Upright orientations come first unless orientations are given.
    """
    steady = [face for face in faces if face.tilt > 0 and not face.rolls]
    allowed = allowed_turns(approach, up)
    if allowed is not None:
        if not approach.free_yaw:
            return list(allowed)
        least = np.cos(np.radians(approach.lean_degrees))
        steady = [face for face in steady if any(face.normal @ (turn.T @ -up) > least for turn in allowed)]
    elif approach.prefers_upright:
        steady = sorted(steady, key=lambda face: not face.upright)
    turns = []
    for face in steady[:MOST_FACES]:
        face_axes = np.column_stack([face.normal, face.along, np.cross(face.normal, face.along)])
        turns += [np.column_stack([-up, along, np.cross(-up, along)]) @ face_axes.T for along in axes]
    return turns


@dataclass(frozen=True, eq=False)
class SeenFromAbove:
    """The outline of a body of the scene that may be in the way, seen from above in level ``axes`` (2, 3)."""

    body: Body
    up: Float
    axes: Float

    @cached_property
    def heights(self) -> Float:
        """The heights (V,) [m] of its vertices along ``up``."""
        return np.asarray(self.body.reduced_world.vertices @ self.up)

    @cached_property
    def whole(self) -> shapely.Geometry | None:
        """The outline of a convex body, or None for any other."""
        vertices = self.body.surface_world.vertices
        hull = hull_solid(vertices).volume()
        solid = solid_of(self.body)
        if solid is None or hull - solid.volume() > CONVEX * hull:
            return None
        return shapely.MultiPoint(vertices @ self.axes.T).convex_hull

    def between(self, low: float, high: float) -> shapely.Geometry | None:
        """Return the outline of the part of the body between two heights [m], or None if there is none.

        It may be too large but not too small. Of a body that is not convex, only the surface counts, not the inside.
        """
        if self.heights.max() <= low + STEP or self.heights.min() >= high - STEP:
            return None
        if self.whole is not None:
            return self.whole
        surface = self.body.reduced_world
        each = self.heights[surface.faces]
        within = (each.max(1) > low + STEP) & (each.min(1) < high - STEP)
        flat = shapely.polygons((surface.vertices @ self.axes.T)[surface.faces[within]])
        return shapely.union_all(shapely.buffer(shapely.make_valid(flat), HAIR, quad_segs=1))


def level_places_for(
    body: Body,
    turns: Sequence[Float],
    levels: Sequence[Level],
    others: Sequence[SeenFromAbove],
    apart: float,
    inset: float,
) -> list[LevelPlace]:
    """Return the places of an object in all ``turns`` (3, 3) on all levels, at least ``apart`` [m] from other bodies.

    ``others`` are the bodies that may be in the way, at least one. The face lies at least ``inset`` [m] inside the
    edges of the tops; with ``inset`` = 0, only a share LEAST_SUPPORT of it must lie on them.
    """
    up, axes = others[0].up, others[0].axes
    found = []
    for level in levels:
        for number, turn in enumerate(turns):
            keep_to_time()
            vertices = body.shape.surface.vertices @ turn.T
            flat, height = vertices @ axes.T, vertices @ up
            sole, low, size = flat[height < height.min() + STEP], flat.min(0), np.ptp(flat, axis=0)
            shapes = [other.between(level.height, level.height + float(np.ptp(height))) for other in others]
            blocked = shapely.union_all([shape for shape in shapes if shape is not None])
            shapely.prepare(blocked)
            corners = _corners_to_try(level.top, blocked, size, apart, inset)
            near = apart - SAME
            corners = corners[
                ~shapely.intersects(blocked, shapely.box(*(corners - near).T, *(corners + size + near).T))
            ]
            within = max(inset - SAME, 0.0)
            first, last = corners - low + sole.min(0) - within, corners - low + sole.max(0) + within
            standing = shapely.box(*first.T, *last.T)
            share = shapely.area(shapely.intersection(level.top, standing)) / shapely.area(standing)
            for k in np.flatnonzero(share > (LEAST_SUPPORT if inset == 0 else WHOLLY)):
                pose = np.eye(4)
                pose[:3, :3] = turn
                pose[:3, 3] = (corners[k] - low) @ axes + (level.height - height.min()) * up
                found.append(LevelPlace(pose, level.height, corners[k], min(float(share[k]), 1.0), number // len(axes)))
    return found


def _corners_to_try(top: shapely.Geometry, blocked: shapely.Geometry, size: Float, apart: float, inset: float) -> Float:
    """Return the corners (n, 2) [m] with the smallest coordinates of rectangles of ``size`` (2,) [m] to try on a top.

    Along either axis a rectangle lies ``inset`` [m] inside an end of a piece of ``top``, in the middle of a piece, or
    ``apart`` [m] beside a piece of ``blocked``: objects that are packed closely stand so. Whether it is free there and
    has enough beneath it is not checked.
    """
    pieces, obstacles, whole = _bounds_of_pieces(top), _bounds_of_pieces(blocked), shapely.bounds(top)
    coordinates = []
    for axis in (0, 1):
        low, high = pieces[:, axis], pieces[:, 2 + axis]
        starts = [low + inset, high - inset - size[axis], (low + high - size[axis]) / 2]
        starts += [obstacles[:, 2 + axis] + apart, obstacles[:, axis] - apart - size[axis]]
        each = np.unique(np.round(np.concatenate(starts), 9))
        coordinates.append(each[(each >= whole[axis] - size[axis]) & (each <= whole[2 + axis])])
    x, y = np.meshgrid(*coordinates, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])[:MOST_PLACES]


def _bounds_of_pieces(shape: shapely.Geometry) -> Float:
    """Return the bounds (n, 4) [m] of the pieces of a shape and of their holes: rows (x low, y low, x high, y high)."""
    pieces = [piece for piece in shapely.get_parts(shape) if piece.geom_type == "Polygon"]
    rings = [ring for piece in pieces for ring in (piece.exterior, *piece.interiors)]
    return shapely.bounds(rings).reshape(-1, 4)
