"""The surface of a body prepared for the contact search: pairs of nearby faces, and where edges and vertices touch.

A feature (an edge or a vertex) touches only where it is a local minimum of the distance along the contact normal: the
surface around it leads away from the other body, up to the angle tolerance. The normal is that of the touched face, or
the cross product of two edges. If faces meet at a smooth edge, as on a tessellated curve, the contact may be between
them and takes the mean of their normals. On a sharp edge or corner the normal is undefined, so there is no contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.ranges import COORDINATES
from holdfast.base.values import Value, seal, sealed
from holdfast.contacts.tolerances import Angles
from holdfast.native import core
from holdfast.scene.body import Body

# [medians] longer boxes are searched separately, as they would widen the search window of all others
LARGE: Final = core.LARGE_BOX
# sine of the angle below which the cross product of two edges is not reliable
NEAR_PARALLEL: Final = core.NEAR_PARALLEL


class SearchMesh(NamedTuple):
    """A triangle surface in the world as plain arrays for compiled code, which are read-only.

    ``vertices`` (V, 3) [m] and ``faces`` (F, 3) are as in ``Surface``; ``triangles`` (F, 3, 3) [m] are the corners of
    the faces, with unit ``normals`` (F, 3) and boxes ``low``, ``high`` (F, 3) [m]. ``box`` (2, 3) [m] is the lowest and
    the highest corner of all boxes. ``edges`` to ``neighbours`` are the fields of ``Topology``. ``mean`` (V, 3) are the
    normals of smooth vertices, zero at sharp ones. ``owns_vertex`` and ``owns_edge`` (F, 3) assign every vertex and
    edge to one face. ``outward`` (F, 3, 3) are unit vectors in the plane of a face, perpendicular to its edges, that
    point away from it. ``facet`` (F,) is the number of the large flat face to which a triangle belongs, or -1.
    ``curved`` (F,) marks the faces that represent a curved surface.
    """

    vertices: Float
    triangles: Float
    normals: Float
    low: Float
    high: Float
    box: Float
    faces: Int
    edges: Int
    sides: Int
    bend: Float
    of_face: Int
    starts: Int
    neighbours: Int
    mean: Float
    owns_vertex: Bool
    owns_edge: Bool
    outward: Float
    facet: Int
    curved: Bool

    @classmethod
    def of(cls, body: Body) -> SearchMesh:
        """Return the mesh of a body in its pose, with as few triangles as its flat faces need."""
        local, surface = body.shape.surface.reduced, body.reduced_world
        known, faces, normals = local.topology, np.ascontiguousarray(local.faces), surface.normals
        vertices = np.ascontiguousarray(surface.vertices)
        triangles, low, high, box, mean, outward = core.prepared(vertices, faces, normals, known.edges, known.bend)
        connected = known.edges, known.sides, known.bend, known.of_face, known.starts, known.neighbours
        about = *connected, mean, *local.owned, outward, local.facets.label, local.curved
        return sealed(cls(vertices, triangles, normals, low, high, box, faces, *about))


def moved_mesh(local: SearchMesh, pose: Float) -> SearchMesh:
    """Return ``local``, the mesh of a body in its own frame, moved to ``pose`` (4, 4)."""
    vertices, triangles, low, high = core.placed(local.vertices, local.faces, pose)
    turn = pose[:3, :3].T
    moved = local._replace(
        vertices=vertices,
        triangles=triangles,
        normals=np.ascontiguousarray(local.normals @ turn),
        low=low,
        high=high,
        box=np.array([[column.min() for column in low.T], [column.max() for column in high.T]]),
        mean=np.ascontiguousarray(local.mean @ turn),
        outward=np.ascontiguousarray((local.outward.reshape(-1, 3) @ turn).reshape(-1, 3, 3)),
    )
    return sealed(moved)


def near_faces(
    a: SearchMesh, b: SearchMesh, gap: float, facets: tuple[int, int] = (-1, -1), *, but_facets: bool = False
) -> Int:
    """Return the pairs (m, 2) of faces of a and b whose boxes come within ``gap`` [m].

    If ``facets`` gives the number of a large flat face of each body, only triangles of these two count. With
    ``but_facets``, pairs in which both belong to large flat faces, which are treated as polygons, do not count.
    """
    return core.near_faces(a, b, gap, *facets, but_facets=but_facets)


def near_facets(a: SearchMesh, b: SearchMesh, gap: float) -> list[tuple[int, int]]:
    """Return the pairs of large flat faces of a and b, by their numbers, whose boxes come within ``gap`` [m]."""
    (low_a, high_a), (low_b, high_b) = _facet_boxes(a), _facet_boxes(b)
    near = (low_a[:, None] <= high_b + gap) & (low_b <= high_a[:, None] + gap)
    return [(int(i), int(j)) for i, j in np.argwhere(near.all(2))]


def _facet_boxes(mesh: SearchMesh) -> tuple[Float, Float]:
    """Return the lowest and the highest corners (n, 3) of the boxes of the large flat faces."""
    order = np.argsort(mesh.facet, kind="stable")
    starts = np.searchsorted(mesh.facet[order], np.arange(mesh.facet.max(initial=-1) + 1))
    if not len(starts):
        return np.empty((0, 3)), np.empty((0, 3))
    return np.minimum.reduceat(mesh.low[order], starts), np.maximum.reduceat(mesh.high[order], starts)


class FeatureLimits(NamedTuple):
    """Tolerances of the search for touching edges and vertices; lengths are in metres.

    Surfaces touch up to ``gap`` apart and ``depth`` into each other. ``sin_angle`` is the sine of the angle by which
    the surface beside a feature may slope towards the other body; beside a curved face ``sin_curved`` holds instead.
    Lengths up to ``tiny`` are rounding. Contacts within ``strict`` of a sharp edge do not count.
    """

    gap: float
    depth: float
    sin_angle: float
    sin_curved: float
    tiny: float
    strict: float


@dataclass(frozen=True, eq=False, repr=False)
class Features(Value):
    """Contacts along lines and at points, halfway between the bodies.

    ``ends`` (m, 2, 3) [m] are the two ends of each line, which are equal for a point. ``normals`` (m, 3) point into b.
    ``heights`` (m, 2) [m] are the separations at the ends. ``inset`` (m,) [m] is the distance from the nearest sharp
    edge of the touched face. ``blended`` (m,) is True if the normal is the mean of several faces.
    """

    ends: Float
    normals: Float
    heights: Float
    inset: Float
    blended: Bool

    def __post_init__(self) -> None:
        seal(self)


def touching_features(
    a: SearchMesh, b: SearchMesh, pairs: Int, *, gap: float, depth: float, angles: Angles, size: float, strict: float
) -> tuple[Features, Features]:
    """Find the lines and the points where edges and vertices touch, among ``pairs`` (m, 2) of faces whose boxes meet.

    ``size`` [m] is that of the smaller body. Contacts within ``strict`` [m] of a sharp edge do not count.
    """
    sin_angle, sin_curved = np.sin(np.radians(angles)).tolist()
    limits = FeatureLimits(gap, depth, sin_angle, sin_curved, COORDINATES * size, strict)
    lines, points = core.touching_features(a, b, pairs, limits)
    return _features(lines), _features(points)


def _features(rows: Float) -> Features:
    return Features(rows[:, :6].reshape(-1, 2, 3), rows[:, 6:9], rows[:, 9:11], rows[:, 11], rows[:, 12] > 0)
