"""Cells tile the surfaces of bodies."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import trimesh

import holdfast as hf
from holdfast.geometry.cells import Cells, surface_cells
from holdfast.geometry.distance import distance_to_surface
from holdfast.geometry.polygon import shapely_polygon
from holdfast.geometry.surface import Surface
from holdfast.queries.map import covered
from holdfast.scene.shipped import shipped_scene

ELL = trimesh.creation.extrude_polygon(
    shapely_polygon([np.array([(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.3), (0, 0.3)], dtype=float)]), 0.05
)
TABLETOP = {body.name: body.surface_world for body in shipped_scene("tabletop").movable}
SURFACES = {
    "box": hf.Box((0.1, 0.2, 0.3)).surface,
    "sliver": hf.Box((0.1, 0.2, 1e-4)).surface,
    "ell": hf.Mesh(ELL.vertices, ELL.faces).surface,
    "cylinder": hf.Cylinder(0.05, 0.2).surface,
    "sphere": hf.Sphere(0.1).surface,
    **TABLETOP,
}
SPACINGS = (0.01, 0.03, 0.5)
OFF = dict.fromkeys(SURFACES, 1e-9) | dict.fromkeys(TABLETOP, 2e-8)  # [m]; coordinates in those files are float32


def area_of(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def some(values: np.ndarray, count: int) -> np.ndarray:
    """About ``count`` of the rows, spread evenly."""
    return values[:: max(1, len(values) // count)]


def distance_to(point: np.ndarray, surface: Surface, k: int) -> float:
    return float(distance_to_surface(point[None], Surface(surface.vertices, surface.faces[k : k + 1]))[0])


@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", SURFACES)
def test_cells_cover_the_surface_once(name: str, spacing: float) -> None:
    surface = SURFACES[name]
    cells = surface_cells(surface, spacing)
    total = area_of(surface.vertices, surface.faces).sum()
    assert area_of(cells.vertices, cells.triangles).sum() == pytest.approx(total, rel=1e-9)
    assert distance_to_surface(some(cells.vertices, 150), surface).max() < OFF[name]


@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", SURFACES)
def test_every_cell_has_a_point_on_the_body_and_an_outward_normal(name: str, spacing: float) -> None:
    surface = SURFACES[name]
    cells = surface_cells(surface, spacing)
    assert set(cells.cell) == set(range(len(cells.points)))
    assert len(cells.normals) == len(cells.points)
    assert distance_to_surface(some(cells.points, 150), surface).max() < OFF[name]
    np.testing.assert_allclose(np.linalg.norm(cells.normals, axis=1), 1, rtol=1e-9)
    triangles = surface.vertices[surface.faces]
    turned = np.cos(np.radians(cells.turned))
    for point, normal, least in zip(some(cells.points, 9), some(cells.normals, 9), some(turned, 9), strict=True):
        off = np.abs(((point - triangles[:, 0]) * surface.normals).sum(1))
        near = [k for k in np.flatnonzero(off < 1e-7) if distance_to(point, surface, k) < 1e-7]
        assert (surface.normals[near] @ normal).max() > least - 1e-6


def test_cells_are_about_one_spacing_wide() -> None:
    cells = surface_cells(SURFACES["box"], 0.01)
    assert len(cells.points) == 2 * (10 * 20 + 10 * 30 + 20 * 30)
    sizes = np.bincount(cells.cell, area_of(cells.vertices, cells.triangles))
    np.testing.assert_allclose(sizes, 1e-4, rtol=1e-9)


@pytest.mark.parametrize("name", ["table", "arch", "tabletop"])
def test_covered_cells_are_those_on_patches(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    for body in assembly.movable:
        cells = surface_cells(body.surface_world, 0.02)
        patches = [p for i in assembly.interfaces if body.name in i.bodies for p in i.patches]
        found = covered(cells, patches, assembly.tolerances.gap)
        for point, hidden in zip(cells.points, found, strict=True):
            on = [abs((point - p.polygon[0]) @ p.normal) < 1e-9 and well_within(p, point) for p in patches]
            assert hidden == any(on)


def well_within(patch: hf.answers.Patch, point: np.ndarray) -> bool:
    """Whether a point of the patch's plane lies on it, and not on its outline."""
    polygon = shapely_polygon(patch.rings)
    seen = shapely.Point((point - patch.polygon[0]) @ patch.frame.T)
    return polygon.contains(seen) and polygon.exterior.distance(seen) > 1e-8 * patch.size


def test_a_choice_of_cells_is_numbered_anew() -> None:
    cells = surface_cells(SURFACES["box"], 0.05)
    keep = np.arange(len(cells.points)) % 3 == 0
    chosen: Cells = cells.chosen(keep)
    np.testing.assert_array_equal(chosen.points, cells.points[keep])
    assert set(chosen.cell) == set(range(len(chosen.points)))
    old = np.flatnonzero(keep)[chosen.cell]
    np.testing.assert_array_equal(old, cells.cell[keep[cells.cell]])


@pytest.mark.parametrize("spacing", [0.01, 0.02])
def test_points_of_a_scan_are_spread_evenly_with_smoothed_normals(spacing: float) -> None:
    """A rough ball of 20,480 triangles: cells of about a spacing, whose normals are those of the ball."""
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.1)
    rough = ball.vertices * (1 + np.random.default_rng(2).normal(0, 3e-4, (len(ball.vertices), 1)))
    surface = hf.Mesh(rough, ball.faces).surface
    cells = surface_cells(surface, spacing)
    assert 0.8 < len(cells.points) / (surface.area / spacing**2) < 1.6
    assert cells.areas.max() < 3 * spacing**2
    apart = np.linalg.norm(cells.points[:, None] - cells.points, axis=2) + np.eye(len(cells.points))
    assert np.quantile(apart.min(1), 0.05) > 0.5 * spacing
    outward = cells.points / np.linalg.norm(cells.points, axis=1)[:, None]
    off = np.degrees(np.arccos(np.clip((cells.normals * outward).sum(1), -1, 1)))
    facets = surface.normals * (centres := surface.vertices[surface.faces].mean(1))
    raw = np.degrees(np.arccos(np.clip(facets.sum(1) / np.linalg.norm(centres, axis=1), -1, 1)))
    assert np.median(off) < 0.5 * np.median(raw)
    assert np.median(cells.turned) == pytest.approx(np.median(raw), rel=0.5)


def test_both_sides_of_a_thin_wall_have_cells_of_their_own() -> None:
    shell = trimesh.creation.icosphere(subdivisions=4, radius=0.1)
    faces = np.vstack([shell.faces, shell.faces[:, ::-1] + len(shell.vertices)])
    surface = Surface(np.vstack([shell.vertices, 0.98 * shell.vertices]), faces)
    cells = surface_cells(surface, 0.02)
    outside = (cells.normals * cells.points).sum(1) > 0
    assert outside.mean() == pytest.approx(0.5, abs=0.1)
    assert np.abs((cells.normals * cells.points).sum(1)).min() > 0.09
