"""The colour scale: what goes where, and what stands apart."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from holdfast.drawing import colours

# what people without red, green or blue cones see, in linear light (Machado, Oliveira and Fernandes 2009)
EYES = {
    "usual": np.eye(3),
    "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def seen(rgb: object, eyes: str) -> np.ndarray:
    """The sRGB colours that look to usual eyes as these colours look to others."""
    srgb = np.asarray(rgb, dtype=float)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    told = np.clip(linear @ np.asarray(EYES[eyes]).T, 0, 1)
    return np.where(told <= 0.0031308, told * 12.92, 1.055 * told ** (1 / 2.4) - 0.055)


def distance(one: object, other: object) -> float:
    return float(np.linalg.norm(colours.oklab(np.asarray(one)) - colours.oklab(np.asarray(other))))


@pytest.mark.parametrize("eyes", EYES)
def test_every_eye_sees_the_scale_get_lighter_from_weak_to_strong(eyes: str) -> None:
    """No two forces look alike: lightness alone, which every eye has, orders them, without a jump that draws a line.

    To usual eyes all steps look equally large.
    """
    most, least = (1.1, 0.8) if eyes == "usual" else (1.2, 0.4)
    lab = colours.oklab(seen(colours.TABLE, eyes))
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    assert np.all(np.diff(lab[:, 0]) > 0.0)
    assert lab[-1, 0] - lab[0, 0] > 0.5
    assert least * steps.mean() < steps.min() < steps.max() < most * steps.mean()


@pytest.mark.parametrize("eyes", EYES)
def test_every_eye_tells_what_is_beside_the_scale_apart(eyes: str) -> None:
    special = [colours.INFINITE, colours.ZERO, colours.FALLS, colours.UNDECIDED, colours.FIXED, colours.COVERED]
    shown = [seen(colour, eyes) for colour in special]
    for one, other in itertools.combinations(shown, 2):
        assert distance(one, other) > 0.05
    for one in shown:
        assert min(distance(one, other) for other in seen(colours.TABLE, eyes)) > 0.05


@pytest.mark.parametrize("eyes", ["usual", "no red", "no green"])
def test_eyes_tell_undecided_and_falling_from_all_others(eyes: str) -> None:
    """The hatching of undecided surfaces comes on top of this."""
    others = [colours.INFINITE, colours.ZERO, colours.FIXED, colours.COVERED, (1.0, 1.0, 1.0), *colours.TABLE]
    apart = [colours.UNDECIDED, colours.FALLS]
    assert distance(*(seen(colour, eyes) for colour in apart)) > 0.1
    for colour in apart:
        assert min(distance(seen(colour, eyes), seen(other, eyes)) for other in others) > 0.085


def test_each_kind_has_its_colour() -> None:
    kinds = [colours.Kind.BALANCED, colours.Kind.FALLS, colours.Kind.UNDECIDED, colours.Kind.FORCE]
    rgb = colours.colours(colours.scale_of([3.0]), [0, 0, 0, 3.0], kinds)
    expected = [colours.ZERO, colours.FALLS, colours.UNDECIDED, colours.TABLE[128]]
    np.testing.assert_allclose(rgb, expected, atol=0.02)


def test_wide_ranges_are_logarithmic_and_narrow_ones_linear() -> None:
    wide, narrow = colours.scale_of([1.0, 10.0, 100.0]), colours.scale_of([10.0, 20.0, 30.0])
    assert wide is not None
    assert wide.log
    assert wide.position(10.0) == pytest.approx(0.5)
    assert narrow is not None
    assert not narrow.log
    assert narrow.position(20.0) == pytest.approx(0.5)


def test_a_few_outliers_are_clamped_and_marked() -> None:
    bulk = np.linspace(10.0, 20.0, 200)
    scale = colours.scale_of(np.concatenate([bulk, [1e9], [1e-9]]))
    assert scale is not None
    assert (scale.below, scale.above, scale.log) == (True, True, False)
    assert 9.0 < scale.low < 11.0
    assert 19.0 < scale.high < 21.0
    marks = colours.ticks(scale)
    assert marks[0].label.startswith("≤ ")
    assert marks[-1].label.startswith("≥ ")
    np.testing.assert_allclose(colours.colours(scale, [1e9])[0], colours.TABLE[-1])
    for far, ends in ((1e-9, ("≤", "2")), (1e9, ("1", "≥"))):
        one_sided = colours.scale_of([*bulk, far])
        assert one_sided is not None
        assert tuple(mark.label[0] for mark in colours.ticks(one_sided)[:: len(colours.ticks(one_sided)) - 1]) == ends


def test_a_weak_spot_is_not_taken_for_an_outlier() -> None:
    scale = colours.scale_of([*np.linspace(10.0, 20.0, 200), 0.1])
    assert scale is not None
    assert (scale.low, scale.below, scale.log) == (0.1, False, True)


def test_two_values_far_apart_are_not_outliers() -> None:
    scale = colours.scale_of([1.0, 1000.0])
    assert scale == colours.Scale(1.0, 1000.0, log=True)


@pytest.mark.parametrize("values", [[], [np.inf], [0.0], [np.inf, 0.0, -1.0], [np.nan]])
def test_without_finite_positive_values_there_is_no_scale(values: list[float]) -> None:
    assert colours.scale_of(values) is None
    assert colours.colours(None, values).shape == (len(values), 3)


@pytest.mark.parametrize("values", [[5.0], [5.0] * 9, [5.0, 5.0 + 1e-12], [5.0, np.inf, 0.0]])
def test_equal_values_sit_inside_a_scale_of_their_size(values: list[float]) -> None:
    scale = colours.scale_of(values)
    assert scale is not None
    assert scale.low < 5.0 < scale.high
    assert 0.2 < float(scale.position(5.0)) < 0.8
    assert len(colours.ticks(scale)) >= 3


def test_infinite_zero_and_unknown_get_their_own_colours() -> None:
    force = [np.inf, 0.0, -1.0, np.nan, 3.0]
    rgb = colours.colours(colours.scale_of(force), force)
    expected = [colours.INFINITE, colours.ZERO, colours.ZERO, colours.COVERED, colours.TABLE[128]]
    np.testing.assert_allclose(rgb, expected, atol=0.02)


@pytest.mark.parametrize(("low", "high"), [(1e-6, 1e-3), (0.3, 9.0), (7.0, 8.0), (1.0, 1e9), (123.0, 45678.0)])
def test_ticks_run_upward_with_room_between_them(low: float, high: float) -> None:
    scale = colours.scale_of([low, high])
    assert scale is not None
    marks = colours.ticks(scale)
    places = [mark.position for mark in marks]
    assert places[0] == 0.0
    assert places[-1] == 1.0
    assert 3 <= len(marks) <= 11
    assert min(np.diff(places)) > 0.05


@pytest.mark.parametrize(("value", "text"), [(1234.0, "1230"), (0.0512, "0.0512"), (98.76, "98.8"), (2.5e7, "2.5e+07")])
def test_numbers_have_three_digits(value: float, text: str) -> None:
    assert colours.number(value) == text
