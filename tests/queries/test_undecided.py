"""Undecided answers are never ranked as 0, and every output counts them with the reason."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest
from retold import REASON, retold, unknown

import holdfast as hf
from holdfast.engines.answers import Answers
from holdfast.engines.limit_engine import corners_of, weakest
from holdfast.scene.shipped.blocks import cube, table

UNDECIDED, UNSTABLE, FINITE = hf.Status.UNDECIDED, hf.Status.UNSTABLE, hf.Status.FINITE


@pytest.fixture(scope="module")
def whole() -> hf.answers.RobustnessMap:
    return hf.robustness_map(hf.assemble(table()), spacing=0.05, engine="graph")


@pytest.fixture(scope="module")
def pushes() -> hf.answers.Robustness:
    points = [(-0.05, 0.01 * k, 0.09) for k in range(5)]
    return hf.robustness(hf.assemble(cube()), "cube", points, (1, 0, 0), engine="graph")


def on(found: hf.answers.RobustnessMap, body: str) -> Any:
    return np.flatnonzero(found.body == body)


def test_the_weakest_point_is_a_decided_one(whole: hf.answers.RobustnessMap) -> None:
    found = retold(whole, on(whole, "slab"), UNDECIDED)
    weak = found.weakest()
    assert weak.status is FINITE
    assert weak.force == pytest.approx(whole.force[whole.body != "slab"].min(), rel=1e-6)
    bodies = found.weakest_of_each_body()
    assert [point.body for point in bodies][-1] == "slab"
    assert [point.status for point in bodies] == [FINITE, FINITE, UNDECIDED]


def test_an_undecided_point_does_not_hide_the_weakest_of_its_body(whole: hf.answers.RobustnessMap) -> None:
    first, second = whole.answers.ranking[:2]
    found = retold(whole, [first], UNDECIDED)
    assert found.weakest().point == tuple(whole.points[second])
    assert found.weakest().force == whole.force[second]


def test_endless_points_are_ranked_before_undecided_ones(whole: hf.answers.RobustnessMap) -> None:
    found = retold(whole, slice(None), hf.Status.INFINITE, force=np.inf)
    found = retold(found, slice(0, 3), UNDECIDED)
    assert found.weakest().status is hf.Status.INFINITE
    assert set(found.answers.ranking[-3:]) == {0, 1, 2}


@pytest.mark.parametrize("status", [UNSTABLE, FINITE])
def test_falling_and_balanced_bodies_are_decided_and_rank_as_zero(
    whole: hf.answers.RobustnessMap, status: hf.Status
) -> None:
    found = retold(retold(whole, on(whole, "slab"), UNDECIDED), on(whole, "leg_left"), status)
    assert (found.weakest().body, found.weakest().status, found.weakest().force) == ("leg_left", status, 0)
    assert found.undecided.count == len(on(whole, "slab"))


def test_with_nothing_decided_the_weakest_point_says_so(whole: hf.answers.RobustnessMap) -> None:
    found = unknown(whole)
    assert found.weakest().status is UNDECIDED
    assert {point.status for point in found.weakest_of_each_body()} == {UNDECIDED}
    assert found.undecided.share == 1
    assert "the least" not in repr(found)


def test_count_share_and_reason_are_in_every_output(whole: hf.answers.RobustnessMap) -> None:
    rows = on(whole, "slab")
    found = retold(whole, rows, UNDECIDED, notes=("faces are flat", REASON))
    n = len(whole.force)
    text = f"{len(rows)} of {n} undecided ({100 * len(rows) / n:.3g} %): {REASON}"
    assert found.undecided.text == text
    assert text in found.summary().headline
    assert text in repr(found)
    assert text in found._repr_html_()
    data = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert data["undecided"] == {"count": len(rows), "share": len(rows) / n, "reasons": [REASON]}
    assert data["weakest"]["status"] == "finite"
    shown = {row[0]: row[1] for row in found.summary().rows}
    assert shown["slab"] == "?"
    assert shown["leg_left"].endswith(" N")


def test_where_all_is_decided_nothing_is_said(whole: hf.answers.RobustnessMap) -> None:
    assert whole.to_dict()["undecided"] == {"count": 0, "share": 0, "reasons": []}
    assert whole.undecided.text == ""
    assert "undecided" not in repr(whole) + whole._repr_html_()


def test_the_reason_is_that_of_the_verdict_or_of_the_engine(pushes: hf.answers.Robustness) -> None:
    assert retold(pushes, [0], UNDECIDED).undecided.reasons == (
        "engine graph found neither that the load is held nor what it moves",
    )
    verdict = dataclasses.replace(pushes.verdict, status=UNDECIDED, reason="its contacts are sharp")
    doubted = dataclasses.replace(pushes, answers=dataclasses.replace(pushes.answers, verdict=verdict))
    assert retold(doubted, [0], UNDECIDED).undecided.reasons == ("its contacts are sharp",)
    assert doubted.undecided.reasons == ()


def test_many_reasons_are_cut(pushes: hf.answers.Robustness) -> None:
    notes = tuple(f"body {k}: undecided" for k in range(9))
    found = retold(pushes, [0, 1], UNDECIDED, notes=notes)
    assert found.undecided.reasons == notes
    assert found.undecided.text.endswith("body 2: undecided; and 6 more reasons")


def test_summaries_of_pushes_and_factors(pushes: hf.answers.Robustness) -> None:
    found = retold(pushes, [0, 2], UNDECIDED)
    rows = found.summary().rows
    assert [row[1] for row in rows][-2:] == ["?", "?"]
    assert [row[3] for row in rows] == ["finite"] * 3 + ["undecided"] * 2
    assert "2 of 5 undecided (40 %)" in repr(found)
    factor = hf.load_factor(hf.assemble(cube()), [hf.Load("cube", (0, 0, 0.05), (1, 0, 0))], engine="graph")
    assert "multiplied by 5.886" in repr(factor)
    assert "1 of 1 undecided (100 %)" in repr(unknown(factor))
    assert unknown(factor).to_dict()["undecided"]["count"] == 1


def test_a_quantile_tells_whether_it_is_an_answer() -> None:
    """Ten samples at two points: zero, two or four of them undecided, three that fall, the rest decided."""
    u = hf.robustness_under(
        hf.assemble(cube()),
        "cube",
        [(-0.05, 0, 0.01), (-0.05, 0.01, 0.01)],
        (1, 0, 0),
        uncertain=hf.sets.Uncertain(mu_range=0.2, samples=10),
        engine="graph",
    )
    assert u.known(0).all()
    assert u.undecided_pushes.count == 0
    at_first = 2 * np.arange(10)
    doubted = retold(retold(u, at_first[:4], UNDECIDED), at_first[4:7], UNSTABLE)
    assert doubted.quantile(0.5)[0] == 0
    assert [bool(doubted.known(q)[0]) for q in (0, 0.2, 0.34, 0.5, 0.7, 0.8)] == [True, True, False, False, False, True]
    assert doubted.known(0.5)[1]
    rows = doubted.summary().rows
    assert rows[-1][0] == "(-0.050, 0.000, 0.010) m"
    assert rows[-1][2:] == ["?", "0 N"]
    data = doubted.to_dict()
    assert data["undecided"] == 0, "still the share of the samples"
    assert data["undecided_pushes"]["count"] == 4
    assert "4 of 20 undecided (20 %)" in repr(doubted)


def test_the_worst_case_is_undecided_only_where_a_corner_may_be_weaker() -> None:
    """An undecided corner beats a finite one but not a force 0 that is known."""
    assembly = hf.assemble(cube())
    base = hf.robustness(assembly, "cube", [(-0.05, 0, 0.01)] * 4, (1, 0, 0), engine="limit").answers
    statuses = [(FINITE, UNDECIDED, UNDECIDED, UNDECIDED), (FINITE, FINITE, UNSTABLE, FINITE)]
    forces = [(3.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, 5.0)]
    tables = [
        dataclasses.replace(base, status=np.array(s, dtype=object), force=np.array(f), lower=np.zeros(4))
        for s, f in zip(statuses, forces, strict=True)
    ]

    class Told:
        def __init__(self, answers: Answers) -> None:
            self.answers = answers

        def load_factor(self, _: object) -> Answers:
            return self.answers

    states = iter(Told(table) for table in tables)
    corners = corners_of(assembly, {"cube": (1.0, 2.0)}, {}, "test")
    found = weakest(assembly, lambda _: next(states), np.zeros(6), np.zeros((6, 4)), corners)  # type: ignore[arg-type,return-value]
    assert list(found.answers.status) == [FINITE, FINITE, UNSTABLE, UNDECIDED]
    assert found.answers.force == pytest.approx([3, 0, 0, 0])
    states = iter(Told(table) for table in tables[::-1])
    again = weakest(assembly, lambda _: next(states), np.zeros(6), np.zeros((6, 4)), corners)  # type: ignore[arg-type,return-value]
    assert list(again.answers.status) == list(found.answers.status)


def test_the_strongest_point_is_decided_and_an_infinite_one_comes_first(whole: hf.answers.RobustnessMap) -> None:
    strong = whole.strongest()
    assert strong == whole.at(int(np.argmax(whole.force)))
    if not np.isinf(strong.force):
        assert (whole.force <= strong.force).all()
    best = int(np.argmax(whole.force))
    doubted = retold(whole, [best], UNDECIDED)
    others = np.delete(np.arange(len(whole.force)), best)
    assert doubted.strongest().force == whole.force[others].max()
    assert unknown(whole).strongest().status is UNDECIDED
