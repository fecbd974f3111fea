"""The native scene file: nothing is lost on the way out and in."""

from __future__ import annotations

import json
import os
import shutil
import stat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.formats.native import schema
from holdfast.scene.shipped import shipped_scene, shipped_scenes

SUFFIXES = (".yaml", ".json")
COLUMN = trimesh.creation.cylinder(0.1, 0.3, sections=9)


def assert_same(first: hf.Scene, second: hf.Scene) -> None:
    """Bit for bit."""
    assert second.name == first.name
    assert second.friction == first.friction
    assert second.gravity.tobytes() == first.gravity.tobytes()
    assert len(second.bodies) == len(first.bodies)
    for a, b in zip(first.bodies, second.bodies, strict=True):
        assert (b.name, b.mass, b.density, b.material, b.fixed) == (a.name, a.mass, a.density, a.material, a.fixed)
        assert b.pose.tobytes() == a.pose.tobytes()
        assert (b.com is None) == (a.com is None)
        assert a.com is None or b.com.tobytes() == a.com.tobytes()
        assert (b.inertia is None) == (a.inertia is None)
        assert a.inertia is None or b.inertia.tobytes() == a.inertia.tobytes()
        assert type(b.shape) is type(a.shape)
        assert b.shape.surface.vertices.tobytes() == a.shape.surface.vertices.tobytes()
        assert b.shape.surface.faces.tobytes() == a.shape.surface.faces.tobytes()


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_come_back_bit_for_bit(name: str, suffix: str, tmp_path: Path) -> None:
    scene = shipped_scene(name)
    path = tmp_path / f"scene{suffix}"
    hf.save_scene(scene, path)
    assert_same(scene, hf.load_scene(path))


NAMES = st.one_of(
    st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), min_size=1, max_size=8).filter(str.strip),
    st.sampled_from(
        [
            *("yes", "null", "1", "1e3", "0x1", "~", "- a", "a: b", "#", "'", '"', "2020-01-01", "=", "<<", "é∞"),
            *("010", "1:30", ".5", "1_000"),
        ]
    ),
)
LENGTHS = st.floats(1e-6, 1e6)
NUMBERS = st.floats(-1e6, 1e6)


@st.composite
def poses(draw: st.DrawFn) -> np.ndarray:
    quaternion = draw(arrays(float, 4, elements=st.floats(-1, 1)))
    if np.linalg.norm(quaternion) < 0.1:
        quaternion = np.array([1.0, 0, 0, 0])
    return pose_from(draw(arrays(float, 3, elements=NUMBERS)), quaternion)


@st.composite
def bodies(draw: st.DrawFn, name: str) -> hf.Body:
    known = draw(st.sampled_from(["mass", "density"]))
    lengths = LENGTHS if known == "mass" else st.floats(0.1, 1e2)  # so that the mass is in its range, too
    shape: Any = draw(
        st.one_of(
            st.builds(hf.Box, arrays(float, 3, elements=lengths)),
            st.builds(hf.Cylinder, lengths, lengths, st.integers(3, 40)),
            st.builds(hf.Sphere, lengths, st.integers(0, 2)),
            st.builds(lambda s: hf.Mesh(COLUMN.vertices * max(s, 1e-4), COLUMN.faces), lengths),
        )
    )
    return hf.Body(
        name,
        shape,
        **draw(st.fixed_dictionaries({known: lengths})),
        pose=draw(poses()),
        com=draw(st.none() | arrays(float, 3, elements=NUMBERS)),
        inertia=draw(st.none() | LENGTHS.map(lambda s: s * np.diag([1.0, 1.1, 1.3]))),
        material=draw(st.sampled_from([None, "wood", "yes"])),
        fixed=draw(st.booleans()),
    )


@st.composite
def scenes(draw: st.DrawFn) -> hf.Scene:
    names = draw(st.lists(NAMES, min_size=2, max_size=4, unique=True))
    made = [draw(bodies(name)) for name in names]
    made.append(hf.Body("".join(names) + "!", hf.Box((1, 1, 1)), fixed=True))
    mu = st.floats(0, 2)
    friction = hf.Friction(
        draw(st.none() | mu),
        {(names[0], names[1]): draw(mu)} if draw(st.booleans()) else {},
        draw(st.dictionaries(st.sampled_from(names), mu)),
        draw(st.sampled_from(["max", "min", "product"])),
    )
    return hf.Scene(made, friction, (draw(NUMBERS), draw(NUMBERS), -9.81), draw(st.just("") | NAMES))


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)
@given(scene=scenes())
def test_any_scene_comes_back_bit_for_bit(suffix: str, tmp_path: Path, scene: hf.Scene) -> None:
    path = tmp_path / f"scene{suffix}"
    hf.save_scene(scene, path)
    assert_same(scene, hf.load_scene(path))


