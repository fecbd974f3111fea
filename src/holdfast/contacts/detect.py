"""Contact detection: the patches at which two bodies touch, within a gap and an angle tolerance.

The normal of what touches a plane face of one body is that of the plane, which is known better than those of a scan.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.progress import reported
from holdfast.contacts.clipping import Piece, clip_faces, facing_pairs, facing_polygons
from holdfast.contacts.interface import Patch
from holdfast.contacts.neighbours import NearPair, in_order
from holdfast.contacts.occlusion import Pair
from holdfast.contacts.patches import (
    NEGLIGIBLE_WIDTH,
    NOMINAL_BREADTH,
    SAME_WAY,
    face_patches,
    line_patches,
    point_patches,
)
from holdfast.contacts.round_contacts import feet, meet_smoothly, not_at
from holdfast.contacts.search_mesh import (
    Features,
    SearchMesh,
    near_faces,
    near_facets,
    touching_features,
)
from holdfast.contacts.tolerances import SIGMAS, OfPair, Tolerances
from holdfast.contacts.without_triangles import of_cuboids, of_round
from holdfast.geometry.distance import distance_to_surface
from holdfast.geometry.facets import COPLANAR
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh


class Touching(NamedTuple):
    """Where two bodies would touch if there were no third bodies.

    ``parts`` holds the patches of each pair from ``Scene.touching``, ``patches`` all of them together, and ``limits``
    the tolerances of the two.
    """

    parts: tuple[tuple[Body, Body, tuple[Patch, ...]], ...]
    patches: tuple[Patch, ...]
    limits: OfPair


def find_all_patches(
    scene: Scene, near: Sequence[NearPair], known: Mapping[Pair, Touching] | None = None, same: Collection[str] = ()
) -> dict[Pair, Touching]:
    """Find where all pairs of bodies would touch if there were no third bodies, in the order of the bodies.

    Between bodies named in ``same``, the result is taken from ``known``; ``near`` are all other pairs that are near
    enough to touch.
    """
    result = {pair: touching for pair, touching in (known or {}).items() if pair[0] in same and pair[1] in same}
    for one, patches in _patches_between(near):
        if patches:
            pair = one.a.name, one.b.name
            parts, others = ((), ()) if (first := result.get(pair)) is None else (first.parts, first.patches)
            result[pair] = Touching((*parts, (one.a, one.b, patches)), (*others, *patches), one.limits)
    return in_order(result, scene) if known else result


def _patches_between(near: Sequence[NearPair]) -> Iterator[tuple[NearPair, tuple[Patch, ...]]]:
    """Yield each of the pairs of bodies with the patches where they touch.

    Pairs of cuboids, and of round bodies on them, come first; triangles are searched only for the remaining pairs.
    """
    meshes: dict[int, SearchMesh] = {}
    as_cuboids = of_cuboids([(one.a, one.b) for one in near], [one.limits.own for one in near])
    known = [
        of_round(one.a, one.b, one.limits.own) if found is None else found
        for one, found in zip(near, as_cuboids, strict=True)
    ]
    uses = Counter(id(body) for k, one in enumerate(near) if known[k] is None for body in (one.a, one.b))
    for k, one in enumerate(reported("contacts", near)):
        patches = known[k]
        if patches is None:
            a, b, _, limits = one
            for body in (a, b):
                if id(body) not in meshes:
                    meshes[id(body)] = SearchMesh.of(body)
            patches = find_patches(a, b, meshes[id(a)], meshes[id(b)], limits.own)
            for body in (a, b):
                uses[id(body)] -= 1
                if not uses[id(body)]:
                    del meshes[id(body)]  # free the memory
        yield one, patches


class TooFineError(Exception):
    """The faces of two bodies meet in more pieces than ``find_patches`` was allowed to join."""


def find_patches(
    a: Body, b: Body, mesh_a: SearchMesh, mesh_b: SearchMesh, tolerances: Tolerances, most: float = np.inf
) -> tuple[Patch, ...]:
    """Find the patches where two bodies touch, with normals that point into ``b``.

    Faces come first, then lines where no face touches, then points where neither touches. Raises TooFineError if
    more than ``most`` pairs of triangles meet: to join the pieces costs far more than to find them.
    """
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    breadth = NOMINAL_BREADTH * size
    found = [] if meet_smoothly(a, b) else _on_triangles(a, b, mesh_a, mesh_b, tolerances, most)
    if found is None:
        return ()
    exact = feet(a, b, gap=gap, depth=depth, breadth=breadth, angles=tolerances.angles)
    if not exact:
        return tuple(found)
    true_gap = gap - a.shape.surface.sagitta - b.shape.surface.sagitta
    touching = [foot.patch(breadth) for foot in exact if foot.heights.min() <= max(true_gap, 0.0)]
    return (*touching, *not_at(exact, found))


def _on_triangles(
    a: Body, b: Body, mesh_a: SearchMesh, mesh_b: SearchMesh, tolerances: Tolerances, most: float
) -> list[Patch] | None:
    """Find the patches of two tessellated bodies; None if no faces are near each other."""
    gap, depth, size = tolerances.gap, tolerances.depth, min(a.size, b.size)
    negligible, breadth = NEGLIGIBLE_WIDTH * size, NOMINAL_BREADTH * size
    angles = tolerances.angles
    locals_ = a.shape.surface.reduced, b.shape.surface.reduced
    facets = near_facets(mesh_a, mesh_b, gap)
    facing, left = facing_polygons(mesh_a, mesh_b, *locals_, facets, tolerances)
    pairs = near_faces(mesh_a, mesh_b, gap, but_facets=True)
    if not len(pairs) and not facets:
        return None
    mixed, small = facing_pairs(mesh_a, mesh_b, pairs, cos_angle=float(np.cos(np.radians(angles.flat))))
    also, _ = facing_polygons(mesh_a, mesh_b, *locals_, mixed, tolerances)
    large = [piece for _, pieces in sorted({**facing, **also}.items()) for piece in pieces]
    pairs = np.concatenate([pairs, *(near_faces(mesh_a, mesh_b, gap, two) for two in left)])
    pieces = [*large, *clip_faces(mesh_a, mesh_b, small, tolerances)]
    if len(pieces) > most:
        raise TooFineError
    faces = face_patches(pieces_on_planes(a, b, pieces, tolerances), gap, angles, negligible)
    lines, points = touching_features(
        mesh_a, mesh_b, pairs, gap=gap, depth=depth, angles=angles, size=size, strict=negligible
    )
    lines, points = features_on_planes(a, b, lines, points, tolerances)
    along = line_patches(lines, faces, gap, negligible, breadth)
    return [*faces, *along, *point_patches(points, [*faces, *along], gap, breadth)]


def pieces_on_planes(a: Body, b: Body, pieces: list[Piece], tolerances: Tolerances) -> list[Piece]:
    """Return the pieces where two bodies touch; beside a scan, those on a plane face of the other have its normal."""
    if not pieces or _scanned(a) == _scanned(b):
        return pieces
    rings = [piece.rings[0] for piece in pieces]
    normals = _on_planes(a, b, np.array([piece.normal for piece in pieces]), rings, tolerances)
    return [replace(piece, normal=normal) for piece, normal in zip(pieces, normals, strict=True)]


def features_on_planes(
    a: Body, b: Body, lines: Features, points: Features, tolerances: Tolerances
) -> tuple[Features, Features]:
    """Return touching edges and corners; beside a scan, those on a plane face of the other body have its normal."""
    count = len(lines.normals)
    if not count + len(points.normals) or _scanned(a) == _scanned(b):
        return lines, points
    both, ends = np.concatenate([lines.normals, points.normals]), np.concatenate([lines.ends, points.ends])
    normals = _on_planes(a, b, both, ends, tolerances)
    return replace(lines, normals=normals[:count]), replace(points, normals=normals[count:])


def _scanned(body: Body) -> bool:
    """Tell whether the surface of a body is measured: a rough mesh, or planes fitted to one with noise."""
    shapes = [part.shape for part in body.shape.parts] if isinstance(body.shape, Compound) else [body.shape]
    fitted = any(isinstance(shape, Mesh) and shape.noise > 0 for shape in shapes)
    return fitted or body.shape.surface.roughness.slope > 0


def _on_planes(a: Body, b: Body, normals: Float, rings: Sequence[Float] | Float, tolerances: Tolerances) -> Float:
    """Return normals (n, 3), from a to b: that of a plane face of the exact body for each of the ``rings`` on it."""
    # A corner, an edge or a face that touches a plane presses along the normal of the plane. The normals of a scan
    # scatter by degrees about it, and contacts tilted against each other wedge: they seem to hold more than μ N.
    body, other, outward = (a, b, 1.0) if _scanned(b) else (b, a, -1.0)
    scatter = SIGMAS * float(np.sqrt(2)) * other.shape.surface.roughness.slope  # √2 slope: of a facet about each axis
    best = np.full(len(normals), max(SAME_WAY, np.cos(max(scatter, np.radians(tolerances.angle)))))
    local, world = body.shape.surface.reduced, body.reduced_world
    gap, corners = tolerances.gap, np.vstack(list(rings))
    starts = np.cumsum([0, *(len(ring) for ring in rings[:-1])])
    triangles = world.vertices[world.faces]
    near = (triangles.max(1) >= corners.min(0) - gap) & (triangles.min(1) <= corners.max(0) + gap)
    faces, region, found = np.flatnonzero(near.all(1) & ~local.curved), local.topology.regions(COPLANAR), normals.copy()
    for number, first in zip(*np.unique(region[faces], return_index=True), strict=True):
        way = outward * world.normals[faces[first]]
        along = normals @ way
        if (along > best).any():
            away = distance_to_surface(corners, replace(world, faces=world.faces[region == number]))
            mine = (along > best) & (np.maximum.reduceat(away, starts) <= gap)
            found[mine], best[mine] = way, along[mine]
    return found
