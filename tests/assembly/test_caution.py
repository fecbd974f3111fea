"""Hundreds of overlaps in one line (S3), and scenes in millimetres (U7)."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, box, floor


def pile(count: int) -> hf.Scene:
    """Cubes in nearly one pose, over a floor that they do not touch."""
    cubes = [box(f"c{k}", (0.1, 0.1, 0.1), 1, (0.0005 * k, 0, 0.5)) for k in range(count)]
    return hf.Scene([floor(), *cubes], 0.5)


def warning_of(scene: hf.Scene) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assembly = hf.assemble(scene)
    assert assembly.overlaps
    texts = [str(warning.message) for warning in caught if issubclass(warning.category, hf.errors.HoldfastWarning)]
    assert len(texts) == 1
    return texts[0]


def test_s3_hundreds_of_overlaps_are_one_line_with_their_number_and_the_deepest() -> None:
    text = warning_of(pile(20))
    assert text.startswith("bodies overlap: 190 pairs, the deepest 'c0' and 'c1' by 99.5 mm; the gap tolerance is 0.17")
    assert "; 190 deeper than twice that" in text
    assert text.count("'c") == 2
    assert len(text) < 250


def test_s3_a_few_overlaps_are_all_named() -> None:
    text = warning_of(pile(3))
    assert text.count(" by ") == 3
    assert "pairs" not in text


def block(size: float, k: int = 0) -> hf.Body:
    return box(f"b{k}", (size, size, size), 1, (2000.0 * k, 0, size / 2))


def sizes(*all_of_them: float) -> hf.Scene:
    return hf.Scene([floor(1e5, 1e5), *(block(size, k) for k, size in enumerate(all_of_them))], 0.5)


@pytest.mark.parametrize("case", [(100,), (70, 100, 30), (25, 25, 25), (20.1,), (2.1, 20.1, 20.1)])
def test_u7_a_scene_whose_sizes_all_say_millimetres_is_refused(case: tuple[float, ...]) -> None:
    match = (
        r"scene: the smallest of \d movable bodies, 'b\d', is .* m across; are the sizes in millimetres\?.*allow_large"
    )
    for call in (hf.assemble, lambda s: hf.stability(s, engine="limit")):
        with pytest.raises(hf.errors.SceneError, match=match):
            call(sizes(*case))
    assert hf.stability(hf.assemble(sizes(*case), allow_large=True), engine="limit").status is hf.Status.STABLE


@pytest.mark.parametrize("case", [(0.1,), (12, 12, 6), (19.9,), (1.9, 100, 100), (2.5, 2.5, 100)])
def test_u7_sizes_that_may_be_metres_are_not(case: tuple[float, ...]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
        assert hf.assemble(sizes(*case)).groups


def test_u7_samples_of_a_large_assembly_are_not_refused() -> None:
    assembly = hf.assemble(sizes(100), allow_large=True)
    found = hf.robustness_under(
        assembly,
        "b0",
        (50, 0, 50),
        (-1, 0, 0),
        uncertain=hf.sets.Uncertain(samples=2, pose_sigma=0.001),
        engine="limit",
    )
    assert found.force.shape == (2, 1)


def with_centre(x: float, across: float = 0.1) -> list[str]:
    """The warnings about a cube whose centre of mass is at ``x`` in its frame, which is turned."""
    turned = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, across / 2], [0, 0, 0, 1.0]])
    cube = hf.Body("cube", hf.Box([across] * 3), mass=1, com=(x, 0, 0), pose=turned)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        hf.assemble(hf.Scene([floor(), cube], 0.5))
    return [str(warning.message) for warning in caught if "centre of mass" in str(warning.message)]


def test_a_centre_of_mass_far_outside_of_its_body_is_told() -> None:
    (text,) = with_centre(50.0)
    assert text.startswith("body 'cube': its centre of mass lies outside of it, 288 times its size away; is com= in")
    assert with_centre(-0.05 - 0.18)
    assert not with_centre(0.05 + 0.17)  # less than the diagonal: of a thing of which only a part can touch
    assert with_centre(50.0, across=10.0)
    assert not with_centre(20.0, across=10.0)


def test_where_the_centre_of_what_is_fixed_lies_does_not_matter() -> None:
    table = hf.Body("table", hf.Box((1, 1, 0.1)), com=(50, 0, 0), fixed=True, pose=at(0, 0, -0.05))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hf.assemble(hf.Scene([table, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5))


@pytest.mark.parametrize(("gap", "told"), [(0.0019, False), (0.0021, True), (0.0039, True), (4.0, True)])
def test_a_gap_of_more_than_half_a_plate_is_told(gap: float, told: bool) -> None:
    """A plate of 4 mm under a cube: beyond 2 mm, what is above it comes near what is below it."""
    plate, cube = box("plate", (0.2, 0.2, 0.004), 1, (0, 0, 0.002)), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.054))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        hf.assemble(hf.Scene([floor(), cube, plate], 0.5), gap=gap)
    texts = [str(warning.message) for warning in caught if str(warning.message).startswith("gap: ")]
    assert len(texts) == told
    assert all("but body 'plate' is only 4 mm thick" in text for text in texts)
