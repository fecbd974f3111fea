"""Distances of rods from triangles, beside points taken closely along both."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.geometry.distance import distance_to_surface, rod_clearance
from holdfast.scene.shapes import Box, Sphere

CUBE = Box((0.2, 0.2, 0.2)).surface


@pytest.mark.parametrize(
    ("start", "along", "apart"),
    [
        ((0.5, 0, 0), (1, 0, 0), 0.4),  # leads away from a face
        ((0.5, 0, 0), (-0.2, 0, 0), 0.2),  # ends before it
        ((0.5, 0, 0), (-1, 0, 0), 0.0),  # goes through
        ((0.15, 0.15, -1), (0, 0, 2), 0.05 * np.sqrt(2)),  # passes an edge
        ((0.3, 0.0, 0.15), (-1, 0, 0), 0.05),  # passes over a face
        ((0.0, 0.0, 0.0), (0.05, 0, 0), 0.05),  # is inside, and touches nothing
    ],
)
def test_a_rod_beside_a_cube(start: tuple[float, ...], along: tuple[float, ...], apart: float) -> None:
    found = rod_clearance(np.array([start], dtype=float), np.array([along], dtype=float), CUBE)
    assert found[0] == pytest.approx(apart, abs=1e-12)


def test_rods_anywhere_are_as_far_as_their_nearest_points() -> None:
    ball = Sphere(0.3, subdivisions=1).surface
    rng = np.random.default_rng(0)
    start, along = rng.normal(size=(60, 3)), rng.normal(size=(60, 3))
    found = rod_clearance(start, along, ball)
    share = np.linspace(0, 1, 2001)[:, None]
    for k in range(len(start)):
        fine = distance_to_surface(start[k] + share * along[k], ball).min()
        assert fine - 0.5 / 2000 * np.linalg.norm(along[k]) <= found[k] <= fine + 1e-12
