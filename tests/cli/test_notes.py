"""What the reader of a file guessed or left out is shown by every command that answers, and stands in its JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from calling import called

SDF = """<sdf version="1.9"><world name="w">
<model name="floor"><static>true</static><link name="l"><collision name="c"><geometry><plane/></geometry></collision></link></model>
<model name="crate"><pose>0 0 0.1 0 0 0</pose><link name="l"><inertial><mass>4</mass></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision></link></model></world></sdf>
"""  # noqa: E501
NOTE = "links floor::l, crate::l: friction 1, which SDF says where a file says none"
FIXED = SDF.replace('<model name="crate">', '<model name="crate"><static>true</static>')

COMMANDS = {
    "assess": ("assess", "{}"),
    "map": ("map", "{}", "--spacing", "0.1", "--engine", "limit"),
    "push": ("push", "{}", "crate", "--at", "-0.1", "0", "0.1", "--along", "1", "0", "0", "--engine", "limit"),
    "transport": ("transport", "{}", "--count", "4", "--engine", "limit"),
    "remove": ("remove", "{}", "crate", "--engine", "limit"),
    "disassemble": ("disassemble", "{}", "--engine", "limit"),
    "build": ("build", "{}", "--engine", "limit", "--pushes", "0"),
    "settle": ("settle", "{}", "--engine", "limit"),
    "safe": ("safe", "{}", "crate", "--force", "1", "--spacing", "0.2"),
    "place": ("place", "{}", "crate", "--engine", "limit", "--solves", "20", "--candidates", "1", "--spacing", "0.2"),
}


@pytest.fixture
def holdfast(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Any:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return lambda *arguments: called(monkeypatch, capsys, *arguments)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_shows_what_was_guessed(command: str, holdfast: Any, tmp_path: Path) -> None:
    (tmp_path / "w.sdf").write_text(SDF)
    arguments = [word.format("w.sdf") for word in COMMANDS[command]]
    _, shown, told = holdfast(*arguments)
    assert NOTE in " ".join(shown.split()), told
    code, shown, told = holdfast(*arguments, "--json")
    assert NOTE in json.loads(shown)["notes"], told
    assert code in (0, 1)  # nothing that the notes say makes an answer an error


def test_a_scene_in_which_nothing_can_move_is_no_pass(holdfast: Any, tmp_path: Path) -> None:
    (tmp_path / "w.sdf").write_text(FIXED)
    code, shown, _ = holdfast("assess", "w.sdf")
    assert code == 3
    assert "nothing here can move" in shown
    code, shown, _ = holdfast("assess", "w.sdf", "--json")
    assert (code, json.loads(shown)["verdict"]) == (3, "undecided")
    code, shown, _ = holdfast("check", "w.sdf", "--stands", "--workers", "1")
    assert code == 3
    assert "nothing here can move" in shown
