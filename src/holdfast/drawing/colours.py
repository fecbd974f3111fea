"""The colour scale of all pictures: weak is dark crimson, strong is pale green, special cases have other colours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, Int
from holdfast.base.colour import Rgb, light_of, rgb_of, srgb_of

_LOG_RATIO: Final = 12.0  # ratio of the largest to the smallest force above which the scale is logarithmic
# The picture is meant to show weak points. They are clamped only if they would compress the rest of the scale, while
# strong outliers are clamped early.
# the scale is clamped at its low end if the smallest force is less than this multiple of the low percentile
_BELOW_USUAL: Final = 1e-3
# the scale is clamped at its high end if the largest force is more than this multiple of the high percentile
_ABOVE_USUAL: Final = 2.0
_OUTLIER_PERCENTILES: Final = (2.0, 90.0)  # percentiles of the forces at which the scale is clamped
_EQUAL_RELATIVE: Final = 1e-3  # forces that differ by less than this share count as equal
_TICK_GAP: Final = 0.09  # smallest distance of a tick from the ends, as a share of the colour bar
# colours of the scale, from weak to strong
_STOPS: Final = ("#6a0c42", "#b5173f", "#ea5a34", "#f9a63f", "#f3e06a", "#cdf3b4")
_TABLE_SIZE: Final = 256  # number of colours in the table

# from linear sRGB to the responses of the three cones, and from their cube roots to OKLab: B. Ottosson, 2020
_TO_LMS: Final = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
_TO_LAB: Final = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip

INK: Final = "#14171c"  # colour of text and of the arrows of pushes
GREY: Final = "#59606b"  # colour of secondary text
CONTACT: Final = "#0b6aa8"  # colour of contacts
FORCE_COLOUR: Final = "#1d8fd6"  # colour of contact forces in space
FRAME: Final = "#dfe2e7"  # colour of the frames of panels and of grids
# colours of groups: of bodies that move together, and of what gives way first
GROUPS: Final = ("#b5173f", "#0b6aa8", "#d9820f", "#3d8f5f", "#7a4fa3", "#8a5a2b", "#1aa3a3", "#d457a0", "#5b6470")
_OTHERS: Final = "#b0b6bf"  # the colour of all further groups

# The curve "ACES filmic" of three.js at exposure 1: S. Hill's fit of the RRT and ODT of the Academy Color Encoding
# System, v -> (v (v + a) - b) / (v (c v + d) + e) between two changes of primaries.
_EXPOSURE: Final = 0.6
_INTO: Final = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_OUT_OF: Final = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
_A, _B, _C, _D, _E = 0.0245786, 0.000090537, 0.983729, 0.4329510, 0.238081  # of the rational curve between them


class Kind(IntEnum):
    """The kind of answer of a cell."""

    FORCE = 0  # a finite force above 0, which is on the scale
    ENDLESS = 1  # no force moves anything
    BALANCED = 2  # the least force moves something
    FALLS = 3  # something moves without any force
    UNDECIDED = 4  # the answer is not known
    NONE = 5  # there is no answer


class Tick(NamedTuple):
    """A mark on the colour bar: its position from 0 (low end) to 1 (high end), and its text."""

    position: float
    label: str


@dataclass(frozen=True)
class Scale:
    """A scale that maps finite positive forces [N] to positions 0..1.

    ``below`` and ``above`` say that some data lie beyond the low or the high end.
    """

    low: float
    high: float
    log: bool
    below: bool = False
    above: bool = False

    def position(self, values: ArrayLike) -> Float:
        """Return the position of each force [N] on the scale, in 0..1; forces beyond an end are clamped to it."""
        force = np.clip(np.asarray(values, dtype=float), self.low, self.high)
        if self.log:
            place = np.log(force / self.low) / np.log(self.high / self.low)
        else:
            place = (force - self.low) / (self.high - self.low)
        return np.asarray(np.clip(place, 0.0, 1.0), dtype=float)


def hex_of(rgb: ArrayLike) -> str:
    """Return the colour "#rrggbb" with these red, green and blue components, in 0..1."""
    return "#" + "".join(f"{round(float(c) * 255):02x}" for c in np.asarray(rgb, dtype=float))


def oklab(rgb: ArrayLike) -> Float:
    """Convert sRGB colours (..., 3) to OKLab coordinates (..., 3).

    Equal distances in these coordinates look about equally different.
    """
    return np.asarray(np.cbrt(light_of(rgb) @ _TO_LMS.T) @ _TO_LAB.T, dtype=float)


def _perceptual_table() -> Float:
    stops = oklab([rgb_of(stop) for stop in _STOPS])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stops, axis=0), axis=1))])
    steps = np.linspace(0.0, length[-1], _TABLE_SIZE)
    lab = np.stack([np.interp(steps, length, stops[:, k]) for k in range(3)], axis=1)
    return srgb_of((lab @ np.linalg.inv(_TO_LAB).T) ** 3 @ np.linalg.inv(_TO_LMS).T)


TABLE: Final = _perceptual_table()
INFINITE: Final[Rgb] = rgb_of("#9fbbe0")  # colour of points that no push moves
ZERO: Final[Rgb] = rgb_of("#d400d4")  # colour of points that the least push moves
FALLS: Final[Rgb] = rgb_of("#1c1c96")  # colour of points on bodies that move without a push
UNDECIDED: Final[Rgb] = rgb_of("#a38fcc")  # colour of points whose answer is not known; pictures also hatch them
FIXED: Final[Rgb] = rgb_of("#d3d2ce")  # colour of fixed bodies
COVERED: Final[Rgb] = rgb_of("#8d8b87")  # colour of surfaces without a value
SPECIAL: Final[dict[Kind, Rgb]] = {
    Kind.BALANCED: ZERO,
    Kind.FALLS: FALLS,
    Kind.UNDECIDED: UNDECIDED,
    Kind.ENDLESS: INFINITE,
    Kind.NONE: COVERED,
}


def scale_of(values: ArrayLike) -> Scale | None:
    """Return the scale that fits these forces [N], or None if none of them is finite and positive."""
    force = np.asarray(values, dtype=float).ravel()
    force = force[np.isfinite(force) & (force > 0.0)]
    if force.size == 0:
        return None
    low, high = float(force.min()), float(force.max())
    if high - low <= _EQUAL_RELATIVE * high:
        return Scale(0.5 * high, 1.5 * high, log=False)
    usual_low, usual_high = (float(np.exp(p)) for p in np.percentile(np.log(force), _OUTLIER_PERCENTILES))
    below, above = low < usual_low * _BELOW_USUAL, high > usual_high * _ABOVE_USUAL
    low, high = (usual_low if below else low), (usual_high if above else high)
    if high - low <= _EQUAL_RELATIVE * high:
        low, high = 0.5 * high, 1.5 * high
    return Scale(low, high, high / low > _LOG_RATIO, below, above)


def sample(position: ArrayLike) -> Float:
    """Return the colours (..., 3), in 0..1, at positions 0..1 of the scale."""
    index = np.rint(np.asarray(position, dtype=float) * (_TABLE_SIZE - 1)).astype(np.int64)
    return np.asarray(TABLE[index], dtype=float)


def kinds_of(values: ArrayLike) -> Int:
    """Return the kinds (C,) of forces (C,) [N], of which none is undecided; a NaN has the kind NONE."""
    force = np.asarray(values, dtype=float)
    kinds = np.full(force.shape, Kind.NONE, dtype=np.int64)
    kinds[np.isfinite(force)] = Kind.FORCE
    kinds[force <= 0.0] = Kind.BALANCED
    kinds[np.isposinf(force)] = Kind.ENDLESS
    return kinds


def colours(scale: Scale | None, values: ArrayLike, kinds: ArrayLike | None = None) -> Float:
    """Return the colours (C, 3), in 0..1, of forces (C,) [N] of these kinds (C,), by default those of ``kinds_of``."""
    force = np.asarray(values, dtype=float)
    known = kinds_of(force) if kinds is None else np.asarray(kinds)
    rgb = np.tile(np.asarray(COVERED), (force.size, 1))
    for kind, colour in SPECIAL.items():
        rgb[known == kind] = colour
    on_scale = known == Kind.FORCE
    if scale is not None:
        rgb[on_scale] = sample(scale.position(force[on_scale]))
    return rgb


def gradient() -> str:
    """Return the colours of the scale from weak to strong as a CSS gradient towards the right."""
    count = 32
    return "linear-gradient(90deg," + ",".join(hex_of(sample(k / count)) for k in range(count + 1)) + ")"


def colours_of(words: Sequence[str]) -> dict[str, str]:
    """Return a colour for each text except "", in the order of frequency; the rarest share one colour."""
    often = Counter(word for word in words if word)
    ranked = sorted(often, key=lambda word: (-often[word], list(words).index(word)))
    return {word: GROUPS[k] if k < len(GROUPS) else _OTHERS for k, word in enumerate(ranked)}


def before_film(rgb: ArrayLike) -> Float:
    """Return the light (..., 3) that the curve "ACES filmic" turns into sRGB colours (..., 3) in 0..1.

    Values may be below 0 or above 1, as saturated colours require; viewers do not clip them before the curve.
    """
    shown = light_of(rgb) @ np.linalg.inv(_OUT_OF).T
    # the positive root of (c y - 1) v² + (d y - a) v + (e y + b) = 0
    square, linear, constant = _C * shown - 1.0, _D * shown - _A, _E * shown + _B
    root = np.sqrt(np.maximum(linear**2 - 4.0 * square * constant, 0.0))
    return np.asarray((-linear - root) / (2.0 * square) @ np.linalg.inv(_INTO).T * _EXPOSURE)


def number(value: float) -> str:
    """Format a force with three significant digits, without an exponent if that stays short."""
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text and 1.0 <= value < 1e6 else text


def ticks(scale: Scale) -> tuple[Tick, ...]:
    """Return the marks of the colour bar: its ends, with ≤ or ≥ if data lie beyond them, and round numbers."""
    first = ("≤ " if scale.below else "") + number(scale.low)
    last = ("≥ " if scale.above else "") + number(scale.high)
    between = _decade_numbers(scale) if scale.log else _round_numbers(scale)
    places = [(float(scale.position(value)), number(value)) for value in between]
    kept = [Tick(place, label) for place, label in places if _TICK_GAP < place < 1.0 - _TICK_GAP]
    return (Tick(0.0, first), *kept, Tick(1.0, last))


def _decade_numbers(scale: Scale) -> list[float]:
    decades = range(int(np.floor(np.log10(scale.low))), int(np.ceil(np.log10(scale.high))) + 1)
    steps = (1, 2, 5) if len(decades) <= 3 else (1, 3) if len(decades) <= 5 else (1,)
    skip = 1 + len(decades) // 10
    return [step * 10.0**decade for decade in decades if decade % skip == 0 for step in steps]


def _round_numbers(scale: Scale) -> list[float]:
    raw = (scale.high - scale.low) / 5.0
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(s for s in (1.0, 2.0, 2.5, 5.0, 10.0) if s * power >= raw * (1 - 1e-9))
    return [float(k * step) for k in range(int(np.ceil(scale.low / step)), int(scale.high / step) + 1)]
