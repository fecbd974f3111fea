"""The command ``disassemble`` and its strip of pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calling import Call, column, command

import holdfast as hf
from holdfast.report.order_report import strip_of
from holdfast.scene.shipped import shipped_scene

disassemble = command("disassemble")


def test_a_strip_and_the_steps(disassemble: Call, tmp_path: Path) -> None:
    code, out, err = disassemble("cantilever", "--png", "strip.png")
    assert code == 0, err
    assert "all 4 bodies come out one by one" in out
    assert [line.split()[1] for line in out.splitlines() if line.strip()[:1] in "1234" and line.strip()] == [*"CDBA"]
    assert (tmp_path / "strip.png").read_bytes()[:4] == b"\x89PNG"


def test_json_of_a_goal(disassemble: Call) -> None:
    out = disassemble("cantilever", "--goal", "D", "--json").out
    data = json.loads(out)["details"]
    assert column(out, "body") == data["order"]
    assert column(out, "answer") == ["safe", "safe"]
    assert data["order"] == ["C", "D"]
    assert data["assembly_order"] == ["D", "C"]
    assert (data["fewest"], data["proven"], data["reached"], data["blocked"]) == (2.0, True, True, {})


def test_an_arch_ends_with_1_and_reasons(disassemble: Call) -> None:
    code, out, _ = disassemble("arch", "--json")
    assert code == 1
    data = json.loads(out)["details"]
    assert data["fewest"] == "inf"
    assert set(data["blocked"]) == {f"v{k}" for k in range(1, 6)}


@pytest.mark.parametrize(
    ("arguments", "ends_with", "text"),
    [
        (("stack", "--goal", "cube7"), 2, "did you mean"),
        (("stack", "--png", "a.jpg"), 2, ".png"),
        (("wedged",), 1, "does not stand"),
    ],
)
def test_what_it_refuses(arguments: tuple[str, ...], ends_with: int, text: str, disassemble: Call) -> None:
    code, _, err = disassemble(*arguments)
    assert (code, text in err) == (ends_with, True)


def test_a_goal_that_nothing_reaches_is_said_to_be_out_of_reach(disassemble: Call) -> None:
    code, out, _ = disassemble("arch", "--goal", "v3")
    assert (code, "v3 cannot be taken out" in out) == (1, True)


def test_the_strip_shows_every_state_and_colours_what_goes_next() -> None:
    d = hf.disassembly_order(hf.assemble(shipped_scene("cantilever")), goal="D")
    strip = strip_of(d)
    assert [frame.next for frame in strip.frames] == ["C", "D", ""]
    names = [[solid.name for solid in frame.solids] for frame in strip.frames]
    assert names == [["floor", "A", "B", "C", "D"], ["floor", "A", "B", "D"], ["floor", "A", "B"]]
    np.testing.assert_array_equal(strip.up, [0, 0, 1])
