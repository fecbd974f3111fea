"""Mesh files that nobody should trust: told errors, no half meshes, no memory by header (D3, D4, D13, D18, D23)."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import resource
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import holdfast as hf
from holdfast.geometry.gltf import BINARY_CHUNK, JSON_CHUNK
from holdfast.scene.meshes import by_trimesh, read
from holdfast.scene.meshes.read import READERS, triangles_of

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
KINDS = ("obj", "stl", "stl_ascii", "ply", "ply_ascii", "glb", "off")


def content_of(kind: str, mesh: trimesh.Trimesh) -> bytes:
    name, _, form = kind.partition("_")
    if name == "ply":
        made: Any = trimesh.exchange.ply.export_ply(mesh, encoding="ascii" if form else "binary_little_endian")
    else:
        made = mesh.export(file_type=kind)
    return made if isinstance(made, bytes) else made.encode()


def written(folder: Path, kind: str, content: bytes) -> Path:
    path = folder / f"part.{kind.partition('_')[0]}"
    path.write_bytes(content)
    return path


def solid() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=1, radius=0.3)


def glb_of(header: dict[str, Any], binary: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    if binary:
        chunks += struct.pack("<II", len(binary), BINARY_CHUNK) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


CORNERS = (
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes() + np.array([0, 1, 2], dtype="<u4").tobytes()
)


def header(**changes: Any) -> dict[str, Any]:
    """The header of a GLB file with one triangle, whose numbers are CORNERS."""
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 48}],
    } | changes


@pytest.mark.parametrize("kind", KINDS)
def test_all_formats_give_the_triangles_that_were_written(kind: str, tmp_path: Path) -> None:
    mesh = solid()
    vertices, faces = triangles_of(written(tmp_path, kind, content_of(kind, mesh)))
    np.testing.assert_allclose(vertices[faces], mesh.triangles, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_d18_a_file_that_ends_early_is_no_mesh(kind: str, tmp_path: Path) -> None:
    """Half a mesh is another mesh: it has another volume, and nobody would know."""
    whole = content_of(kind, solid())
    for share in (0.3, 0.6, 0.9, 0.97):
        part = whole[: int(share * len(whole))]
        part = part if kind in ("stl", "ply", "glb") else part[: part.rfind(b"\n") + 1]  # at the end of a row
        if kind == "obj":
            continue  # a file that says nowhere how long it is
        with pytest.raises(hf.errors.GeometryError, match=r"cannot be read: .*; check the file"):
            triangles_of(written(tmp_path, kind, part))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_file_gives_a_mesh_or_a_told_error(kind: str, data: st.DataObject, tmp_path: Path) -> None:
    whole = bytearray(content_of(kind, trimesh.creation.box((1, 1, 1))))
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(whole) - 1))
        match data.draw(st.sampled_from(["byte", "cut", "insert", "double"])):
            case "byte":
                whole[place] = data.draw(st.integers(0, 255))
            case "cut":
                del whole[place : place + data.draw(st.integers(1, 40))]
            case "insert":
                whole[place:place] = data.draw(st.binary(min_size=1, max_size=20))
            case "double":
                whole[place:place] = whole[place : place + 60]
        whole = whole or bytearray(b"x")
    mesh = None
    with contextlib.suppress(hf.HoldfastError):
        mesh = hf.Mesh.from_file(written(tmp_path, kind, bytes(whole)))
    if mesh is not None:
        assert np.isfinite(mesh.vertices).all()
        assert mesh.faces.max() < len(mesh.vertices)


@pytest.mark.parametrize("kind", ["obj", "stl_ascii", "ply_ascii", "off"])
def test_d23_a_byte_order_mark_is_no_content(kind: str, tmp_path: Path) -> None:
    mesh = solid()
    vertices, faces = triangles_of(written(tmp_path, kind, b"\xef\xbb\xbf" + content_of(kind, mesh)))
    np.testing.assert_allclose(vertices[faces], mesh.triangles, atol=1e-6)


@pytest.mark.parametrize("ends", [b"\r\n", b"\r"])
@pytest.mark.parametrize("kind", ["obj", "stl_ascii", "off"])
def test_lines_may_end_as_on_any_system(kind: str, ends: bytes, tmp_path: Path) -> None:
    mesh = solid()
    vertices, faces = triangles_of(written(tmp_path, kind, content_of(kind, mesh).replace(b"\n", ends)))
    np.testing.assert_allclose(vertices[faces], mesh.triangles, atol=1e-6)


def test_d4_an_obj_is_read_without_its_materials(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mtl")
    (tmp_path / "a.obj").write_text("mtllib pipe.mtl\nusemtl wood\n" + TETRA)
    assert len(triangles_of(tmp_path / "a.obj")[1]) == 4


OBJ: dict[str, tuple[str, str]] = {
    "two numbers before": ("v 0 0\n" + TETRA, r"line 1: needs 3 numbers, got '0 0'"),
    "two numbers after": (TETRA + "v 1 2\n", r"line 9: needs 3 numbers"),
    "two numbers everywhere": ("v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", r"line 1: needs 3 numbers"),
    "no number": ("v 0 x 0\n", r"line 1: needs 3 numbers, got '0 x 0'"),
    "vertex 0": (TETRA + "f 0 1 2\n", r"line 9: a face names vertex '0' of 4: they count from 1"),
    "vertex 5": (TETRA + "f 1 2 5\n", r"a face names vertex 5 of 4"),
    "vertex -5": (TETRA + "f 1 2 -5\n", r"line 9: a face names vertex '-5' of 4"),
    "vertex x": (TETRA + "f 1 2 x/1\n", r"line 9: a face names vertex 'x/1' of 4"),
    "two corners": (TETRA + "f 1 2\n", r"line 9: a face has 2 corners"),
    "huge index": (TETRA + "f 1 2 " + "9" * 30 + "\n", r"cannot be read"),
    "endless index": (TETRA + "f 1 2 " + "9" * 5000 + "\n", r"cannot be read"),
}


@pytest.mark.parametrize("name", OBJ)
def test_d13_odd_rows_of_an_obj_are_told(name: str, tmp_path: Path) -> None:
    text, match = OBJ[name]
    (tmp_path / "a.obj").write_text(text)
    with pytest.raises(hf.errors.GeometryError, match=match) as caught:
        hf.Mesh.from_file(tmp_path / "a.obj")
    assert len(str(caught.value)) < 700


def test_rows_of_an_obj_that_are_unusual_but_right(tmp_path: Path) -> None:
    """Tabs, spaces in front, colours, continued rows, relative indices, quads: trimesh drops some of these rows."""
    text = (
        "# a cube\n  v\t0 0 0 0.5 0.5 0.5\nv 1 0 0 1.0\nv 1 1 \\\n 0\nv 0 1 0\n"
        "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1 # seven\n"
        "vn 0 0 1\nvt 0 0\ng side\nf 1//1 4//1 3//1 2//1\nf -4 -3 -2 -1\n\tf 1/1 2/1 6/1 5/1\n"
        "f 2/1/1 3/1/1 7/1/1 6/1/1\nf 3 4 8 7\nf 4 1 5 8\n"
    )
    (tmp_path / "a.obj").write_text(text)
    assert hf.Mesh.from_file(tmp_path / "a.obj").mass_properties.volume == pytest.approx(1.0)


def before_last(text: str, row: str) -> str:
    place = text.rindex("vertex")
    return f"{text[:place]}{row}\n{text[place:]}"


STL: dict[str, tuple[Callable[[str], str], str]] = {
    "no number": (
        lambda s: s.replace("vertex", "vertex x", 3).replace("vertex x", "vertex", 2),
        r"needs a row of an STL",
    ),
    "two numbers": (lambda s: before_last(s, "vertex 1 2"), r"got 'vertex 1 2'"),
    "a word": (lambda s: before_last(s, "vertex 1 two 3"), r"got '1 two 3'"),
    "four vertices": (lambda s: before_last(s, "vertex 1 2 3"), r"ends at vertex"),
    "no end": (lambda s: s[: s.rindex("endsolid")], r"within a solid"),
    "another row": (lambda s: s.replace("outer loop", "inner loop", 1), r"got 'inner loop'"),
}


@pytest.mark.parametrize("name", STL)
def test_d18_half_readable_stl_files_are_told_without_foreign_tracebacks(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    change, match = STL[name]
    text = change(content_of("stl_ascii", trimesh.creation.box((1, 1, 1))).decode())
    (tmp_path / "a.stl").write_text(text)
    with pytest.raises(hf.errors.GeometryError, match=match):
        hf.Mesh.from_file(tmp_path / "a.stl")
    assert capfd.readouterr() == ("", "")


def test_d18_trimesh_does_not_print_its_own_tracebacks(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Without any handler Python prints what trimesh logs as a warning, traceback and all."""
    text = content_of("ply_ascii", solid()).decode().replace("ply", "ply\ncomment TextureFile none.png", 1)
    (tmp_path / "a.ply").write_text(text)
    handlers, logging.root.handlers = logging.root.handlers, []
    try:
        hf.Mesh.from_file(tmp_path / "a.ply")
        logging.getLogger("trimesh").warning("as it does")
    finally:
        logging.root.handlers = handlers
    assert capfd.readouterr() == ("", "")


