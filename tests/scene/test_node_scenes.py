"""Scenes of named meshes: ``hf.from_trimesh`` and glTF files, with what a file beside them says."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.geometry.gltf import container
from holdfast.scene.meshes.by_trimesh import read_nodes
from holdfast.scene.meshes.read import triangles_of

TABLE, CUBE = (2.0, 1.0, 0.1), (0.2, 0.2, 0.2)
Y_UP = trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0))  # z up to y up


def moved(*xyz: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix(xyz)


def example(turn: np.ndarray | None = None) -> trimesh.Scene:
    """Two cubes of one mesh, the upper one twice as large, on a table."""
    scene = trimesh.Scene()
    first = np.eye(4) if turn is None else turn
    scene.add_geometry(trimesh.creation.box(TABLE), node_name="table", transform=first @ moved(0, 0, -0.05))
    scene.add_geometry(
        trimesh.creation.box(CUBE), node_name="low", geom_name="cube", transform=first @ moved(0, 0, 0.1)
    )
    double = moved(0, 0, 0.4) @ np.diag([2.0, 2.0, 2.0, 1.0])
    scene.graph.update(frame_from=scene.graph.base_frame, frame_to="high", geometry="cube", matrix=first @ double)
    return scene


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def written(content: bytes | None = None, beside: str | None = None) -> Path:
        path = tmp_path / "scene.glb"
        path.write_bytes(example(Y_UP).export(file_type="glb") if content is None else content)
        if beside is not None:
            path.with_name("scene.glb.yaml").write_text(beside)
        return path

    return written


def assert_example(scene: hf.Scene) -> None:
    assert {body.name: body.fixed for body in scene.bodies} == {"table": True, "low": False, "high": False}
    for name, size, at in (("table", TABLE, -0.05), ("low", CUBE, 0.1), ("high", (0.4, 0.4, 0.4), 0.4)):
        low, high = scene.body(name).box
        np.testing.assert_allclose(high - low, size, atol=1e-7)
        np.testing.assert_allclose((high + low) / 2, (0, 0, at), atol=1e-7)


def test_every_node_is_a_body() -> None:
    scene = hf.from_trimesh(example(), density=500, fixed=["table"], friction=0.4)
    assert_example(scene)
    assert scene.body("low").mass == pytest.approx(500 * 0.2**3, rel=1e-12)
    assert scene.body("high").mass == pytest.approx(500 * 0.4**3, rel=1e-12)
    np.testing.assert_allclose(np.diag(scene.body("high").inertia_com), 500 * 0.4**5 / 6, rtol=1e-12)
    assert scene.mu("low", "high") == 0.4
    assert scene.gravity.tolist() == [0, 0, -9.81]


def test_numbers_for_names_come_before_those_for_all() -> None:
    given = {"fixed": ["table"], "friction": 0.4}
    masses = hf.from_trimesh(example(), mass={"low": 3.0}, density=500, **given)
    assert [body.mass for body in masses.movable] == pytest.approx([3.0, 32.0])
    both = hf.from_trimesh(example(), mass=2.0, density={"high": 1000.0}, **given)
    assert [body.mass for body in both.movable] == pytest.approx([2.0, 64.0])


def test_y_up_is_turned_and_a_lone_mesh_stands_on_a_floor() -> None:
    scene = hf.from_trimesh(example(Y_UP), density=500, fixed=["table"], friction=0.4, up_axis="y")
    assert_example(scene)
    assert scene.notes == ("y is up in the file: turned about x so that z is up",)
    lone = hf.from_trimesh(trimesh.creation.box((1, 1, 1)), mass=1.0, friction=0.4, floor=True)
    assert [body.name for body in lone.bodies] == ["mesh", "floor"]


def test_shear_and_mirrors_go_to_the_vertices() -> None:
    scene = trimesh.Scene()
    matrix = moved(1, 2, 3) @ np.array([[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, -2.0, 0], [0, 0, 0, 1]])
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="a", transform=matrix)
    body = hf.from_trimesh(scene, density=10, friction=0.5, floor=True).body("a")
    expected = trimesh.transform_points(trimesh.creation.box((1, 1, 1)).vertices, matrix)
    np.testing.assert_allclose(body.placed(body.shape.vertices), expected, atol=1e-12)
    assert np.linalg.det(body.pose[:3, :3]) == pytest.approx(1)
    assert body.mass == pytest.approx(20, rel=1e-12)
    raw = trimesh.Trimesh(body.shape.vertices, body.shape.faces, process=False)
    assert raw.volume == pytest.approx(2)  # wound outward


def test_materials_name_the_pairs_of_the_friction_table() -> None:
    table = hf.Friction(pairs={("oak", "glass"): 0.3}, default=0.6)
    scene = hf.from_trimesh(
        example(), density=500, fixed=["table"], materials={"table": "oak", "low": "glass"}, friction=table
    )
    assert (scene.mu("table", "low"), scene.mu("low", "high")) == (0.3, 0.6)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"fixed": ["tabel"]}, "fixed: no node is named 'tabel'; did you mean 'table'"),
        ({"fixed": "table"}, "fixed: is 'table'; needs a list"),
        ({"mass": {"lo": 1.0}}, "mass: no node is named 'lo'"),
        ({"density": None}, "node 'low': has no mass; give mass= or density="),
        ({"density": -1.0}, "density: is -1"),
        ({"mass": {"low": float("nan")}}, "mass: is nan"),
        ({"fixed": []}, r"nothing in it is fixed; give fixed=\[name\] \(table, low, high\), or floor=True"),
        ({"materials": {"lo": "oak"}}, "materials: no node is named 'lo'"),
        ({"up_axis": "x"}, "up_axis: is 'x'; needs one of y, z"),
    ],
)
def test_options_are_checked(options: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.from_trimesh(example(), **{"density": 500, "fixed": ["table"], "friction": 0.4, **options})


@pytest.mark.parametrize(
    ("scene", "match"),
    [
        (7, "got a int; needs a trimesh.Scene"),
        (trimesh.Scene(), "holds no triangles"),
        (
            trimesh.Scene([trimesh.creation.box((1, 1, 1))]).apply_transform(np.diag([1, 1, 0, 1])),
            "is scaled to nothing",
        ),
    ],
)
def test_what_is_no_scene_is_refused(scene: object, match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.from_trimesh(scene, density=500, friction=0.4, floor=True)


def test_a_binary_file_has_y_up(write: Callable[..., Path]) -> None:
    scene = hf.load_scene(write(), density=500, fixed=["table"], friction=0.4)
    assert_example(scene)
    assert scene.body("high").mass == pytest.approx(32.0, rel=1e-6)  # glTF keeps single precision
    assert "y is up in the file: turned about x so that z is up" in scene.notes


SIDECAR = """
friction: {default: 0.6, pairs: [{between: [oak, glass], mu: 0.3}]}
density: 500
gravity: [0, 0, -1.6]
nodes:
  table: {fixed: true, material: oak}
  low: {mass: 3.0, material: glass}
