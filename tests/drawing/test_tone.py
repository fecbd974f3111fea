"""Colours come out of the film curve as they went in before it."""

from __future__ import annotations

import numpy as np

from holdfast.base.colour import srgb_of
from holdfast.drawing import colours
from holdfast.drawing.colours import before_film


def aces_filmic(light: np.ndarray) -> np.ndarray:
    """ACESFilmicToneMapping of three.js, line by line as its shader has it (column-major matrices)."""
    into = np.array(
        [0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777]
    ).reshape(3, 3).T  # fmt: skip
    out = np.array(
        [1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602]
    ).reshape(3, 3).T  # fmt: skip
    v = (light / 0.6) @ into.T
    fitted = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return np.clip(fitted @ out.T, 0.0, 1.0)


def test_all_colours_of_the_legend_are_shown_as_they_are() -> None:
    every = np.array([*colours.TABLE, *colours.SPECIAL.values(), colours.FIXED, (0.0, 0.0, 0.0)])
    shown = srgb_of(aces_filmic(before_film(every)))
    np.testing.assert_allclose(shown, every, atol=1e-6)


def test_the_curve_itself_would_change_them() -> None:
    """What would be seen without this: the blue of infinite forces turns grey by a tenth."""
    blue = np.array([colours.INFINITE])
    from holdfast.base.colour import light_of

    assert np.abs(srgb_of(aces_filmic(light_of(blue))) - blue).max() > 0.05
