"""Meshes of several closed parts: told apart where they touch, joined to one solid, against exact mass properties."""

from __future__ import annotations

import itertools

import mesh_parts
import numpy as np
import pytest
import trimesh
from mesh_parts import US, WAYS, Span, of_boxes, spanning
from scipy.spatial.transform import Rotation

import holdfast as hf


def check(mesh: hf.Mesh, truth: tuple[float, np.ndarray, np.ndarray], rel: float = 1e-9) -> None:
    volume, com, inertia = truth
    found = mesh.mass_properties
    assert found.volume == pytest.approx(volume, rel=rel)
    size = float(np.ptp(mesh.vertices, axis=0).max())
    np.testing.assert_allclose(found.com, com, atol=rel * size)
    np.testing.assert_allclose(found.inertia, inertia, atol=rel * volume * size**2)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("shape", US)
def test_a_u_of_boxes_is_one_solid(shape: str, way: str) -> None:
    mesh = WAYS[way]([spanning(*span) for span in US[shape]])
    assert mesh.is_closed
    assert mesh.report.joined == len(US[shape])
    assert mesh.report.shared == 0
    assert f"{len(US[shape])} closed parts joined" in str(mesh.report)
    check(mesh, of_boxes(US[shape]))
    assert mesh.surface.topology.closed
    assert mesh.surface.area == pytest.approx(mesh_parts.clean_u().surface.area, rel=1e-9)  # no walls are left inside


@pytest.mark.parametrize("way", ["apart", "welded"])
def test_a_u_of_boxes_is_a_body_with_the_mass_that_is_given(way: str) -> None:
    mesh = WAYS[way]([spanning(*span) for span in US["on top"]])
    volume, com, inertia = of_boxes(US["on top"])
    body = hf.Body("u", mesh, mass=3.0)
    assert body.mass == 3.0
    np.testing.assert_allclose(body.com_body, com, atol=1e-12)
    np.testing.assert_allclose(body.inertia_com, inertia * 3.0 / volume, atol=1e-12)
    assert hf.Body("u", mesh, density=800).mass == pytest.approx(800 * volume)


@pytest.mark.parametrize("way", WAYS)
def test_boxes_that_touch_at_an_edge_stay_two_parts(way: str) -> None:
    spans: list[Span] = [((0, 0, 0), (1, 1, 1)), ((1, 1, 0), (2, 2, 1))]
    mesh = WAYS[way]([spanning(*span) for span in spans])
    assert mesh.is_closed
    assert (mesh.report.pieces, mesh.report.joined) == (2, 0)
    check(mesh, of_boxes(spans))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("way", ["apart", "welded", "soup"])
def test_random_cubes_of_a_grid_add_up(way: str, seed: int) -> None:
    """Every pair of cubes has a face, an edge, a vertex or nothing in common."""
    rng = np.random.default_rng(seed)
    cells = [cell for cell in itertools.product(range(3), range(3), range(2)) if rng.random() < 0.5]
    spans: list[Span] = [(cell, np.add(cell, 1).tolist()) for cell in cells]
    check(WAYS[way]([spanning(*span) for span in spans]), of_boxes(spans))


@pytest.mark.parametrize("seed", range(12))
def test_common_volume_of_overlapping_boxes_counts_once(seed: int) -> None:
    """The truth counts the cells of a grid that lie in any of the boxes."""
    rng = np.random.default_rng(seed)
    low = rng.integers(0, 5, (4, 3))
    high = low + rng.integers(1, 5, (4, 3))
    cells = [
        cell
        for cell in itertools.product(range(9), repeat=3)
        if ((low <= cell) & (np.add(cell, 1) <= high)).all(1).any()
    ]
    truth = of_boxes([(cell, np.add(cell, 1).tolist()) for cell in cells])
    mesh = WAYS["apart"]([spanning(*span) for span in zip(low.tolist(), high.tolist(), strict=True)])
    check(mesh, truth)
    assert mesh.report.shared == pytest.approx((high - low).prod(1).sum() - truth[0], abs=1e-9)
    assert ("overlapped" in str(mesh.report)) == (mesh.report.shared > 0)


