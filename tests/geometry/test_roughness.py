"""Roughness: that of a scan is its noise, that of a drawing nothing, wherever it lies."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import holdfast as hf


def box(noise: float, seed: int = 0, rounds: int = 4) -> hf.Mesh:
    """A box of 0.2 by 0.15 by 0.1 m, its vertices off by ``noise`` [m] along every axis."""
    mesh = trimesh.creation.box((0.2, 0.15, 0.1))
    for _ in range(rounds):
        mesh = mesh.subdivide()
    rng = np.random.default_rng(seed)
    return hf.Mesh(mesh.vertices + noise * rng.standard_normal(mesh.vertices.shape), mesh.faces)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", [1e-4, 5e-4])
def test_the_roughness_of_a_scan_is_its_noise(noise: float, seed: int) -> None:
    found = box(noise, seed).surface.roughness
    assert found.height == pytest.approx(noise, rel=0.15)
    assert found.slope == pytest.approx(noise / 0.011, rel=0.4)  # edges of 6 to 15 mm


@pytest.mark.parametrize(
    "shape",
    [
        box(0.0),
        box(0.0, rounds=5),
        hf.Box((0.2, 0.1, 0.1)),
        hf.Cylinder(0.05, 0.1),
        hf.Sphere(0.05),
        hf.Mesh(*(lambda m: (m.vertices, m.faces))(trimesh.creation.icosphere(3, 0.05))),
        hf.Mesh(*(lambda m: (m.vertices, m.faces))(trimesh.creation.capsule(0.1, 0.05))),
    ],
)
def test_exact_and_smooth_surfaces_have_none(shape: object) -> None:
    assert shape.surface.roughness.height == shape.surface.roughness.slope == 0.0  # type: ignore[attr-defined]


def test_roughness_grows_with_the_surface() -> None:
    small = box(3e-4)
    large = hf.Mesh(10 * small.vertices, small.faces)
    assert large.surface.roughness.height == pytest.approx(10 * small.surface.roughness.height, rel=1e-9)
    assert large.surface.roughness.slope == pytest.approx(small.surface.roughness.slope, rel=1e-9)