@pytest.mark.parametrize("elsewhere", ["copy.yaml", "deeper/down/copy.yaml", "../copy.json"])
def test_mesh_files_are_found_from_wherever_the_scene_is_saved(
    elsewhere: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    (home / "meshes").mkdir(parents=True)
    COLUMN.export(home / "meshes" / "column.ply")
    shape = {"type": "mesh", "file": "meshes/column.ply", "scale": [0.1, 0.2, 0.3]}
    (home / "scene.json").write_text(
        json.dumps(
            {"format": "holdfast-scene/1", "friction": 1, "bodies": [{"name": "c", "shape": shape, "fixed": True}]}
        )
    )
    monkeypatch.chdir(home)
    scene = hf.load_scene("scene.json")
    target = home / elsewhere
    target.parent.mkdir(parents=True, exist_ok=True)
    hf.save_scene(scene, elsewhere)
    monkeypatch.chdir("/")
    copy = hf.load_scene(target)
    assert_same(scene, copy)
    assert copy.bodies[0].shape.scale == (0.1, 0.2, 0.3)
    assert "vertices" not in target.read_text()
    assert str(tmp_path) not in target.read_text()


def test_a_scene_and_its_meshes_can_move_together(tmp_path: Path) -> None:
    source = Path(hf.__file__).parent / "scene" / "shipped" / "tabletop"
    shutil.copytree(source, tmp_path / "moved")
    assert_same(shipped_scene("tabletop"), hf.load_scene(tmp_path / "moved" / "tabletop.yaml"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_numpy_numbers_can_be_saved(suffix: str, tmp_path: Path) -> None:
    body = hf.Body("c", hf.Cylinder(np.float32(1), np.float64(2), np.int64(8)), mass=np.float64(1), fixed=np.True_)
    hf.save_scene(hf.Scene([body], np.float64(0.5)), tmp_path / f"scene{suffix}")
    assert hf.load_scene(tmp_path / f"scene{suffix}").bodies[0].fixed


@pytest.mark.parametrize(
    ("path", "match"),
    [
        ("scene.txt", r"scene\.txt: suffix '\.txt'; can be written: holdfast scene \(\.yaml"),
        ("no/such/scene.yaml", r"scene\.yaml: cannot be written: No such file.*; name a file in a writable folder"),
        ("file/scene.yaml", r"scene\.yaml: cannot be written: Not a directory; name a file"),
    ],
)
def test_where_a_scene_cannot_be_saved(path: str, match: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(hf.HoldfastError, match=match):
        hf.save_scene(shipped_scene("cube"), tmp_path / path)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("failing", ["replace", "fsync"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_midway_leaves_the_old_file_and_nothing_else(
    failing: str, error: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "scene.yaml"
    target.write_text("old")

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(os, failing, fail)
    with pytest.raises((hf.HoldfastError, KeyboardInterrupt)) as caught:
        hf.save_scene(shipped_scene("cube"), target)
    monkeypatch.undo()
    if isinstance(error, OSError):
        assert "cannot be written: No space left on device; name" in str(caught.value)
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["scene.yaml"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    with pytest.raises(hf.HoldfastError, match=r"scene\.yaml: cannot be written: Permission denied; name"):
        hf.save_scene(shipped_scene("cube"), tmp_path / "scene.yaml")


def test_the_schema_is_closed_and_describes_itself() -> None:
    printed = schema()
    assert printed["$schema"].startswith("https://json-schema.org/")
    assert {"format", "bodies", "friction"} <= set(printed["required"])
    names = set(printed["$defs"])
    for part in (printed, *printed["$defs"].values()):
        assert part["type"] == "object"
        assert part["additionalProperties"] is False
    references = {line.split('"')[1].rpartition("/")[2] for line in json.dumps(printed).split('"$ref": ')[1:]}
    assert references <= names


@pytest.mark.parametrize("name", shipped_scenes())
def test_saved_files_fulfil_the_schema(name: str, tmp_path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    hf.save_scene(shipped_scene(name), tmp_path / "scene.json")
    jsonschema.Draft202012Validator(schema()).validate(json.loads((tmp_path / "scene.json").read_text()))
