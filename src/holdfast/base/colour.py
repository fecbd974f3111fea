"""Conversion between hexadecimal colours, sRGB and linear light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Rgb = tuple[float, float, float]


def rgb_of(hexadecimal: str) -> Rgb:
    """Return the red, green and blue components, in 0..1, of a colour "#rrggbb"."""
    red, green, blue = (int(hexadecimal[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def light_of(rgb: ArrayLike) -> NDArray[np.float64]:
    """Return the linear light (..., 3), in 0..1, of sRGB colours (..., 3); glTF stores colours this way."""
    srgb = np.asarray(rgb, dtype=float)
    return np.asarray(np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4), dtype=float)


def srgb_of(light: ArrayLike) -> NDArray[np.float64]:
    """Return the sRGB colours (..., 3), in 0..1, of linear light (..., 3); the inverse of ``light_of``."""
    linear = np.clip(np.asarray(light, dtype=float), 0.0, 1.0)
    return np.asarray(np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055), dtype=float)
