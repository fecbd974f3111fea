"""Distances of points and rods from a triangle surface, and winding numbers, which tell what is inside."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.geometry.surface import Surface
from holdfast.native import core

PIECE = 200_000  # number of pairs of a rod and an edge that are processed at a time, to limit memory


def distance_to_surface(points: Float, surface: Surface) -> Float:
    """Return the distances (n,) [m] of points (n, 3) from the nearest triangle."""
    triangles = np.ascontiguousarray(surface.vertices[surface.faces])
    return np.asarray(np.sqrt(core.squared_distances(np.ascontiguousarray(points), triangles)))


def winding_number(points: Float, surface: Surface) -> Float:
    """Return how often (n,) the surface winds around points (n, 3): 1 inside and 0 outside, nearly so with small holes.

    It is the sum of the triangles' solid angles over 4π (van Oosterom and Strackee 1983; Jacobson et al. 2013).
    """
    vertices, faces = np.ascontiguousarray(surface.vertices), np.ascontiguousarray(surface.faces)
    return core.winding_numbers(np.ascontiguousarray(points), vertices, faces)


def rod_clearance(start: Float, along: Float, surface: Surface) -> Float:
    """Return the distances (n,) [m] of rods from a surface; rods lead from ``start`` (n, 3) to ``start + along`` [m].

    Unless a rod passes through a triangle, the nearest points are either an end of the rod and a point of the triangle,
    or a point of the rod and a point of an edge.
    """
    triangles = surface.vertices[surface.faces]
    best = np.minimum(distance_to_surface(start, surface), distance_to_surface(start + along, surface))
    step = max(1, PIECE // max(len(triangles), 1))
    for k in range(0, len(start), step):
        piece = slice(k, k + step)
        for corner in range(3):
            origin = triangles[None, :, corner]
            edge = triangles[None, :, (corner + 1) % 3] - origin
            apart = _between_segments(start[piece, None], along[piece, None], origin, edge)
            best[piece] = np.minimum(best[piece], apart.min(1, initial=np.inf))
        best[piece][_through(start[piece], along[piece], triangles).any(1)] = 0.0
    return best


def _between_segments(p: Float, u: Float, q: Float, v: Float) -> Float:
    """Return the distances of segments p + s u and q + t v with 0 <= s, t <= 1.

    Source: Ericson, Real-Time Collision Detection, section 5.1.9.
    """
    r = p - q
    a, b, e = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    c, f = (u * r).sum(-1), (v * r).sum(-1)
    area = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(area > 1e-12 * a * e, np.clip((b * f - c * e) / area, 0, 1), 0.0)
        t = np.where(e > 0, np.clip((b * s + f) / e, 0, 1), 0.0)
        s = np.where(a > 0, np.clip((b * t - c) / a, 0, 1), 0.0)
    return np.asarray(np.linalg.norm(r + s[..., None] * u - t[..., None] * v, axis=-1))


def _through(start: Float, along: Float, triangles: Float) -> Bool:
    """Tell which rods (n, 3) pass through which triangles (m, 3, 3), as (n, m), by signs of volumes."""
    a, b, c = (triangles[None, :, k] - start[:, None] for k in range(3))
    way = along[:, None]
    sides = np.stack([(np.cross(x, y) * way).sum(-1) for x, y in ((a, b), (b, c), (c, a))])
    one_side = (sides >= 0).all(0) | (sides <= 0).all(0)
    normal = np.cross(b - a, c - a)
    height, rate = (a * normal).sum(-1), (way * normal).sum(-1)
    crossed = (height * np.sign(rate) >= 0) & (np.abs(height) <= np.abs(rate)) & (rate != 0)
    return np.asarray(one_side & crossed)
