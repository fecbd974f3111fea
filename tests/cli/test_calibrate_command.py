"""The command ``calibrate``: friction from a file of measured pushes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from calling import command

import holdfast as hf
from holdfast.cli.calibrate_command import measured_pushes

calibrate = command("calibrate")
HEAD = "body,x,y,z,dx,dy,dz,force,moved\n"


def written(folder: Path, *ends: str, head: str = HEAD) -> Path:
    """A file of pushes on the shipped cube, where it slides at mu m g; ``ends`` are their forces and what follows."""
    lines = [f"cube,-0.05,0,0.001,1,0,0,{end}\n" for end in ends]
    (folder / "pushes.csv").write_text(head + "".join(lines))
    return folder / "pushes.csv"


def test_it_says_what_friction_is_and_how_surely(calibrate: Any, tmp_path: Path) -> None:
    pushes = written(tmp_path, "4.905,1", "4.5,yes", "5.3,", "4.0,no")
    code, out, err = calibrate("cube", pushes, "--engine", "limit")
    assert (code, err) == (0, "")
    said = " ".join(out.split())
    assert "4 pushes, 3 of which moved something: friction of 1 of 1 pairs" in said
    assert "cube and floor" in said
    assert "95% interval" in said
    assert "4 N, held" in said
    code, out, _ = calibrate("cube", pushes, "--engine", "limit", "--json", "--save", "friction.json")
    data = json.loads(out)
    saved = hf.load_answer("friction.json")
    assert isinstance(saved, hf.answers.MeasuredFriction)
    assert data["details"]["mu"] == {"cube-floor": saved.mu["cube", "floor"]}
    assert [row["moved"] for row in data["rows"]] == [True, True, True, False]
    assert saved.mu["cube", "floor"] == pytest.approx(0.5, rel=0.02)


def test_every_word_for_what_moved_is_read(tmp_path: Path) -> None:
    words = {"1": True, "true": True, "YES": True, "": True, "0": False, "False": False, "no": False}
    pushes = measured_pushes(written(tmp_path, *(f"4,{word}" for word in words)))
    assert [push[-1] for push in pushes] == [*words.values()]


def test_scatter_and_confidence_are_options(calibrate: Any, tmp_path: Path) -> None:
    one = written(tmp_path, "4.905", head=HEAD.replace(",moved", ""))
    told = json.loads(calibrate("cube", one, "--scatter", 0.1, "--confidence", 0.5, "--json")[1])
    low, high = told["details"]["intervals"]["cube-floor"]
    assert high / low == pytest.approx(2.7183 ** (2 * 0.6745 * 0.1), rel=1e-3)
    code, _, err = calibrate("cube", one)
    assert code == 2
    assert "cannot be estimated from 1 pushes" in err


def test_pushes_that_contradict_each_other_are_undecided(calibrate: Any, tmp_path: Path) -> None:
    code, out, _ = calibrate("cube", written(tmp_path, "1,1", "9,1"), "--scatter", 0.1)
    assert code == 3
    assert "no coefficients explain the pushes" in " ".join(out.split())


@pytest.mark.parametrize(
    ("ends", "head", "says"),
    [
        ((), HEAD, "is empty; needs at least one push"),
        (("1,maybe",), HEAD, "pushes.csv, line 2: moved is 'maybe'; needs 1, 0, true, false, yes or no"),
        (("x,1",), HEAD, "line 2: holds no seven numbers; needs x, y, z, dx, dy, dz, force"),
        (("nan,1", "1,1"), HEAD, "push 0: force: is nan"),
        (("1",), "body,x,y,z,dx,dy,dz\n", "has no column 'force'"),
        (("1,no",), HEAD.replace("moved", "Moved"), "has a column 'Moved'; needs body"),
    ],
)
def test_a_bad_file_is_one_clear_error(
    calibrate: Any, tmp_path: Path, ends: tuple[str, ...], head: str, says: str
) -> None:
    code, _, err = calibrate("cube", written(tmp_path, *ends, head=head))
    assert code == 2
    assert says in " ".join(err.split())
