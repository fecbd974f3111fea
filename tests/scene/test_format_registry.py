"""Formats behind one registry: a binary one added in one class, who reads a file, what is said where nobody does."""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.cli.main import run
from holdfast.plugins import Format, Source, register_format
from holdfast.scene.formats import source as formats_source
from holdfast.scene.formats.registry import is_scene

READABLE = r"can be read: .*holdfast scene \(\.yaml, \.yml, \.json.*\), block assembly \(\.json"


class Crates:
    """A binary format: magic, gravity, friction, count; for each box name, edges, position, mass, fixed or not."""

    MAGIC = b"\x89CRATES\0"
    HEAD = struct.Struct("<8s3ddI")
    CRATE = struct.Struct("<16s3d3dd?")

    @classmethod
    def sniff(cls, source: Source) -> bool:
        return source.head.startswith(cls.MAGIC)

    @classmethod
    def read(cls, source: Source, *, friction: float | None = None, heavier: float = 1.0) -> hf.Scene:
        _, *gravity, mu, count = cls.HEAD.unpack_from(source.content)
        bodies = []
        for row in cls.CRATE.iter_unpack(source.content[cls.HEAD.size :]):
            name, size, at, mass, fixed = row[0].rstrip(b"\0").decode(), row[1:4], row[4:7], row[7], row[8]
            pose = pose_from(np.array(at), np.array([1.0, 0, 0, 0]))
            bodies.append(hf.Body(name, hf.Box(np.array(size)), mass=mass * heavier, pose=pose, fixed=fixed))
        assert len(bodies) == count
        return hf.Scene(bodies, mu if friction is None else friction, gravity)

    @classmethod
    def write(cls, scene: hf.Scene, path: Path) -> bytes:
        rows = [cls.HEAD.pack(cls.MAGIC, *scene.gravity, scene.friction.default, len(scene.bodies))]
        for body in scene.bodies:
            if not isinstance(body.shape, hf.Box):
                raise hf.errors.SceneError(f"body {body.name!r}: is no box; needs boxes")
            row = (body.name.encode(), *body.shape.size, *body.pose[:3, 3], body.mass or 1.0, body.fixed)
            rows.append(cls.CRATE.pack(*row))
        return b"".join(rows)


@pytest.fixture
def register() -> Iterator[Callable[..., Callable[[], None]]]:
    """``register_format`` of what ``Format`` takes, for the time of one test."""
    registered: list[Callable[[], None]] = []

    def for_a_test(*arguments: Any, **options: Any) -> Callable[[], None]:
        registered.append(register_format(Format(*arguments, **options)))
        return registered[-1]

    yield for_a_test
    for take_back in registered:
        take_back()


@pytest.fixture
def crates(register: Any, tmp_path: Path) -> Path:
    """The toy format registered, and a scene in it."""
    register("crates", (".crt",), Crates.sniff, Crates.read, Crates.write)
    path = tmp_path / "table.crt"
    hf.save_scene(hf.shipped_scene("table"), path)
    return path


def assert_same(scene: hf.Scene, other: hf.Scene) -> None:
    assert scene.friction.default == other.friction.default
    assert scene.gravity.tobytes() == other.gravity.tobytes()
    for a, b in zip(scene.bodies, other.bodies, strict=True):
        assert (a.name, a.fixed) == (b.name, b.fixed)
        assert a.pose.tobytes() == b.pose.tobytes()
        assert a.shape.surface.vertices.tobytes() == b.shape.surface.vertices.tobytes()


def test_a_binary_format_comes_back_bit_for_bit(crates: Path) -> None:
    assert crates.read_bytes().startswith(Crates.MAGIC)
    assert_same(hf.shipped_scene("table"), hf.load_scene(crates))


@pytest.mark.parametrize("name", ["table.dat", "table", "table.yaml", "table.json", "TABLE.CRT"])
def test_it_is_told_by_its_content_under_any_name(name: str, crates: Path) -> None:
    crates.rename(crates.with_name(name))
    assert_same(hf.shipped_scene("table"), hf.load_scene(crates.with_name(name)))


def test_a_native_scene_is_told_by_its_content_under_a_binary_suffix(crates: Path, tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("table"), tmp_path / "copy.yaml")
    (tmp_path / "copy.yaml").replace(crates)
    assert_same(hf.shipped_scene("table"), hf.load_scene(crates))


