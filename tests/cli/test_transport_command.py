"""The command ``transport``: exit codes, JSON, the set, the picture."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from calling import column, command

import holdfast as hf
from holdfast.cli import carrier_commands as module
from holdfast.cli import command as shared
from holdfast.report import carrier_report

transport = command("transport")
AXES = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]


def test_it_says_what_gives_way_where(transport: Any) -> None:
    code, out, err = transport("slope", "--engine", "limit", "--count", 36)
    assert (code, err) == (0, "")
    assert "stands on its carrier, 36 directions" in out
    assert "3.27" in out
    assert "topple: cube1" in out
    assert "11.77" in out


def test_the_answer_comes_first_in_one_sentence(transport: Any) -> None:
    """A cube of friction 0.6 slips at 0.6 g whichever way it is carried; the least lower bound is that of all ways."""
    code, out, _ = transport("cube", "--engine", "limit", "--count", 8)
    said = " ".join(out.partition("largest acceleration")[0].split())
    assert code == 0
    assert "+x is 0°, +y is 90°" in said
    assert f"beyond {0.6 * 9.81:.4g} m/s²" in said
    assert "slip of cube" in said
    least = hf.transport_limits(hf.shipped_scene("table")).lower.min()
    _, out, _ = transport("table")
    said = " ".join(out.partition("largest acceleration")[0].split())
    told = float(said.partition("estimated to hold up to ")[2].partition(" m/s² in each of these directions, the ")[0])
    assert least - 0.001 < told <= least


def test_a_long_story_is_told_in_few_parts(transport: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neighbouring directions that move the same bodies share a row, and the weakest rows are told."""
    code, out, _ = transport("tabletop", "--engine", "limit", "--count", 48)
    assert code == 0
    table = "largest acceleration of the carrier"
    assert 3 * 4 <= out.partition(table)[2].count("°") <= 12 * 4
    monkeypatch.setattr(carrier_report, "ARCS", 2)
    code, out, _ = transport("tabletop", "--engine", "limit", "--count", 48)
    assert out.partition(table)[2].count("°") == 2 * 4
    assert "upper_book" in out


def test_the_json_has_the_attributes(transport: Any) -> None:
    code, out, _ = transport("cube", "--count", 8, "--json")
    data = json.loads(out)
    assert code == 0
    told = "direction acceleration status lower upper moving mode mechanism"
    assert all(set(row) == set(told.split()) for row in data["rows"])
    assert column(out, "acceleration") == pytest.approx([0.6 * 9.81] * 8, rel=1e-4)
    assert column(out, "status") == ["finite"] * 8
    assert column(out, "upper") == ["inf"] * 8
    assert data["rows"][0]["mechanism"]["moving"] == ["cube"]


def test_motion_of_the_tray(transport: Any) -> None:
    """Friction bears what gravity leaves of it across, less what the turning takes outwards, towards -x."""
    options = ("--tilt-degrees", 10, 0, 0, "--angular-velocity", 0, 0, 2, "--pivot", 0.5, 0, 0, "--bounds")
    _, out, _ = transport("cube", "--count", 4, "--json", "--engine", "limit", *options)
    along, across = 9.81 * math.cos(math.radians(10)), 9.81 * math.sin(math.radians(10))
    expected = math.sqrt((0.6 * along) ** 2 - across**2) - 2**2 * 0.5
    assert column(out, "acceleration")[0] == pytest.approx(expected, rel=1e-3)
    assert json.loads(out)["details"]["gravity"] == pytest.approx([0, -across, -along])


def test_a_jolt_upwards_presses_the_load_down(transport: Any) -> None:
    for jolt in (2, -2):
        _, out, _ = transport("cube", "--count", 4, "--json", "--engine", "limit", "--jolt", jolt)
        assert column(out, "acceleration") == pytest.approx([0.6 * (9.81 + jolt)] * 4, rel=1e-4)


def test_the_set_and_the_picture_are_written(transport: Any) -> None:
    for name in ("set.json", "set.npz"):
        code, out, _ = transport("cube", "--engine", "limit", "--compare", "graph", "--set", name, "--png", "p.png")
        assert code == 0
        assert f"wrote {name}" in out
        assert hf.load_answer(name).exists([5.7, 0, 0]) is True
        assert Path("p.png").read_bytes().startswith(b"\x89PNG")


def test_the_set_is_of_what_holds_unless_engine_limit_is_asked(transport: Any) -> None:
    assert transport("cube", "--set", "set.json")[0] == 0
    assert hf.load_answer("set.json").contains([5.4, 0, 0]) is True


def test_what_does_not_stand_has_no_set(transport: Any) -> None:
    code, out, err = transport("cube", "--tilt-degrees", 40, 0, 0, "--set", "set.json", "--png", "p.png")
    assert code == 1
    assert "does not stand" in out
    assert "no set written: the assembly is unstable" in err
    assert not Path("set.json").exists()
    assert Path("p.png").exists()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (("--count", 0), "count: is 0"),
        (("--set", "set.txt"), ".json or .npz"),
        (("--png", "p.jpg"), "--png"),
        (("--compare", "grap"), "'grap' is unknown"),
        (("--bodies", "floor"), "is fixed"),
    ],
)
def test_bad_input(options: tuple[object, ...], match: str, transport: Any) -> None:
    code, out, err = transport("cube", *options)
    assert code == 2
    assert out == ""
    assert match in err
    assert err.count("\n") == 1


def test_each_quarter_turn_is_told_where_they_differ(transport: Any) -> None:
    """On a ramp the load slides down first when the carrier accelerates towards the upper end."""
    _, out, _ = transport("slope", "--engine", "limit", "--count", 8)
    told = {
        f"{90 * k}°": f"{v:.4g}"
        for k, v in enumerate(hf.transport_limits(hf.shipped_scene("slope"), AXES, engine="limit").acceleration)
    }
    for angle, value in told.items():
        assert f"towards {angle}: {value} m/s²" in " ".join(out.split())
    assert len(set(told.values())) > 1
    _, out, _ = transport("cube", "--engine", "limit", "--count", 8)
    assert "towards 90°:" not in out


def test_a_picture_that_cannot_be_drawn_is_refused_before_anything_is_computed(
    transport: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared, "find_spec", lambda name: None)
    monkeypatch.setattr(module, "transport_limits", lambda *a, **k: pytest.fail("was computed"))
    code, _, err = transport("cube", "--png", "p.png")
    assert code == 2
    assert "pip install 'holdfast-robotics[viewer]'" in err
