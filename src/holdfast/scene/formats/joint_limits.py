"""Checks of given joint positions against the limits in the file."""

from __future__ import annotations

import numpy as np

from holdfast.base.errors import SceneError, message

SLACK = 0.01  # share of the range, because files round limits (1.57 for a right angle) and simulators let joints yield


def check_within(where: str, position: float, low: float, high: float, *, turning: bool) -> None:
    """Raise SceneError if the position [rad or m] of a joint lies outside ``low`` to ``high``, with both units named.

    Such a position was probably meant in degrees or millimetres. Equal limits do not count: some files leave them out.
    """
    slack = SLACK * (high - low)
    if not high > low or low - slack <= position <= high + slack:
        return
    if turning:
        unit, remedy = "rad", f"positions are radians: {position:g} degrees are {np.radians(position):.4g} rad"
    else:
        unit, remedy = "m", f"positions are metres: {position:g} mm are {1e-3 * position:.4g} m"
    raise SceneError(message(where, f"{position:g} {unit} is outside its limits {low:g} to {high:g} {unit}", remedy))
