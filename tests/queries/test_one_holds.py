"""One number is said to hold: the least lower bound of all rows, in every form of an answer, with its row (P3)."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from retold import shelf
from rich.console import Console

import holdfast as hf
from holdfast.base.public import number
from holdfast.report.carrier_report import carried_report, polar_picture, timeline, transport_report
from holdfast.report.contact_report import map_report, push_report
from holdfast.report.map_picture import picture_of


def down(value: float) -> str:
    """Four digits that say no more than the value."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.floor(value / step) * step:.4g}"


def text_of(report: Any) -> str:
    """A report as it stands in a wide terminal."""
    console = Console(file=io.StringIO(), width=400)
    console.print(report)
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_transport_says_one_number_in_its_head_table_picture_and_json() -> None:
    found = hf.transport_limits(shelf())
    row = int(np.argmin(found.lower))
    assert found.lower[row] < found.lower[int(np.argmin(found.acceleration))]  # here the two directions differ
    value, degrees = down(found.lower[row]), f"{3.6 * row:.4g}°"
    told = text_of(transport_report(found))
    assert f"estimated to hold up to {value} m/s² in each of these directions, the least towards {degrees}" in told
    (arc,) = [line.split() for line in told.splitlines() if "topple: vase" in line and "from" not in line]
    assert arc[4:6] == [value, degrees]
    lines = polar_picture([found]).curves[0].lines
    assert f"estimated to hold up to {value} in all of these, the least at {degrees}" in lines
    assert f"estimated to hold up to {value} m/s²" in repr(found)
    data = json.loads(json.dumps(found.to_dict()))
    assert data["holds"] == {"lower": found.lower[row], "row": row, "direction": found.directions[row].tolist()}


def test_a_map_says_what_holds_at_its_points_and_not_between_them() -> None:
    found = hf.robustness_map(shelf(), spacing=0.03)
    row = int(np.argmin(found.lower))
    held = f"estimated to hold up to {down(found.lower[row])} N"
    assert f"{held} at each of these points, the least on {found.body[row]} at (" in text_of(map_report(found))
    assert f"{held} at each of these points" in picture_of(found).subtitle
    holds = found.to_dict()["holds"]
    assert (holds["row"], holds["body"], holds["lower"]) == (row, found.body[row], found.lower[row])


def test_what_is_carried_is_judged_by_the_least_of_all_times() -> None:
    motion = hf.Profile(np.linspace(0, 1, 21), [(2 * np.sin(6 * t), 0, 0) for t in np.linspace(0, 1, 21)])
    found = hf.carry(shelf(), motion)
    row = int(np.argmin(found.lower))
    assert found.to_dict()["holds"] == {"lower": found.lower[row], "row": row, "time": float(motion.time[row])}
    assert found.time_scale() == pytest.approx(np.sqrt(found.lower[row]))
    assert f"at most {100 / found.lower[row]:.3g} %" in found.reason
    assert found.reason.endswith(f"withstands, at {number(float(motion.time[row]), 's')}")
    assert found.reason in timeline(found).lines[0]
    assert down(found.lower[row]) in text_of(carried_report(found)).split("times with the smallest factors")[1]


@pytest.mark.parametrize(
    ("engine", "head", "said"),
    [
        ("compliant", "(engine compliant: contacts at rest)", "proved to hold up to "),
        ("limit", "(engine limit: an equilibrium exists)", "proved to have an equilibrium up to "),
        ("graph", "(engine graph: an estimate)", "no bound is known on either side"),
    ],
)
def test_what_an_engine_claims_is_not_said_as_what_a_number_promises(engine: str, head: str, said: str) -> None:
    found = hf.robustness(shelf(), "vase", (0.07, 0, 0.15), (1, 0, 0), engine=engine)
    first, second = text_of(push_report(found)).splitlines()[:2]
    assert head in first
    assert "holds" not in first
    assert second.startswith(said)
    if engine == "graph":
        assert found.to_dict()["holds"] is None


def test_an_undecided_row_promises_nothing_for_all() -> None:
    found = hf.transport_limits(shelf(), [(1, 0, 0), (0, 1, 0)])
    lower = found.lower.copy()
    assert hf.transport_limits(shelf(), [(1, 0, 0)]).to_dict()["holds"]["row"] == 0
    lower[1] = 0.0
    doubtful = replace(found, answers=replace(found.answers, lower=lower))
    assert doubtful.to_dict()["holds"] == {"lower": 0.0, "row": 1, "direction": [0.0, 1.0, 0.0]}
    assert "in each of these directions, the least" not in text_of(transport_report(doubtful))


def test_what_only_a_hold_keeps_is_said_to_move() -> None:
    """No contact slides, opens or rolls there, so the mode is "none", which in a sentence would deny the motion."""
    base = hf.Body("base", hf.Box((0.1, 0.1, 0.1)), fixed=True, position=(0, 0, -0.5))
    box = hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=1.0)
    hand = hf.Hold("box", hf.pose(0, 0, 0), forces=20.0, moments=1.0)
    held = hf.Scene([base, box], 0.5, holds=[hand])
    found = hf.robustness(held, "box", (0, 0, 0.05), (0, 0, -1), engine="limit")
    assert found.mode[0] == "none"
    assert found.summary().rows[0][-1] == "motion: box"


def test_a_direction_that_is_undecided_takes_no_promise_from_those_without_a_limit() -> None:
    found = hf.transport_limits(shelf(), [(1, 0, 0), (0, 1, 0)])
    endless = {"force": np.array([0.0, np.inf]), "lower": np.array([0.0, np.inf])}
    status = np.array([hf.Status.UNDECIDED, hf.Status.INFINITE], dtype=object)
    told = text_of(transport_report(replace(found, answers=replace(found.answers, status=status, **endless))))
    assert "however fast it accelerates: nothing moves" in told
    assert "no limit found" not in told
