"""MJCF files that are broken, or ask for more than a scene: one clear error each, and nothing outside is read."""

from __future__ import annotations

import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from scene_content import read_scene

import holdfast as hf
from holdfast.scene.formats.mjcf.reader import sniff
from holdfast.scene.formats.source import Source
from holdfast.scene.xml import root_name

pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")

BODY = '<body name="a" pos="0 0 .1"><freejoint/><geom {}/></body>'
BOX = 'type="box" size=".1 .1 .1"'
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
WORLD = f'<worldbody><geom name="floor" type="plane" size="1 1 1"/>{BODY.format(BOX)}</worldbody>'
MESH = BODY.format('type="mesh" mesh="m"')
MESHED = f'<worldbody><geom type="plane" size="1 1 1"/>{MESH}</worldbody>'
MANY = f'<replicate count="1000"><replicate count="1000">{MESH}</replicate></replicate>'


def whole(content: str) -> str:
    return f"<mujoco>{content}</mujoco>"


def load(content: str, folder: Path, **options: Any) -> hf.Scene:
    (folder / "scene.xml").write_text(content, encoding="utf-8")
    return hf.load_scene(folder / "scene.xml", **options)


@pytest.mark.parametrize(
    ("content", "yes"),
    [
        ("<mujoco/>", True),
        ("\ufeff<?xml version='1.0'?>\n<!-- <robot/> --><!-- two -->\n <mujoco model='x'>", True),
        ("<!DOCTYPE mujoco [<!ENTITY a 'b'>]><mujoco/>", True),
        ("<robot><mujoco/></robot>", False),
        ("<!-- <mujoco/> --><sdf version='1.6'/>", False),
        ("<mujocoinclude/>", False),
        ("<!-- <mujoco/>", False),
        ("mujoco", False),
        ("", False),
    ],
)
def test_a_model_is_told_by_its_root(content: str, yes: bool) -> None:
    source = Source(Path("scene.xml"), content.encode())
    assert sniff(source) is yes
    assert (root_name(content.lstrip("\ufeff")) == "mujoco") is yes


