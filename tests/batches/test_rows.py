"""Rows of real scenes are what single calls give, bit for bit; keys see every byte."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reproduced import reproducible
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.borders.supervisor import Reply
from holdfast.base.borders.worker import TIME
from holdfast.batches.job import BatchQuestion, Job
from holdfast.batches.rows import answered
from holdfast.batches.run import record_of
from holdfast.batches.tables import TABLES, Tables, completed

CUBE = """
format: holdfast-scene/1
friction: 0.5
bodies:
  - {name: floor, shape: {type: box, size: [1, 1, 0.1]}, position: [0, 0, -0.05], fixed: true}
  - {name: cube, shape: {type: mesh, file: cube.obj}, mass: 1.0, position: [0, 0, 0.05]}
"""
PUSHES = "body,x,y,z,dx,dy,dz,scene\ncube,-0.05,0,0.05,1,0,0,\nnobody,0,0,0,1,0,0,\ncube3,0,0,0.3,0,0,-1,stack\n"
WAYS = [[1, 0, 0], [0, 1, 0]]
OPTIONS: dict[str, Any] = {
    "map": {"spacing": 0.05, "engine": "limit"},
    "transport": {"directions": WAYS},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene file with a mesh, a file of pushes, and one that is no scene."""
    (tmp_path / "in").mkdir()
    corners = [(x, y, z) for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {' '.join(map(str, face))}" for face in faces]
    (tmp_path / "in" / "cube.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "in" / "cube.yaml").write_text(CUBE)
    (tmp_path / "in" / "broken.yaml").write_text("format: holdfast-scene/1\nbodies: 3\n")
    (tmp_path / "pushes.csv").write_text(PUSHES)
    return tmp_path


def test_rows_equal_single_calls_bit_for_bit(folder: Path) -> None:
    scenes = [*sorted((folder / "in").glob("*.yaml")), ("stack", hf.shipped_scene("stack")), hf.shipped_scene("slope")]
    ask = ("stability", "map", "transport", f"push:{folder / 'pushes.csv'}")
    report = hf.batch(
        scenes, ask, resources=hf.sets.Resources(shard_size=2), out=folder / "out", workers=2, options=OPTIONS
    )
    assert dict(report.outcomes) == {"error": 1, "answered": 3}
    tables = hf.read_batch(folder / "out")
    for name, scene in (
        (str(folder / "in" / "cube.yaml"), hf.load_scene(folder / "in" / "cube.yaml")),
        ("stack", hf.shipped_scene("stack")),
    ):
        own = {table: [r for r in tables.rows(table) if r["scene"] == name] for table in TABLES}
        assembly = hf.assemble(scene)
        verdict = hf.stability(assembly)
        assert (own["scenes"][0]["status"], own["scenes"][0]["reason"]) == (verdict.status, verdict.reason)
        surfaces = hf.robustness_map(assembly, **OPTIONS["map"])
        compare([r for r in own["pushes"] if r["source"] == "map"], surfaces, surfaces.points, -surfaces.normals)
        limits = hf.transport_limits(assembly, WAYS)
        assert [r["acceleration"] for r in own["transports"]] == limits.acceleration.tolist()
        body, point, way = (
            ("cube3", (0, 0, 0.3), (0, 0, -1)) if name == "stack" else ("cube", (-0.05, 0, 0.05), (1, 0, 0))
        )
        push = hf.robustness(assembly, body, point, way)
        compare([r for r in own["pushes"] if r["source"] == "push"], push, push.points, push.directions)
        assert own["scenes"][0]["weakest"] == min(*surfaces.force, *push.force)
        assert own["scenes"][0]["weakest_lower"] == min(*surfaces.lower, *push.lower) < max(surfaces.lower)
        weak = min((row for row in own["pushes"]), key=lambda row: row["force"])
        assert own["scenes"][0]["weakest_body"] == weak["body"]
        assert own["scenes"][0]["weakest_mode"] == weak["mode"]
        assert own["scenes"][0]["weakest_moving"] == weak["moving"]
        poses = [[r[key] for key in ("x", "y", "z", "qx", "qy", "qz", "qw")] for r in own["bodies"]]
        for body, pose in zip(scene.bodies, poses, strict=True):
            assert pose[:3] == body.pose[:3, 3].tolist()
            np.testing.assert_allclose(Rotation.from_quat(pose[3:]).as_matrix(), body.pose[:3, :3], atol=1e-15)
        weight = sum(r["normal_force"] for r in own["interfaces"] if "floor" in (r["a"], r["b"]))
        assert weight == pytest.approx(9.81 * own["scenes"][0]["mass"], rel=1e-6)
    (broken,) = (r for r in tables.rows() if r["outcome"] == "error")
    with pytest.raises(hf.HoldfastError) as told:
        hf.load_scene(folder / "in" / "broken.yaml")
    assert broken["problem"] == str(told.value)


def compare(rows: list[dict[str, Any]], found: Any, points: Any, ways: Any) -> None:
    assert len(rows) == len(found.force)
    for name in ("force", "lower", "upper", "status", "mode"):
        assert [row[name] for row in rows] == getattr(found, name).tolist(), name
    assert [tuple(row["moving"]) for row in rows] == found.moving.tolist()
    assert [[row[a] for a in ("x", "y", "z")] for row in rows] == points.tolist()
    assert [[row[a] for a in ("dx", "dy", "dz")] for row in rows] == ways.tolist()


def asked(path: Path, **options: Any) -> dict[str, Any]:
    """The row of a scene file, asked in this process."""
    told: list[Tables] = []
    job = Job(0, path.name, BatchQuestion(("stability",), options), path=str(path), place=str(path))
    (row,) = answered(job, told.append)["scenes"]
    first = told[0]["scenes"][0]
    assert {name: first.get(name) for name in row} == dict.fromkeys(row) | first
    assert (first["key"], first["files"]) == (row["key"], row["files"])
    return row


def test_what_was_answered_before_a_scene_ended_its_worker_is_kept(folder: Path) -> None:
    """The rows of a scene of which the map takes too long: those of its verdict, of its bodies and interfaces."""
    path = str(folder / "in" / "cube.yaml")
    job = Job(0, path, BatchQuestion(("stability", "map"), OPTIONS), path=path, place=path)
    told: list[Tables] = []
    whole = answered(job, lambda part: told.append(copy.deepcopy(part)))
    assert [len(part["bodies"]) for part in told] == [0, 2, 2]
    kept = record_of(job, Reply(TIME, "", "no answer within 60 s", tuple(told), 60.0))
    assert (kept["scenes"][0]["outcome"], kept["scenes"][0]["status"]) == ("time", "stable")
    assert kept["scenes"][0]["problem"] == "no answer within 60 s"
    assert kept["interfaces"] == whole["interfaces"]
    assert kept["interfaces"][0]["normal_force"] == pytest.approx(9.81, rel=1e-6)
    assert whole["pushes"]
    assert kept["pushes"] == []
    unread = record_of(job, Reply(TIME, "", "no answer within 60 s"))
    assert [len(unread[table]) for table in TABLES] == [1, 0, 0, 0, 0]


def test_what_is_not_known_is_not_the_weakest() -> None:
    """A cube on its edge along the edge of another: nothing is known of it, and the 0 of its pushes is no force."""
    below, above = (
        hf.Body(name, hf.Box((0.1,) * 3), mass=1, pose=hf.pose(0, 0, z * 2**0.5, pitch=45), fixed=name == "below")
        for name, z in (("below", 0.05), ("above", 0.15))
    )
    options: dict[str, Any] = {"map": {"engine": "limit", "spacing": 0.1}, "transport": {"engine": "limit"}}
    job = Job(0, "ridges", BatchQuestion(("map", "transport"), options), scene=hf.Scene([below, above], 0.5))
    tables = answered(job, lambda _: None)
    (row,) = tables["scenes"]
    assert {push["status"] for push in tables["pushes"]} == {"undecided"}
    assert (row.get("weakest"), row.get("acceleration")) == (None, None)
    assert (row["weakest_lower"], row["acceleration_lower"]) == (0, 0)
    assert row["undecided"] == len(tables["pushes"]) + len(tables["transports"])


def test_a_key_sees_every_byte_of_every_file(folder: Path) -> None:
    path = folder / "in" / "cube.yaml"
    first = asked(path)
    assert first["files"] == ["cube.yaml", "cube.obj"]
    assert asked(path)["key"] == first["key"]
    assert asked(path, stability={"engine": "limit"})["key"] != first["key"]
    mesh = path.with_name("cube.obj")
    mesh.write_text(mesh.read_text() + "# a comment\n")
    second = asked(path)
    assert second["key"] != first["key"]
    assert second["reason"] == first["reason"]
    mesh.unlink()
    third = asked(path)
    assert third["outcome"] == "error"
    assert third["key"] not in (first["key"], second["key"])
    assert "cube.obj" in third["files"]


def test_a_key_does_not_depend_on_where_the_folder_is(folder: Path) -> None:
    before = asked(folder / "in" / "cube.yaml")
    (folder / "in").rename(folder / "elsewhere")
    assert asked(folder / "elsewhere" / "cube.yaml")["key"] == before["key"]


def test_json_lines_are_strict_and_schema_says_what_they_are(folder: Path) -> None:
    hf.batch([("cube", hf.shipped_scene("cube"))], out=folder / "out", workers=1)
    schema = json.loads((folder / "out" / "schema.json").read_text())["tables"]
    tables = hf.read_batch(folder / "out")
    for name, columns in TABLES.items():
        assert [column["name"] for column in schema[name]] == [column.name for column in columns]
        for row in tables.rows(name):
            assert list(row) == [column.name for column in columns]
    (row,) = tables.rows()
    assert "seconds" not in reproducible("scenes", row)


def test_tables_for_other_programs(folder: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    options = {"map": {"spacing": 0.1, "engine": "limit"}}
    hf.batch([("cube", hf.shipped_scene("cube"))], ("stability", "map"), out=folder / "out", workers=1, options=options)
    tables = hf.read_batch(folder / "out")
    pushes = tables.arrow("pushes")
    assert pushes.schema.field("force").type == pa.float64()
    assert pushes.schema.field("force").metadata[b"unit"] == b"N"
    assert float("inf") in pushes.column("force").to_pylist()
    from pyarrow import dataset

    read = dataset.dataset(folder / "out" / "pushes").to_table()
    assert read.to_pylist() == pushes.to_pylist() == list(tables.rows("pushes"))
    with pytest.raises(hf.HoldfastError, match="did you mean 'pushes'"):
        list(tables.rows("pushs"))


def test_columns_that_are_gone_are_read_over() -> None:
    """Tables of 1.0.0rc1 have them."""
    row = {"scene": "a", "body": "cube", "force": 5.0, "solved": True, "error": 0.0}
    assert completed("pushes", row) == completed("pushes", {"scene": "a", "body": "cube", "force": 5.0})
    with pytest.raises(ValueError, match="guessed"):
        completed("pushes", row | {"guessed": 1.0})
