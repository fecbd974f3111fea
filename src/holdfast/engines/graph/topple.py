"""Toppling axes of a cut, and the torque with which contacts resist a rotation about them (Sec. V-C2, V-C3).

Signs: the moving side turns by +a about the axis through o. ``n`` is the inward normal of the stationary side, ``f`` is
the force of the moving side on the stationary side, and v = (p - o) x a is minus the velocity of the moving side at the
node p. If v·n < 0, the motion is blocked. If v·n > 0, the contact opens and its preload f·v has to be overcome. If
v·n = 0, the contact slides.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from holdfast.base.arrays import Bool, Float, frozen
from holdfast.base.compiled import compiled
from holdfast.engines.graph.slip import node_slip
from holdfast.geometry.hull import hull_edges, outline_numbers

ON_AXIS = 1e-6  # distance of a node from the axis, relative to the assembly's size, below which the node does not move
SLIDING = 1e-6  # |v·n| / |v| below which v·n counts as 0
KEPT = 2000  # sets of points whose axes are kept


def toppling_axes(points: Float, size: float) -> tuple[Float, Float]:
    """Return origins (m, 3) and unit directions (m, 3) of the edges of the convex hull of contact ``points`` (n, 3).

    Facets in one plane count as one facet, and edges on one line as one edge. Points in one plane give the edges of a
    polygon, and points on one line give that line. A single point gives three orthogonal lines, because every rotation
    about it is a sum of rotations about these. Points are in [m], and ``size`` [m] is that of the assembly. The axes of
    the last KEPT sets of points are kept: most cuts of an edited assembly are as they were.
    """
    return _axes_of(np.ascontiguousarray(points, dtype=np.float64).tobytes(), size)


@lru_cache(maxsize=KEPT)
def _axes_of(coordinates: bytes, size: float) -> tuple[Float, Float]:
    points = np.frombuffer(coordinates).reshape(-1, 3)
    tolerance = ON_AXIS * size
    centred = points - points.mean(0)
    _, extents, directions = np.linalg.svd(centred, full_matrices=False)
    spread = extents / np.sqrt(len(points))
    if spread[0] <= tolerance:
        return frozen(np.repeat(points[:1], 3, axis=0)), frozen(np.eye(3))
    if len(spread) < 2 or spread[1] <= tolerance:
        return frozen(points[:1]), frozen(directions[:1])
    if len(spread) < 3 or spread[2] <= tolerance:
        corners = outline_numbers(centred @ directions[:2].T)
        segments = np.column_stack([corners, np.roll(corners, -1)])
    else:
        segments = hull_edges(centred, SLIDING)
    return _lines(points[segments[:, 0]], points[segments[:, 1]], tolerance)


def _lines(start: Float, end: Float, tolerance: float) -> tuple[Float, Float]:
    """Return origins and unit directions of the lines through segments, each line once."""
    direction = end - start
    length = np.linalg.norm(direction, axis=1)
    keep = length > tolerance
    start, direction = start[keep], direction[keep] / length[keep, None]
    new = _first_of_line(start, direction, tolerance)
    return frozen(start[new]), frozen(direction[new])


@compiled
def _first_of_line(start: Float, direction: Float, tolerance: float) -> Bool:
    """Return which segments (n,) do not lie on the line of an earlier segment."""
    new = np.ones(len(start), dtype=np.bool_)
    for i in range(len(start)):
        for j in range(i):
            if not new[j]:
                continue
            along = 0.0
            arm2 = 0.0
            aligned = 0.0
            for k in range(3):
                arm = start[i, k] - start[j, k]
                arm2 += arm * arm
                along += arm * direction[j, k]
                aligned += direction[i, k] * direction[j, k]
            if abs(aligned) > 1 - 1e-9 and arm2 - along * along <= tolerance * tolerance:
                new[i] = False
                break
    return new


def friction_axis(points: Float, normals: Float, mu: Float, normal_force: Float) -> tuple[Float, Float]:
    """Return origin (1, 3) and direction (1, 3) of the axis about which a cut with parallel normals twists.

    The axis is normal to the contacts and goes through Mason's centre of friction Σ μ f_n p / Σ μ f_n, or through the
    centroid of the ``points`` (n, 3) if no node presses. ``normal_force`` (n,) is f_n [N].
    """
    share = mu * np.maximum(normal_force, 0)
    if not share.sum() > 0:
        share = np.ones(len(points))
    return (share @ points / share.sum())[None], normals[:1]


def all_parallel(normals: Float, angle: float) -> bool:
    """Say whether all unit normals (n, 3) are parallel to the first, up to sign and within ``angle`` [deg]."""
    return bool(np.abs(normals @ normals[0]).min() >= np.cos(np.radians(angle)))


@compiled
def axis_torques(
    origins: Float,
    axes: Float,
    flat: Bool,
    points: Float,
    frames: Float,
    forces: Float,
    mu: Float,
    moving_is_a: Bool,
    size: float,
) -> Float:
    """Return the resisting torque (2m,) [N m] about every axis.

    Entries 2k and 2k + 1 are for the positive and the negative sense of axis k. A torque of inf means that the rotation
    is blocked. The axes are given by ``origins`` (m, 3) [m] and unit ``axes`` (m, 3). ``flat`` (m,) marks axes about
    which every node slides. The n nodes are given by ``points`` (n, 3) [m], ``frames`` (n, 3, 3) with the rows normal
    (into body b), t1 and t2, ``forces`` (n, 3) [N] on body b in that frame, and ``moving_is_a`` (n,), which says
    whether body a is the moving one. ``size`` [m] is that of the assembly.
    """
    m = len(origins)
    torque = np.zeros(2 * m)
    v = np.empty(3)
    for k in range(2 * m):
        line = k // 2
        sense = 1.0 if k % 2 == 0 else -1.0
        for i in range(len(points)):
            arm0 = points[i, 0] - origins[line, 0]
            arm1 = points[i, 1] - origins[line, 1]
            arm2 = points[i, 2] - origins[line, 2]
            a0, a1, a2 = sense * axes[line, 0], sense * axes[line, 1], sense * axes[line, 2]
            v[0] = arm1 * a2 - arm2 * a1
            v[1] = arm2 * a0 - arm0 * a2
            v[2] = arm0 * a1 - arm1 * a0
            speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            if speed <= ON_AXIS * size:
                continue
            side = 1.0 if moving_is_a[i] else -1.0  # turns the node's frame into the stationary side's
            vn = side * (frames[i, 0, 0] * v[0] + frames[i, 0, 1] * v[1] + frames[i, 0, 2] * v[2])
            v1 = side * (frames[i, 1, 0] * v[0] + frames[i, 1, 1] * v[1] + frames[i, 1, 2] * v[2])
            v2 = side * (frames[i, 2, 0] * v[0] + frames[i, 2, 1] * v[1] + frames[i, 2, 2] * v[2])
            if flat[line] or abs(vn) <= SLIDING * speed:
                tangential = np.sqrt(v1 * v1 + v2 * v2)
                strength = node_slip(
                    forces[i, 0], forces[i, 1], forces[i, 2], mu[i], 0.0, -v1 / tangential, -v2 / tangential
                )
                torque[k] += strength * tangential
            elif vn < 0.0:
                torque[k] = np.inf
                break
            else:
                torque[k] += forces[i, 0] * vn + forces[i, 1] * v1 + forces[i, 2] * v2
        torque[k] = max(torque[k], 0.0)
    return torque
