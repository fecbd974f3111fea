"""The command line: exit codes, JSON, files; no traceback and nothing but the answer on stdout."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calling import Call

import holdfast as hf
from holdfast.base.archive import to_dict
from holdfast.scene.shipped.blocks import at, box, floor


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With a scene that falls, one that cannot be judged, and one that is bad."""
    monkeypatch.chdir(tmp_path)
    tower = [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0.06, 0, 0.15))]
    hf.save_scene(hf.Scene(tower, 0.5), "falls.yaml")
    turned = np.array([np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0])
    below = hf.Body("below", hf.Box((0.1, 0.1, 0.1)), pose=at(0, 0, 0.05 * np.sqrt(2), turned), fixed=True)
    above = hf.Body("above", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0, 0, 0.15 * np.sqrt(2), turned))
    hf.save_scene(hf.Scene([below, above], 0.5), "ridges.yaml")
    sunk = box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.04))
    hf.save_scene(hf.Scene([floor(), sunk], 0.5), "sunk.yaml")
    low, high = (box(n, (0.1, 0.1, 0.1), 1, (0, 0, z)) for n, z in (("low", 0.05), ("high", 0.15043)))
    hf.save_scene(hf.Scene([floor(), low, high], 0.5), "hovers.yaml")
    (tmp_path / "bad.yaml").write_text("a: 1\n")
    return tmp_path


def reject(constant: str) -> float:
    raise AssertionError(f"{constant} is no JSON")


def read(text: str) -> Any:
    assert text.count("\n") == 1
    return json.loads(text, parse_constant=reject)


@pytest.mark.parametrize("as_json", [[], ["--json"]])
@pytest.mark.parametrize("command", [["assess"], ["map", "--spacing", "0.05"]], ids=["assess", "map"])
@pytest.mark.parametrize(
    ("scene", "code"), [("table", 0), ("falls.yaml", 1), ("bad.yaml", 2), ("nowhere", 2), ("ridges.yaml", 3)]
)
def test_exit_codes(scene: str, code: int, command: list[str], as_json: list[str], call: Call, folder: Path) -> None:
    answer = call(command[0], scene, *command[1:], *as_json)
    assert answer.code == code
    if code == 2:
        assert answer.out == ""
        assert answer.err.startswith("error: ")
        assert answer.err.count("\n") == 1
    else:
        assert answer.err == ""
        assert answer.out
    if as_json and code != 2:
        read(answer.out)


def test_a_hovering_body_exits_with_3_and_is_told_what_to_do(call: Call, folder: Path) -> None:
    line = "high is 0.43 mm above 'low' (gap tolerance 0.17 mm) and would rest there: settle, or gap=0.001"
    answer = call("assess", "hovers.yaml")
    assert answer.code == 3
    assert line in " ".join(answer.out.split())
    data = read(call("assess", "hovers.yaml", "--json").out)
    assert {tuple(g["bodies"]): g["status"] for g in data["rows"]} == {("low",): "stable", ("high",): "undecided"}
    assert line in data["rows"][1]["reason"]
    assert call("assess", "hovers.yaml", "--gap", "0.001").code == 0
    mapped = read(call("map", "hovers.yaml", "--spacing", "0.05", "--engine", "limit", "--json").out)
    assert any(line in note for note in mapped["notes"])


def test_the_json_of_assess_has_the_attributes(call: Call) -> None:
    data = read(call("assess", "table", "--json").out)
    told = "engine equilibrium_exists self_stress forces residual moving mechanism certificate"
    details = data["details"]
    assert set(told.split()) <= set(details)
    assert (data["question"], data["verdict"], data["claim"]) == ("stability", "stable", "holds")
    assert details["equilibrium_exists"] is True
    assert len(details["interfaces"]) == 4
    assert {"bodies", "area", "status", "flags", "patches"} <= set(details["interfaces"][0])


def test_the_json_of_an_unstable_scene_spells_infinity(call: Call, folder: Path) -> None:
    data = read(call("assess", "falls.yaml", "--json").out)
    details = data["details"]
    assert data["verdict"] == "unstable"
    assert details["residual"] == "inf"
    assert details["forces"] is None
    assert "b" in details["moving"]
    assert details["certificate"]["power"] > 0


def test_the_json_of_map_has_the_attributes(call: Call) -> None:
    data = read(call("map", "table", "--spacing", 0.05, "--json").out)
    rows, details = data["rows"], data["details"]
    told = {"point", "direction", "body", "force", "status", "lower", "upper", "moving", "mode"}
    assert all(set(row) == told for row in rows)
    assert {row["upper"] for row in rows} == {"inf"}
    assert all(float(row["lower"]) <= float(row["force"]) for row in rows)
    assert "inf" in {row["force"] for row in rows}
    least = min(float(row["force"]) for row in rows)
    weakest = [row["direction"] for row in rows if float(row["force"]) <= least * (1 + 1e-12)]  # mirrored
    assert details["weakest"]["force"] == pytest.approx(least, rel=1e-12)
    assert details["weakest"]["direction"] in weakest
    assert details["engine"] == "compliant"
    assert (data["question"], data["claim"], data["bound"]) == ("map", "holds", "estimated")


@pytest.mark.parametrize(
    ("value", "expected"),
    [(math.inf, "inf"), (-math.inf, "-inf"), (hf.Status.STABLE, "stable"), ((1, [2.5]), [1, [2.5]]), (None, None)],
)
def test_plain_data(value: Any, expected: Any) -> None:
    assert to_dict(value) == expected


def test_nan_never_becomes_a_number() -> None:
    try:
        said = to_dict(math.nan)
    except ValueError:
        return
    assert said in ("nan", None)


