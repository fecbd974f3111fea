"""The surface around a point of it: the normal there, how far edges are, which way it goes (compiled)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, dot3, lean
from holdfast.contacts.skin import Skin
from holdfast.geometry.topology import FLAT, SMOOTH


class Within(NamedTuple):
    """Tolerances of one search, all but the angle's in metres.

    Surfaces touch up to ``gap`` apart and ``depth`` into each other; a feature may fall towards the other body by an
    angle whose sine is ``sin_angle``, beside faces that stand for a curved surface ``sin_curved``; lengths up to
    ``tiny`` are rounding, and sharp edges are stayed away from by ``strict``.
    """

    gap: float
    depth: float
    sin_angle: float
    sin_curved: float
    tiny: float
    strict: float


@compiled
@lean
def slack_at(bend: float, height: float, tiny: float, strict: float) -> float:
    """How far outside a face, beyond one of its edges, a point may lie and still touch it; negative at sharp edges."""
    if not np.isfinite(bend) or bend <= FLAT:
        return tiny
    if bend < SMOOTH:
        return tiny + abs(height) * float(np.tan(bend / 2))
    return -strict


@compiled
@lean
def normal_at(skin: Skin, face: int, point: Float, height: float, tiny: float, normal: Float) -> float:
    """The normal of a surface at a point over a face: the mean of two faces' near a smooth edge, a vertex's at one.

    Returns 1.0 where it is such a mean, else 0.0.
    """
    near = 0  # bit k: at edge k
    for k in range(3):
        bend = skin.bend[skin.of_face[face, k]]
        if FLAT < bend < SMOOTH:
            out = skin.outward[face, k]
            p = skin.triangles[face, k]
            beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
            if beyond >= -slack_at(bend, height, tiny, 0.0):
                near |= 1 << k
    for m in range(3):
        normal[m] = skin.normals[face, m]
    for k in range(3):
        vertex = skin.faces[face, k]
        if near >> k & 1 and near >> (k + 2) % 3 & 1 and dot3(skin.mean[vertex], skin.mean[vertex]) > 0:
            for m in range(3):
                normal[m] = skin.mean[vertex, m]
            return 1.0
    for k in range(3):
        if near >> k & 1:
            edge = skin.of_face[face, k]
            other = skin.sides[edge, 1] if skin.sides[edge, 0] == face else skin.sides[edge, 0]
            for m in range(3):
                normal[m] += skin.normals[other, m]
            break
    length = np.sqrt(dot3(normal, normal))
    if length < 1:  # the two faces are wound against each other, as in a mesh whose inside is not known: no mean
        for m in range(3):
            normal[m] = skin.normals[face, m]
        return 0.0
    for m in range(3):
        normal[m] /= length
    return 1.0 if near else 0.0


@compiled
@lean
def vertex_rises(skin: Skin, vertex: int, normal: Float, within: Within) -> bool:
    """Whether all edges from a vertex go the way of ``normal``, or fall by no more than the angle."""
    v = skin.vertices[vertex]
    for n in range(skin.starts[vertex], skin.starts[vertex + 1]):
        w = skin.vertices[skin.neighbours[n]]
        x, y, z = w[0] - v[0], w[1] - v[1], w[2] - v[2]
        if x * normal[0] + y * normal[1] + z * normal[2] < -within.sin_angle * np.sqrt(x * x + y * y + z * z):
            return False
    return True


@compiled
@lean
def edge_rises(skin: Skin, edge: int, normal: Float, within: Within) -> bool:
    """Whether both faces beside an edge go the way of ``normal``, or fall by no more than the angle."""
    for side in range(2):
        face = skin.sides[edge, side]
        sin_angle = within.sin_curved if skin.curved[face] else within.sin_angle
        for k in range(3):
            if skin.of_face[face, k] == edge:
                out = skin.outward[face, k]
                if dot3(out, normal) > sin_angle:
                    return False
    return True


@compiled
@lean
def lies_over(skin: Skin, face: int, point: Float, height: float, tiny: float, strict: float) -> bool:
    """Whether a point at a height over a face's plane projects into the face, or may be taken to."""
    for k in range(3):
        out = skin.outward[face, k]
        p = skin.triangles[face, k]
        beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
        if beyond > slack_at(skin.bend[skin.of_face[face, k]], height, tiny, strict):
            return False
        if abs(beyond) <= strict:  # at a sharp corner, even where the edges of this face that meet there are not
            x, y, z = point[0] - p[0], point[1] - p[1], point[2] - p[2]
            sharp = dot3(skin.mean[skin.faces[face, k]], skin.mean[skin.faces[face, k]]) == 0
            if sharp and x * x + y * y + z * z - height * height <= strict * strict:
                return False
    return True


@compiled
@lean
def inset_of(skin: Skin, face: int, point: Float) -> float:
    """Distance of a point over a face to the nearest sharp edge of that face; infinite where it has none."""
    least = np.inf
    for k in range(3):
        bend = skin.bend[skin.of_face[face, k]]
        if SMOOTH <= bend < np.inf:
            out = skin.outward[face, k]
            p = skin.triangles[face, k]
            beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
            least = min(least, -beyond)
    return least


@compiled
@lean
def height_over(skin: Skin, face: int, point: Float) -> float:
    """How high a point lies over the plane of a face, negative below it."""
    p, m = skin.triangles[face, 0], skin.normals[face]
    return float((point[0] - p[0]) * m[0] + (point[1] - p[1]) * m[1] + (point[2] - p[2]) * m[2])
