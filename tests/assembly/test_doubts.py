"""Notes on bodies whose density or size suggests other units (P6)."""

from __future__ import annotations

import warnings

import pytest

import holdfast as hf
from holdfast.assembly.caution import doubts
from holdfast.scene.shipped.blocks import at, box, floor


def notes(*bodies: hf.Body) -> tuple[str, ...]:
    """What is noted in the verdict on these bodies over a floor."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        return hf.stability(hf.Scene([floor(), *bodies], 0.5)).notes


def test_four_tonnes_in_four_litres_are_told() -> None:
    (note,) = notes(box("can", (0.1, 0.2, 0.2), 4000, (0, 0, 0.1)))
    assert note.startswith("can: 4,000 kg in 4 litres, 1e+06 kg/m³, is heavier than any material")


@pytest.mark.parametrize(("density", "told"), [(0.5, True), (1.0, False), (22_600.0, False), (30_000.0, True)])
def test_only_what_no_material_weighs_is_told(density: float, told: bool) -> None:
    bodies = hf.Body("b", hf.Sphere(0.1), density=density, pose=at(0, 0, 0.1)), box("c", (1, 1, 1), 500, (2, 0, 0.5))
    assert any("kg/m³" in note for note in notes(*bodies)) is told


def test_many_of_them_are_told_in_few_lines() -> None:
    cubes = [box(f"b{k}", (0.1, 0.1, 0.1), 500, (k, 0, 0.05)) for k in range(9)]
    told = [note for note in notes(*cubes) if "kg" in note or "more" in note]
    assert len(told) == 6
    assert told[-1] == "and 4 more bodies like that"


def test_one_body_in_millimetres_among_metres_is_told() -> None:
    cups = [hf.Body(f"cup{k}", hf.Cylinder(0.04, 0.1), mass=0.3, pose=at(k, 0, 0.05)) for k in range(3)]
    book = box("book", (150, 210, 30), 15e3, (0, 300, 15))
    told = [note for note in notes(*cups, book) if "millimetres" in note]
    assert len(told) == 1
    assert told[0].startswith("book: ")
    tray = box("tray", (40, 20, 2), 1000, (0, 30, 1))  # 40 mm: too small for a house, large beside the cups
    assert any("tray: 40 m across, 400 times as large" in note for note in notes(*cups, tray))
    assert not any("across" in note for note in notes(*cups, box("crate", (2, 2, 2), 100, (0, 9, 1))))


def test_every_answer_carries_them() -> None:
    scene = hf.Scene([floor(), box("can", (0.1, 0.2, 0.2), 4000, (0, 0, 0.1))], 0.5)
    push = hf.robustness(scene, "can", (-0.05, 0, 0.1), (1, 0, 0))
    carried = hf.transport_limits(scene, [(1, 0, 0)])
    mapped = hf.robustness_map(scene, spacing=0.1)
    for answer in (push, carried, mapped, hf.stability(scene)):
        assert any("4,000 kg" in note for note in answer.notes)
        assert any("4,000 kg" in note for note in answer.to_dict()["notes"])


def test_scenes_that_are_right_raise_no_doubt() -> None:
    for name in hf.sets.shipped_scenes():
        assert doubts(hf.shipped_scene(name).movable) == (), name