"""


def test_a_file_beside_it_says_the_rest(write: Callable[..., Path]) -> None:
    path = write(beside=SIDECAR)
    scene = hf.load_scene(path)
    assert_example(scene)
    assert [scene.body(name).mass for name in ("low", "high")] == pytest.approx([3.0, 32.0])
    assert (scene.mu("table", "low"), scene.mu("low", "high")) == (0.3, 0.6)
    assert scene.gravity.tolist() == [0, 0, -1.6]
    other = hf.load_scene(path, mass={"low": 4.0}, density=1000, friction=0.1, gravity=(0, 0, -2))
    assert [other.body(name).mass for name in ("low", "high")] == pytest.approx([4.0, 64.0])
    assert (other.mu("table", "low"), other.gravity[2]) == (0.1, -2)


@pytest.mark.parametrize(
    ("beside", "match"),
    [
        ("nodes: {lo: {mass: 1}}", "scene.glb.yaml: no node is named 'lo'; did you mean 'low'"),
        ("frcition: 0.5", r"scene.glb.yaml: frcition: unknown key; did you mean 'friction'\?"),
        ("nodes: {low: {mass: .nan}}", "scene.glb.yaml: nodes.low.mass"),
        ("nodes: {low: {fixed: 1}}", "scene.glb.yaml: nodes.low.fixed: needs true or false"),
        ("nodes: [1]", "scene.glb.yaml: nodes"),
        ("a: *b", "scene.glb.yaml:1: "),
    ],
)
def test_a_file_beside_it_that_is_wrong_is_told(beside: str, match: str, write: Callable[..., Path]) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.load_scene(write(beside=beside), density=500, fixed=["table"], friction=0.4)


def test_friction_is_never_guessed(write: Callable[..., Path]) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"says nothing of friction; give friction=, or .*scene.glb.yaml"):
        hf.load_scene(write(), density=500, fixed=["table"])


def text_file(folder: Path, embedded: bool, uri: str = "parts.bin") -> Path:
    """The example as .gltf, with its numbers in the file or in another."""
    content = example(Y_UP).export(file_type="glb")
    length = struct.unpack_from("<I", content, 12)[0]
    data, binary = json.loads(content[20 : 20 + length]), content[28 + length :]
    data["buffers"][0]["uri"] = (
        "data:application/octet-stream;base64," + base64.b64encode(binary).decode() if embedded else uri
    )
    (folder / "parts.bin").write_bytes(binary)
    (folder / "scene.gltf").write_text(json.dumps(data))
    return folder / "scene.gltf"


@pytest.mark.parametrize("embedded", [True, False])
def test_a_text_file_says_the_same(embedded: bool, tmp_path: Path) -> None:
    assert_example(hf.load_scene(text_file(tmp_path, embedded), density=500, fixed=["table"], friction=0.4))


@pytest.mark.parametrize(
    ("uri", "match"),
    [
        ("../../secret.bin", "names '../../secret.bin', outside of the folder"),
        ("/etc/passwd", "names '/etc/passwd', outside of the folder"),
        ("none.bin", "none.bin: no such buffer"),
        ("https://example.org/parts.bin", "needs a path"),
        ("data:text/plain,aaaa", "which is not base64"),
        ("data:a;base64,!!!!", "cannot be read"),
    ],
)
def test_a_text_file_names_nothing_elsewhere(uri: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(hf.errors.SceneError, match=match) as caught:
        hf.load_scene(text_file(tmp_path, False, uri), density=500, fixed=["table"], friction=0.4)
    assert "scene.gltf" in str(caught.value)


def test_a_text_file_that_is_malformed_is_told(tmp_path: Path) -> None:
    path = text_file(tmp_path, False)
    whole = json.loads(path.read_text())
    for key, value in (
        ("bufferViews", [{"buffer": 7}]),
        ("buffers", [{}]),
        ("meshes", [1]),
        ("nodes", [{"children": [0]}]),
    ):
        path.write_text(json.dumps(whole | {key: value}))
        with pytest.raises(hf.errors.SceneError, match=r"scene.gltf: cannot be read: .*; check the file"):
            hf.load_scene(path, density=500, fixed=["table"], friction=0.4)


def test_a_text_file_of_version_1_is_told(tmp_path: Path) -> None:
    """Its lists are maps, so that nothing else that is said of it would help."""
    path = text_file(tmp_path, True)
    for version in ("1.0", "3.0"):
        path.write_text(
            json.dumps(json.loads(path.read_text()) | {"asset": {"version": version}, "buffers": {"b": {}}})
        )
        with pytest.raises(hf.errors.SceneError, match=f"is of version '{version}', not 2"):
            hf.load_scene(path, density=500, fixed=["table"], friction=0.4)


@pytest.mark.parametrize(
    ("kind", "more", "said"),
    [
        ("meshes", {"weights": [0.0, 0.5]}, "weights of meshes"),
        ("nodes", {"weights": [1]}, "weights of nodes"),
        ("nodes", {"skin": 0}, "skin of nodes"),
        ("meshes", {"weights": [0.0, 0.0]}, ""),
    ],
)
def test_what_changes_the_shape_of_a_mesh_is_named(kind: str, more: dict[str, Any], said: str, tmp_path: Path) -> None:
    path = text_file(tmp_path, True)
    data = json.loads(path.read_text())
    data[kind][-1] |= more
    path.write_text(json.dumps(data))
    notes = hf.load_scene(path, density=500, fixed=["table"], friction=0.4).notes
    assert [note for note in notes if "not read" in note] == (
        [f"not read, though it may matter: {said}"] if said else []
    )


def test_half_a_binary_file_is_refused(write: Callable[..., Path]) -> None:
    content = example(Y_UP).export(file_type="glb")
    for part in (content[:16], content[:100], content[:-100]):
        with pytest.raises(hf.errors.SceneError, match=r"scene.glb: cannot be read: "):
            hf.load_scene(write(part), density=500, fixed=["table"], friction=0.4)
    assert sorted(node.name for node in read_nodes(content)[0]) == ["high", "low", "table"]


def divided(primitives: int, *, binary: bool, more: dict[str, Any], extra: tuple[dict[str, Any], ...] = ()) -> bytes:
    """The example with each mesh in several primitives of materials of their own, and its nodes below another one."""
    content = example(Y_UP).export(file_type="glb")
    length = struct.unpack_from("<I", content, 12)[0]
    data, numbers = json.loads(content[20 : 20 + length]), content[28 + length :]
    views, accessors = data["bufferViews"], data["accessors"]
    for mesh in data["meshes"]:
        (whole,) = mesh["primitives"]
        indices = accessors[whole["indices"]]
        size = {5121: 1, 5123: 2, 5125: 4}[indices["componentType"]]
        ends = np.linspace(0, indices["count"] // 3, primitives + 1).astype(int)
        mesh["primitives"] = [*extra]
        for number, (begin, end) in enumerate(pairwise(ends)):
            start = indices.get("byteOffset", 0) + 3 * size * int(begin)
            accessors.append({**indices, "byteOffset": start, "count": 3 * int(end - begin)})
            accessors[-1].pop("min", None), accessors[-1].pop("max", None)
            part = {"attributes": dict(whole["attributes"]), "indices": len(accessors) - 1, "material": number}
            mesh["primitives"].append(part)
    data["materials"] = [{"name": f"m{number}"} for number in range(primitives)]
    data |= more
    if binary:
        return container(data, numbers)
    data["buffers"] = [{"byteLength": len(numbers), "uri": "data:a;base64," + base64.b64encode(numbers).decode()}]
    return json.dumps(data | {"bufferViews": views}).encode()


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("primitives", [1, 2, 3, 12])
def test_a_mesh_of_several_primitives_is_one_body(primitives: int, binary: bool, tmp_path: Path) -> None:
    """However the triangles are divided among materials, and whatever lines and points stand beside them."""
    looks = {"extensionsRequired": ["KHR_technique_webgl", "KHR_techniques_webgl", "KHR_materials_unlit"]}
    lines = {"attributes": {"POSITION": 0}, "mode": 1}, {"attributes": {"POSITION": 0}, "mode": 0}
    for extra in ((), lines):
        path = tmp_path / ("scene.glb" if binary else "scene.gltf")
        path.write_bytes(divided(primitives, binary=binary, more=looks, extra=extra))
        scene = hf.load_scene(path, density=500, fixed=["table"], friction=0.4)
        assert_example(scene)
        assert [body.mass for body in scene.movable] == pytest.approx([4.0, 32.0])
        assert hf.stability(scene, engine="limit").stable


@pytest.mark.parametrize(
    ("more", "extra", "match"),
    [
        ({"extensionsRequired": ["KHR_physics_rigid_bodies"]}, (), "requires the extension 'KHR_physics_rigid_bodies'"),
        ({"extensionsRequired": ["KHR_texture_basisu", "MSFT_physics"]}, (), "extension 'MSFT_physics', which is not"),
        ({}, ({"attributes": {"POSITION": 0}, "mode": 6},), "has a fan of triangles"),
    ],
)
def test_what_would_be_left_out_is_refused(
    more: dict[str, Any], extra: tuple[dict[str, Any], ...], match: str, tmp_path: Path
) -> None:
    for binary in (True, False):
        path = tmp_path / ("scene.glb" if binary else "scene.gltf")
        path.write_bytes(divided(2, binary=binary, more=more, extra=extra))
        with pytest.raises(hf.errors.SceneError, match=match):
            hf.load_scene(path, density=500, fixed=["table"], friction=0.4)
        if binary:
            with pytest.raises(hf.errors.GeometryError, match=match):
                triangles_of(path)


def test_positions_that_are_fractions_are_refused(tmp_path: Path) -> None:
    content = divided(1, binary=False, more={})
    data = json.loads(content)
    data["accessors"][data["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["normalized"] = True
    (tmp_path / "scene.gltf").write_text(json.dumps(data))
    with pytest.raises(hf.errors.SceneError, match="positions as fractions of whole numbers"):
        hf.load_scene(tmp_path / "scene.gltf", density=500, fixed=["table"], friction=0.4)


def test_primitives_with_vertices_of_their_own_are_joined(tmp_path: Path) -> None:
    whole, halves = trimesh.creation.box((0.2, 0.1, 0.4)), trimesh.Scene()
    for number, faces in enumerate((whole.faces[:5], whole.faces[5:])):
        half = trimesh.Trimesh(whole.vertices, faces, process=False)
        half.remove_unreferenced_vertices()
        halves.add_geometry(half, node_name=f"half{number}")
    content = halves.export(file_type="glb")
    length = struct.unpack_from("<I", content, 12)[0]
    data = json.loads(content[20 : 20 + length])
    first, second = data["meshes"]
    first["primitives"] += second["primitives"]
    data["meshes"], data["nodes"] = [first], [{"name": "crate", "mesh": 0}]
    data["scenes"] = [{"nodes": [0]}]
    (tmp_path / "crate.glb").write_bytes(container(data, content[28 + length :]))
    body = hf.load_scene(tmp_path / "crate.glb", density=1000, friction=0.5, floor=True).body("crate")
    assert body.mass == pytest.approx(8.0)
    np.testing.assert_allclose(np.diag(body.inertia_com), 8 / 12 * np.array([0.17, 0.20, 0.05]), rtol=1e-6)
