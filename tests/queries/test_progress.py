"""Whatever may take long tells how far it is, and stops where the listener raises."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.progress import listening

TABLE = hf.shipped_scene("table")
CUBE = hf.Body("new", hf.Box((0.05, 0.05, 0.05)), mass=0.2)

VERBS: dict[str, Callable[[], object]] = {
    "assemble": lambda: hf.assemble(TABLE),
    "stability": lambda: hf.stability(hf.assemble(TABLE)),
    "robustness": lambda: hf.robustness(hf.assemble(TABLE), "slab", (0, 0, 0.25), (0, 0, -1)),
    "limit": lambda: hf.robustness(hf.assemble(TABLE), "slab", (0, 0, 0.25), (0, 0, -1), engine="limit"),
    "map": lambda: hf.robustness_map(hf.assemble(TABLE), ["slab"], spacing=0.1),
    "carry": lambda: hf.carry(hf.assemble(TABLE), "road", engine="graph"),
    "transport": lambda: hf.transport_limits(hf.assemble(TABLE), engine="graph"),
    "disassembly": lambda: hf.disassembly_order(hf.assemble(TABLE)),
    "placement": lambda: hf.plan_placement(
        hf.assemble(hf.shipped_scene("cube")),
        CUBE,
        where=hf.Where(supports=["floor"]),
        search=hf.Search(spacing=0.2, solves=3),
    ),
}


@pytest.mark.parametrize("verb", VERBS)
def test_the_share_that_is_done_only_grows(verb: str) -> None:
    """Of each stage from one start to the next; a stage may be gone through several times."""
    told: defaultdict[str, list[tuple[int, int]]] = defaultdict(list)
    with listening(lambda stage, done, total: told[stage].append((done, total))):
        VERBS[verb]()
    assert told
    for stage, reports in told.items():
        assert all(0 <= done <= total for done, total in reports), stage
        for (before, _), (now, _) in pairwise(reports):
            assert now >= before or now == 0, stage


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("after", [0, 3])
def test_what_the_listener_raises_stops_the_work(verb: str, after: int) -> None:
    heard: list[str] = []

    def listener(stage: str, done: int, total: int) -> None:
        heard.append(stage)
        if len(heard) > after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), listening(listener):
        VERBS[verb]()
    assert len(heard) == after + 1


def test_an_answer_whose_drawing_is_stopped_leaves_the_old_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = tmp_path / "map.png"
    picture.write_bytes(b"old")
    found = hf.robustness_map(hf.assemble(TABLE), ["slab"], spacing=0.1)

    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", stopped)  # the last moment before the new picture takes the old one's place
    with pytest.raises(KeyboardInterrupt):
        found.save_png(picture)
    assert picture.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [picture]


def test_paths_in_a_thread_of_their_own_lead_to_the_same_force(monkeypatch: pytest.MonkeyPatch) -> None:
    force = hf.robustness(TABLE, "slab", (0, 0, 0.25), (0, 0, -1)).force
    monkeypatch.setattr("holdfast.elastic.system.LONG", 0)
    again = hf.robustness(hf.assemble(TABLE), "slab", (0, 0, 0.25), (0, 0, -1)).force
    np.testing.assert_array_equal(again, force)
