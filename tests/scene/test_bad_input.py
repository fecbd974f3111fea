"""Scene files that are wrong: one clear error each, quickly, and no traceback at the command line."""

from __future__ import annotations

import json
import re
import sys
import time
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import pytest
import trimesh

import holdfast as hf
from holdfast.cli.main import run
from holdfast.scene.formats import source

HEAD = "format: holdfast-scene/1\n"
FLOOR = "  - {name: floor, shape: {type: box, size: [1, 1, 0.1]}, fixed: true}\n"


def scene(bodies: str = "", top: str = "friction: 0.5\n") -> str:
    return f"{HEAD}{top}bodies:\n{FLOOR}{bodies}"


def cube(rest: str = "mass: 1", name: str = "cube", shape: str = "type: box, size: [0.1, 0.1, 0.1]") -> str:
    return scene(f"  - {{name: {name}, shape: {{{shape}}}, {rest}}}\n")


def mesh(source: str) -> str:
    return cube(shape=f"type: mesh, {source}")


def native(**changes: object) -> dict[str, object]:
    floor = {"name": "floor", "shape": {"type": "box", "size": [1, 1, 0.1]}, "fixed": True}
    return {"format": "holdfast-scene/1", "friction": 0.5, "bodies": [floor]} | changes


def block(**changes: object) -> str:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    body = {"name": "a", "vertices": corners, "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "mass": 1}
    return json.dumps({"friction": 0.5, "gravity": [0, 0, -9.81], "blocks": [body | {"fixed": True} | changes]})


IDENTITY = "[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]"
TETRA = "vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]"
BINARY = bytes(range(256)) * 20

# name: (file name, content, what the message must say after the file's name)
FILES: dict[str, tuple[str, str | bytes, str]] = {
    "empty file": ("s.yaml", "", r"is in no known format \(empty\); .*format: holdfast-scene/1"),
    "empty json": ("s.json", "", r":1: is not JSON: .*; check"),
    "binary": ("s.yaml", BINARY, r"cannot be read: .*; needs a readable UTF-8"),
    "binary json": ("s.json", BINARY, r"cannot be read: .*; needs a readable UTF-8"),
    "control characters": ("s.yaml", "a: \x01", r"is not a YAML scene: .*control characters.*; check"),
    "no format": ("s.yaml", "friction: 0.5\n", r"no known format \(no `format` .* .friction.\); .*holdfast-scene/1"),
    "a list": ("s.yaml", "- 1\n", r"is in no known format \(only \[1\]\); .*format: holdfast-scene/1"),
    "unknown format": ("s.yaml", scene().replace("/1", "/9"), r"format: .*'holdfast-scene/9'; "),
    "json trailing": ("s.json", json.dumps(native()) + "xyz", r":1: is not JSON: Extra data; check"),
    "json nan": ("s.json", json.dumps(native(gravity=[0, 0, float("nan")])), r"gravity\[2\]: .*nan; "),
    "json infinity": ("s.json", json.dumps(native(friction=float("inf"))), r"friction: .*inf.*; "),
    "json twice": ("s.json", '{"format": "a", "format": "b"}', r"key 'format' stands twice; keep one"),
    "json huge integer": ("s.json", '{"format": ' + "9" * 5000 + "}", r"; "),
    "huge integer": ("s.yaml", "format: " + "9" * 5000, r"is not a YAML scene: .*; check"),
    "large integer": ("s.json", block(mass=10**400), r"; "),
    "yaml twice": ("s.yaml", cube("mass: 1, mass: 2"), r":5: .*key 'mass' twice; "),
    "yaml syntax": ("s.yaml", "a: [1, 2\nb: 3", r":2: is not a YAML scene: .*; check"),
    "two documents": ("s.yaml", scene() + "---\na: 1\n", r":5: is not a YAML scene: .*another document; "),
    "billion laughs": (
        "s.yaml",
        "a: &a [x]\n" + "".join(f"{y}: &{y} [{', '.join([f'*{x}'] * 9)}]\n" for x, y in pairwise("abcdefghi")),
        r":2: uses the alias \*a; write the value out",
    ),
    "recursive alias": ("s.yaml", "a: &a [*a]\n", r":1: uses the alias \*a; write the value out"),
    "python object": ("s.yaml", "!!python/object/apply:os.system [touch HACKED]\n", r":1: .*python/object.*; check"),
    "python object inside": ("s.yaml", cube("mass: !!python/object/apply:os.system [touch HACKED]"), r":5: .*python"),
    "deep yaml open": ("s.yaml", "[" * 10_000, r":1: is nested too deeply; the limit is 40"),
    "no bodies": ("s.yaml", f"{HEAD}friction: 1\n", r"bodies: is not given; "),
    "bodies is a map": ("s.yaml", f"{HEAD}friction: 1\nbodies: {{a: 1}}\n", r"bodies: .*list; "),
    "body is a number": ("s.yaml", f"{HEAD}friction: 1\nbodies: [7]\n", r"bodies\[0\]: .* got 7; "),
    "mass is negative": ("s.yaml", cube("mass: -2"), r"body 'cube'.*mass.* is -2; needs .* > 0"),
    "mass is nan": ("s.yaml", cube("mass: .nan"), r"mass \(body 'cube'\): .*finite.*nan; "),
    "names twice": ("s.yaml", cube(name="floor"), r"several bodies are named 'floor'; names are unique"),
    "pose and position": ("s.yaml", cube(f"mass: 1, position: [0, 0, 0], pose: [{IDENTITY}]"), r"'cube'\): needs eith"),
    "pose is nan": ("s.yaml", cube(f"mass: 1, pose: [{IDENTITY.replace('0]', '.nan]', 1)}]"), r"pose.*'cube'.*nan; "),
    "pose is 3x3": ("s.yaml", cube("mass: 1, pose: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"), r"pose.* \(body 'cube'\): .*"),
    "quaternion is long": ("s.yaml", cube("mass: 1, orientation: [1, 1, 0, 0]"), r"'cube'\): .*length 1\.414.*unit qu"),
    "quaternion is zero": ("s.yaml", cube("mass: 1, orientation: [0, 0, 0, 0]"), r"'cube'\): .*length 0.*unit quatern"),
    "mesh is missing": ("s.yaml", mesh("file: nope.stl"), r"nope\.stl: no such mesh file; paths are relative"),
    "mesh is garbage": ("s.yaml", mesh("file: garbage.ply"), r"garbage\.ply: cannot be read: .*; check the file"),
    "mesh is empty": ("s.yaml", mesh("file: empty.obj"), r"empty\.obj: holds no triangles; needs a surface"),
    "mesh of points": ("s.yaml", mesh("file: points.obj"), r"points\.obj: holds no triangles; needs a surface mesh, n"),
    "mesh suffix": ("s.yaml", mesh("file: box.step"), r"box\.step: suffix '\.step'; reads \.obj, \.stl"),
    "mesh has nan": ("s.yaml", mesh("file: nan.obj"), r"nan\.obj: vertices: contains nan at index \(0, 2\); needs"),
    "mesh index": ("s.yaml", mesh("file: index.ply"), r"index\.ply: a face names vertex 9 of 3; needs indices"),
    "mesh scale of two": ("s.yaml", mesh("file: box.ply, scale: [1, 1]"), r"scale.*\(body 'cube'\): .*; "),
    "mesh is open": ("s.yaml", mesh("file: open.ply"), r"open\.ply: is not watertight.*; give mass=, com="),
    "inline fraction": ("s.yaml", mesh(f"{TETRA}, faces: [[0, 1, 2.5]]"), r"faces\[0\]\[2\] \(body 'cube'\): .*2\.5; "),
    "inline nan": ("s.yaml", mesh("vertices: [[0, 0, .nan]], faces: [[0, 0, 0]]"), r"vertices\[0\]\[2\] .*finite.* na"),
    "inline and file": ("s.yaml", mesh(f"file: box.ply, {TETRA}, faces: [[0, 1, 2]]"), r"'cube'\): needs either file"),
    "blocks without keys": ("s.json", '{"blocks": [{"name": "a"}]}', r"is not a block assembly: .*vertices.*; needs"),
    "block index": ("s.json", block(faces=[[0, 1, 99, 2]]), r"99.* size 4.*; needs"),
    "block fraction": ("s.json", block(faces=[[0, 1, 2.5]]), r"'a'.*2\.5.*; needs"),
    "block without faces": ("s.json", block(faces=[]), r"; needs"),
    "block fixed text": ("s.json", block(fixed="false"), r"'a'.*fixed.*'false'.*; "),
    "settled without keys": (
        "s.json",
        '{"format": "settled-scene/1"}',
        r"s.json: units: is not given \(and 1 more\); `holdfast schema settled` prints the format",
    ),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with good and bad meshes, also the working directory."""
    monkeypatch.chdir(tmp_path)
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.export("box.ply")
    trimesh.Trimesh(box.vertices, box.faces[1:], process=False).export("open.ply")
    for name, content in {
        "garbage.ply": BINARY,
        "empty.obj": b"",
        "points.obj": b"v 0 0 0\nv 1 0 0\n",
        "box.step": b"ISO-10303-21;",
        "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "index.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n",
    }.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


@pytest.fixture
def written(folder: Path, request: pytest.FixtureRequest) -> tuple[Path, str]:
    """The file of one case, and what its message must say."""
    name, content, match = FILES[request.param]
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path, match


@pytest.mark.parametrize("written", FILES, indirect=True, ids=lambda name: name.replace(" ", "_"))
def test_the_error_says_what_where_and_what_to_do(
    written: tuple[Path, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both from Python and at the command line, where a path is all the user gave: the message leads back to it."""
    path, match = written
    started = time.perf_counter()
    with pytest.raises(hf.HoldfastError) as caught:
        hf.load_scene(path)
    assert time.perf_counter() - started < 2
    said = str(caught.value)
    assert "\n" not in said
    assert len(said) < 600
    assert re.search(match, said), said
    named = {path.name, *(other.name for other in path.parent.iterdir()), "nope.stl"}
    assert any(name in said for name in named)
    monkeypatch.setattr(sys, "argv", ["holdfast", "assess", str(path)])
    with pytest.raises(SystemExit) as stopped:
        run()
    out, err = capsys.readouterr()
    assert (stopped.value.code, out, err[:7], err.count("\n")) == (2, "", "error: ", 1)
    assert not Path("HACKED").exists()


@pytest.mark.parametrize(("home", "limit", "name"), [(source, "MAX_YAML", "s.yaml"), (source, "MAX_BYTES", "s.json")])
def test_a_file_that_is_too_large_is_refused_unread(
    home: ModuleType, limit: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(home, limit, 1000)
    (tmp_path / name).write_text("x" * 1001)
    with pytest.raises(
        hf.errors.SceneError, match=rf"{name}: is 1,001 bytes; the limit is 1,000: keep meshes in files"
    ):
        hf.load_scene(tmp_path / name)


@pytest.mark.parametrize(("name", "match"), [("missing.yaml", "no such scene file"), (".", "is a folder")])
def test_a_scene_file_that_is_not_there(name: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(hf.errors.SceneError, match=f"{match}.*; check the path"):
        hf.load_scene(tmp_path / name)


def test_an_unhashable_key_is_not_called_repeated(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("? [a]\n: 1\n")
    with pytest.raises(hf.errors.SceneError, match=r"s\.yaml:1: ") as caught:
        hf.load_scene(tmp_path / "s.yaml")
    assert "twice" not in str(caught.value)
