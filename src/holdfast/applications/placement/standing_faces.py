"""Find the faces on which an object can stand: the facets of its convex hull, or the flat ends of an ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float, unit
from holdfast.base.rigid import tangents
from holdfast.geometry.hull import convex_hull, hull_facets, smallest_rectangle
from holdfast.scene.body import Body
from holdfast.scene.round_shapes import Ellipsoid

COPLANAR = 1e-3  # [rad] hull triangles whose normals differ by less belong to one face
ROLLED = np.radians(np.arange(5.0, 31.0, 5.0))  # [rad] rotations at which a facet is tested for a round side
LEVEL = 0.02  # on a round side, the height of the centre of mass changes by no more than this share
ONE_FACE = np.radians(1.0)  # [rad] contact normals that differ by less belong to one face
UPRIGHT = np.cos(
    np.radians(15.0)
)  # cosine of the largest angle between the object's third axis and up if it is upright
STEADY = np.radians(20.0)  # [rad] a face on which the object stands up to this tilt is no facet of a round side


@dataclass(frozen=True, eq=False)
class Face:
    """A face of the object's convex hull, in the body frame.

    ``normal`` (3,) points outwards. ``foot`` (3,) [m] is the centre of mass projected into the plane of the face, and
    ``corners`` (k, 3) [m] are the corners of the face. ``along`` (3,) is the direction of its longer side. ``tilt``
    [rad] is how far a plane can be tilted, in the worst direction, before the object tips over on this face; it is 0 if
    the object does not stand on it even on a horizontal plane. ``rolls`` is True for a facet of a round side, on which
    the real object would roll, because the height of its centre of mass stays the same.
    """

    normal: Float
    foot: Float
    corners: Float
    along: Float
    tilt: float
    rolls: bool

    @property
    def upright(self) -> bool:
        """Whether the object is upright on this face."""
        return bool(self.normal[2] <= -UPRIGHT)


def faces_of(body: Body) -> tuple[Face, ...]:
    """Return all faces of the body's convex hull, the steadiest first; for an ellipsoid, its two flat ends."""
    flat = _flat_ends(body)
    if flat:
        return flat
    vertices = body.shape.surface.vertices
    facets = hull_facets(vertices, COPLANAR)
    outer = vertices[np.unique(np.concatenate([corners for _, corners in facets]))] - body.com_body
    spun = np.linalg.eigh(body.inertia_com)[1].T
    faces = [_face(normal, vertices[corners], body.com_body, outer, spun) for normal, corners in facets]
    return tuple(sorted(faces, key=lambda face: -round(face.tilt, 9)))


def rolls_on(faces: Sequence[Face], pose: Float, normals: Float) -> bool:
    """Return whether an object at ``pose`` (4, 4) has contacts on one facet of a round side only.

    ``normals`` (n, 3) are those of its contacts, which point into it, world frame.
    """
    if not len(normals):
        return False
    local = -normals @ pose[:3, :3]
    touching = faces[int(np.argmax([float(face.normal @ local[0]) for face in faces]))]
    return bool(touching.rolls) and bool((local @ local[0] > np.cos(ONE_FACE)).all())


def _flat_ends(body: Body) -> tuple[Face, ...]:
    """Return both ends of the shortest axis of an ellipsoid; none for other shapes, or if it would roll from there.

    An ellipsoid with its centre of mass in the middle stands where the centre is lowest. The facets of its mesh do not
    count, because the real surface would touch elsewhere. With radii c < b < a, it stands on planes tilted by up to
    atan((b² - c²) / (2 b c)), the largest angle in the ellipse (b, c) between the normal and the line to the middle.
    """
    if not isinstance(body.shape, Ellipsoid):
        return ()
    radii = np.asarray(body.shape.radii, dtype=float)
    short, middle, long = np.argsort(radii, kind="stable").tolist()
    c, b = radii[short], radii[middle]
    if c > (1 - LEVEL) * b or np.abs(body.com_body).max() > LEVEL * c:
        return ()
    tilt = float(np.arctan((b**2 - c**2) / (2 * b * c)))
    ends = np.eye(3)[short] * np.array([[-1.0], [1.0]])
    return tuple(Face(end, c * end, c * end[None], np.eye(3)[long], tilt, rolls=False) for end in ends)


def _face(normal: Float, points: Float, com: Float, outer: Float, spun: Float) -> Face:
    """Describe one facet.

    ``points`` (k, 3) [m] are its corners. ``outer`` (n, 3) [m] are the corners of the whole hull relative to the centre
    of mass ``com``, and the rows of ``spun`` (3, 3) are the principal axes of inertia.
    """
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
    tilt = float(np.arctan2(max(margin, 0.0), height))
    weakest = edges[int(np.argmin(inside))] @ frame
    return Face(
        normal,
        foot @ frame + level * normal,
        ring @ frame + level * normal,
        axes[0] @ frame,
        tilt,
        tilt < STEADY and rolls(normal, np.vstack([weakest, spun]), outer),
    )


def rolls(normal: Float, axes: Float, outer: Float) -> bool:
    """Return whether a body on its face with outward ``normal`` (3,) would roll about one of the directions ``axes``.

    ``axes`` (m, 3) are projected into the face. When the body has turned by an angle a, the height of its centre of
    mass is H(a) = max over the corners ``outer`` (n, 3) of corner . n(a), where n(a) is the direction that points down,
    in the body frame. On a round side H is constant. On a flat face it rises first, or falls if the body topples.
    """
    flat = axes - (axes @ normal)[:, None] * normal
    flat = unit(flat[np.linalg.norm(flat, axis=1) > 0.5 * np.linalg.norm(axes, axis=1)])
    across = np.cross(np.vstack([flat, -flat]), normal)
    down = np.cos(ROLLED)[:, None] * normal + np.sin(ROLLED)[:, None] * across[:, None, :]
    height = (down @ outer.T).max(2)
    return bool((np.abs(height / (outer @ normal).max() - 1) <= LEVEL).all(1).any())
