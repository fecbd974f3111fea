"""The judge objects to every answer that cannot be true, and to no other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import holdfast as hf
from fuzz import judge, trials
from fuzz.outcome import Ending
from holdfast.scene.shipped.blocks import at, cube

POINTS, ALONG = [(-0.05, 0, 0.05), (-0.05, 0, 0.09)], (1, 0, 0)


@pytest.fixture(scope="module")
def asked() -> dict[str, hf.answers.Robustness]:
    assembly = hf.assemble(cube())
    return {name: hf.robustness(assembly, "cube", POINTS, ALONG, engine=name) for name in ("limit", "compliant")}


def retold(found: hf.answers.Robustness, **columns: Any) -> hf.answers.Robustness:
    """The same answer with other columns."""
    return replace(found, answers=replace(found.answers, **columns))


def rules(limit: hf.answers.Robustness, other: hf.answers.Robustness) -> set[str]:
    found = [*judge.contradictions(limit), *judge.contradictions(other), *judge.between(limit, other, 9.81, 9.81)]
    return {rule for rule, _ in found}


def test_true_answers_pass(asked: dict[str, hf.answers.Robustness]) -> None:
    assert not rules(asked["limit"], asked["compliant"])
    assert not [*judge.nans(asked["limit"]), *judge.nans(asked["compliant"])]
    assert not judge.changed(asked["limit"], asked["limit"])


@pytest.mark.parametrize("name", ["force", "lower", "upper"])
@pytest.mark.parametrize("value", [np.nan, -1.0])
def test_what_is_no_number_is_seen(asked: dict[str, hf.answers.Robustness], name: str, value: float) -> None:
    column = np.array(getattr(asked["limit"], name))
    column[1] = value
    assert [*judge.nans(retold(asked["limit"], **{name: column}))] == [f"limit.{name}"]


def test_every_rule_can_be_broken(asked: dict[str, hf.answers.Robustness]) -> None:
    limit, other = asked["limit"], asked["compliant"]
    upper, inf = np.array(limit.upper), np.full(2, np.inf)
    assert rules(limit, retold(other, force=1.01 * upper, upper=inf)) == {"compliant above limit.upper"}
    more = retold(other, lower=1.01 * upper, force=1.02 * upper, upper=inf)
    assert rules(limit, more) == {"compliant.lower above limit.upper"}
    assert rules(limit, retold(other, lower=1.001 * np.array(other.force))) == {"lower <= force <= upper"}
    assert rules(retold(limit, force=1.01 * upper), other) == {"lower <= force <= upper"}
    endless = retold(other, force=inf, upper=inf, lower=np.zeros(2))
    assert rules(limit, endless) == {"infinite", "compliant above limit.upper"}
    fallen = retold(other, status=np.array([hf.Status.UNSTABLE] * 2, dtype=object))
    assert rules(limit, fallen) == {"unstable with a force"}
    assert judge.changed(other, retold(other, force=np.nextafter(other.force, 0)))


def test_infinity_may_stand_for_a_factor_beyond_all_balance(asked: dict[str, hf.answers.Robustness]) -> None:
    endless = retold(
        asked["compliant"],
        force=np.full(2, np.inf),
        upper=np.full(2, np.inf),
        status=np.array([hf.Status.INFINITE] * 2, dtype=object),
    )
    for weights, told in ((0.9e5, {"compliant above limit.upper"}), (1.1e5, set())):
        far = retold(asked["limit"], force=np.full(2, 9.81 * weights), upper=np.full(2, 9.81 * weights))
        assert rules(far, endless) == told


def test_a_proof_of_a_fall_is_heard(asked: dict[str, hf.answers.Robustness]) -> None:
    floor, body = cube().bodies
    assembly = hf.assemble(hf.Scene([floor, body.moved(at(0.53, 0, 0.05))], 0.5))
    falls = hf.robustness(assembly, "cube", (0.48, 0, 0.05), ALONG, engine="limit")
    assert falls.verdict.status is hf.Status.UNSTABLE
    one = replace(asked["compliant"], answers=asked["compliant"].answers.rows(slice(0, 1)))
    assert rules(falls, one) >= {"stable, yet proved to move"}


def test_a_trial_sees_a_wrong_engine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The whole trial: an answer that is ten per cent too high, and one that is another one when asked again."""
    item = {"kind": "scene", "scene": trials.plain_cube(), "twice": True}
    item["pushes"] = [{"body": "b", "place": [0.1, 0.2, 0.3], "direction": None}]
    assert trials.tried(item).ending is Ending.OK
    true = trials.answers

    def high(path: Path, pushes: list[Any]) -> Any:
        found = true(path, pushes)
        columns = {name: 1.1 * getattr(found[0][1][1], name) for name in ("lower", "force", "upper")}
        found[0][1][1] = retold(found[0][1][1], **columns)
        return found

    monkeypatch.setattr(trials, "answers", high)
    assert trials.tried(item).sign == "compliant.lower above limit.upper"
    turns = iter([true, high])
    monkeypatch.setattr(trials, "answers", lambda path, pushes: next(turns)(path, pushes))
    assert trials.tried(item).sign == "compliant changed"


@settings(max_examples=60, deadline=None)
@given(st.text(min_size=1, max_size=40).filter(str.strip))
def test_any_name_survives_a_scene_file(tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    assert trials.tried({"kind": "name", "name": name, "output": "file"}).good
