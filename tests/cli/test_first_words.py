"""What a newcomer reads first: the command without arguments, and the tables of plain scenes."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from calling import Call
from rich.console import Console

import holdfast as hf
from holdfast.cli.main import COMMANDS, TASKS
from holdfast.report.contact_report import stability_report
from holdfast.scene.shipped.blocks import at


def test_without_arguments_it_shows_five_tasks(call: Call) -> None:
    code, text, _ = call()
    assert code == 0
    assert len(TASKS) == 5
    for task, command in TASKS:
        assert task in text
        assert command in text
        assert command.split()[:1] == ["holdfast"]
        assert command.split()[1] in COMMANDS


def test_the_push_of_the_five_tasks_answers(call: Call) -> None:
    code, text, _ = call(*TASKS[1][1].split()[1:])
    assert code == 0
    assert "before something moves" in text


def test_each_leg_has_its_own_force() -> None:
    """A table on four equal legs (±a, ±b) with a pot at (x, y): W / 4 + P (±x / 4a ± y / 4b) by linear springs."""
    legs = [hf.Part(hf.Box((0.05, 0.05, 0.7)), at(x, y, 0.35)) for x in (0.45, -0.45) for y in (0.25, -0.25)]
    top = hf.Part(hf.Box((1.0, 0.6, 0.03)), at(0, 0, 0.715))
    scene = hf.Scene(
        [
            hf.Body("floor", hf.Box((3, 3, 0.1)), pose=at(0, 0, -0.05), fixed=True),
            hf.Body("table", hf.Compound([top, *legs]), mass=12),
            hf.Body("pot", hf.Cylinder(0.1, 0.2), mass=3, pose=at(0.3, 0.1, 0.83)),
        ],
        0.5,
    )
    assembly = hf.assemble(scene)
    console = Console(file=io.StringIO(), width=80)
    console.print(stability_report(assembly, hf.stability(assembly)))
    lines = console.file.getvalue().splitlines()  # type: ignore[attr-defined]
    rows = {line.split(" mm ")[0].strip(): line.split() for line in lines if line.strip().startswith("at (")}
    expected = {
        f"at ({1e3 * x:.0f}, {1e3 * y:.0f}, 0)": 9.81 * (15 / 4 + 3 * (0.3 / (4 * x) + 0.1 / (4 * y)))
        for x in (0.45, -0.45)
        for y in (0.25, -0.25)
    }
    assert {place: float(row[-2]) for place, row in rows.items()} == pytest.approx(expected, rel=3e-3)  # three digits


@pytest.mark.parametrize("tension", [0.0, 400.0])
@pytest.mark.parametrize(("mu", "degrees"), [(0.5, 20.0), (0.9, 35.0)])
def test_how_much_of_its_friction_a_cube_on_a_slope_uses(mu: float, degrees: float, tension: float) -> None:
    """m g sin a of μ (m g cos a + tension area), on 0.01 m²."""
    angle, floor = np.radians(degrees), hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    cube = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=2, pose=at(0, 0, 0.05))
    friction = hf.Friction(mu, tension={("floor", "cube"): tension} if tension else {})
    assembly = hf.assemble(hf.Scene([floor, cube], friction, 9.81 * np.array([np.sin(angle), 0, -np.cos(angle)])))
    console = Console(file=io.StringIO(), width=80)
    console.print(stability_report(assembly, hf.stability(assembly, engine="limit")))
    (row,) = (line.split() for line in console.file.getvalue().splitlines() if "floor - cube" in line)  # type: ignore[attr-defined]
    used = 19.62 * np.sin(angle) / (mu * (19.62 * np.cos(angle) + 0.01 * tension))
    assert row[-3:] == [f"{mu:g}", f"{19.62 * np.cos(angle):.3g}", f"{used:.0%}"]


def test_nothing_that_is_zero_is_printed_as_rounding(call: Call, tmp_path: Path) -> None:
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    orange = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0, 0, 0.04))
    hf.save_scene(hf.Scene([floor, orange], 0.5), tmp_path / "orange.yaml")
    code, text, _ = call(
        "push", tmp_path / "orange.yaml", "orange", "--at", "-0.04", "0", "0.04", "--along", "1", "0", "0"
    )
    assert code == 0
    assert "e-" not in text


def test_a_reason_is_said_once_whatever_is_only_balanced() -> None:
    scene = hf.Scene(
        [
            hf.Body("floor", hf.Box((3, 3, 0.1)), pose=at(0, 0, -0.05), fixed=True),
            hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0.5, 0, 0.05)),
            hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05)),
            hf.Body("other", hf.Sphere(0.05), mass=1, pose=at(-0.5, 0, 0.05)),
        ],
        0.5,
    )
    reason = hf.stability(scene).reason
    assert reason.count("held by the forces at its contacts") == 1
    assert reason.count("only balanced") == 1
    assert "ball, other" in reason


def test_an_engine_without_bounds_answers_a_push(call: Call) -> None:
    code, text, _ = call(
        "push", "cube", "cube", "--at", "-0.05", "0", "0.05", "--along", "1", "0", "0", "--engine", "graph"
    )
    assert code == 0
    assert "no bound is known on either side" in text


@pytest.mark.parametrize(
    "question", [("push", "vase", "--at=-0.08,0,0.1", "--along=1,0,0"), ("map", "--spacing", "0.1"), ("transport",)]
)
def test_no_reason_is_said_twice(call: Call, tmp_path: Path, question: tuple[str, ...]) -> None:
    """One box falls, another hovers by a little more than what counts as contact."""
    scene = hf.Scene(
        [
            hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True),
            hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(0.53, 0, 0.05)),
            hf.Body("vase", hf.Box((0.16, 0.16, 0.2)), mass=1, pose=at(0, 0, 0.1004)),
        ],
        0.5,
    )
    hf.save_scene(scene, tmp_path / "scene.yaml")
    command, *rest = question
    _, text, _ = call(command, tmp_path / "scene.yaml", *rest)
    told = " ".join(text.split())
    assert told.count("would rest there") == 1
    assert told.count("no contact forces balance every body") <= 1
