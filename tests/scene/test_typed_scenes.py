"""Scene files as people mistype them, and as others forge them (findings U6, D5, D15, D23)."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
from scene_content import read_scene

import holdfast as hf
from holdfast.scene.formats import source

HEAD = "format: holdfast-scene/1\nfriction: {friction}\nbodies:\n"
FLOOR = "  - {name: floor, shape: {type: box, size: [1, 1, 0.1]}, fixed: true}\n"


def yaml(body: str = "", friction: str = "0.5", end: str = "") -> str:
    return HEAD.replace("{friction}", friction) + FLOOR + (f"  - {body}\n" if body else "") + end


def cylinder(shape: str = "radius: 0.1, height: 0.2", rest: str = "mass: 1") -> str:
    return yaml(f"{{name: c, shape: {{type: cylinder, {shape}}}, {rest}}}")


def load(content: str) -> hf.Scene:
    return read_scene(content.encode(), "s.yaml")


MISTYPED: dict[str, tuple[str, str]] = {
    "radus": (cylinder("radus: 1, height: 1"), r"shape\.radus \(body 'c'\): unknown key.*; did you mean 'radius'\?"),
    "hieght": (cylinder("radius: 1, hieght: 1"), r"shape\.hieght .*; did you mean 'height'\?"),
    "weight": (cylinder(rest="weight: 1"), r"bodies\[1\]\.weight .*; did you mean 'mass'\?"),
    "materil": (cylinder(rest="mass: 1, materil: oak"), r"bodies\[1\]\.materil .*; did you mean 'material'\?"),
    "Mass": (cylinder(rest="Mass: 1"), r"did you mean 'mass'\?"),
    "quaternion": (cylinder(rest="mass: 1, quaternion: [1, 0, 0, 0]"), r"did you mean 'orientation'\?"),
    "size of a cylinder": (cylinder("radius: 1, height: 1, size: 2"), r"shape\.size .*unknown key; `holdfast schema`"),
    "length of a cylinder": (cylinder("radius: 1, length: 1"), r"shape\.length .*did you mean 'height'\?"),
    "gravty": (yaml(end="gravty: [0, 0, -9.81]\n"), r"gravty: unknown key; did you mean 'gravity'\?"),
    "deflt": (yaml(friction="{deflt: 1}"), r"friction\.deflt: unknown key; did you mean 'default'\?"),
    "muu": (yaml(friction="{default: 1, pairs: [{between: [a, b], muu: 1}]}"), r"pairs\[0\]\.muu: .*mean 'mu'\?"),
    "cilinder": (yaml("{name: c, shape: {type: cilinder}, mass: 1}"), r"type is 'cilinder'.*did you mean 'cylinder'\?"),
    "no type": (yaml("{name: c, shape: {radius: 1}, mass: 1}"), r"shape .*has no type, needs one of 'box', 'cylinder'"),
    "type is a list": (yaml("{name: c, shape: {type: [box]}, mass: 1}"), r"shape .*type is \['box'\]"),
    "height of a capsule": (
        yaml("{name: c, shape: {type: capsule, radius: 1, height: 1}, mass: 1}"),
        r"shape\.height .*did you mean 'length'\?",
    ),
    "siz of a part": (
        yaml("{name: c, shape: {type: compound, parts: [{shape: {type: box, siz: 1}}]}, mass: 1}"),
        r"bodies\[1\]\.shape\.parts\[0\]\.shape\.siz \(body 'c'\): .*did you mean 'size'\?",
    ),
    "poze of a part": (
        yaml("{name: c, shape: {type: compound, parts: [{poze: 1, shape: {type: sphere, radius: 1}}]}, mass: 1}"),
        r"parts\[0\]\.poze .*did you mean 'pose'\?",
    ),
    "elipsoid": (
        yaml("{name: c, shape: {type: elipsoid, radii: [1, 1, 1]}, mass: 1}"),
        r"bodies\[1\]\.shape \(body 'c'\): type is 'elipsoid', needs one of .*'compound'; did you mean 'ellipsoid'\?",
    ),
    "friction of a body": (yaml("{name: c, friction: 1}"), r"friction \(body 'c'\): unknown key.*; `holdfast schema`"),
    "shape is a text": (yaml("{name: c, shape: box, mass: 1}"), r"shape .*needs keys and values, got 'box'"),
}


WRONG: dict[str, tuple[str, str]] = {
    "mass is a text": (cylinder(rest="mass: '3'"), r"mass \(body 'c'\): needs a number, got '3'"),
    "mass is a truth value": (cylinder(rest="mass: yes"), r"mass .*needs a number, got True"),
    "mass by sixties": (cylinder(rest="mass: 1:30"), r"mass .*needs a number, got '1:30'"),
    "mass by eights": (cylinder(rest="mass: 010"), r"mass .*needs a number, got '010'"),
    "radius is a text": (cylinder("radius: '0.1', height: 1"), r"radius .*needs a number, got '0\.1'"),
    "segments is a text": (cylinder("radius: 1, height: 1, segments: '6'"), r"segments .*needs a number, got '6'"),
    "segments is a part": (cylinder("radius: 1, height: 1, segments: 6.5"), r"segments .*6\.5"),
    "fixed is a text": (cylinder(rest="mass: 1, fixed: 'no'"), r"fixed .*needs true or false, got 'no'"),
    "fixed is a number": (cylinder(rest="mass: 1, fixed: 0"), r"fixed .*needs true or false, got 0"),
    "name is a number": (yaml("{name: 3, shape: {type: sphere, radius: 1}, mass: 1}"), r"name .*got 3"),
    "friction is a text": (yaml(friction="high"), r"s\.yaml: friction: needs a number, got 'high'; "),
    "scale is a text": (
        yaml("{name: c, shape: {type: mesh, file: a.stl, scale: '1'}, mass: 1}"),
        r"shape\.scale \(body 'c'\): needs a number, got '1'",
    ),
    "mu is a text": (
        yaml(friction="{default: 1, values: {floor: '1'}, combine: max}"),
        r"values: needs a number for 'floor', got '1'",
    ),
    "orientation overflows": (cylinder(rest="mass: 1, orientation: [1.0e+300, 1.0e+300, 0, 0]"), r"has length 1\.4"),
    "key is a number": (yaml("{1: 2}"), r"s\.yaml:5: .*key 1 is no text: put it in quotes"),
    "key is a truth value": (yaml("{yes: 2}"), r"key True is no text"),
}


@pytest.mark.parametrize("name", MISTYPED | WRONG)
def test_u6_mistyped_keys_are_told_with_what_was_meant_and_wrong_types_are_refused(name: str) -> None:
    content, match = (MISTYPED | WRONG)[name]
    with pytest.raises(hf.errors.SceneError, match=match):
        load(content)


@pytest.mark.parametrize(("written", "value"), [("1e-1", 0.1), (".1", 0.1), ("+1", 1), ("1.", 1), ("2.5e0", 2.5)])
def test_numbers_may_be_written_as_in_json_and_more(written: str, value: float) -> None:
    assert load(cylinder(rest=f"mass: {written}")).body("c").mass == value


def test_d15_a_lone_surrogate_in_a_name_is_told() -> None:
    floor = {"name": "a\ud800b", "shape": {"type": "box", "size": [1, 1, 1]}, "fixed": True}
    content = json.dumps({"format": "holdfast-scene/1", "friction": 0.5, "bodies": [floor]})
    with pytest.raises(hf.errors.SceneError, match=r"name: is 'a\\ud800b'; needs a text without lone surrogates"):
        read_scene(content.encode(), "s.json")


@pytest.mark.parametrize("name", ["s.yaml", "s.json", "-"])
def test_d23_a_byte_order_mark_is_no_content_whatever_the_name(name: str) -> None:
    floor = {"name": "floor", "shape": {"type": "box", "size": [1, 1, 1]}, "fixed": True}
    content = json.dumps({"format": "holdfast-scene/1", "friction": 0.5, "bodies": [floor]})
    assert len(read_scene(b"\xef\xbb\xbf" + content.encode(), name).bodies) == 1


# Two sizes: what takes twice as long for twice as much is linear, and what is quadratic takes four times as long
KEYS = {
    "json": lambda n: json.dumps({f"k{i}": 1 for i in range(n)}),
    "yaml": lambda n: "".join(f"k{i}: 1\n" for i in range(n)),
    "numbers that collide": lambda n: "".join(f"{i * (2**61 - 1)}: 1\n" for i in range(1, n)),
    "bodies": lambda n: json.dumps(
        {
            "format": "holdfast-scene/1",
            "friction": 0.5,
            "bodies": [{"name": f"b{i}", "shape": {"type": "box", "size": [1, 1, 1]}, "fixed": True} for i in range(n)],
        }
    ),
}


@pytest.mark.parametrize("kind", KEYS)
def test_d5_many_keys_take_linear_time(kind: str) -> None:
    """60,000 keys took minutes: a quadratic check compares 1.8e9 pairs, which no machine does in the time allowed."""
    started = time.process_time()
    name = "s.json" if KEYS[kind](2)[0] == "{" else "s.yaml"
    if kind == "bodies":
        assert len(read_scene(KEYS[kind](20_000).encode(), name).bodies) == 20_000
    else:
        with pytest.raises(hf.errors.SceneError):
            read_scene(KEYS[kind](60_000).encode(), name)
    assert time.process_time() - started < 40


def test_d5_a_file_of_many_faults_is_told_by_its_first() -> None:
    """Millions of faults would take more memory than the file by far."""
    many = ", ".join(["7"] * 1000)
    with pytest.raises(hf.errors.SceneError, match=r"bodies\[0\]: needs keys and values, got 7; "):
        load(f"format: holdfast-scene/1\nfriction: 0.5\nbodies: [{many}]\n")
    with pytest.raises(hf.errors.SceneError, match=r"scene: has 1,002 keys; 'k0' and others are unknown; "):
        load("format: holdfast-scene/1\nbodies: []\n" + "".join(f"k{k}: 1\n" for k in range(1000)))
    mesh = "{type: mesh, vertices: [" + ", ".join(["[0, 0, x]"] * 1000) + "], faces: [[0, 1, 2]]}"
    with pytest.raises(hf.errors.SceneError, match=r"vertices\[0\]\[2\] \(body 'm'\): needs a number, got 'x'; "):
        load(yaml(f"{{name: m, shape: {mesh}, mass: 1}}"))


def test_d5_a_key_that_stands_twice_among_many_is_found() -> None:
    keys = [*range(20_000), 777]
    with pytest.raises(hf.errors.SceneError, match="key 'k777' twice"):
        load("".join(f"k{i}: 1\n" for i in keys))


@pytest.mark.parametrize("suffix", [".json", ".yaml"])
@pytest.mark.parametrize("depth", [41, 900, 100_000])
def test_deep_files_are_refused_alike(suffix: str, depth: int) -> None:
    for opening, closing in (("[", "]"), ('{"a":', "}")):
        content = opening * depth + "1" + closing * depth
        with pytest.raises(hf.errors.SceneError, match="is nested too deeply; the limit is 40 levels"):
            read_scene(content.encode(), f"s{suffix}")


@pytest.mark.parametrize("suffix", [".json", ".yaml"])
def test_the_deepest_file_that_is_read(suffix: str) -> None:
    content = '{"a":' + "[" * 39 + "1" + "]" * 39 + "}"
    with pytest.raises(hf.errors.SceneError, match="is in no known format"):
        read_scene(content.encode(), f"s{suffix}")


def test_a_json_file_has_a_limit_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "MAX_JSON_BYTES", 100)
    with pytest.raises(hf.errors.SceneError, match="is 101 bytes; the limit is 100: keep meshes in files of their own"):
        read_scene(b"[" + b" " * 99 + b"]", "s.json")


def test_a_scene_from_a_stream_finds_its_meshes_beside_its_name(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    content = yaml("{name: t, shape: {type: mesh, file: t.obj}, mass: 1}")
    assert len(read_scene(content.encode(), tmp_path / "stream").body("t").shape.faces) == 4
