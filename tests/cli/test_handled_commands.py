"""The commands ``remove``, ``build`` and ``safe``: what they print, their JSON, and their exit codes."""

from __future__ import annotations

import json

import pytest
from calling import Call, column, command

import holdfast as hf

remove, build, safe = command("remove"), command("build"), command("safe")


def test_remove_says_whether_and_who_would_move(remove: Call) -> None:
    code, out, _ = remove("stack", "cube3")
    assert (code, "cube3: may be taken out" in out) == (0, True)
    code, out, _ = remove("stack", "cube2")
    assert code == 1
    assert "cube2: may not be taken out" in out
    assert "would move: cube3" in out
    code, out, _ = remove("wedged_floor", "cube", "--engine", "limit")
    assert (code, "undecided" in out) == (3, True)


def test_remove_as_json(remove: Call) -> None:
    code, out, _ = remove("stack", "cube2", "--lift", 1, 0, 0, "--json")
    data = json.loads(out)
    (row,) = data["rows"]
    assert (code, row["answer"], row["moving"], row["blockers"]) == (1, "unsafe", ["cube3"], [])
    assert data == hf.can_remove(hf.shipped_scene("stack"), "cube2", lift=(1, 0, 0)).data()


def test_what_a_hand_would_have_to_hold_is_told(remove: Call) -> None:
    sideways = ("stack", "cube2", "--lift", 1, 0, 0)
    assert "hold cube3" not in remove(*sideways).out
    assert "it may with hands: hold cube3 with 9.81 N" in " ".join(remove(*sideways, "--hands", 1).out.split())


def test_build_lists_the_steps_and_what_each_state_holds(build: Call) -> None:
    code, out, _ = build("stack", "--pushes", 50, "--save", "b.json")
    assert code == 0
    assert "all 3 bodies go in one by one" in out
    steps = [line.split()[:2] for line in out.splitlines() if line.strip()[:1] in ("1", "2", "3")]
    assert steps == [["1", "cube1"], ["2", "cube2"], ["3", "cube3"]]
    assert hf.load_answer("b.json") == hf.build_order(hf.shipped_scene("stack"), pushes=50)


def test_build_says_how_many_steps_it_leaves_out(build: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("holdfast.report.description.MOST_ROWS", 1)
    code, out, _ = build("stack")
    assert code == 0
    assert "... and 2 more" in out


def test_build_tells_what_must_stand_before(build: Call) -> None:
    code, out, _ = build("arch", "--pushes", 0)
    assert code == 1
    assert "v1, v2, v3, v4, v5 must stand before the other 0" in out
    code, out, _ = build("arch", "--pushes", 0, "--json")
    assert json.loads(out)["details"]["first"] == [f"v{k}" for k in range(1, 6)]


def test_safe_lists_pushes_with_their_effects(safe: Call) -> None:
    code, out, _ = safe("cube", "cube", "--force", 9, "--spacing", 0.05)
    assert code == 0
    assert "pushes move it alone" in out
    assert "nothing moves below" in out
    code, out, _ = safe("cube", "cube", "--force", 9, "--spacing", 0.05, "--direction", 0, 0, -1, "--json")
    assert set(column(out, "effect")) == {"nothing"}


def test_bad_input_ends_with_2(call: Call) -> None:
    for words, text in (
        (("remove", "stack", "cube7"), "did you mean"),
        (("remove", "stack", "floor"), "the body is fixed"),
        (("safe", "stack", "cube3", "--force", "-1"), "needs a finite number > 0"),
        (("safe", "stack", "cube3"), "--force"),
    ):
        code, _, err = call(*words)
        assert code == 2
        assert text in err


def test_what_does_not_stand_ends_with_1(build: Call) -> None:
    code, _, err = build("wedged")
    assert (code, "does not stand" in err) == (1, True)
