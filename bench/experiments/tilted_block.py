"""A block on a slope, turned about the slope's normal: at which dip it topples. Gui and others 2024."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.experiments.source import G0, Source, block, threshold
from bench.suite import Case, Row

SLENDER = np.radians(
    20.0
)  # width over height is the tangent of this, the dip at which a block that is not turned topples
TURNS = (0, 10, 20, 30)  # [degrees]
MUCH = 2.0  # friction at which it does not slide


def tilted(turn: float, dip: float) -> hf.Scene:
    """A block on a plane whose gravity leans by ``dip`` [degrees] towards ``turn`` [degrees] from its thin side."""
    tilt, way = np.radians(dip), np.radians(turn)
    width, high = 0.1, 0.1 / np.tan(SLENDER)
    down = G0 * np.array([np.sin(tilt) * np.cos(way), np.sin(tilt) * np.sin(way), -np.cos(tilt)])
    bodies = [hf.Body("slope", hf.HalfSpace(), fixed=True), block("block", (width, 5 * width, high), (0, 0, high / 2))]
    return hf.Scene(bodies, friction=MUCH, gravity=down)


def _topples(turn: int) -> list[Row]:
    dip = np.degrees(np.arctan(np.tan(SLENDER) / np.cos(np.radians(turn))))  # beyond it the weight leaves the base
    case = f"block turned by {turn}°: dip at which it topples [°]"
    return [threshold(case, f"{dip:.3f}", partial(tilted, turn), (30.0, 10.0))]


def cases() -> Mapping[str, Case]:
    """One case a turn."""
    return {f"tilted block {turn}": partial(_topples, turn) for turn in TURNS}


SOURCE = Source(
    "tilted block",
    "J.-Y. Gui, L. R. Alejano, M. Cano, J. Arzúa, I. Pérez-Rey, Analytical and experimental studies on toppling"
    " behavior of blocks misaligned with the slope face, Bull. Eng. Geol. Environ. 83 (2024); printed here is the"
    " closed form",
    "the dip at which a block topples that is turned on a slope; their abstract says that it rises by a few tenths of a"
    " degree at a turn of 10 degrees, by about 1 at 20 and by 2 to 3 at 30",
    "a block that topples at 20 degrees if it is not turned; sharp edges",
    cases,
)
