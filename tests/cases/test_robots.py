"""Scenes as robot simulators ship them load, with what their files and their simulators say of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shared
import trimesh

import holdfast as hf

ROBOTS = shared.FOLDER / "robots"
EULER = (320.41278, 30.864384, -17.834925)  # degrees about the fixed x, y and z axes: the cylinder of cube_cylinder
SIZES = {"domino": (0.00635, 0.0254, 0.0508), "jenga": (0.15, 0.05, 0.03), "table": (1.5, 1.0, 0.05)}


def urdf(name: str) -> Path:
    return ROBOTS / "urdf" / name / f"{name}.urdf"


@shared.needed
@pytest.mark.parametrize(
    ("name", "body", "mass", "mu"),
    [("domino", "cube", 0.025, 0.5), ("jenga", "jenga.urdf", 0.05, 0.5), ("table", "table.urdf", None, 1.0)],
)
def test_things_of_bullet_load(name: str, body: str, mass: float | None, mu: float) -> None:
    scene = hf.load_scene(urdf(name), floor=True)
    found = scene.body(body)
    assert found.mass == mass
    assert found.fixed == (mass is None)  # as in Bullet
    assert scene.mu(body, "floor") == mu
    low, high = found.box
    np.testing.assert_allclose(high - low, SIZES[name], atol=1e-12)
    assert (low + high)[2] / 2 == pytest.approx(0.6 if name == "table" else 0.0, abs=1e-12)


@shared.needed
def test_a_jenga_block_is_refused_without_a_floor() -> None:
    with pytest.raises(hf.errors.SceneError, match=r"jenga.urdf:2: .*nothing carries; give floor=True"):
        hf.load_scene(urdf("jenga"))


@shared.needed
@pytest.mark.parametrize("name", SIZES)
def test_bullet_says_the_same_of_its_things(name: str) -> None:
    bullet = pytest.importorskip("pybullet", reason="needs pybullet, of the extra bench")
    client = bullet.connect(bullet.DIRECT)
    try:
        thing = bullet.loadURDF(str(urdf(name)), flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        info = bullet.getDynamicsInfo(thing, -1)
        (shape,) = bullet.getCollisionShapeData(thing, -1)
    finally:
        bullet.disconnect(client)
    scene = hf.load_scene(urdf(name), floor=True)
    body = scene.bodies[0]
    assert (body.mass or 0.0) == info[0]
    assert scene.mu(body.name, "floor") == info[1]
    if not body.fixed:
        np.testing.assert_allclose(np.diag(body.inertia_com), info[2], rtol=1e-9)
        np.testing.assert_allclose(body.com_body, info[3], atol=1e-9)
    np.testing.assert_allclose(body.box[1] - body.box[0], shape[3], rtol=1e-9)
    np.testing.assert_allclose((body.box[1] + body.box[0]) / 2, shape[5], atol=1e-9)


@shared.needed
def test_shapes_of_gazebo_load() -> None:
    scene = hf.load_scene(ROBOTS / "sdf" / "shapes.sdf")
    assert scene.gravity.tolist() == [0, 0, -9.8]  # of SDF
    at = {"box": 0.0, "cylinder": -1.5, "sphere": 1.5, "capsule": -3.0, "ellipsoid": 3.0, "cone": 4.5}
    assert [body.name for body in scene.bodies] == ["ground_plane", *at]
    assert isinstance(scene.body("ground_plane").shape, hf.HalfSpace)
    for name, y in at.items():
        body = scene.body(name)
        np.testing.assert_allclose(body.pose[:3, 3], [0, y, 0.5], atol=1e-15)
        np.testing.assert_allclose(body.com_world, [0, y, 0.25 if name == "cone" else 0.5], atol=1e-15)
        assert scene.mu(name, "ground_plane") == 1.0
    inertias = {"box": (0.16666,) * 3, "cylinder": (0.1458, 0.1458, 0.125), "ellipsoid": (0.068, 0.058, 0.026)}
    for name, diagonal in inertias.items():
        assert scene.body(name).mass == 1.0
        assert np.diag(scene.body(name).inertia_com).tolist() == list(diagonal)
    assert scene.body("capsule").shape == hf.Capsule(0.2, 0.6)
    assert scene.body("ellipsoid").shape == hf.Ellipsoid((0.2, 0.3, 0.5))
    mass = np.pi * 0.5**2 / 3  # of a cone of radius 0.5, height 1 and density 1
    cone = scene.body("cone")
    assert cone.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(np.diag(cone.inertia_com) / mass, [0.075, 0.075, 0.075], rtol=1e-12)
    assert any("friction 1, which SDF says" in note for note in scene.notes)


@shared.needed
def test_nested_models_of_gazebo_load() -> None:
    scene = hf.load_scene(ROBOTS / "sdf" / "nested_model.sdf")
    assert {body.name: body.mass for body in scene.movable} == {"model_00": 1.0, "model_00::model_01": 1.0}
    box = scene.body("model_00::model_01")
    c, s = np.cos(0.785398), np.sin(0.785398)
    expected = [[c, -s, 0, 1.25], [s, c, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]]
    np.testing.assert_allclose(box.pose, expected, atol=1e-15)
    assert box.inertia_com.tolist() == np.eye(3).tolist()
    links = "links model_00::link_00, model_00::model_01::link_01"
    assert f"{links}: mass 1 kg, which SDF says where a file says none" in scene.notes


@shared.needed
def test_a_box_on_a_plane_of_usd_loads() -> None:
    pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")
    scene = hf.load_scene(ROBOTS / "usd" / "box_on_plane.usda")
    assert {body.name: body.fixed for body in scene.bodies} == {"box_body": False, "plane": True}
    box = scene.body("box_body")
    assert box.mass == 1.0
    np.testing.assert_allclose(box.com_world, [0, 0, 0.1], atol=1e-15)
    np.testing.assert_allclose(np.diag(box.inertia_com), [0.006666666828095913] * 3, rtol=1e-9)
    np.testing.assert_allclose(box.box, ([-0.1, -0.1, 0], [0.1, 0.1, 0.2]), atol=1e-8)  # USD keeps single precision
    np.testing.assert_allclose(scene.body("plane").box, ([-1, -1, -0.1], [1, 1, 0]), atol=1e-8)
    np.testing.assert_allclose(scene.gravity, [0, 0, -np.float32(9.8067)], rtol=1e-9)
    assert scene.mu("box_body", "plane") == 0.5  # the least of 0.78 and 0.5
    assert scene.excluded == ()  # its collision group filters one that is not there


@shared.needed
def test_a_cylinder_over_a_cube_of_usd_loads() -> None:
    pytest.importorskip("pxr", reason="needs usd-core, of the extra usd")
    scene = hf.load_scene(ROBOTS / "usd" / "cube_cylinder.usda")
    assert {body.name: body.fixed for body in scene.bodies} == {"Cylinder_dynamic": False, "mesh_0": True}
    prism = 800 * 6 * 0.05**2 * 0.5 * 0.2  # the density of its plastic, and twelve sides
    body = scene.body("Cylinder_dynamic")
    assert body.mass == pytest.approx(prism, rel=1e-7)
    np.testing.assert_allclose(body.com_world, [0, 0.04081685096025467, 0.3882038203736343], atol=1e-9)
    turns = [trimesh.transformations.rotation_matrix(np.radians(a), n) for a, n in zip(EULER, np.eye(3), strict=True)]
    axis = (turns[2] @ turns[1] @ turns[0])[:3, 2]  # its y axis, which unitsResolve turns to z
    inertia = body.pose[:3, :3] @ body.inertia_com @ body.pose[:3, :3].T
    moments, axes = np.linalg.eigh(inertia)
    assert abs(axes[:, 0] @ axis) == pytest.approx(1, abs=1e-6)
    assert moments[1] == pytest.approx(moments[2], rel=1e-6)
    np.testing.assert_allclose(scene.body("mesh_0").box, ([-0.5, -0.5, -2], [0.5, 0.5, -1]), atol=1e-7)
    assert scene.mu("Cylinder_dynamic", "mesh_0") == pytest.approx(0.2, rel=1e-7)
