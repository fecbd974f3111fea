"""Find the flat faces on which an object can stand, which are the facets of its convex hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents
from holdfast.geometry.hull import convex_hull, hull_facets, smallest_rectangle
from holdfast.scene.body import Body

COPLANAR = 1e-3  # [rad] hull triangles whose normals differ by less belong to one face


@dataclass(frozen=True, eq=False)
class Face:
    """A face of the object's convex hull, in the body frame.

    ``normal`` (3,) points outwards. ``foot`` (3,) [m] is the centre of mass projected into the plane of the face, and
    ``corners`` (k, 3) [m] are the corners of the face. ``along`` (3,) is the direction of its longer side. ``tilt``
    [rad] is how far a plane can be tilted, in the worst direction, before the object tips over on this face; it is 0 if
    the object does not stand on it even on a horizontal plane.
    """

    normal: Float
    foot: Float
    corners: Float
    along: Float
    tilt: float


def faces_of(body: Body) -> tuple[Face, ...]:
    """Return all faces of the body's convex hull, the steadiest first."""
    vertices = body.shape.surface.vertices
    facets = hull_facets(vertices, COPLANAR)
    faces = [_face(normal, vertices[corners], body.com_body) for normal, corners in facets]
    return tuple(sorted(faces, key=lambda face: -round(face.tilt, 9)))


def _face(normal: Float, points: Float, com: Float) -> Face:
    frame = np.array(tangents(normal))
    level = float((points @ normal).max())
    size = float(np.ptp(points, axis=0).max())
    ring = convex_hull(points @ frame.T, 1e-9 * size)
    foot = com @ frame.T
    edges = np.roll(ring, -1, axis=0) - ring
    length = np.linalg.norm(edges, axis=1)
    inside = (edges[:, 0] * (foot - ring)[:, 1] - edges[:, 1] * (foot - ring)[:, 0]) / length
    margin, height = float(inside.min()), max(level - float(com @ normal), 1e-9 * size)
    axes, _, _ = smallest_rectangle(ring)
    return Face(
        normal,
        foot @ frame + level * normal,
        ring @ frame + level * normal,
        axes[0] @ frame,
        float(np.arctan2(max(margin, 0.0), height)),
    )