def test_a_binary_stl_that_begins_with_solid(tmp_path: Path) -> None:
    whole = content_of("stl", solid())
    (tmp_path / "a.stl").write_bytes(b"solid part".ljust(80) + whole[80:])
    assert len(triangles_of(tmp_path / "a.stl")[1]) == len(solid().faces)


HUGE = {"componentType": 5126, "count": 300_000_000, "type": "VEC3"}
COUNTS: dict[str, tuple[str, bytes, str]] = {
    "stl": ("a.stl", b"\0" * 80 + struct.pack("<I", 3_000_000_000), r"has 84 bytes, but says 3,000,000,000 triangles"),
    "ply": (
        "a.ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3000000000\nproperty float x\nend_header\n",
        r"says 3,000,000,000 of 'vertex', and has 0 bytes",
    ),
    "ply text": (
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex 3000000000\nproperty float x\nend_header\n1\n",
        r"says 3,000,000,000 of 'vertex', and has 1 rows",
    ),
    "ply without properties": (
        "a.ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 30\nend_header\n" + b"\0" * 100,
        r"does not say what its 'vertex' holds",
    ),
    "ply whose faces alone have properties": (
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        r"does not say what its 'vertex' holds",
    ),
    "ply of many digits": (
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex " + b"9" * 5000 + b"\nproperty float x\nend_header\n",
        r"and has 0 rows",
    ),
    "ply without end": ("a.ply", b"ply\nformat ascii 1.0\n", r"has no header of a PLY file"),
    "off": ("a.off", b"OFF\n3000000000 3000000000 0\n0 0 0\n", r"says 3,000,000,000 vertices .* and has 1 and 0"),
    "glb": (
        "a.glb",
        glb_of(header(accessors=[HUGE] * 2, bufferViews=[], buffers=[])),
        r"accessor 0 says 300,000,000 items, and no bytes for them",
    ),
    "glb header": (
        "a.glb",
        struct.pack("<4sIIII", b"glTF", 2, 20, 3_000_000_000, JSON_CHUNK),
        r"says a header of 3,000,",
    ),
    "glb chunk": (
        "a.glb",
        glb_of({}) + struct.pack("<II", 3_000_000_000, BINARY_CHUNK),
        r"says a part of 3,000,000,000 bytes, and has 0 left",
    ),
}


