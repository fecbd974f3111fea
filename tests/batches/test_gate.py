"""The gate passes, fails or leaves undecided by the rows alone, and tells what changed."""

from __future__ import annotations

import math
from typing import Any

import pytest

from holdfast.base.errors import SceneError
from holdfast.batches.gate import FAILED, PASSED, UNDECIDED, GateRules, Scenes, findings, judged

ROW = {"scene": "a", "outcome": "answered", "problem": None, "status": "stable", "reason": "rests", "seconds": 0.5}
ROW |= {"weakest": 5.0, "weakest_lower": 4.0, "weakest_body": "cup", "undecided": 0}
BODY = {"x": 0.0, "y": 0.0, "z": 0.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0}


def row(**changed: Any) -> dict[str, Any]:
    return ROW | changed


@pytest.mark.parametrize(
    ("given", "rules", "result"),
    [
        (row(), GateRules(stands=True), PASSED),
        (row(status="unstable"), GateRules(stands=True), FAILED),
        (row(status="undecided"), GateRules(stands=True), UNDECIDED),
        (row(status="unstable"), GateRules(), PASSED),
        (row(crushed=["carton"]), GateRules(stands=True), FAILED),
        (row(crushed=["carton"]), GateRules(min_force=3.9), PASSED),
        (row(outcome="time", status=None), GateRules(), FAILED),
        (row(), GateRules(min_force=3.9), PASSED),
        (row(), GateRules(min_force=4.0), PASSED),
        (row(), GateRules(min_force=4.5), UNDECIDED),
        (row(), GateRules(min_force=5.0), UNDECIDED),
        (row(), GateRules(min_force=5.1), FAILED),
        (row(undecided=2), GateRules(min_force=3.0), UNDECIDED),
        (row(undecided=2), GateRules(min_force=6.0), FAILED),
        (row(weakest=None, weakest_lower=None), GateRules(min_force=3.0), UNDECIDED),
        (row(weakest=math.inf, weakest_lower=math.inf), GateRules(min_force=1e9), PASSED),
    ],
)
def test_a_scene_is_judged_by_itself(given: dict[str, Any], rules: GateRules, result: str) -> None:
    found, told = judged(given, rules)
    assert found == result
    assert (told == "") == (result == PASSED)


def test_who_moves_is_told_not_only_who_is_pushed() -> None:
    wanted = GateRules(min_force=6.0)
    told = judged(row(weakest_mode="topple", weakest_moving=["can", "jar"]), wanted)[1]
    assert told == "5 N on cup moves can, jar, 6 N is wanted"
    assert judged(row(), wanted)[1] == "5 N on cup moves something, 6 N is wanted", "a table of an older version"


def compared(now: dict[str, Any], body: dict[str, float], **rules: float) -> str:
    scenes = Scenes({"a": now}, {"a": {"cup": body}})
    before = Scenes({"a": ROW, "b": ROW}, {"a": {"cup": BODY}})
    first, second = findings(scenes, GateRules(**rules), before)
    assert (second.scene, second.result) == ("b", FAILED)
    assert first.result == (FAILED if first.reason else PASSED)
    return first.reason


def test_what_changed_is_told() -> None:
    assert compared(row(), BODY) == ""
    assert compared(row(weakest=5.04), BODY) == ""
    assert compared(row(weakest=5.06), BODY) == "changed: weakest push from 5 N to 5.06 N"
    assert compared(row(weakest=5.06), BODY, force=0.02) == ""
    assert "weakest push from 5 N to ∞" in compared(row(weakest=math.inf), BODY, force=0.5)
    assert "weakest push from 5 N to none" in compared(row(weakest=None), BODY)
    assert compared(row(status="undecided"), BODY) == "changed: status from stable to undecided"


def test_poses_are_compared_whatever_the_sign_of_a_quaternion() -> None:
    assert compared(row(), BODY | {"y": 3e-3, "z": -4e-3}) == "changed: cup moved by 5 mm"
    assert compared(row(), BODY | {"x": 5e-3}, distance=6e-3) == ""
    assert compared(row(), BODY | {"x": 2e-6}) == "changed: cup moved by 0.002 mm", "a micrometre is allowed"
    assert compared(row(), BODY | {"x": 5e-7}) == ""
    assert compared(row(), BODY | {"qw": -1.0}) == ""
    half = math.radians(2.0) / 2
    turned = BODY | {"qx": math.sin(half), "qw": math.cos(half)}
    assert compared(row(), turned) == "changed: cup turned by 2 degrees"
    assert compared(row(), turned, angle=2.1) == ""


def test_bodies_that_come_and_go_are_told() -> None:
    scenes = Scenes({"a": ROW}, {"a": {"jug": BODY}})
    (found,) = findings(scenes, GateRules(), Scenes({"a": ROW}, {"a": {"cup": BODY}}))
    assert found.reason == "changed: new: jug, gone: cup"


@pytest.mark.parametrize(
    ("given", "rules", "helps"),
    [
        (row(status="unstable"), GateRules(stands=True), "`holdfast assess a` shows why"),
        (
            row(status="unstable", path="-my scene's.yaml"),
            GateRules(stands=True),
            """assess './-my scene'"'"'s.yaml'`""",
        ),
        (row(), GateRules(min_force=5.1), "`holdfast map a` shows where"),
        (row(crushed=["carton"]), GateRules(stands=True), "what lies on them"),
        (row(outcome="time", status=None), GateRules(), "--seconds"),
        (row(outcome="memory", status=None), GateRules(), "--megabytes"),
        (row(outcome="error", status=None, problem="no friction; give friction=, for all"), GateRules(), "--options"),
    ],
)
def test_a_scene_that_does_not_pass_is_told_what_helps(given: dict[str, Any], rules: GateRules, helps: str) -> None:
    (found,) = findings(Scenes({"a": given}), rules)
    assert helps in found.remedy
    (passing,) = findings(Scenes({"a": row()}), GateRules(stands=True))
    assert passing.remedy == ""


def test_what_only_changed_may_become_the_baseline() -> None:
    before = Scenes({"a": row(weakest=9.0), "b": ROW})
    assert ["baseline" in each.remedy for each in findings(Scenes({"a": ROW}), GateRules(), before)] == [True, True]


@pytest.mark.parametrize("number", [math.nan, -1.0, math.inf])
def test_a_rule_that_would_pass_everything_is_refused(number: float) -> None:
    for name in ("min_force", "distance", "angle", "force"):
        with pytest.raises(SceneError, match="needs a finite number >= 0"):
            GateRules(**{name: number})
