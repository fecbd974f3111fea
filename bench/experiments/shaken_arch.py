"""The horizontal acceleration of its base at which an arch begins to rock: Oppenheim 1992."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from bench.experiments.arches import arch
from bench.experiments.source import ENGINES, Source, level_acceleration, row
from bench.suite import Case, Row

PRINTED = "0.37"
MUCH = 3.0  # friction at which no voussoir slides
FINER = 13  # voussoirs of a second arch, which nobody printed


def _rocks(count: int) -> list[Row]:
    scene = arch(count, 0.15, MUCH, half_angle=np.radians(157.5) / 2, radius=10.0)
    found = {engine: level_acceleration(scene, engine) for engine in ENGINES}
    if count == FINER:
        return [{"case": f"shaken arch, {count} voussoirs", **found}]
    return [row("shaken arch, 7 voussoirs", PRINTED, "limit", "", **found)]


def cases() -> Mapping[str, Case]:
    """The printed arch, and one of finer voussoirs."""
    return {f"shaken arch {count}": partial(_rocks, count) for count in (7, FINER)}


SOURCE = Source(
    "shaken arch",
    "I. J. Oppenheim, The masonry arch as a four-link mechanism under base motion, Earthquake Engineering and"
    " Structural Dynamics 21 (1992) 1005-1017",
    "the horizontal acceleration of the base, in g, at which it begins to rock",
    "circular arch of 157.5 degrees, thickness 0.15 of the radius of 10 m, 7 voussoirs, so much friction that none"
    " slides",
    cases,
)
