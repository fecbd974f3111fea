"""Maps as glTF and PLY: colours, forces and kinds at the vertices, read by other programs and by the specifications."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.drawing import colours
from holdfast.drawing.colours import Kind
from holdfast.drawing.map_files import painted, write_glb, write_ply
from holdfast.drawing.picture import Arrow, HeatSurface, Picture, Solid

INF = float("inf")
LARGEST = 3.4028234663852886e38
LEGEND = {  # as the picture shows them, and as a file codes them
    Kind.ENDLESS: ("#9fbbe0", LARGEST, INF),
    Kind.BALANCED: ("#d400d4", 0.0, 0.0),
    Kind.FALLS: ("#1c1c96", 0.0, 0.0),
    Kind.UNDECIDED: ("#a38fcc", -1.0, -1.0),
}
NUMBERS = {5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def box_of(name: str, low: tuple[float, float, float], force: Any, kinds: Any) -> HeatSurface:
    """A unit cube with a cell for each of its twelve triangles."""
    mesh = trimesh.creation.box((1, 1, 1))
    vertices, faces = np.asarray(mesh.vertices) + 0.5 + np.array(low), np.array(mesh.faces)
    points = vertices[faces].mean(1)
    hover = ("",) * 12
    return HeatSurface(name, vertices, faces, np.arange(12), points, np.array(force, float), hover, np.array(kinds))


@pytest.fixture
def picture() -> Picture:
    """A cube with an answer of every kind, and one 30 m away with forces over three decades, on a floor."""
    kinds = [Kind.FORCE] * 4 + [kind for kind in LEGEND for _ in range(2)]
    force = [1.0, 2.0, 50.0, 800.0, INF, INF, 0, 0, 0, 0, 0, 0]
    heat = (
        box_of("odd", (0, 0, 0), force, kinds),
        box_of("far \u202e<b>", (30, 0, 0), np.geomspace(0.5, 900, 12), [Kind.FORCE] * 12),
    )
    ground = trimesh.creation.box((80, 80, 1))
    floor = Solid("floor", np.asarray(ground.vertices) - (0, 0, 0.5), np.array(ground.faces), True)
    hidden = Solid("odd", np.array([[0.0, 0, 2], [1, 0, 2], [0, 1, 2]]), np.array([[0, 1, 2]]), False)
    arrows = (Arrow(np.array([0.0, 0, 2]), np.array([0.0, 0, 1]), "odd: 1 N, slides"),)
    return Picture("title", "subtitle", heat, (floor, hidden), weakest=arrows)


def parsed(path: Path) -> tuple[dict[str, Any], list[np.ndarray]]:
    """The header of a glTF file, and the numbers of its accessors, by the specification."""
    content = path.read_bytes()
    size = struct.unpack_from("<I", content, 12)[0]
    header, held = json.loads(content[20 : 20 + size]), content[28 + size :]
    arrays = []
    for each in header["accessors"]:
        view = header["bufferViews"][each["bufferView"]]
        kind, width = NUMBERS[each["componentType"]], WIDTHS[each["type"]]
        assert view["byteLength"] == each["count"] * width * kind.itemsize
        found = np.frombuffer(held, kind, each["count"] * width, view["byteOffset"])
        arrays.append(found.reshape(-1, width) if width > 1 else found)
    return header, arrays


def bodies_of(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """The vertices (z up), triangles, colours as #rrggbb, forces and kinds of each body of a glTF file."""
    header, arrays = parsed(path)
    found = {}
    for node in header["nodes"]:
        (part,) = header["meshes"][node["mesh"]]["primitives"]
        numbers = {name: arrays[k].astype(float) for name, k in part["attributes"].items()}
        x, y, z = (numbers["POSITION"] @ (m := np.array(node["matrix"]).reshape(4, 4).T)[:3, :3].T + m[:3, 3]).T
        light = numbers.get("COLOR_0", np.ones((len(x), 4)))[:, :3] / 65535
        srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        texts = np.array(["#" + "".join(f"{c:02x}" for c in row) for row in np.rint(255 * srgb).astype(int).tolist()])
        found[node["name"]] = {
            "vertices": np.column_stack([x, -z, y]),
            "corners": arrays[part["indices"]],
            "rgb": texts,
            "force": numbers.get("_FORCE", np.empty(0)),
            "kind": numbers.get("_KIND", np.empty(0)),
        }
    return found


