"""The command ``carry``: exit codes, JSON, files, names, straps, the picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from calling import column, command

import holdfast as hf

carry = command("carry")


def test_it_says_what_gives_way_when(carry: Any) -> None:
    code, out, err = carry("cube", "--profile", "road", "--engine", "limit")
    assert (code, err) == (1, "")
    assert "gives way" in out
    assert "slip: cube" in out
    assert "0.03755 s" in out
    assert "0.8661 times" in out
    assert "tis-gdv.de" in out


def test_a_slower_drive_holds(carry: Any) -> None:
    code, out, _ = carry("cube", "--profile", "road", "--speed", 0.85)
    assert code == 0
    assert "holds" in out
    code, out, _ = carry("cube", "--profile", "road", "--engine", "limit", "--speed", 0.85)
    assert code == 3
    assert "an equilibrium exists at all times, which need not hold" in out


def test_files_and_names_are_told_apart(carry: Any, tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text("t,ax,ay,az\n0,0,0,0\n1,10,0,0\n")
    code, out, _ = carry("cube", "--profile", "drive.csv", "--engine", "limit", "--json")
    details = json.loads(out)["details"]
    assert code == 1
    assert json.loads(out)["verdict"] == "unstable"
    assert details["first"] == ["cube"]
    assert details["time"] == pytest.approx(0.5886, abs=2e-3)
    assert details["samples"]["time"] == column(out, "time") == [0.0, 1.0]
    assert column(out, "factor") == ["inf", pytest.approx(0.5886)]


def test_the_vehicle_drives_where_it_heads(carry: Any) -> None:
    """A tall box on a wedge: the wedge's own directions differ."""
    times = {}
    for heading in ((0, 1, 0), (0, -1, 0)):
        _, out, _ = carry("slope", "--profile", "eumos40509_0.8g", "--engine", "limit", "--json", "--heading", *heading)
        times[heading] = json.loads(out)["details"]["time_scale"]
    assert times[0, 1, 0] == pytest.approx((3.27 / (0.8 * 9.80665)) ** 0.5, rel=1e-3)
    assert times[0, -1, 0] == pytest.approx((11.772 / (0.8 * 9.80665)) ** 0.5, rel=1e-3)


@pytest.mark.parametrize(
    ("omega", "options", "code"),
    [
        (0, (), 0),
        (0, ("--tilt-degrees", 40, 0, 0), 1),  # beyond the angle of friction, 31 degrees
        (2, (), 0),
        (2, ("--pivot", 2, 0, 0), 1),  # 8 m/s² outwards, of 5.9 that friction bears
    ],
)
def test_a_carrier_leans_and_turns_about_a_point(
    omega: float, options: tuple[object, ...], code: int, carry: Any, tmp_path: Path
) -> None:
    rows = "".join(f"{t},0,0,0,0,0,0,0,0,{omega}\n" for t in (0, 1))
    (tmp_path / "turn.csv").write_text(rows)
    assert carry("cube", "--profile", "turn.csv", *options)[0] == code


def test_straps_hold_what_slips(carry: Any, tmp_path: Path) -> None:
    path = [["floor", 0, -0.05, 0], ["cube", 0, -0.05, 0.1], ["cube", 0, 0.05, 0.1], ["floor", 0, 0.05, 0]]
    (tmp_path / "straps.json").write_text(json.dumps([{"route": path, "pretension": 50}]))
    options = ("--profile", "eumos40509_0.8g", "--engine", "limit")
    assert carry("cube", *options)[0] == 1
    assert carry("cube", *options, "--straps", "straps.json")[0] == 3  # an equilibrium exists
    assert carry("cube", *options[:2], "--straps", "straps.json")[0] == 0


def test_answer_and_picture_are_written(carry: Any, tmp_path: Path) -> None:
    code, out, _ = carry("cube", "--profile", "road", "--engine", "limit", "--png", "c.png", "--save", "c.npz")
    assert code == 1
    assert "wrote c.png" in out
    assert (tmp_path / "c.png").stat().st_size > 20_000
    assert hf.load_answer(tmp_path / "c.npz").outcome is hf.Status.UNSTABLE
    code, _, err = carry("cube", "--profile", "road", "--png", "c.jpg")
    assert code == 2
    assert ".png" in err
