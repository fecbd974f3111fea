"""The command ``disassemble`` and its strip of pictures."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import holdfast as hf
from holdfast.report.disassembly import strip_of
from holdfast.scene.shipped import shipped_scene


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "holdfast", "disassemble", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def test_a_strip_and_the_steps(tmp_path: Path) -> None:
    done = run("cantilever", "--png", tmp_path / "strip.png")
    assert done.returncode == 0, done.stderr
    assert "all 4 bodies come out one by one" in done.stdout
    assert [line.split()[1] for line in done.stdout.splitlines() if line.strip()[:1] in "1234" and line.strip()] == [
        *"CDBA"
    ]
    assert (tmp_path / "strip.png").read_bytes()[:4] == b"\x89PNG"


def test_json_of_a_goal() -> None:
    done = run("cantilever", "--goal", "D", "--json")
    data = json.loads(done.stdout)
    assert data["order"] == ["C", "D"]
    assert data["assembly_order"] == ["D", "C"]
    assert (data["fewest"], data["proven"], data["reached"], data["blocked"]) == (2.0, True, True, {})
    assert [step["answer"] for step in data["steps"]] == ["safe", "safe"]


def test_an_arch_ends_with_1_and_reasons() -> None:
    done = run("arch", "--json")
    assert done.returncode == 1
    data = json.loads(done.stdout)
    assert data["fewest"] == "inf"
    assert set(data["blocked"]) == {f"v{k}" for k in range(1, 6)}


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("stack", "--goal", "cube7"), "did you mean"),
        (("stack", "--png", "a.jpg"), ".png"),
    ],
)
def test_bad_input_ends_with_2(arguments: tuple[str, ...], text: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert text in done.stderr


def test_what_does_not_stand_ends_with_1() -> None:
    done = run("wedged")
    assert done.returncode == 1
    assert "does not stand" in done.stderr


def test_a_goal_that_nothing_reaches_is_said_to_be_out_of_reach() -> None:
    done = run("arch", "--goal", "v3")
    assert done.returncode == 1
    assert "v3 cannot be taken out" in done.stdout


def test_the_strip_shows_every_state_and_colours_what_goes_next() -> None:
    d = hf.disassembly_order(hf.assemble(shipped_scene("cantilever")), goal="D")
    strip = strip_of(d)
    assert [frame.next for frame in strip.frames] == ["C", "D", ""]
    names = [[solid.name for solid in frame.solids] for frame in strip.frames]
    assert names == [["floor", "A", "B", "C", "D"], ["floor", "A", "B", "D"], ["floor", "A", "B"]]
    np.testing.assert_array_equal(strip.up, [0, 0, 1])
