"""Build poses in which a chosen face of the object lies on chosen points of the scene, with opposed normals."""

from __future__ import annotations

import numpy as np

from holdfast.applications.placement.support import SupportPoints
from holdfast.applications.standing_faces import Face
from holdfast.base.arrays import Float, Int, unit
from holdfast.base.rigid import tangents

STEEPEST_LINE = 0.8  # sine of the largest slope of the line between two points that are used together
STEEPEST_PLANE = 0.4  # cosine of the largest tilt of the plane of three points
LEAST_APART = 0.15  # smallest distance between points that are used together, as a share of the object's size
ALIGNED = 0.7  # share of the poses in which the face is aligned with an edge of the scene


def choose_points(
    support: SupportPoints, count: int, size: float, up: Float, apart: bool, rng: np.random.Generator
) -> Int:
    """Choose up to ``count`` points that an object of ``size`` [m] can span, and return their numbers.

    With ``apart``, they belong to different bodies.
    """
    chosen = [int(rng.choice(len(support.chance), p=support.chance))]
    while len(chosen) < count:
        chance = support.chance.copy()
        for k in chosen:
            arm = support.points - support.points[k]
            distance = np.linalg.norm(arm, axis=1)
            near = (distance < size) & (distance > LEAST_APART * size) & (np.abs(arm @ up) < STEEPEST_LINE * distance)
            if apart:
                near &= support.body != support.body[k]
            chance[~near] = 0
        if len(chosen) == 2:
            a, b = support.points[chosen]
            normal = np.cross(b - a, support.points - a)
            length = np.linalg.norm(normal, axis=1)
            wide = length > LEAST_APART * size * np.linalg.norm(b - a)
            chance[~(wide & (np.abs(normal @ up) > STEEPEST_PLANE * length))] = 0
        if not chance.sum() > 0:
            break
        chosen.append(int(rng.choice(len(chance), p=chance / chance.sum())))
    return np.array(chosen)


def pose_on(points: Float, normal: Float, face: Face, along: Float, rng: np.random.Generator) -> Float:
    """Return the pose (4, 4) with ``face`` on the plane of 1 to 3 points (n, 3) [m] with this ``normal`` (3,).

    With several points, the centre of mass lies between them. A single point lies anywhere in the face, more likely
    near the foot of the centre of mass. The longer side of the face points along ``along`` (3,).
    """
    if len(points) == 1:
        corner = rng.dirichlet(np.ones(len(face.corners))) @ face.corners
        on_face = face.foot + rng.random() ** 2 * (corner - face.foot)
        on_scene = points[0]
    else:
        on_face, on_scene = face.foot, rng.dirichlet(np.full(len(points), 3.0)) @ points
    turn = _turned(face, normal, along)
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = on_scene - turn @ on_face
    return pose


def plane_of(points: Float, normals: Float, up: Float) -> Float:
    """Return the unit normal (3,) of the plane through 1 to 3 points (n, 3) with surface ``normals`` (n, 3).

    With one point, it is the surface normal there. With two, the plane is as level as possible.
    """
    if len(points) == 1:
        return np.asarray(normals[0])
    along = unit(points[1] - points[0])
    if len(points) == 2:
        return unit(up - (up @ along) * along)
    normal = unit(np.cross(along, points[2] - points[0]))
    return normal if normal @ up > 0 else -normal


def direction_in(points: Float, normal: Float, edges: Float, rng: np.random.Generator) -> Float:
    """Choose a random unit direction (3,) in the plane for the longer side of the face.

    In a share ALIGNED of the cases, it is along or across one of the ``edges`` (m, 3) of the scene or a line between
    the points.
    """
    t1, t2 = tangents(normal)
    if rng.random() > ALIGNED:
        angle = rng.uniform(0, 2 * np.pi)
        return np.asarray(np.cos(angle) * t1 + np.sin(angle) * t2)
    lines = edges if len(points) == 1 else np.vstack([edges, unit(points[1:] - points[0])])
    flat = lines - (lines @ normal)[:, None] * normal
    flat = flat[np.linalg.norm(flat, axis=1) > 0.5]
    way = unit(flat[rng.integers(len(flat))]) if len(flat) else t1
    quarter = rng.integers(4)
    across = np.cross(normal, way)
    return np.asarray((way, across, -way, -across)[quarter])


def _turned(face: Face, normal: Float, along: Float) -> Float:
    """Return the rotation (3, 3) that maps the face's normal to minus ``normal`` and its longer side to ``along``."""
    body = np.column_stack([face.normal, face.along, np.cross(face.normal, face.along)])
    world = np.column_stack([-normal, along, np.cross(-normal, along)])
    return np.asarray(world @ body.T)
