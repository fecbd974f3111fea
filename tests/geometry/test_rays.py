"""Where a ray meets triangles, beside linear equations solved one by one."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.geometry.triangles import first_hit
from holdfast.scene.shapes import Box


def test_random_rays_meet_what_the_equations_say() -> None:
    """o + s d = a + u (b - a) + v (c - a) for every triangle, the least s > 0 with u, v >= 0 and u + v <= 1."""
    rng = np.random.default_rng(7)
    met = 0
    for _ in range(200):
        vertices, origin = rng.normal(size=(30, 3)), 3 * rng.normal(size=3)
        ray = rng.normal(size=3) - origin
        triangles = np.arange(30).reshape(-1, 3)
        found = []
        for number, (a, b, c) in enumerate(vertices[triangles]):
            u, v, s = np.linalg.solve(np.stack([b - a, c - a, -ray], axis=1), origin - a)
            if u >= 0 and v >= 0 and u + v <= 1 and s > 0:
                found.append((s, number))
        hit = first_hit(vertices, triangles, origin, ray)
        met += hit is not None
        assert (hit is None) == (not found)
        if hit is not None:
            assert (hit.distance, hit.triangle) == pytest.approx(min(found))
    assert 20 < met < 180


def test_rays_along_a_face_and_through_an_edge() -> None:
    surface = Box(np.array([2.0, 2.0, 2.0])).surface
    assert first_hit(surface.vertices, surface.faces, np.array([3.0, 3.0, 0.0]), np.array([0.0, 0.0, 1.0])) is None
    through = first_hit(surface.vertices, surface.faces, np.array([0.0, 0.0, 4.0]), np.array([0.0, 0.0, -1.0]))
    assert through is not None
    assert through.distance == pytest.approx(3.0), "the diagonal of the top"
