"""A short run of the fuzzer, and what its parts promise: inputs from numbers, resumption, smaller reproductions."""

from __future__ import annotations

import base64
import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.campaign import campaign, in_turn, item_of, summary
from fuzz.draw import KINDS
from fuzz.keeper import Keeper
from fuzz.originals import originals
from fuzz.outcome import Ending, Outcome
from fuzz.scenes import ARRANGEMENTS
from fuzz.shrink import smallest
from fuzz.store import Store

SEED = 14
SHORT = 390  # inputs: 60 scenes, 300 files, 30 names


def test_a_short_run_finds_nothing(trier: Keeper, tmp_path: Path) -> None:
    told: list[str] = []
    store = Store(tmp_path, SEED)
    bad = campaign(store, [*KINDS], SHORT, told.append, trier)
    assert not bad, "\n".join(told)
    assert {kind: tally.next for kind, tally in store.tallies.items()} == {"scene": 60, "file": 300, "name": 30}
    for kind, tally in store.tallies.items():
        assert tally.counts[Ending.OK] > 0.05 * tally.next, summary(store)
        assert kind == "name" or tally.counts[Ending.TOLD] > 0


@pytest.mark.parametrize("kind", KINDS)
def test_an_input_follows_from_its_number(kind: str) -> None:
    some = [item_of(SEED, kind, number) for number in range(30)]
    assert some == [item_of(SEED, kind, number) for number in range(30)]
    assert json.loads(json.dumps(some)) == some
    assert len({json.dumps(item) for item in some}) > 25
    assert item_of(SEED + 1, kind, 0) != some[0]


def test_scenes_reach_over_what_they_should() -> None:
    sizes, masses, friction, counts = [], [], [], Counter()
    for number in range(400):
        scene = item_of(SEED, "scene", number)["scene"]
        movable = [body for body in scene["bodies"] if body["name"] != "ground"]
        counts[len(movable)] += 1
        masses += [body["mass"] for body in movable]
        sizes += [edge for body in movable if body["shape"]["type"] == "box" for edge in body["shape"]["size"]]
        friction.append(scene["friction"] if isinstance(scene["friction"], float) else scene["friction"]["default"])
    assert set(counts) == {2, 3, 4, 5}
    assert min(sizes) < 3e-4
    assert max(sizes) > 5
    assert min(masses) < 1e-5
    assert max(masses) > 1e5
    assert min(friction) == 0
    assert max(friction) > 100
    assert len({arrange.__name__ for arrange in ARRANGEMENTS}) == 9


def test_every_format_is_mutated() -> None:
    kinds = Counter((item["reader"], item["suffix"]) for item in (item_of(SEED, "file", k) for k in range(500)))
    assert {(original["reader"], original["suffix"]) for original in originals()} <= set(kinds)


class Told(Keeper):
    """Outcomes by a rule instead of a worker."""

    def __init__(self) -> None:
        self.asked: list[dict[str, Any]] = []

    def tried(self, item: dict[str, Any]) -> Outcome:
        self.asked.append(item)
        bad = item["kind"] == "name" and "$" in item["name"]
        return Outcome(Ending.CRASH, "dollar") if bad else Outcome(Ending.OK, seconds=0.1)


def test_a_run_goes_on_where_the_last_one_ended(tmp_path: Path) -> None:
    parts, whole = Told(), Told()
    for count in (7, 20, 13):
        campaign(Store(tmp_path / "parts", 3), ["name"], count, lambda _: None, parts)
    campaign(Store(tmp_path / "whole", 3), ["name"], 40, lambda _: None, whole)
    made = [item_of(3, "name", k) for k in range(40)]
    assert [item for item in parts.asked if item in made] == [item for item in whole.asked if item in made]
    tally, other = (Store(tmp_path / name, 3).tally("name") for name in ("parts", "whole"))
    assert (tally.next, tally.counts, tally.signs) == (40, other.counts, other.signs)


def test_one_process_at_a_time_works_on_a_seed(tmp_path: Path) -> None:
    with Store(tmp_path, 3).locked():
        with pytest.raises(BlockingIOError), Store(tmp_path, 3).locked():
            pass
        with Store(tmp_path, 4).locked():
            pass
    with Store(tmp_path, 3).locked():
        pass


def test_a_defect_is_kept_once_and_small(tmp_path: Path) -> None:
    store = Store(tmp_path, 3)
    bad = campaign(store, ["name"], 200, lambda _: None, Told())
    assert bad > 1
    assert store.tally("name").signs == {"crash: dollar": bad}
    (path,) = tmp_path.glob("crash-name-*.json")
    kept = json.loads(path.read_text())
    assert kept["item"]["name"] == "$"
    assert (kept["ending"], kept["sign"], kept["seed"]) == ("crash", "dollar", 3)


def test_kinds_take_turns_by_their_shares() -> None:
    assert Counter(in_turn([*KINDS], 390)) == {"scene": 60, "file": 300, "name": 30}
    assert set(in_turn(["scene"], 5)) == {"scene"}


@settings(max_examples=40, deadline=None)
@given(st.binary(max_size=200), st.binary(min_size=1, max_size=3))
def test_files_shrink_to_what_matters(around: bytes, core: bytes) -> None:
    content = around[: len(around) // 2] + core + around[len(around) // 2 :]

    def fails(item: dict[str, Any]) -> bool:
        return core in base64.b64decode(item["content"])

    item = {"kind": "file", "content": base64.b64encode(content).decode(), "beside": {"a": ""}}
    found = smallest(item, fails, 5000)
    assert base64.b64decode(found["content"]) == core
    assert found["beside"] == {}


def test_scenes_shrink_to_what_matters() -> None:
    """One heavy body is at fault: the rest goes, its number gets round."""
    item = next(
        item for item in (item_of(SEED, "scene", k) for k in range(100)) if len(item["scene"]["bodies"]) == 5
    )  # fmt: skip
    item["scene"]["bodies"][2]["mass"] = 123456.0

    def fails(other: dict[str, Any]) -> bool:
        return any(body.get("mass", 0) > 1e5 for body in other["scene"]["bodies"])

    item["pushes"] = [push | {"body": item["scene"]["bodies"][2]["name"]} for push in item["pushes"]]
    found = smallest(item, fails, 5000)
    assert [body["mass"] for body in found["scene"]["bodies"]] == [100000.0 * 2] or len(found["scene"]["bodies"]) == 1
    assert len(found["pushes"]) == 1
