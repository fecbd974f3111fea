"""Distances of points from a triangle surface, and winding numbers, which tell whether they are inside."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.geometry.surface import Surface
from holdfast.native import core


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
