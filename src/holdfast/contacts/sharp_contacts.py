"""Contacts of a sharp edge or corner with another one, which have no certain normal: all the forces that they may take.

Where two convex bodies touch, the normal lies in the normal cone of either body there, that of the faces that meet.
Both cones have a common part, and friction cones about its extreme normals make up those about all others: u is in the
dual cone about n if u·n >= sin φ |u|, which holds for sums of n, too. So a few plain nodes may take any force that such
a contact may take, and more, if anything: what they cannot hold falls. Nothing that stands on them is known to stand.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import cross
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.neighbours import neighbours
from holdfast.contacts.overlap import distance
from holdfast.contacts.patches import NOMINAL_BREADTH
from holdfast.contacts.round_bodies import Meeting, PlacedEllipsoid, PlacedRod, RoundLimits, meet
from holdfast.contacts.search_mesh import NEAR_PARALLEL, SearchMesh, near_faces
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry.distance import distance_to_surface
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import FLAT
from holdfast.native import core
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

ANY_NORMAL = np.vstack([np.eye(3), -np.eye(3)])  # forces along these make up every force


def meeting_sharply(
    scene: Scene, tolerances: Tolerances, settled: Collection[frozenset[str]]
) -> tuple[tuple[Body, Body], ...]:
    """Return the pairs of bodies within the gap that are not ``settled``: a corner or an edge of one meets the other.

    All pairs that touch otherwise are settled, by their names. Of a body in parts, a body of only those parts that may
    touch is returned.
    """
    return tuple(
        (a, b)
        for a, b in neighbours(scene, tolerances.widest(scene))
        if frozenset((a.name, b.name)) not in settled
        and distance(a, b, 1.001 * _between(scene, tolerances, a, b).gap) is not None
    )


def _between(scene: Scene, tolerances: Tolerances, a: Body, b: Body) -> Tolerances:
    return tolerances.between(scene.body(a.name), scene.body(b.name))


def sharp_interface(scene: Scene, tolerances: Tolerances, a: Body, b: Body) -> Interface:
    """Return an interface of ``sharp_patches``, with the largest friction coefficient of any parts of two bodies."""
    materials = itertools.product(a.materials, b.materials)
    mu = max(scene.friction.between(a.name, b.name, {a.name: one, b.name: other}) for one, other in materials)
    return Interface((a.name, b.name), patches=sharp_patches(a, b, _between(scene, tolerances, a, b)), mu=mu)


def sharp_patches(a: Body, b: Body, tolerances: Tolerances) -> list[Patch]:
    """Return points that may take at least every force of two bodies that touch with sharp edges and corners alone.

    Each has a normal into ``b``. A body that is not convex there, curved, or not known to have an inside may push in
    any direction.
    """
    gap, size = 1.001 * tolerances.gap, min(a.size, b.size)  # as in ``meeting_sharply``
    meshes = SearchMesh.of(a), SearchMesh.of(b)
    pairs = near_faces(*meshes, gap)
    near = [np.unique(column) for column in pairs.T]
    points = _points(meshes, near, gap, COORDINATES * size)
    if not len(points):  # one lies within the other: it may take any force and torque there
        ends = np.array([np.min(meshes[0].vertices, axis=0), np.max(meshes[0].vertices, axis=0)])
        corners = np.array(list(itertools.product(*ends.T)))
        return [Patch(p[None], n, breadth=NOMINAL_BREADTH * size, inset=0.0) for p in corners for n in ANY_NORMAL]
    apart = [_distances(points, mesh, faces) for mesh, faces in zip(meshes, near, strict=True)]
    reach = np.maximum(gap, np.maximum(*(far.min(axis=1) for far in apart)))[:, None] + COORDINATES * size
    plain = all(body.shape.surface.oriented for body in (a, b))
    found = []
    for k, point in enumerate(points):
        cones = [
            _normals(mesh, faces[far[k] <= reach[k]], point, gap)
            for mesh, faces, far in zip(meshes, near, apart, strict=True)
        ]
        one, other = cones
        normals = ANY_NORMAL
        if plain and one is not None and other is not None:
            common = _polar(np.vstack([_polar(one), _polar(-other)]), np.sin(np.radians(tolerances.angle)))
            normals = common if len(common) else ANY_NORMAL
        found += [Patch(point[None], normal, breadth=NOMINAL_BREADTH * size, inset=0.0) for normal in normals]
    return found


def _points(meshes: tuple[SearchMesh, SearchMesh], near: list[Int], gap: float, rounding: float) -> Float:
    """Return points (n, 3) [m] whose hull holds every point where the surfaces come within ``gap``.

    They are the vertices of either that are near the other, where edges pass each other, and the ends of what two edges
    that are almost parallel have beside each other. Points that are nearer to each other than ``rounding`` count once.
    """
    found = []
    for (one, own), (other, faces) in itertools.permutations(zip(meshes, near, strict=True)):
        corners = one.vertices[np.unique(one.faces[own])]
        found.append(corners[_distances(corners, other, faces).min(axis=1, initial=np.inf) <= gap])
    edges, others = (
        mesh.vertices[mesh.edges[own[np.abs(mesh.bend[own]) > FLAT]]]
        for mesh, own in ((mesh, np.unique(mesh.of_face[faces])) for mesh, faces in zip(meshes, near, strict=True))
    )
    every = np.vstack([*found, _passing(edges, others, gap)])
    if not len(every):
        return every
    first = np.argmax(np.linalg.norm(every[:, None] - every, axis=2) <= rounding, axis=1)
    return np.asarray(every[np.unique(first)])


def _passing(edges: Float, others: Float, gap: float) -> Float:
    """Return the points (n, 3) of ``edges`` (m, 2, 3) [m] at which ``others`` (k, 2, 3) pass within ``gap``."""
    (p, q), (r, s) = edges.swapaxes(0, 1)[:, :, None], others.swapaxes(0, 1)
    along, across, apart = q - p, s - r, r - p
    normal = cross(along, across)
    aa, bb, nn = ((one * one).sum(axis=-1) for one in (along, across, normal))
    crossing = nn > NEAR_PARALLEL**2 * aa * bb
    met = (cross(apart, across) * normal).sum(axis=-1) / np.maximum(nn, 1e-300)
    ends = np.stack([(apart * along).sum(axis=-1), ((s - p) * along).sum(axis=-1)]) / aa
    shares = np.where(crossing, met, np.clip(ends, 0.0, 1.0))
    points = p + shares[..., None] * along
    beside = np.clip(((points - r) * across).sum(axis=-1) / bb, 0.0, 1.0)
    close = np.linalg.norm(points - r - beside[..., None] * across, axis=-1) <= gap
    return np.asarray(points[np.where(crossing, close & (shares >= 0) & (shares <= 1), close.any(axis=0))])


def _distances(points: Float, mesh: SearchMesh, faces: Int) -> Float:
    """Return the distances (n, F) [m] of points (n, 3) from each of these ``faces`` (F,)."""
    found = [distance_to_surface(points, Surface(mesh.vertices, mesh.faces[[k]])) for k in faces]
    return np.array(found).reshape(len(faces), len(points)).T


def _normals(mesh: SearchMesh, faces: Int, point: Float, gap: float) -> Float | None:
    """Return the different normals (m, 3) of ``faces`` (F,) that meet at a point, None unless they are flat and convex.

    Up to twice the ``gap`` counts as rounding.
    """
    normals = mesh.normals[faces]
    rises = (mesh.triangles[faces].reshape(-1, 3) - point) @ normals.T
    if mesh.curved[faces].any() or (rises > 2 * gap).any():
        return None
    return np.asarray(np.unique(np.round(normals / COORDINATES) * COORDINATES, axis=0))


def _polar(generators: Float, slack: float = COORDINATES**0.5) -> Float:
    """Return unit generators (n, 3) of the cone of all e with e·g <= 0 for each g of ``generators`` (m, 3).

    ``slack`` is the sine of the angle by which they may miss that.
    """
    _, sizes, rows = np.linalg.svd(generators)
    free = rows[int((sizes > COORDINATES * sizes.max(initial=0.0)).sum()) :]  # directions along which it is a line
    borders = np.vstack([generators, free])
    pairs = np.array(list(itertools.combinations(range(len(borders)), 2)))
    crossed = cross(borders[pairs[:, 0]], borders[pairs[:, 1]])
    length = np.linalg.norm(crossed, axis=1, keepdims=True)
    crossed = np.vstack([free, (crossed / np.maximum(length, 1e-300))[length[:, 0] > COORDINATES**0.5]])
    every = np.vstack([crossed, -crossed])
    kept = every[(every @ generators.T <= slack).all(axis=1)]
    return np.asarray(np.unique(np.round(kept / COORDINATES) * COORDINATES, axis=0))


def on_edges(one: PlacedRod | PlacedEllipsoid, surface: Surface, edges: Int, limits: RoundLimits) -> Iterator[Meeting]:
    """Yield where a round body touches ``edges`` (n,) of a closed ``surface``; normals point into the surface.

    An edge is touched at a point only if it is nearer there than the two faces
    beside it, and a corner only if it is nearer than all edges that meet there.
    """
    ends = surface.vertices[surface.topology.edges[edges]]
    wide = one.extent + limits.gap
    box = [one.centre - wide, one.centre + wide]
    near = ((ends.min(1) <= box[1]) & (ends.max(1) >= box[0])).all(1)
    if isinstance(one, PlacedEllipsoid):  # its exact contact is iterative, so far edges are ruled out first
        apart = one.least_apart(ends)
        near &= (apart <= limits.gap) & (apart >= -limits.depth)
    for edge, (start, stop) in zip(edges[near].tolist(), ends[near], strict=True):
        two = PlacedRod((start + stop) / 2, (stop - start) / 2, 0.0, flat=False)
        found = meet(one, two, limits)
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
