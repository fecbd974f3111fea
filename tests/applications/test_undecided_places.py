"""Placements go by what is decided, and transport and disassembly do not take the unknown for 0."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from retold import REASON, retold, unknown

import holdfast as hf
from holdfast.applications.placement import comparing, planner, support
from holdfast.queries import map as maps
from holdfast.report.pose_report import placement_report
from holdfast.scene.shipped.blocks import box, floor

UNDECIDED = hf.Status.UNDECIDED
SCENE = hf.Scene([floor(0.3, 0.3), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)
THING = hf.Body("object", hf.Box((0.05, 0.05, 0.05)), mass=0.2)


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Callable[..., hf.answers.Placement]:
    """Place the object, with the maps of it in place changed by ``changes`` in turn, the rest by the last of them.

    There are two for each pose, of the object and of the cube that it rests on; the last one is of both.
    """

    def call(*changes: Callable[[Any], Any], before: Callable[[Any], Any] = lambda found: found, **options: Any) -> Any:
        turn = itertools.chain(changes, itertools.repeat(changes[-1]))
        monkeypatch.setattr(comparing, "refined", lambda checks, after, pose, beneath: (pose, after))
        for module in (comparing, planner):
            monkeypatch.setattr(module, "robustness_map", lambda *a, **k: next(turn)(maps.robustness_map(*a, **k)))
        monkeypatch.setattr(support, "robustness_map", lambda *a, **k: before(maps.robustness_map(*a, **k)))
        return hf.plan_placement(
            hf.assemble(SCENE),
            THING,
            where=hf.Where(supports=["cube"]),
            search=hf.Search(spacing=0.02, **options),
            engine="graph",
        )

    return call


def same(found: Any) -> Any:
    return found


def weak(found: Any) -> Any:
    """Everything can be pushed with 1 mN."""
    return retold(found, slice(None), hf.Status.FINITE, force=1e-3)


def test_a_candidate_of_which_nothing_is_known_is_below_every_other(place: Any) -> None:
    p = place(unknown, unknown, weak, weak, same, candidates=2)
    assert p.status is hf.Status.STABLE
    assert [candidate.robustness for candidate in p.candidates] == [1e-3, None]
    q = place(weak, weak, unknown, unknown, same, candidates=2)
    assert [candidate.robustness for candidate in q.candidates] == [1e-3, None]
    assert (q.pose != p.pose).any(), "the other of the same two poses"


def test_a_candidate_whose_object_is_unknown_is_below_a_known_one(place: Any) -> None:
    def hidden(found: Any) -> Any:
        return retold(found, found.body == "object", UNDECIDED)

    p = place(hidden, hidden, weak, weak, same, candidates=2)
    assert p.candidates[0].robustness == 1e-3
    assert p.candidates[1].robustness > 1e-3


def test_the_score_is_that_of_the_decided_points(place: Any) -> None:
    def some(found: Any) -> Any:
        return retold(found, [found.answers.ranking[0]], UNDECIDED, notes=(REASON,))

    plain, p = place(same), place(some)
    n = len(p.map.force)
    assert plain.reason == "everything stands with it"
    assert p.robustness == pytest.approx(np.sort(plain.map.force)[1])
    assert p.weakest.status is hf.Status.FINITE
    told = f"1 of {n:,} points of the map is undecided ({100 / n:.3g} %): {REASON}"
    assert f"{told}; the other points hold at least" in p.reason
    assert p.to_dict()["undecided"]["count"] == 1
    assert told in repr(p)


def test_a_place_of_which_nothing_is_known_says_so(place: Any, tmp_path: Any) -> None:
    p = place(unknown)
    assert p.status is hf.Status.STABLE, "it stands"
    assert p.weakest.status is UNDECIDED
    assert dict(p.summary().facts)["least push afterwards"] == "undecided"
    told = "\n".join(str(part) for part in placement_report(p, "scene", "object").parts)
    assert "least push afterwards: undecided" in told
    assert "0 N" not in told
    p.save_png(tmp_path / "p.png")


def test_supports_of_which_nothing_is_known_carry_nothing(place: Any) -> None:
    p = place(same, before=unknown)
    assert p.status is UNDECIDED
    assert p.pose is None
    assert "certainly withstands a push" in p.reason
    assert REASON in p.reason


def test_an_unknown_limit_promises_no_speed() -> None:
    found = hf.transport_limits(hf.assemble(SCENE), [[1, 0, 0], [0, 1, 0]])
    path = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    assert hf.sets.safe_time_scale(path, found) > 1
    assert hf.sets.safe_time_scale(path, retold(found, [0], UNDECIDED)) == 0


def test_the_least_limit_is_a_decided_one() -> None:
    found = hf.transport_limits(hf.assemble(SCENE), engine="limit")
    told = retold(found, slice(0, 30), UNDECIDED, notes=(REASON,))
    assert f"30 of 100 undecided (30 %): {REASON}" in repr(told)
    assert "the least 0 " not in repr(told)
    assert [row[3] for row in told.summary().rows] == ["finite"] * 8


def test_a_disassembly_counts_what_it_does_not_know() -> None:
    """Engine limit cannot tell whether neighbours clamp a body: voussoirs between others."""
    found = hf.disassembly_order(hf.assemble(hf.shipped_scene("wedged_floor")), engine="limit")
    stuck = [removal for removal in found.stuck if removal.answer == "undecided"]
    assert found.undecided.count == len(stuck)
    assert found.undecided.rows == len(found.remaining)
    assert found.to_dict()["undecided"]["count"] == len(stuck)
    assert found.blocked == {removal.body: removal.reason for removal in found.stuck}


def test_the_papers_test_has_no_force_where_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    d = hf.disassembly_order(hf.assemble(SCENE), engine="limit")
    (row,) = d.paper_table()
    assert row.force == pytest.approx(9.81, rel=1e-3)
    state = d.removals.state(frozenset({"cube"}))

    class Doubtful:
        def load_factor(self, *asked: Any) -> Any:
            answers = state.load_factor(*asked)
            status = np.array([UNDECIDED] * len(answers), dtype=object)
            return dataclasses.replace(
                answers, status=status, force=np.zeros(len(answers)), lower=np.zeros(len(answers))
            )

    monkeypatch.setattr(d.removals, "state", lambda part: Doubtful())
    (row,) = d.paper_table()
    assert (row.force, row.removable) == (None, False)