def check_odd(vertices: np.ndarray, rgb: np.ndarray, force: np.ndarray, kind: np.ndarray, infinity: int) -> None:
    """Every corner of every cell says what the answer of its cell is."""
    for known, row in LEGEND.items():
        here = kind == known
        assert here.sum() == 6
        assert set(rgb[here]) == {row[0]}
        assert set(force[here].tolist()) == {row[infinity]}
    assert sorted(force[kind == Kind.FORCE].tolist()) == sorted([1.0, 2.0, 50.0, 800.0] * 3)
    covered = kind == Kind.NONE
    assert set(force[covered]) == {-2.0}
    assert vertices[covered][:, 2].tolist() == [2.0, 2.0, 2.0]


def test_the_vertices_of_a_gltf_file_bear_colours_and_forces(picture: Picture, tmp_path: Path) -> None:
    write_glb(picture, tmp_path / "m.glb")
    found = bodies_of(tmp_path / "m.glb")
    odd, far = found["odd"], found["far \u202e<b>"]
    check_odd(odd["vertices"], odd["rgb"], odd["force"], odd["kind"], 1)
    scale = colours.scale_of([1, 2, 50, 800, *np.geomspace(0.5, 900, 12)])
    assert scale is not None
    assert scale.log
    expected = [colours.hex_of(rgb) for rgb in colours.sample(scale.position(far["force"]))]
    assert far["rgb"].tolist() == expected
    assert (far["rgb"][np.argmin(far["force"])], far["rgb"][np.argmax(far["force"])]) == ("#6a0c42", "#cdf3b4")
    np.testing.assert_allclose(far["force"], np.repeat(np.geomspace(0.5, 900, 12), 3), rtol=1e-7)
    assert set(found["floor"]["force"]) == {-2.0}
    assert set(found["floor"]["rgb"]) == {"#d3d2ce"}


def test_surfaces_are_where_they_are_and_wound_outward(picture: Picture, tmp_path: Path) -> None:
    write_glb(picture, tmp_path / "m.glb")
    far = bodies_of(tmp_path / "m.glb")["far \u202e<b>"]
    solid = trimesh.Trimesh(far["vertices"], far["corners"].reshape(-1, 3), process=True)
    assert solid.volume == pytest.approx(1, rel=1e-6)
    assert solid.center_mass == pytest.approx((30.5, 0.5, 0.5), abs=1e-6)
    (tip,) = (body for name, body in bodies_of(tmp_path / "m.glb").items() if name.startswith("weakest push 1: odd"))
    assert tip["vertices"][:, 2].min() == pytest.approx(1)


def test_other_programs_read_it(picture: Picture, tmp_path: Path) -> None:
    write_glb(picture, tmp_path / "m.glb")
    scene = trimesh.load_scene(tmp_path / "m.glb", process=False)
    matrix, geometry = scene.graph["odd"]
    mesh = scene.geometry[geometry]
    assert mesh.vertex_attributes["_FORCE"].max() == np.float32(LARGEST)
    low, high = trimesh.transform_points(mesh.vertices, matrix).min(0), (1, 2, 0)
    assert low.tolist() == pytest.approx([0, 0, -1])
    assert trimesh.transform_points(mesh.vertices, matrix).max(0).tolist() == pytest.approx(list(high))


def test_no_number_in_a_gltf_file_is_infinite(picture: Picture, tmp_path: Path) -> None:
    write_glb(picture, tmp_path / "m.glb")
    header, arrays = parsed(tmp_path / "m.glb")
    assert all(np.isfinite(array).all() for array in arrays)
    assert "Infinity" not in json.dumps(header)
    for each, array in zip(header["accessors"], arrays, strict=True):
        if "min" in each:
            assert (each["min"], each["max"]) == (array.min(0).tolist(), array.max(0).tolist())
    said = header["scenes"][0]["extras"]["holdfast_map"]
    assert said["value"] == "largest push [N]"
    assert (said["scale"]["low"], said["scale"]["high"]) == (0.5, 900.0)
    assert {each["kind"]: each.get("colour") for each in said["kinds"]} == {
        0: None, 5: "#8d8b87", **{int(kind): row[0] for kind, row in LEGEND.items()}
    }  # fmt: skip
    assert said["attributes"]["_FORCE"]["no push moves it"] == LARGEST


