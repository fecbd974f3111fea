"""Notes on numbers that suggest other units or another origin (P6, U7)."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.caution import doubts_of_scene
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
        assert doubts_of_scene(hf.shipped_scene(name)) == (), name
        assert hf.assemble(hf.shipped_scene(name)).scene.notes == hf.shipped_scene(name).notes, name


@pytest.mark.parametrize("angle", [1.5708, 1.57, 3.1416, 0.7854, 0.785, 1.0472, 0.5236, -1.5708, 4.7124, 6.2832])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_radians_that_stand_for_degrees_are_told(angle: float, axis: int) -> None:
    rpy = [0.0, 0.0, 0.0]
    rpy[axis] = angle
    cup = hf.Body("cup", hf.Box((0.1, 0.1, 0.1)), mass=1, position=(0, 0, 0.06), rpy_degrees=rpy)
    (note,) = [each for each in notes(cup) if "radians" in each]
    assert note.startswith(f"cup is turned by {abs(angle):.5g} degrees: are these radians? {abs(angle):.5g} rad are")
    assert f"are {np.degrees(abs(angle)):.3g} degrees" in note


@pytest.mark.parametrize(
    "angles", [(90.0,), (1.5708, 90.0), (30.0, 45.0), (1.3,), (0.01, 0.02, 1.5708, 0.3), (1.0,), (0.0,)]
)
def test_degrees_raise_no_doubt(angles: tuple[float, ...]) -> None:
    cups = [
        hf.Body(f"cup{k}", hf.Box((0.1, 0.1, 0.1)), mass=1, position=(k, 0, 0.05), rpy_degrees=(0, 0, angle))
        for k, angle in enumerate(angles)
    ]
    assert not any("radians" in note for note in notes(*cups))


def test_a_tilt_in_radians_is_told() -> None:
    scene = hf.Scene([floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)
    assert "0.5236 rad are 30°" in scene.tilted((0.5236, 0, 0)).notes[-1]
    assert "rad" not in scene.tilted((30, 0, 0)).notes[-1]


@pytest.mark.parametrize(("mu", "told"), [(0.0, False), (3.0, False), (3.1, True), (50.0, True)])
def test_friction_that_no_pair_has_is_told(mu: float, told: bool) -> None:
    a = box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))
    for friction in (mu, hf.Friction(0.5, pairs={("a", "floor"): mu})):
        said = hf.stability(hf.Scene([floor(), a], friction)).notes
        assert (f"friction is above 3, which hardly any pair has, of floor and a ({mu:g})" in said) is told
    other = hf.Friction(values={"floor": 50.0, "a": 0.5}, combine="min")
    assert hf.stability(hf.Scene([floor(), a], other)).notes == (), "the floor's own is of no pair"


@pytest.mark.parametrize("shape", [hf.Box((0.008, 0.024, 0.116)), hf.Cylinder(0.04, 0.116), hf.Box((0.5, 0.5, 0.116))])
@pytest.mark.parametrize("under", ["floor", "table"])
def test_a_body_that_sinks_by_half_its_height_is_told_with_its_remedy(shape: hf.Box | hf.Cylinder, under: str) -> None:
    """And what the remedy says makes it stand."""
    ground = hf.Body("floor", hf.HalfSpace(), fixed=True) if under == "floor" else replace(floor(), name="table")
    for height, told in ((0.0, True), (5e-5, True), (0.005, False), (0.058, False)):
        body = hf.Body("thing", shape, mass=0.1, position=(0, 0, height))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
            verdict = hf.stability(hf.Scene([ground, body], 0.5))
        assert verdict.stable == (height == 0.058)
        said = [note for note in verdict.notes if "sinks by half its height" in note]
        assert bool(said) is told
        if told:
            assert f"into {under}: the origin of a shape is its middle: put it 0.058 m higher, or" in said[0]


def test_a_stack_with_origins_at_the_foot_is_told_body_by_body() -> None:
    cubes = [box(f"c{k}", (0.1, 0.1, 0.1), 1, (0, 0, 0.1 * k)) for k in range(2)]
    (note,) = [note for note in notes(*cubes) if "sinks" in note]
    assert note.startswith("c0 sinks by half its height into floor")
    tall = [box(f"c{k}", (0.1, 0.1, h), 1, (0, 0, z)) for k, (h, z) in enumerate([(0.1, 0.05), (0.3, 0.1)])]
    (note,) = [note for note in notes(*tall) if "sinks" in note]
    assert note.startswith("c1 sinks by half its height into c0")