@pytest.mark.parametrize("seed", range(4))
def test_rounding_between_the_parts_does_no_harm(seed: int) -> None:
    turn = np.eye(4)
    turn[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    parts = [spanning(*span).apply_transform(turn) for span in US["beside"]]
    volume, com, inertia = of_boxes(US["beside"])
    R = turn[:3, :3]
    for way in ("apart", "soup"):
        check(WAYS[way](parts), (volume, R @ com, R @ inertia @ R.T), rel=1e-7)


def test_a_cavity_is_kept_when_its_part_is_joined_to_another() -> None:
    outer, hole, beside = spanning((0, 0, 0), (3, 3, 3)), spanning((1, 1, 1), (2, 2, 2)), spanning((3, 0, 0), (4, 3, 3))
    hole.faces = hole.faces[:, ::-1]
    kernel = spanning((1.25, 1.25, 1.25), (1.75, 1.75, 1.75))
    assert WAYS["apart"]([outer, hole, beside]).mass_properties.volume == pytest.approx(27 - 1 + 9)
    assert WAYS["apart"]([outer, hole, kernel, beside]).mass_properties.volume == pytest.approx(27 - 1 + 0.125 + 9)


def test_parts_that_do_not_touch_stay_as_they_are() -> None:
    parts = [spanning((0, 0, 0), (1, 1, 1)), spanning((2, 0, 0), (3, 1, 1))]
    mesh = WAYS["apart"](parts)
    assert (mesh.report.pieces, mesh.report.joined) == (2, 0)
    np.testing.assert_array_equal(mesh.surface.vertices, np.vstack([part.vertices for part in parts]))


@pytest.mark.parametrize("way", ["apart", "welded", "soup"])
def test_parts_of_which_one_is_open_are_refused_as_before(way: str) -> None:
    parts = [spanning(*span) for span in US["on top"]]
    parts[1].update_faces(np.arange(12) > 0)
    mesh = WAYS[way](parts)
    with pytest.raises(hf.errors.GeometryError, match=r"body 'u'.*is not watertight.*open edges.*; give mass=, com="):
        hf.Body("u", mesh, mass=1)
    body = hf.Body("u", mesh, mass=1, com=(0, 0, 0))
    assert not body.shape.is_closed
    assert mesh.report.joined == 0


def test_a_wall_inside_a_solid_is_refused() -> None:
    """Three faces at an edge: it is not known whether there is one solid or two."""
    cube = spanning((0, 0, 0), (1, 1, 1))
    wall = [[0, 0, 0], [1, 1, 0], [1, 1, 1], [0, 0, 1]]
    vertices, faces = np.vstack([cube.vertices, wall]), np.vstack([cube.faces, [[8, 9, 10], [8, 10, 11]]])
    with pytest.raises(hf.errors.GeometryError, match=r"not watertight.*edges with more than two faces"):
        hf.Body("walled", hf.Mesh(vertices, faces), mass=1)


def test_a_box_whose_faces_stand_twice_is_one_box() -> None:
    cube = spanning((0, 0, 0), (1, 1, 1))
    mesh = hf.Mesh(cube.vertices, np.vstack([cube.faces, cube.faces[:, ::-1]]))
    assert mesh.mass_properties.volume == pytest.approx(1)
    assert mesh.report.joined == 0


def test_round_parts_that_overlap_are_joined() -> None:
    """Two balls a radius apart share a lens of pi (4 r + d) (2 r - d)² / 12."""
    r, apart = 1.0, 1.0
    balls = [trimesh.creation.icosphere(subdivisions=4, radius=r).apply_translation((x, 0, 0)) for x in (0, apart)]
    lens = np.pi * (4 * r + apart) * (2 * r - apart) ** 2 / 12
    mesh = WAYS["apart"](balls)
    assert mesh.report.shared == pytest.approx(lens, rel=0.01)
    assert mesh.mass_properties.volume == pytest.approx(8 / 3 * np.pi - lens, rel=0.01)
