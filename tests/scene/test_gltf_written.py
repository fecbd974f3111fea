"""Scenes written as glTF: what is in the files, by other readers than ours, and that they come back as they were."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import at, box, floor

RNG = np.random.default_rng(5)
ROCK = trimesh.Trimesh(RNG.normal(size=(40, 3)) * (0.1, 0.07, 0.05)).convex_hull
TURNED = pose_from(RNG.normal(size=3), RNG.normal(size=4))
NAMES = [
    "world",
    "a/b",
    "é漢\u202e",
    '<b>&"',
    "edges",
    "a",
    "a_1",
    "a=b:c",
    " x ",
    "1",
    "0",
    "GLTF",
    "\n\tx",
    "y" * 500,
]


def shelf() -> hf.Scene:
    """Unlike things: all shapes, a scan, parts of materials of their own, exclusions, all sorts of friction."""
    table = hf.Compound(
        [hf.Part(hf.Box((1, 1, 0.1))), hf.Part(hf.Mesh(ROCK.vertices, ROCK.faces), at(0, 0, 0.2), "stone")]
    )
    spin = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix()
    bodies = [
        hf.Body("ground", hf.HalfSpace(), pose=TURNED, fixed=True),
        hf.Body("board", hf.Box((1, 0.2, 0.02)), density=600, fixed=True, material="oak"),
        hf.Body("crate", hf.Box((0.1, 0.2, 0.3)), density=300, pose=TURNED, material="oak"),
        hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0, 0, 1)),
        hf.Body("can", hf.Cylinder(0.03, 0.1), mass=0.3, com=(0, 0, 0.01), pose=at(1, 2, 3)),
        hf.Body("pill", hf.Capsule(0.02, 0.05), mass=0.1, inertia=spin @ np.diag([1e-4, 2e-4, 2.5e-4]) @ spin.T),
        hf.Body("egg", hf.Ellipsoid((0.02, 0.02, 0.03)), density=1000, material="shell"),
        hf.Body("rock", hf.Mesh(ROCK.vertices, ROCK.faces, noise=1e-4), density=2500, pose=TURNED),
        hf.Body("sheet", hf.Mesh(*sheet()), mass=0.2, com=(0.1, 0, 0), inertia=np.eye(3) * 1e-3),
        hf.Body("table", table, mass=8),
    ]
    pairs = {("oak", "stone"): 0.7, ("orange", "can"): 0.0, ("oak", "egg"): 0.31}
    return hf.Scene(bodies, hf.Friction(0.5, pairs), (0.3, -2, -9), "a shelf", [("egg", "pill"), ("ground", "rock")])


def sheet() -> tuple[np.ndarray, np.ndarray]:
    return np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.1]]), np.array([[0, 1, 2], [1, 3, 2]])


def file_of(path: Path) -> tuple[dict[str, Any], bytes]:
    """The header of a file and its numbers, read by what the specification says."""
    content = path.read_bytes()
    if path.suffix == ".gltf":
        return json.loads(content), b""
    magic, version, length, size, kind = struct.unpack_from("<4sIIII", content)
    assert (magic, version, length, kind) == (b"glTF", 2, len(content), 0x4E4F534A)
    assert size % 4 == 0
    assert struct.unpack_from("<I", content, 24 + size)[0] == 0x004E4942
    return json.loads(content[20 : 20 + size]), content[28 + size :]


def edited(path: Path, change: Callable[[dict[str, Any]], None]) -> hf.Scene:
    """The scene of a file after a change of its header, as another program may make it."""
    header, _ = file_of(path)
    change(header)
    path.write_text(json.dumps(header))
    return hf.load_scene(path)


def node(header: dict[str, Any], name: str) -> dict[str, Any]:
    return next(each for each in header["nodes"] if each["name"] == name)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_scene_comes_back_as_it_was(suffix: str, tmp_path: Path) -> None:
    """Bit for bit, but for the corners of meshes, which are in single precision."""
    scene, path = shelf(), tmp_path / f"scene{suffix}"
    hf.save_scene(scene, path)
    again = hf.load_scene(path)
    assert (again.name, again.friction, again.excluded) == (scene.name, scene.friction, scene.excluded)
    assert again.gravity.tolist() == scene.gravity.tolist()
    for old, new in zip(scene.bodies, again.bodies, strict=True):
        assert (new.name, new.material, new.fixed, new.mass) == (old.name, old.material, old.fixed, old.mass)
        assert np.array_equal(new.pose, old.pose)
        assert np.array_equal(new.com_body, old.com_body)
        if not old.fixed:
            assert np.array_equal(new.inertia_com, old.inertia_com)
        if old.name not in ("rock", "sheet"):
            assert new == old
        else:
            np.testing.assert_allclose(new.shape.vertices, old.shape.vertices, rtol=1e-7)
            assert new.shape.noise == old.shape.noise
            assert np.array_equal(new.shape.faces, old.shape.faces)


def test_another_reader_sees_every_body_where_it_is(tmp_path: Path) -> None:
    """trimesh, with y up: a point (x, y, z) of the scene is at (x, z, -y)."""
    scene = shelf()
    hf.save_scene(scene, tmp_path / "scene.glb")
    found = trimesh.load_scene(tmp_path / "scene.glb", process=False)
    assert sorted(found.graph.nodes_geometry) == sorted(body.name for body in scene.bodies)
    for body in scene.bodies:
        matrix, geometry = found.graph[body.name]
        surface = body.shape if isinstance(body.shape, hf.Mesh) else body.shape.surface
        seen = trimesh.transform_points(found.geometry[geometry].vertices, matrix)
        x, y, z = body.placed(surface.vertices).T
        np.testing.assert_allclose(seen, np.column_stack([x, z, -y]), atol=1e-6 * (1 + np.abs(seen).max()))


def test_colours_are_light_and_fixed_bodies_are_grey(tmp_path: Path) -> None:
    hf.save_scene(hf.Scene([floor(), box("a", (1, 1, 1), 1, (0, 0, 0.5))], 0.5), tmp_path / "scene.glb")
    header, _ = file_of(tmp_path / "scene.glb")
    looks = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in header["materials"]]
    for look, rgb in zip(looks, [(0xD3, 0xD2, 0xCE), (0x4F, 0x7C, 0xAC)], strict=True):
        assert look == pytest.approx([*(((c / 255 + 0.055) / 1.055) ** 2.4 for c in rgb), 1.0])


def test_names_are_kept_whatever_they_are(tmp_path: Path) -> None:
    bodies = [box(name, (0.1, 0.1, 0.1), 1, (k, 0, 0.05)) for k, name in enumerate(NAMES)]
    scene = hf.Scene([floor(), *bodies], hf.Friction(0.5, {("world", "a"): 0.1}), excluded=[("1", "world")])
    for suffix in (".glb", ".gltf"):
        hf.save_scene(scene, tmp_path / f"scene{suffix}")
        assert hf.load_scene(tmp_path / f"scene{suffix}") == scene


def test_nodes_of_one_name_get_numbers(tmp_path: Path) -> None:
    path = tmp_path / "scene.gltf"
    hf.save_scene(hf.Scene([floor(), *(box(f"b{k}", (1, 1, 1), 1, (2 * k, 0, 0)) for k in range(3))], 0.5), path)

    def alike(header: dict[str, Any]) -> None:
        for each, name in zip(header["nodes"], ["floor", "cube", "cube", "cube_1"], strict=True):
            each["name"] = name

    assert [body.name for body in edited(path, alike).bodies] == ["floor", "cube", "cube_2", "cube_1"]


def test_thousands_of_equal_bodies_share_a_mesh(tmp_path: Path) -> None:
    scene = hf.Scene([floor(), *(box(f"b{k}", (0.1, 0.1, 0.1), 1, (k, 0, 0.05)) for k in range(500))], 0.5)
    hf.save_scene(scene, tmp_path / "scene.glb")
    header, _ = file_of(tmp_path / "scene.glb")
    assert len(header["meshes"]) == 9  # the floor, and a box in each of eight colours
    assert (tmp_path / "scene.glb").stat().st_size < 500 * 300 + 5000
    assert hf.load_scene(tmp_path / "scene.glb") == scene


def test_a_large_scan_takes_what_its_numbers_take(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(6, 0.2)
    path = tmp_path / "scan.glb"
    hf.save_scene(hf.Scene([floor(), hf.Body("scan", hf.Mesh(ball.vertices, ball.faces), mass=2)], 0.5), path)
    assert path.stat().st_size < 12 * (len(ball.vertices) + len(ball.faces)) + 3000


def test_a_mesh_far_from_its_frame_keeps_its_corners(tmp_path: Path) -> None:
    far = hf.Mesh(ROCK.vertices + np.array([3000, -2000, 5]), ROCK.faces)
    scene = hf.Scene([floor(), hf.Body("rock", far, mass=1, pose=TURNED)], 0.5)
    hf.save_scene(scene, tmp_path / "scene.glb")
    again = hf.load_scene(tmp_path / "scene.glb").body("rock")
    np.testing.assert_allclose(again.shape.vertices, far.vertices, atol=1e-8)
    np.testing.assert_allclose(again.pose, TURNED, atol=1e-9)


def scaled(header: dict[str, Any]) -> None:
    box = node(header, "box")
    box["matrix"] = (np.array(box["matrix"]).reshape(4, 4).T @ np.diag([2.0, 2, 2, 1])).T.ravel().tolist()


def moved_corner(header: dict[str, Any]) -> None:
    taken, other = (node(header, name) for name in ("box", "wedge"))
    taken["mesh"] = other["mesh"]


@pytest.mark.parametrize(("change", "volume"), [(scaled, 8 * 0.006), (moved_corner, 0.3 * 0.2 * 0.1 / 6)])
def test_a_mesh_that_was_edited_counts_as_it_is(change: Any, volume: float, tmp_path: Path) -> None:
    """Or a body would be answered for that is not in the file."""
    wedge = hf.Mesh([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    given = hf.Body("box", hf.Box((0.1, 0.2, 0.3)), mass=2, com=(0.01, 0, 0), inertia=np.eye(3), pose=TURNED)
    path = tmp_path / "scene.gltf"
    hf.save_scene(hf.Scene([floor(), given, hf.Body("wedge", wedge, mass=1)], 0.5), path)
    scene = edited(path, change)
    body = scene.body("box")
    assert isinstance(body.shape, hf.Mesh)
    assert body.shape.mass_properties.volume == pytest.approx(volume, rel=1e-6)
    assert (body.mass, body.com, body.inertia) == (2, None, None)
    assert any("meshes are not those that holdfast wrote" in note and "box" in note for note in scene.notes)
    assert scene.body("wedge").com is not None


def test_a_moved_node_is_a_moved_body_and_a_deleted_one_is_gone(tmp_path: Path) -> None:
    path = tmp_path / "scene.gltf"
    hf.save_scene(shelf(), path)

    def change(header: dict[str, Any]) -> None:
        node(header, "orange")["matrix"][12:15] = [0.5, 0.25, 0.125]  # y is up
        kept = [k for k, each in enumerate(header["nodes"]) if each["name"] not in ("can", "pill")]
        header["scenes"][0]["nodes"] = kept

    scene = edited(path, change)
    assert scene.body("orange").pose[:3, 3].tolist() == [0.5, -0.125, 0.25]
    assert scene.body("orange").shape == hf.Sphere(0.04)
    assert "can" not in scene.names
    assert scene.excluded == (("ground", "rock"),)
    assert set(scene.friction.pairs) == {("oak", "stone"), ("egg", "oak")}
    assert sum("left out: they name what is not in the file" in note for note in scene.notes) == 2


def test_options_come_before_what_is_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    hf.save_scene(shelf(), path)
    scene = hf.load_scene(path, friction=0.2, mass={"pill": 0.5}, density=77, fixed=["egg"], gravity=(0, 0, -1))
    assert scene.mu("orange", "can") == 0.2
    assert any("in place of the table in the file" in note for note in scene.notes)
    assert scene.body("pill").mass == 0.5
    assert scene.body("pill").inertia is None  # that of another mass
    assert (scene.body("crate").density, scene.body("ground").mass, scene.body("egg").fixed) == (300, None, True)
    assert scene.gravity.tolist() == [0, 0, -1]
    path.with_name("scene.glb.yaml").write_text("nodes: {pill: {mass: 0.7}}\nfriction: 0.3\n")
    beside = hf.load_scene(path)
    assert (beside.body("pill").mass, beside.mu("orange", "can")) == (0.7, 0.3)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ({"mass": -1}, "mass: is -1"),
        ({"mass": "3"}, "mass: needs a number"),
        ({"shape": {"type": "mesh", "file": "../../secret.stl"}}, r"names the mesh file '../../secret.stl'"),
        ({"shape": {"type": "ball"}}, "shape"),
        ({"colour": 1}, "colour: unknown key"),
        ({"inertia": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, "negative principal moment"),
    ],
)
def test_what_is_wrong_in_a_file_is_told(words: dict[str, Any], match: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.gltf"
    hf.save_scene(hf.Scene([floor(), box("a", (1, 1, 1), 1, (0, 0, 0.5))], 0.5), path)
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        edited(path, lambda header: node(header, "a")["extras"]["holdfast"].update(words))
    assert "scene.gltf" in str(caught.value)


def test_nothing_half_written_is_left(tmp_path: Path) -> None:
    path = tmp_path / "there" / "scene.glb"
    with pytest.raises(hf.HoldfastError, match="cannot be written"):
        hf.save_scene(shelf(), path)
    assert not any(tmp_path.iterdir())
