"""Mesh files as scenes, and how meshes are taken in others: hulls, up axes, outlines and cones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from tests.cases.shared import FOLDER, needed

QUADS = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
RIM = FOLDER / "intake" / "rim.obj"


def cube(low: float, after: int = 0) -> str:
    """Rows of a cube of 0.1 m above ``low``, of which the first corner is number ``after`` + 1."""
    corners = "".join(f"v {x} {y} {low + z}\n" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1))
    return corners + "".join(f"f {' '.join(str(after + k) for k in quad)}\n" for quad in QUADS)


@pytest.fixture
def two(tmp_path: Path) -> Path:
    (tmp_path / "two.obj").write_text(f"mtllib no.mtl\no low\n{cube(0)}o high\n{cube(0.1, 8)}")
    return tmp_path / "two.obj"


GIVEN: dict[str, Any] = {"friction": 0.5, "density": 500, "floor": True}


def test_one_body_or_one_for_each_object(two: Path) -> None:
    whole = hf.load_scene(two, **GIVEN)
    assert [(body.name, round(float(body.mass or 0), 9)) for body in whole.movable] == [("two", 1.0)]
    parts = hf.load_scene(two, bodies="objects", **GIVEN)
    assert [(body.name, round(float(body.mass or 0), 9)) for body in parts.movable] == [("low", 0.5), ("high", 0.5)]
    assert hf.stability(parts).stable
    assert "lengths are taken as metres: mesh files have no units" in parts.notes


def test_copies_and_a_y_that_is_up(two: Path) -> None:
    scene = hf.load_scene(two, poses={"a": hf.pose(), "b": hf.pose(x=1)}, up_axis="y", **GIVEN)
    np.testing.assert_allclose(scene.body("b").box, ((1, -0.2, 0), (1.1, 0, 0.1)), atol=1e-12)


@pytest.mark.parametrize("kind", ["stl", "ply", "off"])
def test_other_kinds(kind: str, tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / f"cube.{kind}")
    scene = hf.load_scene(tmp_path / f"cube.{kind}", pose=hf.pose(z=0.05), **GIVEN)
    assert scene.body("cube").mass == pytest.approx(0.5)
    with pytest.raises(hf.errors.SceneError, match=rf"\.{kind} files have no objects; read it as one body"):
        hf.load_scene(tmp_path / f"cube.{kind}", bodies="objects", **GIVEN)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({}, r"two.obj: is a mesh, which says nothing of friction, of mass and of what it lies on; give friction="),
        ({"friction": 0.5}, r"two.obj: body 'two': has no mass; give density= or mass="),
        ({"friction": 0.5, "mass": 1}, r"two.obj: is a thing that nothing carries; give floor=True"),
        ({**GIVEN, "bodies": "many"}, r"bodies: is 'many'; needs one of one, objects"),
        ({**GIVEN, "collision": "box"}, r"collision: is 'box'; needs one of mesh, hull"),
        ({**GIVEN, "collision": {"tow": "hull"}}, r"collision: no body is named 'tow'; did you mean 'two'"),
        ({**GIVEN, "up_axis": "x"}, r"up_axis: is 'x'; needs one of y, z"),
    ],
)
def test_what_is_missing_is_asked_for(options: dict[str, Any], match: str, two: Path) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.load_scene(two, **options)


@needed
def test_an_open_mesh_has_a_hull() -> None:
    with pytest.raises(hf.errors.GeometryError, match=r"not watertight"):
        hf.load_scene(RIM, **GIVEN)
    scene = hf.load_scene(RIM, collision="hull", **GIVEN)
    assert "meshes are their convex hulls, as collision= says" in scene.notes
    shape = scene.body("rim").shape
    assert shape.mass_properties.volume == pytest.approx(trimesh.load(RIM).convex_hull.volume, rel=1e-9)


def test_hulls_of_single_bodies_of_urdf_and_sdf(two: Path) -> None:
    hollow = trimesh.creation.annulus(0.1, 0.2, 0.1)
    hollow.export(two.parent / "ring.obj")
    mesh = '<geometry><mesh filename="ring.obj"/></geometry>'
    links = "".join(f'<link name="{name}"><collision>{mesh}</collision></link>' for name in "ab")
    joint = '<joint name="j" type="floating"><parent link="a"/><child link="b"/></joint>'
    (two.parent / "r.urdf").write_text(f'<robot name="r">{links}{joint}</robot>')
    scene = hf.load_scene(two.parent / "r.urdf", collision={"b": "hull"}, **GIVEN)
    assert scene.body("r/a").mass == pytest.approx(500 * hollow.volume, rel=1e-6)
    assert scene.body("r/b").mass == pytest.approx(500 * hollow.convex_hull.volume, rel=1e-6)
    collision = '<collision name="c"><geometry><mesh><uri>ring.obj</uri></mesh></geometry></collision>'
    model = f'<model name="m"><link name="l">{collision}</link></model>'
    (two.parent / "m.sdf").write_text(f'<sdf version="1.9">{model}</sdf>')
    scene = hf.load_scene(two.parent / "m.sdf", collision={"m": "hull"}, **GIVEN)
    assert scene.body("m").mass == pytest.approx(500 * hollow.convex_hull.volume, rel=1e-6)


def test_a_dae_file_with_y_up(tmp_path: Path) -> None:
    from tests.fuzz.foreign import DAE

    (tmp_path / "part.dae").write_text(DAE.replace("Z_UP", "Y_UP"))
    with pytest.raises(hf.errors.GeometryError, match=r'Y_UP.*say up_axis="y" to turn it, or "z" to take it as it is'):
        hf.Mesh.from_file(tmp_path / "part.dae")
    straight = hf.Mesh.from_file(tmp_path / "part.dae", up_axis="z")
    turned = hf.Mesh.from_file(tmp_path / "part.dae", up_axis="y")
    np.testing.assert_allclose(turned.vertices, straight.vertices[:, [0, 2, 1]] * (1, -1, 1), atol=1e-15)
    assert turned.file is None


L_SHAPE = "".join(f"<point>{p}</point>" for p in ("0 0", ".2 0", ".2 .1", ".1 .1", ".1 .2", "0 .2"))
LINE = "".join(f"<point>{p}</point>" for p in ("0 0", "1 0", "2 0"))
HOLE = "".join(f"<point>{p}</point>" for p in (".02 .02", ".04 .02", ".04 .04"))


def sdf_of(geometry: str) -> str:
    inertial = "<inertial><mass>2</mass></inertial>"
    link = f'<link name="l">{inertial}<collision name="c"><geometry>{geometry}</geometry></collision></link>'
    return f'<sdf version="1.9"><model name="m">{link}</model></sdf>'


def test_outlines_are_solids_and_holes(tmp_path: Path) -> None:
    lines = f"<polyline>{L_SHAPE}<height>.1</height></polyline><polyline>{HOLE}<height>.1</height></polyline>"
    (tmp_path / "m.sdf").write_text(sdf_of(lines))
    body = hf.load_scene(tmp_path / "m.sdf", floor=True).body("m")
    assert body.shape.mass_properties.volume == pytest.approx(0.1 * (0.03 - 0.0002), rel=1e-12)
    np.testing.assert_allclose(body.box, ((0, 0, 0), (0.2, 0.2, 0.1)), atol=1e-15)


@pytest.mark.parametrize(
    ("geometry", "match"),
    [
        ("<polyline><point>0 0</point><height>1</height></polyline>", r"has 1 points; needs three and more"),
        (f"<polyline>{L_SHAPE}</polyline>", r"<polyline>: has no <height>"),
        (f"<polyline>{L_SHAPE}<height>.1</height></polyline><sphere/>", r"has 2 shapes; needs one"),
        (f"<polyline>{LINE}<height>1</height></polyline>", "encloses no area"),
    ],
)  # fmt: skip
def test_outlines_that_are_none(geometry: str, match: str, tmp_path: Path) -> None:
    (tmp_path / "m.sdf").write_text(sdf_of(geometry))
    with pytest.raises(hf.HoldfastError, match=match):
        hf.load_scene(tmp_path / "m.sdf", floor=True)


def test_models_in_folders_and_at_addresses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"):
        monkeypatch.delenv(variable, raising=False)
    (tmp_path / "models" / "Tall Plane").mkdir(parents=True)
    collision = '<collision name="c"><geometry><plane/></geometry></collision>'
    ground = f'<model name="ground"><static>true</static><link name="l">{collision}</link></model>'
    (tmp_path / "models" / "Tall Plane" / "model.sdf").write_text(f'<sdf version="1.9">{ground}</sdf>')
    (tmp_path / "worlds").mkdir()
    world = tmp_path / "worlds" / "w.sdf"
    for uri in (
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Tall%20Plane",
        "https://fuel.ignitionrobotics.org/1.0/openrobotics/models/Tall Plane/2",
        "https://fuel.gazebosim.org/1.0/o/models/Tall%20Plane/tip/files/model.sdf",
        "model://Tall Plane",
    ):
        world.write_text(f'<sdf version="1.9"><world name="w"><include><uri>{uri}</uri></include></world></sdf>')
        assert [body.name for body in hf.load_scene(world, model_path=[tmp_path / "models"]).bodies] == ["ground"]
        with pytest.raises(hf.errors.SceneError, match=r"'Tall Plane', whose folder is unknown; .*model_path="):
            hf.load_scene(world)
        monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path / "models"))
        assert any("looked for in GAZEBO_MODEL_PATH" in note for note in hf.load_scene(world).notes)
        monkeypatch.delenv("GAZEBO_MODEL_PATH")
    with pytest.raises(hf.errors.SceneError, match=r"model_path: '.*none' is no folder"):
        hf.load_scene(world, model_path=[tmp_path / "none"])
    for uri in (
        "model://..",
        "model://../worlds",
        "https://fuel.gazebosim.org/1.0/o/models/..",
        "https://x.org/models/a",
    ):
        world.write_text(f'<sdf version="1.9"><world name="w"><include><uri>{uri}</uri></include></world></sdf>')
        with pytest.raises(hf.errors.SceneError):
            hf.load_scene(world, model_path=[tmp_path / "models"])


def test_cones_of_usd(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from tests.fuzz.foreign import USD

    cone = USD.replace('def Cube "a"', 'def Cone "a"').replace(
        "double size = 0.2", "double radius = 0.1\n double height = 0.2"
    )
    (tmp_path / "c.usda").write_text(cone)
    body = hf.load_scene(tmp_path / "c.usda", friction=0.5, floor=True).body("a")
    np.testing.assert_allclose(body.box, ((-0.1, -0.1, 0), (0.1, 0.1, 0.2)), atol=1e-9)