@pytest.mark.parametrize("name", COUNTS)
def test_d3_counts_are_compared_with_the_file_before_memory_is_taken(name: str, tmp_path: Path) -> None:
    file, content, match = COUNTS[name]
    (tmp_path / file).write_bytes(content)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(hf.errors.GeometryError, match=match):
        triangles_of(tmp_path / file)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # KiB


def many(count: int) -> list[dict[str, Any]]:
    return [{"mesh": 0} for _ in range(count)]


GLB: dict[str, tuple[dict[str, Any], str]] = {
    "another file": (header(buffers=[{"byteLength": 48, "uri": "pipe"}]), r"keeps its numbers in another file"),
    "view too long": (header(bufferViews=[{"buffer": 0, "byteLength": 49}] * 2), r"view 0 ends at byte 49 of 48"),
    "negative offset": (
        header(bufferViews=[{"buffer": 0, "byteOffset": -4, "byteLength": 4}] * 2),
        r"byteOffset is -4, not a whole",
    ),
    "count too large": (
        header(accessors=[{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}] * 2),
        r"accessor 0 says 4 items, 48 bytes, of 36",
    ),
    "stride too small": (
        header(bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": 1}] * 2),
        r"accessor 0 says 3 items, 14 bytes",
    ),
    "sparse": (
        header(accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {}}] * 2),
        r"export them in full",
    ),
    "count is a text": (
        header(accessors=[{"bufferView": 0, "componentType": 5126, "count": "3", "type": "VEC3"}] * 2),
        r"count is '3'",
    ),
    "unknown type": (
        header(accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC9"}] * 2),
        r"VEC9",
    ),
    "views of views": (
        header(bufferViews=[{"buffer": 0, "byteLength": 48}] * 30),
        r"has views of 1,440 bytes, and holds 48",
    ),
    "compressed": (
        header(extensionsRequired=["KHR_draco_mesh_compression"]),
        r"is compressed with KHR_draco_mesh_compression",
    ),
    "no mesh": (header(nodes=[{"mesh": 7}]), r"cannot be read"),
    "nan in a node": (header(nodes=[{"mesh": 0, "translation": [float("nan"), 0, 0]}]), r"a node has the translation"),
    "own ancestor": (header(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]), r"their own ancestors"),
    "two parents": (header(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}]), r"has two parents"),
    "nodes are no list": (header(nodes={"mesh": 0}), r"nodes is no list"),
    "a chain of nodes": (
        header(nodes=[{"mesh": 0, "children": [k + 1]} for k in range(3000)] + [{"mesh": 0}]),
        r"up to 3,001 below each",
    ),
}


