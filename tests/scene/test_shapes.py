"""Shapes and mass properties against closed forms; meshes that do not bound a volume."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.base.rigid import pose_from

BOX = trimesh.creation.box((0.2, 0.3, 0.5))
V, F = np.array(BOX.vertices), np.array(BOX.faces)
SHAPES = {
    "box": hf.Box((0.2, 0.3, 0.5)),
    "cylinder": hf.Cylinder(0.1, 0.4),
    "sphere": hf.Sphere(0.2),
    "mesh": hf.Mesh(V, F),
    "inside_out": hf.Mesh(V, F[:, ::-1]),
    "ring": hf.Mesh(*(lambda m: (m.vertices, m.faces))(trimesh.creation.annulus(0.05, 0.1, 0.04))),
}
CLOSED_FORMS = {
    "box": (0.03, np.array([0.34, 0.29, 0.13]) / 12),
    "cylinder": (np.pi * 0.004, [0.01 / 4 + 0.16 / 12, 0.01 / 4 + 0.16 / 12, 0.01 / 2]),
    "sphere": (4 / 3 * np.pi * 0.008, [0.4 * 0.04] * 3),
    "mesh": (0.03, np.array([0.34, 0.29, 0.13]) / 12),
    "inside_out": (0.03, np.array([0.34, 0.29, 0.13]) / 12),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_volume_and_inertia_are_the_closed_forms(name: str) -> None:
    volume, moments = CLOSED_FORMS[name]
    found = SHAPES[name].mass_properties
    assert found.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(found.com, 0, atol=1e-15)
    np.testing.assert_allclose(found.inertia, np.diag(moments) * volume, rtol=1e-12, atol=1e-15 * volume)


@pytest.mark.parametrize("name", SHAPES)
def test_surfaces_are_closed_and_face_outward(name: str) -> None:
    shape = SHAPES[name]
    surface = shape.surface
    solid = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert 0 < solid.volume <= shape.mass_properties.volume * (1 + 1e-12)
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("name", ["cylinder", "sphere"])
def test_the_sagitta_is_how_far_the_triangles_lie_inside(name: str) -> None:
    shape = SHAPES[name]
    surface = shape.surface
    middles = surface.vertices[surface.faces].mean(1)
    if name == "cylinder":
        middles = surface.vertices[surface.faces[:128]].reshape(-1, 3, 3)[:, :2].mean(1)[:, :2]
    inside = shape.radius - np.linalg.norm(middles, axis=1).min()
    assert 0 < inside <= surface.sagitta * (1 + 1e-9) < 0.02 * shape.radius


@pytest.mark.parametrize("name", SHAPES)
def test_density_gives_mass(name: str) -> None:
    body = hf.Body("b", SHAPES[name], density=700)
    assert body.mass == pytest.approx(700 * SHAPES[name].mass_properties.volume)


def test_inertia_is_scaled_by_mass_and_moved_by_the_parallel_axis_theorem() -> None:
    size, mass, com = np.array([0.2, 0.3, 0.5]), 3.0, np.array([0.01, -0.02, 0.2])
    about_centre = mass / 12 * np.diag((size**2).sum() - size**2)
    at_centre = hf.Body("b", hf.Box(size), mass=mass)
    moved = hf.Body("b", hf.Box(size), mass=mass, com=com)
    np.testing.assert_allclose(at_centre.inertia_com, about_centre, atol=1e-15)
    steiner = mass * ((com @ com) * np.eye(3) - np.outer(com, com))
    np.testing.assert_allclose(moved.inertia_com, about_centre + steiner, rtol=1e-12)
    np.testing.assert_allclose(moved.com_world, com)


def test_given_com_and_inertia_win() -> None:
    inertia = np.diag([1.0, 2.0, 2.5])
    body = hf.Body("b", hf.Box((1, 1, 1)), mass=1, com=(0.1, 0, 0), inertia=inertia)
    np.testing.assert_array_equal(body.com, [0.1, 0, 0])
    np.testing.assert_array_equal(body.inertia_com, inertia)


def test_com_of_a_mesh_is_that_of_its_volume() -> None:
    body = hf.Body("b", hf.Mesh(V + np.array([1, 2, 3]), F), mass=1)
    assert body.com is None
    np.testing.assert_allclose(body.com_body, [1, 2, 3], rtol=1e-12)


def test_a_body_given_by_density_can_be_replaced() -> None:
    body = hf.Body("b", hf.Box((1, 1, 2)), density=500)
    moved = dataclasses.replace(body, pose=pose_from(np.ones(3), np.array([1.0, 0, 0, 0])))
    assert (moved.mass, moved.density) == (1000, 500)
    assert moved == body.moved(moved.pose)
    assert dataclasses.replace(body, mass=None, density=100).mass == 200
    assert dataclasses.replace(body, mass=3, density=None).density is None
    with pytest.raises(
        hf.errors.SceneError, match="mass = 1000 and density = 100; give one of them, the other as None"
    ):
        dataclasses.replace(body, density=100)


def test_a_moved_body_keeps_all_but_its_pose() -> None:
    body = hf.Body("b", hf.Box((1, 1, 2)), mass=3, com=(0, 0, 0.1), inertia=np.eye(3), material="oak")
    pose = pose_from(np.ones(3), np.array([0.0, 1.0, 0, 0]))
    moved = body.moved(pose)
    assert moved.pose.tobytes() == pose.tobytes()
    assert moved.moved(body.pose) == body
    fixed = hf.Body("floor", hf.Box((1, 1, 2)), fixed=True)
    assert fixed.moved(pose).fixed
    with pytest.raises(hf.errors.GeometryError, match="body 'b': pose: is a reflection"):
        body.moved(np.diag([-1.0, 1, 1, 1]))


def test_u4_a_trimesh_given_to_mesh_is_told_what_to_write() -> None:
    with pytest.raises(
        hf.errors.GeometryError, match=r"got a Trimesh; give it to Body .* Mesh\(mesh.vertices, mesh.faces\)"
    ):
        hf.Mesh(BOX)
    with pytest.raises(hf.errors.GeometryError, match=r"faces: has shape \(0,\); needs shape \(n, 3\)"):
        hf.Mesh(V)


def test_the_file_of_a_mesh_is_a_path_whoever_gave_it(tmp_path: Path) -> None:
    """An answer with the text of a path in it was written, and could not be read."""
    mesh = hf.Mesh(V, F, file="box.obj", scale=[1, 2, 3])  # type: ignore[arg-type]
    assert mesh.file == Path("box.obj")
    assert mesh.scale == (1.0, 2.0, 3.0)
    scene = hf.Scene([hf.Body("table", hf.HalfSpace(), fixed=True), hf.Body("box", mesh, mass=1)], 0.5)
    m = hf.transport_limits(scene, (1, 0, 0), engine="limit")
    m.save(tmp_path / "limits.json")
    assert hf.load_answer(tmp_path / "limits.json") == m


def test_a_trimesh_is_taken_as_a_mesh() -> None:
    body = hf.Body("b", BOX, density=1000)
    assert isinstance(body.shape, hf.Mesh)
    assert body.mass == pytest.approx(30)


def test_an_inside_out_mesh_is_turned() -> None:
    surface = SHAPES["inside_out"].surface
    assert (surface.normals * surface.vertices[surface.faces].mean(1)).sum(1).min() > 0


def test_a_cavity_is_kept() -> None:
    inner = trimesh.creation.box((0.1, 0.1, 0.1))
    hollow = hf.Mesh(np.vstack([V, inner.vertices]), np.vstack([F, inner.faces[:, ::-1] + len(V)]))
    assert hollow.mass_properties.volume == pytest.approx(0.03 - 0.001)


@pytest.mark.parametrize("as_shape", [lambda v, f: hf.Mesh(v, f), trimesh.Trimesh], ids=["Mesh", "Trimesh"])
@pytest.mark.parametrize("options", [{"mass": 1}, {"density": 1000}])
def test_a_mesh_that_does_not_close_needs_mass_and_com(as_shape: Any, options: dict[str, float]) -> None:
    with pytest.raises(hf.errors.GeometryError, match=r"watertight.*mass=, com=") as error:
        hf.Body("leaky", as_shape(V, F[1:]), **options)
    assert "leaky" in str(error.value)


def test_a_mesh_that_does_not_close_is_taken_with_mass_and_com() -> None:
    body = hf.Body("leaky", hf.Mesh(V, F[1:]), mass=1, com=(0, 0, 0))
    assert body.mass == 1
    assert not body.shape.is_closed


@pytest.mark.parametrize("count", [1, 5, 6, 7, 11])
def test_flipped_faces_are_turned_back_and_reported(count: int) -> None:
    """Half-flipped faces would silently halve contact areas."""
    faces = F.copy()
    faces[:count] = faces[:count, ::-1]
    mesh = hf.Mesh(V, faces)
    assert mesh.is_closed
    assert mesh.report.flipped == count
    assert mesh.report.oriented
    assert mesh.mass_properties.volume == pytest.approx(0.03)
    assert (mesh.surface.normals * mesh.surface.vertices[mesh.surface.faces].mean(1)).sum(1).min() > 0


def test_a_surface_with_one_side_is_flagged() -> None:
    """A Moebius strip cannot be wound alike."""
    turns = 24
    t = 2 * np.pi * np.arange(turns) / turns
    rims = [
        np.column_stack([(1 + w * np.cos(t / 2)) * np.cos(t), (1 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)])
        for w in (-0.3, 0.3)
    ]
    k = np.arange(turns - 1)
    faces = np.vstack([np.column_stack([k, k + 1, k + turns]), np.column_stack([k + 1, k + 1 + turns, k + turns])])
    last = turns - 1
    faces = np.vstack([faces, [[last, turns, last + turns], [turns, 0, last + turns]]])
    mesh = hf.Mesh(np.vstack(rims), faces, label="body 'strip'")
    with pytest.warns(hf.errors.HoldfastWarning, match=r"'strip'.*inside cannot be told"):
        assert not mesh.report.oriented
    assert mesh.report.open_edges == 2 * turns


@pytest.mark.parametrize("inward", [False, True])
def test_an_open_mesh_is_turned_outward_by_the_volume_it_nearly_bounds(inward: bool) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.1)
    faces = np.array(ball.faces)[5:]
    mesh = hf.Mesh(ball.vertices, faces[:, ::-1] if inward else faces)
    assert mesh.report.open_edges > 0
    assert mesh.report.oriented
    assert mesh.report.flipped == (len(faces) if inward else 0)
    assert not mesh.is_closed
    assert (mesh.surface.normals * mesh.surface.vertices[mesh.surface.faces].mean(1)).sum(1).min() > 0


def test_the_report_counts_what_was_mended() -> None:
    vertices = np.vstack([V, V])  # every face has corners of its own copy
    faces = np.vstack([F[:6], F[6:] + len(V), F[:1], [[0, 0, 1]]])
    report = hf.Mesh(vertices, faces).report
    assert (report.welded, report.duplicate, report.degenerate) == (len(V), 1, 1) or report.welded > 0
    assert report.duplicate == 1
    assert report.degenerate == 1
    assert report.closed
    assert report.pieces == 1
    assert "1 duplicate faces left out" in str(report)


def folded_box(height: float) -> hf.Mesh:
    """A box with two triangles back to back on one of its edges, wound opposite ways, that stick out by ``height``."""
    one, other = F[0, :2]
    middle = (V[one] + V[other]) / 2
    tip = middle + height * middle / np.linalg.norm(middle)
    faces = np.vstack([F, [[one, other, len(V)], [other, one, len(V)]]])
    return hf.Mesh(np.vstack([V, tip]), faces)


def test_a_box_is_closed_though_a_needle_is_folded_onto_one_of_its_edges() -> None:
    """One of both triangles alone would leave two open edges, and the box no inside."""
    mesh = folded_box(1e-6)
    assert (mesh.report.duplicate, mesh.report.open_edges, mesh.report.crowded_edges) == (2, 0, 0)
    assert mesh.is_closed
    assert mesh.mass_properties.volume == pytest.approx(0.03, rel=1e-12)
    assert len(mesh.surface.faces) == len(F)


def test_a_sheet_on_the_edge_of_a_box_that_is_drawn_from_both_sides_is_kept() -> None:
    mesh = folded_box(0.1)
    assert (mesh.report.duplicate, mesh.report.open_edges, mesh.report.crowded_edges) == (1, 2, 1)
    assert len(mesh.surface.faces) == len(F) + 1


def test_a_box_all_of_whose_faces_are_drawn_from_both_sides_is_a_box() -> None:
    mesh = hf.Mesh(V, np.vstack([F, F[:, ::-1]]))
    assert mesh.report.duplicate == len(F)
    assert mesh.mass_properties.volume == pytest.approx(0.03, rel=1e-12)


def rough(noise: float, seed: int, levels: int = 5) -> trimesh.Trimesh:
    """A box of 0.2 x 0.15 x 0.1 m in small triangles whose vertices are off by a normal deviate [m]."""
    mesh = trimesh.creation.box((0.2, 0.15, 0.1))
    for _ in range(levels):
        mesh = mesh.subdivide()
    mesh.merge_vertices()
    rng = np.random.default_rng(seed)
    mesh.vertices = mesh.vertices + rng.normal(scale=noise, size=mesh.vertices.shape)
    return mesh


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("noise", [2e-4, 5e-4])
def test_the_faces_of_a_noisy_scan_are_fitted_and_their_residual_told(noise: float, seed: int) -> None:
    scan = rough(noise, seed)
    mesh = hf.Mesh(scan.vertices, scan.faces, noise=noise)
    planes = mesh.report.planes
    assert len(planes) == 6
    truth = np.vstack([np.eye(3), -np.eye(3)])
    offsets = {0: 0.1, 1: 0.075, 2: 0.05}
    for axis, direction in enumerate(truth):
        (plane,) = (p for p in planes if np.array(p.normal) @ direction > 0.9)
        assert np.array(plane.normal) @ direction > np.cos(np.radians(0.2))
        assert plane.offset == pytest.approx(offsets[axis % 3], abs=noise / 3)
        assert plane.residual == pytest.approx(noise, rel=0.2)
    face_area = 2 * (0.2 * 0.15 + 0.15 * 0.1 + 0.1 * 0.2)
    assert sum(p.area for p in planes) > 0.95 * face_area
    assert "6 planes fitted" in str(mesh.report)


def test_a_round_scan_stays_round() -> None:
    """Nothing flat is invented on a ball."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.1)
    ball.vertices = ball.vertices + np.random.default_rng(0).normal(scale=2e-4, size=ball.vertices.shape)
    mesh = hf.Mesh(ball.vertices, ball.faces, noise=2e-4)
    assert sum(p.area for p in mesh.report.planes) < 0.25 * 4 * np.pi * 0.01
    assert np.linalg.norm(mesh.surface.vertices, axis=1).min() > 0.1 - 2e-3


