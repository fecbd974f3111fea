"""How poses are rated, and how the best are moved to where there is more room."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.placement.checks import Checks
from holdfast.applications.placement.comparing import Clock, rated, refined
from holdfast.applications.placement.planner import planner
from holdfast.applications.placement.result import Candidate
from holdfast.scene.shipped.blocks import at, box, floor

GOOD = hf.answers.Rating(own=2.0, beneath=8.0, edge=0.03, clearance=0.05, rolls=False, upright=True, size=0.12)
NONE = np.empty((0, 3))


def test_the_score_against_its_formula() -> None:
    assert GOOD.least == 2.0
    assert GOOD.room == 0.03
    assert GOOD.score == pytest.approx(2.0 * (0.25 * 0.03 + 0.03) / (0.03 + 0.03))
    assert replace(GOOD, edge=0.0).score == pytest.approx(0.25 * 2.0)
    assert replace(GOOD, upright=False).score == pytest.approx(GOOD.score / 2)
    assert replace(GOOD, own=None).least == 8.0


@pytest.mark.parametrize(
    "worse",
    [
        {"own": 1.0},
        {"beneath": 1.0},
        {"edge": 0.02},
        {"clearance": 0.02},
        {"upright": False},
        {"rolls": True, "own": 100.0, "beneath": 100.0},
        {"own": None, "beneath": 100.0},
    ],
    ids=lambda worse: next(iter(worse)),
)
def test_what_makes_a_pose_worse(worse) -> None:
    assert replace(GOOD, **worse).key < GOOD.key


def test_a_pose_that_rolls_is_better_than_one_of_which_nothing_is_known() -> None:
    assert replace(GOOD, rolls=True).key > replace(GOOD, own=None).key


def slab_with(*others: hf.Body) -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([floor(), box("slab", (0.4, 0.3, 0.02), 3, (0, 0, 0.01)), *others], 0.5))


def moved(
    assembly: hf.answers.Assembly, x: float, y: float, next_to: str | None = None
) -> tuple[np.ndarray, hf.answers.Assembly]:
    """A cube of 5 cm put on the slab at x, y, and moved from there to where there is more room."""
    thing = hf.Body("thing", hf.Box((0.05, 0.05, 0.05)), mass=0.3)
    checks = planner(assembly, thing, where=hf.Where(supports=["slab"], next_to=next_to), engine="graph").checks
    fault, after = checks.fault(at(x, y, 0.045))
    assert fault == ""
    return refined(checks, after, at(x, y, 0.045), ("floor", "slab"))


def test_from_the_corner_to_the_middle() -> None:
    """The room on an empty slab is half its width less half the cube, 12.5 cm, at most; it is capped by the size."""
    pose, after = moved(slab_with(), 0.17, 0.12)
    thing = after.scene.body("thing")
    room = np.array([0.2, 0.15]) - np.abs(thing.surface_world.vertices[:, :2]).max(0)
    assert room.min() >= min(0.9 * 0.125, thing.size) - 0.01
    assert pose[2, 3] == 0.045
    assert hf.stability(after).status is hf.Status.STABLE


def test_away_from_a_neighbour_and_across_it() -> None:
    """A wall cuts off a strip of the slab in which there is little room: there is more on its other side."""
    wall = box("wall", (0.02, 0.3, 0.1), 1, (0.1, 0, 0.07))
    pose, after = moved(slab_with(wall), 0.15, 0)
    assert pose[0, 3] < 0.05
    assert hf.stability(after).status is hf.Status.STABLE


def test_not_away_from_what_it_is_next_to() -> None:
    """In the middle of the slab the edges are farthest; only a post beside it would drive the object from there."""
    beside = slab_with(box("post", (0.02, 0.02, 0.1), 1, (-0.05, 0, 0.07)))
    assert moved(beside, 0, 0)[0][0, 3] > 0.01
    assert moved(beside, 0, 0, next_to="post")[0][:2, 3].tolist() == [0, 0]


def test_every_step_leads_to_more_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether everything stands is only asked of poses with more room than the last one in which it did."""
    rooms, stood = list[float](), list[float]()
    room, judged = Checks.room, Checks.judged

    def seen(*given: Any) -> tuple[float, float]:
        found = room(*given)
        rooms.append(min(found))
        return found

    def asked(checks: Checks, after: hf.answers.Assembly) -> tuple[str, hf.answers.Assembly | None]:
        assert not stood or rooms[-1] > max(stood), "a step to where there is less room"
        fault, stands = judged(checks, after)
        if stands is not None:
            stood.append(rooms[-1] if rooms else 0.0)
        return fault, stands

    monkeypatch.setattr(Checks, "room", seen)
    monkeypatch.setattr(Checks, "judged", asked)
    moved(slab_with(), 0.17, 0.12)
    assert len(stood) > 1, "the pose from which it starts, and steps"


def test_a_weak_neighbour_does_not_change_the_rating() -> None:
    pin = box("pin", (0.005, 0.005, 0.1), 0.001, (-0.15, 0, 0.07))
    forces = []
    for assembly in (slab_with(), slab_with(pin)):
        thing = hf.Body("thing", hf.Box((0.05, 0.05, 0.05)), mass=0.3)
        asked = planner(assembly, thing, where=hf.Where(supports=["slab"]), engine="graph")
        _, after = asked.checks.fault(at(0.1, 0, 0.045))
        found = rated(
            asked.checks, asked.faces, Candidate(at(0.1, 0, 0.045), NONE, NONE, ""), after, Clock.started(None)
        )
        forces.append(found.rating.own)
        assert found.beneath == ("floor", "slab")
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


def test_shares_of_a_budget_come_one_after_the_other() -> None:
    clock = Clock.started(10.0)
    ends = [clock.by(stage) - clock.start for stage in ("map", "coarse map", "search", "compare", "refine", "end")]
    assert ends == sorted(ends)
    assert 0 < ends[0] < ends[-1] < 10
    assert clock.by("end", 0.5) - clock.start == pytest.approx(ends[-1] / 2)
    assert Clock.started(None).by("map") == np.inf