def test_a_ply_file_says_the_same(picture: Picture, tmp_path: Path) -> None:
    write_ply(picture, tmp_path / "m.ply")
    content = (tmp_path / "m.ply").read_bytes()
    head, _, rest = content.partition(b"end_header\n")
    lines = head.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    count, faces = (int(line.split()[2]) for line in lines if line.startswith("element"))
    kind = np.dtype(
        [*((a, "<f4") for a in "xyz"), *((c, "u1") for c in "rgb"), ("f", "<f4"), ("k", "u1"), ("n", "<i4")]
    )
    found = np.frombuffer(rest, kind, count)
    assert len(rest) == count * kind.itemsize + faces * 13
    rgb = np.array([f"#{r:02x}{g:02x}{b:02x}" for r, g, b in found[list("rgb")].tolist()])
    odd = found["n"] == 0
    vertices = np.column_stack([found[axis] for axis in "xyz"])
    check_odd(vertices[odd], rgb[odd], found["f"][odd], found["k"][odd], 2)
    assert "comment body 0: odd" in lines
    assert any(line.startswith("comment body 1: far") for line in lines)
    assert "comment kind 1: no push moves it (∞) #9fbbe0".encode("ascii", "backslashreplace").decode() in lines
    mesh = trimesh.load(tmp_path / "m.ply", process=False)
    assert len(mesh.faces) == faces == 12 + 12 + 1 + 12
    assert mesh.metadata["_ply_raw"]["vertex"]["data"]["force"].max() == INF
    assert len(hf.Mesh.from_file(tmp_path / "m.ply").faces) == faces


def test_a_scene_far_from_the_origin_keeps_its_corners(tmp_path: Path) -> None:
    there = (3e5, -2e5, 7.0)
    heat = (box_of("a", there, range(12), [Kind.FORCE] * 12),)
    write_ply(Picture("", "", heat, ()), tmp_path / "m.ply")
    assert b"property double x" in (tmp_path / "m.ply").read_bytes()
    low = hf.Mesh.from_file(tmp_path / "m.ply").vertices.min(0)
    assert low.tolist() == list(there)
    write_glb(Picture("", "", heat, ()), tmp_path / "m.glb")
    np.testing.assert_allclose(bodies_of(tmp_path / "m.glb")["a"]["vertices"].min(0), there, rtol=0, atol=1e-6)


def test_names_of_many_bodies_leave_a_header_that_can_be_read(tmp_path: Path) -> None:
    heat = tuple(box_of(f"{k} " + "\u202e" * 400, (2 * k, 0, 0), range(12), [Kind.FORCE] * 12) for k in range(300))
    write_ply(Picture("\n", "\x00", heat, ()), tmp_path / "m.ply")
    assert len(hf.Mesh.from_file(tmp_path / "m.ply").faces) == 3600
    head = (tmp_path / "m.ply").read_bytes().partition(b"end_header")[0].decode("ascii")
    assert "and 200 more bodies" in head
    assert max(map(len, head.splitlines())) < 2000


def test_cells_share_no_corners_and_nothing_is_lost(picture: Picture) -> None:
    odd = painted(picture)[0]
    assert len(odd.vertices) == 39
    assert sorted(odd.triangles.ravel()) == list(range(39))


def test_a_map_is_written_as_the_picture_shows_it(tmp_path: Path) -> None:
    """A slab on legs: at every point of the map the file has the force of the map, in its colour of the scale."""
    found = hf.robustness_map(hf.shipped_scene("table"), spacing=0.1, engine="limit")
    found.save_glb(tmp_path / "m.glb")
    found.save_ply(tmp_path / "m.ply")
    bodies = bodies_of(tmp_path / "m.glb")
    for name in ("slab", "leg_left", "leg_right"):
        here = found.body == name
        force = np.minimum(found.force[here], LARGEST)
        said = bodies[name]["force"]
        assert set(np.float32(force)) == set(np.float32(said[said != -2.0]))
        weakest = bodies[name]["vertices"][said == np.float32(force.min())]
        point = found.points[here][np.argmin(force)]
        assert np.linalg.norm(weakest - point, axis=1).min() < 0.08  # half the diagonal of a cell
    assert set(bodies["floor"]["force"]) == {-2.0}
    assert any(name.startswith("weakest push 1: ") for name in bodies)
    with pytest.raises(hf.HoldfastError, match=r"m.png: does not end in .glb"):
        found.save_glb(tmp_path / "m.png")
    before = (tmp_path / "m.glb").read_bytes()
    found.save_glb(tmp_path / "m.glb")
    assert (tmp_path / "m.glb").read_bytes() == before
