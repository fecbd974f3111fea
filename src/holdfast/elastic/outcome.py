"""How a load path ends, and how coming to rest ends.

The compiled core has the same numbers (``native/outcome.hpp``): it returns them and writes them into arrays.
"""

from __future__ import annotations

from enum import IntEnum


class PathOutcome(IntEnum):
    """How a load path ends."""

    LOST = 0  # no further point was found before the end was clear
    PEAK = 1  # the load has a largest value
    ENDLESS = 2  # contact forces balance any multiple of the load
    REACHED = 3  # it leads to the load up to which it was to be followed


class RestOutcome(IntEnum):
    """How the search for a state of rest ends."""

    LOST = 0  # neither of the two was found
    RESTS = 1
    DRIFTS = 2  # bodies keep moving at a constant velocity
