"""Convex sets: hulls of points in a plane and in space, half spaces, and gauges.

There are three algorithms, because each does something that the others cannot: corners within a stated tolerance
(``convex_hull``), corner numbers of scaled points (``corner_numbers``), and facets in space (Qhull). What is taken from
``scipy.spatial`` is imported when it is called: that takes a tenth of a second and is seldom needed for boxes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from holdfast.base.arrays import Float, Int, unit
from holdfast.base.ranges import SUM
from holdfast.native import core

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull, cKDTree

PIECE = 4_000_000  # numbers that are in memory at a time, 32 MB
SLIGHT: Final = core.SLIGHT  # a point that violates a facet by less does not count


def convex_hull(points: Float, tolerance: float) -> Float:
    """Return the corners (m, 2) of the convex hull, counter-clockwise (monotone chain).

    Corners within ``tolerance`` of the line through their neighbours are dropped.
    """
    return core.convex_hull(np.ascontiguousarray(points), tolerance)


def smallest_rectangle(hull: Float) -> tuple[Float, Float, Float]:
    """Return the smallest rectangle around a hull (m, 2).

    It is given by its unit axes as rows (2, 2), that of the longer side first, and its low and high bounds (2,) along
    them.
    """
    axes = core.rectangle_axes(np.ascontiguousarray(hull))
    along = hull @ axes.T
    return axes, along.min(0), along.max(0)


def corner_numbers(points: Float) -> Int:
    """Return the numbers (k,) of the points (n, 2) that are corners of their hull, counter-clockwise (Andrew).

    The points should be scaled to about a unit square.
    """
    order = np.argsort(points[:, 0] + 1e-9 * points[:, 1], kind="stable")
    return core.corner_numbers(np.ascontiguousarray(points), order)


def outline_numbers(points: Float) -> Int:
    """Return the numbers (k,) of the corners of the hull of points (n, 2), counter-clockwise, in Qhull's order."""
    return np.asarray(qhull(points).vertices, dtype=np.int64)


def hull_edges(points: Float, flat: float) -> Int:
    """Return the edges (E, 2) of the hull of points (n, 3), as pairs of point numbers.

    Edges at which two triangles meet at an angle of ``flat`` [rad] or less lie within a facet and are left out.
    """
    hull = qhull(points)
    normals = hull.equations[:, :3]
    facet, opposite = np.indices(hull.neighbors.shape)
    other = hull.neighbors
    folded = (normals[facet] * normals[other]).sum(-1) < 1 - flat**2 / 2
    facet, opposite = facet[(other > facet) & folded], opposite[(other > facet) & folded]
    return np.column_stack([hull.simplices[facet, (opposite + k) % 3] for k in (1, 2)]).astype(np.int64)


def hull_facets(points: Float, angle: float) -> list[tuple[Float, Int]]:
    """Return the facets of the hull of points (n, 3): outward unit normals (3,) and the numbers (k,) of their corners.

    Triangles belong to one facet if their normals differ by less than ``angle`` [rad] from that of its first triangle.
    """
    hull = qhull(points)
    normals = hull.equations[:, :3]
    first: list[int] = []
    groups: list[list[int]] = []
    for k in np.lexsort(normals.T):
        alike = np.flatnonzero(normals[first] @ normals[k] > np.cos(angle))
        if len(alike):
            groups[alike[0]].append(int(k))
        else:
            first.append(int(k))
            groups.append([int(k)])
    return [(unit(normals[g].mean(0)), np.unique(hull.simplices[g]).astype(np.int64)) for g in groups]


def search_tree(points: Float) -> cKDTree:
    """Return a search tree of points (n, d)."""
    from scipy.spatial import cKDTree

    return cKDTree(points)


def qhull(points: Float, options: str | None = None) -> ConvexHull:
    """Return the convex hull of points (n, d) by Qhull. Raises ``scipy.spatial.QhullError`` if they are degenerate."""
    from scipy.spatial import ConvexHull

    return ConvexHull(points, qhull_options=options)


def largest_row(A: Float, points: Float) -> Float:
    """Return the largest entry (n,) of A x for each x of ``points`` (n, d); -inf if A (m, d) has no rows.

    Points are processed in pieces that fit into memory.
    """
    step = max(1, PIECE // max(len(A), 1))
    pieces = [(points[k : k + step] @ A.T).max(axis=1, initial=-np.inf) for k in range(0, len(points), step)]
    return np.concatenate(pieces) if pieces else np.empty(0)


def hull_gauge(known: Float, price: Float, points: Float) -> tuple[Float, Float]:
    """Return upper bounds (n,) of a gauge γ at ``points`` (n, d), and the facets (n, d) that give them.

    A gauge is convex and positively homogeneous. So γ(Σ λ x) <= Σ λ γ(x) for every combination of the ``known`` points
    (m, d) with λ >= 0, and γ of each known point is at most its ``price`` (m,): 1 for a point on the boundary of the
    set, 0 for a direction in which the set is unbounded. The first 2 d known points are along the positive and then the
    negative axes; a remainder that a combination does not reach is paid for along these.

    A facet is a y with y·x <= price at all known points for which y·point is the bound, up to rounding. Where the bound
    is differentiable, y is its derivative by the point.
    """
    return core.hull_gauge(np.ascontiguousarray(known), price, np.ascontiguousarray(points), SUM)