LAUGHS = '<!DOCTYPE mujoco [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]>' + whole("<!-- &b; -->" + WORLD)
OUTSIDE = '<!DOCTYPE mujoco SYSTEM "/etc/passwd">' + whole(WORLD)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (LAUGHS, r"scene\.xml: line 1 declares a DOCTYPE; document types and entities are not read"),
        (OUTSIDE, r"declares a DOCTYPE"),
        (whole(WORLD) + "<mujoco/>", r"is not well-formed XML: junk after document element: line 1"),
        ("<mujoco><worldbody>", r"is not well-formed XML: no element found"),
        (whole("<worldbody><geom/></worldbody>"), r"MuJoCo refuses it: .*size 0 must be positive in geom"),
        (whole("<worldbod/>"), r"MuJoCo refuses it: .*worldbod"),
        (whole(WORLD.replace("0 0 .1", "0 nan .1")), r"scene\.xml: body 'a': .*nan"),
        (whole(WORLD.replace(".1 .1 .1", "1e9 1e9 1e9")), r"scene\.xml: body 'a'"),
        (whole("<worldbody/>"), r"scene: has no bodies"),
        (whole(f"<worldbody>{BODY.format(BOX)}</worldbody>"), r"none of its 1 bodies is fixed"),
        (whole("<body>" * 2000 + "</body>" * 2000), r"is nested too deeply; the limit is 200 levels"),
        (whole('<size nuserdata="999999999"/>' + WORLD), r"size nuserdata: is '999999999'; the limit is"),
        (
            whole(f"<worldbody>{MANY}</worldbody>"),
            r"has more than 100,000 elements with all copies of its <replicate>",
        ),
        (whole('<custom><numeric name="n" size="999999999"/></custom>' + WORLD), r"numeric size: is '999999999'"),
        (whole('<extension><plugin plugin="no.such.plugin"/></extension>' + WORLD), r"MuJoCo refuses it"),
    ],
)  # fmt: skip
def test_a_hostile_or_broken_model_is_one_clear_error(content: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(content, tmp_path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "size", ['nstack="2000000000" njmax="2000000000" nconmax="2000000000"', 'memory="999999T"', 'memory="64"']
)
def test_room_for_the_solver_is_not_taken(size: str, tmp_path: Path) -> None:
    for scene in (
        load(whole(f"<size {size}/>{WORLD}"), tmp_path),
        read_scene(whole(f"<size {size}/>{WORLD}").encode(), "w.xml"),
    ):
        assert [body.name for body in scene.movable] == ["a"]


def test_contacts_of_thousands_of_geoms_have_room(tmp_path: Path) -> None:
    wall = f'<replicate count="2500" offset="0 0 0.01"><geom {BOX}/></replicate>'
    assert len(load(whole(f'<size memory="1M"/><worldbody>{wall}</worldbody>'), tmp_path).bodies) == 2500


def attaching(*files: str) -> str:
    models = "".join(f'<model name="m{k}" file="{file}"/>' for k, file in enumerate(files))
    there = "".join(f'<attach model="m{k}" body="b" prefix="p{k}"/>' for k in range(len(files)))
    return whole(
        f'<asset>{models}</asset><worldbody>{there}<geom {BOX}/><body name="b"><geom {BOX}/></body></worldbody>'
    )


@pytest.mark.parametrize("circle", [["scene.xml"], ["1.xml", "scene.xml"], ["1.xml", "2.xml", "1.xml"]])
def test_a_model_that_attaches_itself_is_told(circle: list[str], tmp_path: Path) -> None:
    """MuJoCo follows it until the process dies of it."""
    for here, there in pairwise(circle):
        (tmp_path / here).write_text(attaching(there))
    with pytest.raises(hf.errors.SceneError, match=r"model file '.*\.xml': attaches a model to itself"):
        load(attaching(circle[0]), tmp_path)


def test_a_model_that_includes_what_attaches_it_is_told(tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(whole('<asset><model name="m" file="scene.xml"/></asset>'))
    with pytest.raises(hf.errors.SceneError, match="attaches a model to itself"):
        load(whole('<include file="in.xml"/><worldbody><attach model="m" body="b" prefix="p"/></worldbody>'), tmp_path)


def test_models_that_double_by_attaching_are_counted(tmp_path: Path) -> None:
    """Nineteen models, each of which attaches the next one twice: half a million bodies, from 4 kB."""
    for k in range(18):
        (tmp_path / f"{k}.xml").write_text(attaching(f"{k + 1}.xml", f"{k + 1}.xml"))
    (tmp_path / "18.xml").write_text(whole(f'<worldbody><body name="b"><geom {BOX}/></body></worldbody>'))
    with pytest.raises(hf.errors.SceneError, match="has more than 100,000 elements with all copies"):
        load(attaching("0.xml", "0.xml"), tmp_path)
    (tmp_path / "2.xml").write_text((tmp_path / "18.xml").read_text())
    assert load(whole(f'<asset><model name="m" file="0.xml"/></asset>{WORLD}'), tmp_path).body("a").fixed is False
    for k in range(30):
        (tmp_path / f"{k}.xml").write_text(attaching(f"{k + 1}.xml"))
    with pytest.raises(hf.errors.SceneError, match="is attached more than 20 levels deep"):
        load(attaching("0.xml"), tmp_path)


def test_files_of_attached_models_stay_inside(folder: Path) -> None:
    (folder / "parts" / "child.xml").write_text(mesh("t.obj"))
    content = attaching("parts/child.xml").replace('body="b"', 'body="a"')
    assert load(content, folder).bodies
    (folder / "parts" / "child.xml").write_text(mesh("../../beside/t.obj"))
    with pytest.raises(hf.errors.SceneError, match=r"leads to .*, outside"):
        load(content, folder)


@pytest.mark.parametrize(
    ("asset", "match"),
    [
        ('<hfield name="h" nrow="4096" ncol="4096" size="1 1 1 1"/>', "300,000 cells of heightfields"),
        (3 * '<hfield nrow="400" ncol="400" size="1 1 1 1"/>', "300,000 cells of heightfields"),
        ('<hfield name="h" file="large.png" size="1 1 1 1"/>', "300,000 cells of heightfields"),
        ('<hfield name="h" file="large.bin" size="1 1 1 1"/>', "300,000 cells of heightfields"),
    ],
)
def test_what_few_bytes_would_fill_is_refused_before_it_is(asset: str, match: str, tmp_path: Path) -> None:
    sizes = (30_000).to_bytes(4, "big") * 2
    (tmp_path / "large.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + sizes + b"\x08\2\0\0\0")
    (tmp_path / "large.bin").write_bytes((30_000).to_bytes(4, "little") * 2 + b"\0" * 40)
    with pytest.raises(hf.errors.SceneError, match=rf"has more than {match}"):
        load(whole(f"<asset>{asset}</asset>{WORLD}"), tmp_path)


@pytest.mark.parametrize(
    "asset",
    [
        '<texture name="t" builtin="flat" width="16384" height="1"/>',
        '<texture name="t" type="2d" builtin="flat" width="99999" height="99999"/>',
        '<texture name="t" type="2d" file="/etc/passwd"/>',
        '<texture type="cube" name="t" fileright="../x.png"/>',
        '<texture type="2d" name="t" file="http://example.org/t.png"/>',
        '<skin name="s" file="../s.skn"/>',
    ],
)
def test_what_only_looks_is_neither_made_nor_opened(asset: str, tmp_path: Path) -> None:
    content = whole(f"<asset>{asset}</asset>{WORLD}")
    for scene in (load(content, tmp_path), read_scene(content.encode(), "w.xml")):
        assert scene.bodies == load(whole(WORLD), tmp_path).bodies
        assert scene.notes == ()


def mesh(file: str, compiler: str = "") -> str:
    return whole(f'{compiler}<asset><mesh name="m" file="{file}"/></asset>{MESHED}')


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of a model, with files in it, below it and beside it."""
    for place in ("model/parts", "model/..meshes", "beside"):
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "t.obj").write_text(TETRAHEDRON)
    (tmp_path / "model" / "t.obj").write_text(TETRAHEDRON)
    (tmp_path / "model" / "link.obj").symlink_to(tmp_path / "beside" / "t.obj")
    return tmp_path / "model"


@pytest.mark.parametrize(
    "content",
    [
        mesh("t.obj"),
        mesh("./t.obj"),
        mesh("parts/t.obj"),
        mesh("parts/../t.obj"),
        mesh("..meshes/t.obj"),
        mesh("t.obj", '<compiler meshdir="parts"/>'),
        mesh("t.obj", '<compiler assetdir="parts" meshdir="parts"/>'),
        mesh("elsewhere/t.obj", '<compiler strippath="true"/>'),
    ],
)
def test_files_below_the_folder_are_read(content: str, folder: Path) -> None:
    scene = load(content, folder)
    assert scene.body("a").shape.mass_properties.volume == pytest.approx(1 / 6, rel=1e-6)


@pytest.mark.parametrize(
    "content",
    [
        mesh("../beside/t.obj"),
        mesh("link.obj"),
        mesh("parts/../../beside/t.obj"),
        mesh("t.obj", '<compiler meshdir="../beside"/>'),
        mesh("t.obj", '<compiler assetdir="/etc"/>'),
        mesh("/etc/passwd"),
        whole(f'<include file="../beside/t.obj"/>{WORLD}'),
        whole(f'<asset><hfield name="h" file="../../h.png"/></asset>{WORLD}'),
    ],
)
def test_files_outside_the_folder_are_not_read(content: str, folder: Path) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"file .*: leads to .*, outside .*; say within= a folder"):
        load(content, folder)


def test_a_wider_folder_may_be_allowed(folder: Path) -> None:
    scene = load(mesh("t.obj", '<compiler meshdir="../beside"/>'), folder, within=folder.parent)
    assert scene.body("a").shape.mass_properties.volume == pytest.approx(1 / 6, rel=1e-6)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (mesh("no.obj"), r"mesh file 'no\.obj': is not in .*model'; give it beside the model"),
        (mesh("http://x.org/t.obj"), r"mesh file 'http://x\.org/t\.obj': is no path; name a file beside the model"),
        (mesh("parts"), r"is a folder, not a mesh file"),
        (mesh("broken.obj"), r"MuJoCo refuses it"),
        (mesh("broken.stl"), r"MuJoCo refuses it"),
        (whole('<include file="a.xml"/>'), r"include file 'a\.xml': is not in"),
        (whole('<include file="bomb.xml"/>' + WORLD), r"bomb\.xml: line 1 declares a DOCTYPE"),
        (whole('<include file="self.xml"/>' + WORLD), r"MuJoCo refuses it"),
    ],
)
def test_files_that_are_missing_or_broken_are_one_clear_error(content: str, match: str, folder: Path) -> None:
    (folder / "broken.obj").write_text("v 0 0\nf 1 2 99\n")
    (folder / "broken.stl").write_bytes(b"\xff" * 200)
    (folder / "bomb.xml").write_text(LAUGHS)
    (folder / "self.xml").write_text('<mujocoinclude><include file="self.xml"/></mujocoinclude>')
    with pytest.raises(hf.errors.SceneError, match=match) as caught:
        load(content, folder)
    assert "\n" not in str(caught.value)


def test_a_named_pipe_is_not_opened(folder: Path) -> None:
    os.mkfifo(folder / "pipe.obj")
    with pytest.raises(hf.errors.SceneError, match="is a named pipe"):
        load(mesh("pipe.obj"), folder)


def test_included_files_may_name_files(folder: Path) -> None:
    (folder / "more.xml").write_text(
        '<mujocoinclude><asset><mesh name="m" file="parts/t.obj"/></asset></mujocoinclude>'
    )
    assert load(whole(f'<include file="more.xml"/>{MESHED}'), folder).body("a").mass is not None


def test_what_stands_in_the_current_folder_is_not_taken(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are relative to the model, though MuJoCo would look where it was started."""
    (folder.parent / "only.obj").write_text(TETRAHEDRON)
    monkeypatch.chdir(folder.parent)
    with pytest.raises(hf.errors.SceneError, match=r"'only\.obj': is not in"):
        load(mesh("only.obj"), folder)


def test_a_model_from_a_stream_needs_no_file() -> None:
    assert read_scene(whole(WORLD).encode(), "-").body("a").mass == pytest.approx(8)


def test_a_model_from_a_stream_may_name_files(folder: Path) -> None:
    content = mesh("t.obj", '<compiler meshdir="parts"/>').encode()
    assert read_scene(content, folder / "scene.xml").body("a").mass is not None


def test_warnings_of_mujoco_are_notes_and_leave_no_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A light at no place has no bearing on the scene, but MuJoCo would write a log where it was started."""
    (folder / "here").mkdir()
    monkeypatch.chdir(folder / "here")
    scene = load(whole(WORLD.replace("<worldbody>", '<worldbody><light pos="0 0 nan"/>')), folder)
    assert scene.notes == ("MuJoCo warns: XML contains a 'NaN'. Please check it carefully.",)
    assert not any((folder / "here").iterdir())