def test_the_command_line_converts_both_ways(crates: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    native, back = crates.with_suffix(".yaml"), crates.with_name("back.crt")
    for source, target in ((crates, native), (native, back)):
        monkeypatch.setattr(sys, "argv", ["holdfast", "convert", str(source), str(target)])
        with pytest.raises(SystemExit) as stopped:
            run()
        assert not stopped.value.code
    assert_same(hf.shipped_scene("table"), hf.load_scene(native))
    assert back.read_bytes() == crates.read_bytes()


def test_a_format_that_is_taken_back_is_gone(register: Any, tmp_path: Path) -> None:
    take_back = register("crates", (".crt",), Crates.sniff, Crates.read, Crates.write)
    crates = tmp_path / "table.crt"
    hf.save_scene(hf.shipped_scene("table"), crates)
    take_back()
    take_back()
    with pytest.raises(hf.errors.SceneError, match="is in no known format"):
        hf.load_scene(crates)
    with pytest.raises(hf.errors.SceneError, match=r"suffix '\.crt'; can be written: "):
        hf.save_scene(hf.shipped_scene("table"), crates)


def test_options_reach_the_reader(crates: Path) -> None:
    scene = hf.load_scene(crates, friction=0.25, heavier=2.0)
    assert scene.friction.default == 0.25
    assert scene.body("slab").mass == 2 * hf.load_scene(crates).body("slab").mass


def test_an_unknown_option_is_named_beside_those_there_are(crates: Path) -> None:
    match = r"crt: option frictoin=: is unknown .*'crates'; did you mean friction=\? its options: friction=, heavier="
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.load_scene(crates, frictoin=0.5)


def test_a_format_without_options_says_so(tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("cube"), tmp_path / "cube.yaml")
    with pytest.raises(hf.errors.SceneError, match=r"friction=.* unknown to the format 'holdfast scene'; it has none"):
        hf.load_scene(tmp_path / "cube.yaml", friction=0.5)


def test_an_unknown_option_of_a_writer_leaves_the_file_as_it_was(crates: Path) -> None:
    before = crates.read_bytes()
    with pytest.raises(hf.errors.SceneError, match=r"table\.crt: option colour=: is unknown .*; it has none"):
        hf.save_scene(hf.shipped_scene("cube"), crates, colour="red")
    assert crates.read_bytes() == before


def test_a_writer_that_fails_leaves_the_file_as_it_was(crates: Path) -> None:
    before = crates.read_bytes()
    with pytest.raises(hf.errors.SceneError, match=r"table\.crt: body .* is no box"):
        hf.save_scene(hf.shipped_scene("arch"), crates)
    assert crates.read_bytes() == before
    assert [path.name for path in crates.parent.iterdir()] == [crates.name]


def named(name: str) -> Callable[[Source], hf.Scene]:
    """A reader whose scene says who read it."""
    return lambda _: hf.Scene(hf.shipped_scene("cube").bodies, 0.5, name=name)


def tagged(tag: str) -> Callable[[Source], bool]:
    """A sniffer for JSON with this tag."""
    return lambda source: isinstance(source.data, dict) and source.data.get("tag") == tag


def test_formats_that_share_a_suffix_are_told_apart_by_content(register: Any, tmp_path: Path) -> None:
    for name in ("red", "blue"):
        register(name, (".json",), tagged(name), named(name))
    for name in ("blue", "red"):
        (tmp_path / "s.json").write_text(json.dumps({"tag": name}))
        assert hf.load_scene(tmp_path / "s.json").name == name


def test_the_format_of_the_suffix_is_asked_first(register: Any, tmp_path: Path) -> None:
    for suffix in (".one", ".two"):
        register(suffix, (suffix,), lambda source: source.head == b"both", named(suffix))
    for suffix in (".two", ".one"):
        (tmp_path / f"s{suffix}").write_text("both")
        assert hf.load_scene(tmp_path / f"s{suffix}").name == suffix


def test_a_suffix_without_a_sniffer_decides_alone(register: Any, tmp_path: Path) -> None:
    register("plain", (".plain",), None, named("plain"))
    (tmp_path / "s.plain").write_text("anything")
    assert hf.load_scene(tmp_path / "s.plain").name == "plain"


def test_a_file_is_parsed_once_however_many_formats_look_at_it(
    register: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    parse = formats_source.from_json
    monkeypatch.setattr(formats_source, "from_json", lambda *arguments: (calls.append(arguments), parse(*arguments))[1])
    for tag in "abc":
        register(tag, (".json",), tagged(tag), named(tag))
    for content in ('{"tag": "c"}', '{"tag": "d"}', "{"):
        (tmp_path / "s.json").write_text(content)
        calls.clear()
        try:
            hf.load_scene(tmp_path / "s.json")
        except hf.errors.SceneError:
            assert content != '{"tag": "c"}'
        assert len(calls) == 1


@pytest.mark.parametrize(
    ("name", "content", "seen"),
    [
        ("s.bin", b"\x89PNG\r\n\x1a\n" + bytes(99), r"first bytes b'\\x89PNG.*"),
        ("s", b"\xff\xfe" + "wide".encode("utf-16-le"), r"first bytes b'\\xff\\xfew.*"),
        ("s.stlx", b"solid thing\n", r"first bytes b'solid thing.*"),
        ("s.xml", b"<html/>", "first bytes b'<html/>'"),
        ("s.txt", b"", "empty"),
        ("s.json", b"{}", "only {}"),
        ("s.json", b'{"a": 1, "b": 2, "c": 3, "d": 4}', "no `format` among its keys 'a', 'b', 'c' and 1 more"),
        ("s.json", b'{"format": "toy/1"}', "`format` is 'toy/1'"),
        ("s.json", b"[1, 2]", r"only \[1, 2\]"),
        ("s.yaml", b"7\n", "only 7"),
    ],
)
def test_a_file_that_nobody_can_read_is_told_what_can_be_read(
    name: str, content: bytes, seen: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(hf.errors.SceneError, match=rf"{name}: is in no known format \({seen}\); {READABLE}") as caught:
        hf.load_scene(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_a_format_that_is_only_written_is_not_promised_to_readers(register: Any, tmp_path: Path) -> None:
    register("postcards", (".card",), write=lambda scene, path: b"wish you were here")
    hf.save_scene(hf.shipped_scene("cube"), tmp_path / "s.card")
    with pytest.raises(hf.errors.SceneError, match=r"; postcards can be written, not read; can be read: ") as caught:
        hf.load_scene(tmp_path / "s.card")
    assert ".card:" not in str(caught.value).partition("can be read")[2]


def test_a_format_that_is_only_read_is_not_promised_to_writers(register: Any, tmp_path: Path) -> None:
    register("fossils", (".fossil",), None, named("fossil"))
    match = r"suffix '\.fossil' \(fossils can be read, not written\); can be written: holdfast scene \(\.yaml, .*\)$"
    with pytest.raises(hf.errors.SceneError, match=match):
        hf.save_scene(hf.shipped_scene("cube"), tmp_path / "s.fossil")
    assert not any(tmp_path.iterdir())


def test_a_missing_extra_is_named_with_the_way_to_get_it(register: Any, tmp_path: Path) -> None:
    def read(source: Source) -> hf.Scene:
        import no_such_package  # type: ignore[import-not-found]

        return no_such_package.scene(source.path)

    register("exotic", (".exo",), None, read, extra="exotic")
    (tmp_path / "s.exo").write_text("")
    match = r"'exotic': needs no_such_package, which is not installed; pip install 'holdfast-robotics\[exotic\]'"
    with pytest.raises(hf.HoldfastError, match=match):
        hf.load_scene(tmp_path / "s.exo")


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"name": "holdfast scene"}, "format: there is one named 'holdfast scene'; give it another name"),
        ({"suffixes": ("toy",)}, r"'toy': suffix 'toy'; needs a dot"),
        ({"suffixes": (".TOY",)}, r"'toy': suffix '\.TOY'; needs a dot and small letters"),
        ({"read": None}, "'toy': neither reads nor writes; give"),
        ({"suffixes": ()}, "'toy': no file would be in it; give"),
    ],
)
def test_a_format_that_makes_no_sense_is_refused(register: Any, arguments: dict[str, Any], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        register(**{"name": "toy", "suffixes": (".toy",), "read": named("toy"), **arguments})


@pytest.mark.parametrize(
    ("name", "text", "scene"),
    [
        ("a.yaml", "format: holdfast-scene/1\nbodies: []\n", True),
        ("a.yaml", "format: holdfast-scene/9\n", True),
        ("a.json", '{"format": "holdfast-scene/1", ', True),  # damaged
        ("a.yml", "directives: []\n", True),
        ("a.yml", "on: &x push\njobs: *x\n", False),
        ("a.yaml", "{{ if .Values }}: [\n", False),
        ("a.json", "{}", False),
        ("a.json", "", False),
        ("a.xml", "<mujoco model='m'><worldbody/></mujoco>", True),
        ("a.xml", "<mujocoinclude/>", False),
        ("a.xml", "<package/>", False),
        ("a.urdf", "<package/>", True),
        ("a.usda", "", True),
        ("none.yaml", None, True),
    ],
)
def test_files_of_other_programs_are_no_scenes(tmp_path: Path, name: str, text: str | None, scene: bool) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    assert is_scene(tmp_path / name) == scene