@pytest.mark.parametrize("noise", [-1e-4, np.nan, "much"])
def test_noise_that_makes_no_sense_is_refused(noise: Any) -> None:
    with pytest.raises(hf.errors.GeometryError, match=r"Mesh: noise"):
        hf.Mesh(V, F, noise=noise)


FLAT = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2], [0, 2, 3], [0, 3, 1]])


@pytest.mark.parametrize("options", [{"mass": 1}, {"density": 1000}])
def test_a_closed_mesh_without_volume_is_refused(options: dict[str, float]) -> None:
    with np.errstate(all="ignore"), pytest.raises(hf.errors.GeometryError, match=r"volume"):
        hf.Body("flat", hf.Mesh(*FLAT), **options)


def test_a_piece_that_is_inside_out_beside_another_is_not_taken_as_negative_mass() -> None:
    """Two separate boxes, the second inside out: either turned, or an error that says so; never volume 0."""
    mesh = hf.Mesh(np.vstack([V, V + 3]), np.vstack([F, F[:, ::-1] + len(V)]))
    with np.errstate(all="ignore"):
        try:
            body = hf.Body("pair", mesh, density=1000)
        except hf.errors.GeometryError:
            return
    assert body.mass == pytest.approx(60)


@pytest.mark.parametrize(
    ("build", "match"),
    [
        (lambda: hf.Box((0, 1, 1)), r"Box: size: is \[0.*needs numbers > 0"),
        (lambda: hf.Box((1, 1)), r"Box: size: has shape \(2,\); needs shape \(3"),
        (lambda: hf.Box("abc"), r"Box: size: got 'abc'; needs numbers"),
        (lambda: hf.Cylinder(-1, 1), r"Cylinder: radius: is -1; needs .* > 0"),
        (lambda: hf.Cylinder(1, np.inf), r"Cylinder: height: is inf; needs"),
        (lambda: hf.Cylinder(1, 1, 2), r"Cylinder: segments: is 2; needs a whole number of at least 3"),
        (lambda: hf.Cylinder(1, 1, 8.5), r"Cylinder: segments.*8\.5; needs"),
        (lambda: hf.Cylinder(1, 1, "a"), r"Cylinder: segments.*'a'; needs"),
        (lambda: hf.Sphere(0), r"Sphere: radius: is 0; needs .* > 0"),
        (lambda: hf.Sphere(1, -1), r"Sphere: subdivisions.*-1; needs"),
        (lambda: hf.Mesh([[0, 0, np.nan]] * 3, [[0, 1, 2]]), r"vertices: contains nan at index \(0, 2\); needs"),
        (lambda: hf.Mesh(V[:, :2], F), r"vertices: has shape \(8, 2\); needs shape \(n, 3\)"),
        (lambda: hf.Mesh(V, F[:0]), r"no triangles; needs"),
        (lambda: hf.Mesh(V, [[0, 1, 8]]), r"names vertex 8 of 8; needs"),
        (lambda: hf.Mesh(V, [[0, 1, -2]]), r"names vertex -2 of 8; needs"),
        (lambda: hf.Mesh(V, [[0, 1, 2.5]]), r"2\.5.*; needs"),
        (lambda: hf.Mesh(V, [[0, 0, 0]]).surface, r"all 1 triangles are degenerate; needs"),
        (lambda: hf.Mesh.from_file("a.obj", scale=0), r"a\.obj: scale: is .*0.*; needs numbers > 0"),
        (lambda: hf.Mesh.from_file("a.obj", scale=(1, 2)), r"a\.obj: scale.*; needs"),
        (lambda: hf.Mesh.from_file("a.obj", scale="big"), r"a\.obj: scale.*'big'; needs"),
        (lambda: hf.Body("b", None, mass=1), r"body 'b': shape is a NoneType; needs Box"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1))), r"body 'b': has no mass; give mass= or density="),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=-2), r"body 'b': mass: is -2; needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=10**400), r"body 'b': mass.*; needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), density=0), r"body 'b': density: is 0; needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=1, density=2), r"body 'b': mass = 1 and density = 2; give one"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=1, com=(0, 0)), r"body 'b': com: has shape \(2,\); needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=1, inertia=-np.eye(3)), r"body 'b': inertia: .*; needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=1, inertia=np.triu(np.ones((3, 3)))), r"symmetric; needs"),
        (lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=1, fixed="false"), r"body 'b': fixed.*'false'.*; "),
        (lambda: hf.Body(" ", hf.Box((1, 1, 1)), mass=1), r"body: name: is ' '; needs"),
    ],
)
def test_errors_say_what_where_and_what_to_do(build: Any, match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        build()
