"""Toppling axes of a cut (Sec. V-C2, V-C3); native/topple.hpp finds the torque that resists a turn about them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from holdfast.base.arrays import Float, frozen
from holdfast.geometry.hull import hull_edges, outline_numbers
from holdfast.native import core

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
    tolerance = core.ON_AXIS * size
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
        segments = hull_edges(centred, core.SLIDING)
    return _lines(points[segments[:, 0]], points[segments[:, 1]], tolerance)


def _lines(start: Float, end: Float, tolerance: float) -> tuple[Float, Float]:
    """Return origins and unit directions of the lines through segments, each line once."""
    direction = end - start
    length = np.linalg.norm(direction, axis=1)
    keep = length > tolerance
    start, direction = start[keep], direction[keep] / length[keep, None]
    new = np.empty(len(start), dtype=bool)
    core.first_of_line(start, direction, tolerance, new)
    return frozen(start[new]), frozen(direction[new])


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
