"""What commands print with ``--json`` is one envelope, as its schema says; the exit code follows its verdict."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from calling import called
from envelopes import problems

import holdfast as hf
from holdfast.cli.main import COMMANDS, Commands

SIDE = ("--at", -0.05, 0, 0.05, "--along", 1, 0, 0)
LIMIT = ("--engine", "limit")
SMALL = ("--supports", "cube", "--spacing", 0.05, "--candidates", 1, "--engine", "graph")
# Each command with --json, in states that differ: the arguments, the exit code and how many rows it has
ASKED: dict[str, tuple[tuple[object, ...], int, int]] = {
    "assess": (("cube", *LIMIT), 0, 1),
    "assess, falls": (("falls.yaml",), 1, 1),
    "assess, undecided": (("wedged", *LIMIT), 3, 1),
    "assess, crushed": (("crushed.yaml",), 1, 1),
    "push": (("cube", "cube", *SIDE), 0, 1),
    "push, crushed": (("crushed.yaml", "cube", *SIDE, *LIMIT), 1, 1),
    "map": (("cube", "--spacing", 0.1, *LIMIT), 0, 10),
    "transport": (("cube", "--count", 4, *LIMIT), 0, 4),
    "carry": (("cube", "--profile", "eumos40509_0.5g"), 0, 4),
    "carry, too fast": (("cube", "--profile", "eumos40509_0.8g"), 1, 4),
    "carry, who knows": (("cube", "--profile", "eumos40509_0.5g", *LIMIT), 3, 4),
    "calibrate": (("cube", "pushes.csv", *LIMIT), 0, 3),
    "calibrate, undecided": (("cube", "odd.csv", "--scatter", 0.1, *LIMIT), 3, 2),
    "place": (("cube", "box.yaml:box", *SMALL), 0, 1),
    "place, no place": (("cube", "box.yaml:huge", *SMALL, "--solves", 2), 3, 0),
    "place, two": (("cube", "box.yaml:box", "box.yaml:box2", "--engine", "graph", "--solves", 6), 0, 2),
    "firmer": (("cube", "cube", "--slide", 0.005, "--seconds", 1, *LIMIT), 0, 1),
    "rest": (("cube",), 0, 6),
    "settle": (("cube", *LIMIT), 0, 1),
    "settle, falls": (("falls.yaml", *LIMIT), 1, 1),
    "remove": (("stack", "cube3", *LIMIT), 0, 1),
    "remove, blocked": (("stack", "cube2", *LIMIT), 1, 1),
    "remove, undecided": (("wedged_floor", "cube", *LIMIT), 3, 1),
    "disassemble": (("stack", "--engine", "graph"), 0, 3),
    "disassemble, gave up": (("arch", "--hands", 1, *LIMIT), 3, 0),
    "build": (("stack", "--engine", "graph", "--pushes", 30), 0, 3),
    "build, arch": (("arch", *LIMIT, "--pushes", 0), 1, 0),
    "safe": (("cube", "cube", "--force", 9, "--spacing", 0.1), 0, 10),
    "batch": (("cube.yaml", "--out", "out", "--ask", "stability,map,transport", "--workers", 1), 0, 1),
    "batch, one is broken": (("cube.yaml", "broken.yaml", "--out", "out", "--workers", 1), 3, 2),
    "check": (("cube.yaml", "--stands", "--workers", 1), 0, 1),
    "check, falls": (("cube.yaml", "falls.yaml", "crushed.yaml", "--stands", "--workers", 1), 1, 3),
    "convert": (("cube", "other.yaml"), 0, 0),
    "doctor": ((), 0, 0),
}
WITHOUT = {"view", "report", "verify", "schema", "mcp"}  # which answer no question


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Any:
    monkeypatch.chdir(tmp_path)
    cube, up = hf.shipped_scene("cube"), hf.pose(z=0.3)
    hf.save_scene(cube, "cube.yaml")
    hf.save_scene(cube.moved({"cube": up}), "falls.yaml")
    weight = hf.Body("weight", hf.Box((0.05, 0.05, 0.05)), mass=2, position=(0, 0, 0.125))
    soft = [hf.Body("cube", b.shape, mass=1, pose=b.pose, top_load=5.0) if b.name == "cube" else b for b in cube.bodies]
    hf.save_scene(hf.Scene([*soft, weight], 0.6), "crushed.yaml")
    boxes = [hf.Body(name, hf.Box((0.02, 0.02, 0.02)), mass=0.1) for name in ("box", "box2")]
    far = [body.moved(hf.pose(x=1 + k)) for k, body in enumerate(boxes)]
    huge = hf.Body("huge", hf.Box((5, 5, 5)), mass=1000, position=(20, 0, 0))
    hf.save_scene(hf.Scene([cube.body("floor"), *far, huge], 0.6), "box.yaml")
    Path("broken.yaml").write_text("bodies: [")
    head, push = "body,x,y,z,dx,dy,dz,force\n", "cube,-0.05,0,0.05,1,0,0"
    Path("pushes.csv").write_text(head + "".join(f"{push},{force}\n" for force in (4.0, 4.4, 4.2)))
    Path("odd.csv").write_text(head + "".join(f"{push},{force}\n" for force in (1.0, 9.0)))
    return lambda *arguments: called(monkeypatch, capsys, *arguments)


@pytest.mark.parametrize("name", ASKED)
def test_every_command_prints_an_envelope_and_ends_as_its_verdict_says(name: str, call: Any) -> None:
    arguments, code, rows = ASKED[name]
    ended, out, err = call(name.partition(",")[0], *arguments, "--json")
    data = json.loads(out)
    assert problems(data) == []
    assert (ended, len(data["rows"])) == (code, rows), (data["reason"], err)
    assert {"stable": 0, None: 0, "unstable": 1, "undecided": 3}[data["verdict"]] == code
    assert data["reason"]


def test_no_command_with_json_is_left_out() -> None:
    def with_json() -> Iterator[str]:
        for name in COMMANDS:
            commands: Any = Commands()
            commands._called = name
            if any("--json" in each.opts for each in commands.get_command(None, name).params):
                yield name

    assert set(with_json()) == {name.partition(",")[0] for name in ASKED} == set(COMMANDS) - WITHOUT


def test_the_schema_is_printed(call: Any) -> None:
    code, out, _ = call("schema", "answer")
    schema = json.loads(out)
    assert (code, schema["title"]) == (0, "holdfast-answer/1")
    assert {"push", "map", "scene"} <= set(schema["discriminator"]["mapping"])


def test_rows_of_a_batch_say_what_was_asked(call: Any) -> None:
    arguments, code, _ = ASKED["batch"]
    ended, out, _ = call("batch", *arguments, "--json")
    (row,) = json.loads(out)["rows"]
    assert ended == code
    assert (row["question"], row["verdict"], row["claim"]) == ("scene", "stable", "holds")
    push, acceleration = row["rows"]
    assert push["body"] == "cube"
    assert 0 < push["lower"] <= push["force"]
    assert acceleration["acceleration"] == pytest.approx(0.6 * 9.81, rel=1e-3)
    assert list(hf.read_batch("out").data()) == [row]
    assert problems(row) == []


def test_a_check_says_of_each_scene_whether_it_stands_and_whether_it_passes(call: Any) -> None:
    _, out, _ = call("check", *ASKED["check, falls"][0], "--json")
    data = json.loads(out)
    told = {row["details"]["scene"]: (row["verdict"], row["details"]["result"]) for row in data["rows"]}
    assert told == {
        "cube.yaml": ("stable", "passed"),
        "falls.yaml": ("unstable", "failed"),
        "crushed.yaml": ("unstable", "failed"),
    }
    assert data["details"]["counts"] == {"passed": 1, "failed": 2}