def test_one_body_can_be_mapped(call: Call) -> None:
    data = read(call("map", "table", "--bodies", "slab", "--spacing", 0.05, "--json").out)
    assert {row["body"] for row in data["rows"]} == {"slab"}


@pytest.mark.parametrize("as_json", [[], ["--json"]])
def test_map_writes_pictures(as_json: list[str], call: Call, folder: Path) -> None:
    answer = call("map", "cube", "--spacing", 0.05, "--png", "m.png", "--html", "m.html", *as_json)
    assert answer.code == 0
    assert (folder / "m.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert "<html" in (folder / "m.html").read_text()[:2000].lower()
    if as_json:
        read(answer.out)
    else:
        assert "wrote m.png" in answer.out
        assert "wrote m.html" in answer.out


@pytest.mark.parametrize("target", ["--png", "--html"])
def test_a_picture_that_cannot_be_written_is_an_error(target: str, call: Call, folder: Path) -> None:
    name = f"m.{target[2:]}"
    answer = call("map", "cube", "--spacing", 0.1, target, f"no/such/{name}")
    assert answer.code == 2
    assert f"{name}: cannot be written" in answer.err
    answer = call("map", "cube", "--spacing", 0.1, target, "m.jpg")
    assert answer.code == 2
    assert f"m.jpg does not end in .{target[2:]}" in answer.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["assess", "table", "--no-such-option"],
        ["assess"],
        ["map", "table", "--spacing", "wide"],
        ["map", "table", "--spacing", "-1"],
        ["map", "table", "--spacing", "1e-7"],
        ["map", "table", "--bodies", "slb"],
        ["map", "table", "--max-cuts", "many"],
        ["assess", "table", "--engine", "grap"],
        ["assess", "table", "--nodes", "1"],
        ["assess", "table", "--engine", "graph", "--nodes", "2"],
        ["assess", "table", "--engine", "limit", "--nodes", "9"],
        ["assess", "table", "--mass-margin", "0.2"],
        ["assess", "table", "--gap", "nan"],
        ["assess", "table", "--angle-degrees", "90"],
        ["assess", "table", "--mass-margin", "1"],
        ["convert", "table", "table.txt"],
        ["convert", "table", "no/such/table.yaml"],
    ],
    ids=" ".join,
)
def test_wrong_usage_exits_with_2_and_says_why(arguments: list[str], call: Call, folder: Path) -> None:
    answer = call(*arguments)
    assert answer.code == 2
    assert answer.out == ""
    assert "rror: " in answer.err
    assert "Traceback" not in answer.err


@pytest.mark.parametrize(
    "arguments", [["map", "bonded_wall", "--spacing", "0.2"], ["map", "table", "--max-cuts", "1", "--json"]]
)
def test_an_engine_without_an_answer_exits_with_3_and_the_remedy(
    arguments: list[str], call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("holdfast.base.progress.EVERY", 600.0)  # no line of progress, however busy the machine is
    answer = call(*arguments, "--engine", "graph")
    assert answer.code == 3
    assert answer.out == ""
    assert answer.err.startswith("no answer: engine graph: ")
    assert "declare heavy bodies immobile" in answer.err
    assert answer.err.count("\n") == 1


def test_a_warning_goes_to_stderr_and_the_answer_to_stdout(call: Call, folder: Path) -> None:
    answer = call("assess", "sunk.yaml", "--json")
    assert answer.code == 3
    assert read(answer.out)["details"]["overlaps"][0]["bodies"] == ["floor", "cube"]
    assert re.match(r"warning: bodies.*overlap.*'floor' and 'cube'.* 10 mm", answer.err)
    assert answer.err.count("\n") == 1


def test_convert_tells_what_a_reader_guessed_and_left_out(call: Call, folder: Path) -> None:
    pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")
    body = (
        '<body name="a" pos="0 0 .1"><freejoint/><geom size=".1"/><geom size=".2" contype="0" conaffinity="0"/></body>'
    )
    text = f'<mujoco><worldbody><geom type="plane" size="1 1 1"/>{body}</worldbody></mujoco>'
    (folder / "scene.xml").write_text(text, encoding="utf-8")
    quiet = call("convert", "scene.xml", "scene.yaml")
    told = call("convert", "scene.xml", "scene.yaml", "-v")
    heavy, left_out = told.out.removeprefix(quiet.out).splitlines()
    assert heavy.startswith("note: geoms that touch nothing give mass to a")
    assert left_out == "note: left out: 1 geoms that collide with nothing"
    notes = json.loads(call("convert", "scene.xml", "scene.yaml", "--json").out)["notes"]
    assert [f"note: {note}" for note in notes] == [heavy, left_out]


def test_the_schema_is_printed(call: Call) -> None:
    answer = call("schema")
    assert answer.code == 0
    assert json.loads(answer.out)["additionalProperties"] is False
    assert len(answer.out.splitlines()) > 100, "a person reads it too"


def test_version_and_help(call: Call) -> None:
    assert call("--version").out.strip() == f"holdfast {hf.__version__}"
    answer = call("map", "--help")
    assert answer.code == 0
    assert "--spacing" in answer.out


def test_a_defect_is_called_one(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("holdfast.cli.scenes.assemble", fail)
    answer = call("assess", "cube")
    assert answer.code == 4
    assert "defect in holdfast" in answer.err


@pytest.mark.parametrize(
    ("arguments", "code"), [(["assess", "cube", "--json"], 0), (["assess", "nowhere.yaml"], 2), (["--nonsense"], 2)]
)
def test_as_a_process(arguments: list[str], code: int) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "holdfast.cli.main", *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if code == 0:
        read(done.stdout)
        assert done.stderr == ""