@pytest.mark.parametrize("name", GLB)
def test_headers_of_glb_files_that_cannot_be_right(name: str, tmp_path: Path) -> None:
    head, match = GLB[name]
    (tmp_path / "a.glb").write_bytes(glb_of(head, CORNERS))
    with pytest.raises(hf.errors.GeometryError, match=match) as caught:
        triangles_of(tmp_path / "a.glb")
    assert str(caught.value).isprintable()


def test_d3_instances_do_not_make_a_small_file_huge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(by_trimesh, "MOST_CORNERS", 600)
    (tmp_path / "a.glb").write_bytes(glb_of(header(nodes=many(99), scenes=[{"nodes": list(range(99))}]), CORNERS))
    assert len(triangles_of(tmp_path / "a.glb")[1]) == 99
    (tmp_path / "b.glb").write_bytes(glb_of(header(nodes=many(100), scenes=[{"nodes": list(range(100))}]), CORNERS))
    with pytest.raises(hf.errors.GeometryError, match="has 606 corners with all instances, of 600"):
        triangles_of(tmp_path / "b.glb")


def test_a_deep_header_is_told(tmp_path: Path) -> None:
    text = b'{"a":' * 20_000 + b"1" + b"}" * 20_000
    chunk = struct.pack("<II", len(text), JSON_CHUNK) + text
    (tmp_path / "a.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunk)) + chunk)
    with pytest.raises(hf.errors.GeometryError, match="is nested too deeply"):
        triangles_of(tmp_path / "a.glb")


def test_a_file_beyond_the_limit_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, "MAX_BYTES", 10)
    (tmp_path / "a.obj").write_text(TETRA)
    with pytest.raises(hf.errors.GeometryError, match="bytes; the limit is 10: simplify the mesh"):
        triangles_of(tmp_path / "a.obj")


@pytest.mark.parametrize("content", [b"", b"\0" * 200, b"hello\n", b"\xff\xfe" * 50])
@pytest.mark.parametrize("suffix", READERS)
def test_every_reader_refuses_what_is_not_its_own(suffix: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / f"a{suffix}").write_bytes(content)
    with pytest.raises(hf.errors.GeometryError, match=r"cannot be read: |holds no triangles; "):
        triangles_of(tmp_path / f"a{suffix}")


@pytest.mark.parametrize(("up_axis", "size"), [("y", (0.1, 0.3, 0.2)), ("z", (0.1, 0.2, 0.3))])
@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
def test_gltf_in_a_robot_file_is_turned_as_up_axis_says(
    up_axis: str, size: tuple[float, ...], suffix: str, tmp_path: Path
) -> None:
    exported = trimesh.Scene(trimesh.creation.box((0.1, 0.2, 0.3))).export(file_type=suffix[1:])
    for name, content in exported.items() if isinstance(exported, dict) else [("model.glb", exported)]:
        (tmp_path / name).write_bytes(content)
    text = f'<collision><geometry><mesh filename="model{suffix}"/></geometry></collision>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="l">{text}</link></robot>')
    scene = hf.load_scene(tmp_path / "r.urdf", friction=0.5, density=100, floor=True, up_axis=up_axis)
    np.testing.assert_allclose(np.ptp(scene.body("r").box, axis=0), size, atol=1e-7)
