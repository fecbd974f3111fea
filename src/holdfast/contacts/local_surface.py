"""The surface near a point on it: its normal, the distance of sharp edges, and where it slopes (compiled)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, dot3, lean
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.geometry.topology import FLAT, SMOOTH


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


@compiled
@lean
def slack_at(bend: float, height: float, tiny: float, strict: float) -> float:
    """Return how far [m] beyond an edge of a face a point may be and still touch the face; negative at a sharp edge."""
    if not np.isfinite(bend) or bend <= FLAT:
        return tiny
    if bend < SMOOTH:
        return tiny + abs(height) * float(np.tan(bend / 2))
    return -strict


@compiled
@lean
def normal_at(mesh: SearchMesh, face: int, point: Float, height: float, tiny: float, normal: Float) -> float:
    """Write the normal of the surface at a point over a face; return 1.0 if it is a mean of several faces, else 0.0.

    Near a smooth edge it is the mean normal of the two faces, near a smooth vertex that of the vertex.
    """
    near = 0  # bit k is set if the point is at edge k
    for k in range(3):
        bend = mesh.bend[mesh.of_face[face, k]]
        if FLAT < bend < SMOOTH:
            out = mesh.outward[face, k]
            p = mesh.triangles[face, k]
            beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
            if beyond >= -slack_at(bend, height, tiny, 0.0):
                near |= 1 << k
    for m in range(3):
        normal[m] = mesh.normals[face, m]
    for k in range(3):
        vertex = mesh.faces[face, k]
        if near >> k & 1 and near >> (k + 2) % 3 & 1 and dot3(mesh.mean[vertex], mesh.mean[vertex]) > 0:
            for m in range(3):
                normal[m] = mesh.mean[vertex, m]
            return 1.0
    for k in range(3):
        if near >> k & 1:
            edge = mesh.of_face[face, k]
            other = mesh.sides[edge, 1] if mesh.sides[edge, 0] == face else mesh.sides[edge, 0]
            for m in range(3):
                normal[m] += mesh.normals[other, m]
            break
    length = np.sqrt(dot3(normal, normal))
    if length < 1:  # the two faces have opposite windings, as in a mesh whose inside is unknown, so there is no mean
        for m in range(3):
            normal[m] = mesh.normals[face, m]
        return 0.0
    for m in range(3):
        normal[m] /= length
    return 1.0 if near else 0.0


@compiled
@lean
def vertex_rises(mesh: SearchMesh, vertex: int, normal: Float, limits: FeatureLimits) -> bool:
    """Tell whether all edges at a vertex lead away along ``normal``, or slope against it by no more than the angle."""
    v = mesh.vertices[vertex]
    for n in range(mesh.starts[vertex], mesh.starts[vertex + 1]):
        w = mesh.vertices[mesh.neighbours[n]]
        x, y, z = w[0] - v[0], w[1] - v[1], w[2] - v[2]
        if x * normal[0] + y * normal[1] + z * normal[2] < -limits.sin_angle * np.sqrt(x * x + y * y + z * z):
            return False
    return True


@compiled
@lean
def edge_rises(mesh: SearchMesh, edge: int, normal: Float, limits: FeatureLimits) -> bool:
    """Tell whether both faces at an edge lead away along ``normal``, or slope against it by no more than the angle."""
    for side in range(2):
        face = mesh.sides[edge, side]
        sin_angle = limits.sin_curved if mesh.curved[face] else limits.sin_angle
        for k in range(3):
            if mesh.of_face[face, k] == edge:
                out = mesh.outward[face, k]
                if dot3(out, normal) > sin_angle:
                    return False
    return True


@compiled
@lean
def lies_over(mesh: SearchMesh, face: int, point: Float, height: float, tiny: float, strict: float) -> bool:
    """Tell whether a point at ``height`` [m] over the plane of a face projects into the face, within tolerances."""
    for k in range(3):
        out = mesh.outward[face, k]
        p = mesh.triangles[face, k]
        beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
        if beyond > slack_at(mesh.bend[mesh.of_face[face, k]], height, tiny, strict):
            return False
        if abs(beyond) <= strict:  # near a sharp corner, even if the edges of this face at the corner are smooth
            x, y, z = point[0] - p[0], point[1] - p[1], point[2] - p[2]
            sharp = dot3(mesh.mean[mesh.faces[face, k]], mesh.mean[mesh.faces[face, k]]) == 0
            if sharp and x * x + y * y + z * z - height * height <= strict * strict:
                return False
    return True


@compiled
@lean
def inset_of(mesh: SearchMesh, face: int, point: Float) -> float:
    """Return the distance [m] of a point over a face to the nearest sharp edge of the face; infinite if it has none."""
    least = np.inf
    for k in range(3):
        bend = mesh.bend[mesh.of_face[face, k]]
        if SMOOTH <= bend < np.inf:
            out = mesh.outward[face, k]
            p = mesh.triangles[face, k]
            beyond = out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2])
            least = min(least, -beyond)
    return least


@compiled
@lean
def height_over(mesh: SearchMesh, face: int, point: Float) -> float:
    """Return the height [m] of a point over the plane of a face, negative below it."""
    p, m = mesh.triangles[face, 0], mesh.normals[face]
    return float((point[0] - p[0]) * m[0] + (point[1] - p[1]) * m[1] + (point[2] - p[2]) * m[2])
