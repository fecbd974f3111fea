"""The ranges of numbers that users may give. A number outside them is a mistake or too extreme for double precision.

They are wide: from a thousandth of a millimetre to a thousand kilometres, from a microgram to a million tonnes. Squares
and products of such numbers, as in inertias and torques, neither overflow nor underflow. What rounding may do to them
has its home here too: the tolerances from which all others of that kind derive.
"""

from __future__ import annotations

from typing import NamedTuple


class Range(NamedTuple):
    """The range of one kind of number: the least and the largest magnitude of numbers other than zero, and the unit."""

    least: float
    largest: float
    unit: str = ""

    def __str__(self) -> str:
        return f"from {self.least:g} to {self.largest:g}{f' {self.unit}' if self.unit else ''}"

    def most(self) -> str:
        """The upper end in words, for numbers that may be zero or negative."""
        return f"of at most {self.largest:g}{f' {self.unit}' if self.unit else ''}"


LENGTH = Range(1e-6, 1e6, "m")  # sizes of bodies, distances between points
PLACE = Range(0.0, 1e6, "m")  # coordinates of points and positions
TOLERANCE = Range(1e-12, 1e6, "m")  # gaps, standard deviations of positions
MASS = Range(1e-9, 1e9, "kg")
DENSITY = Range(1e-6, 1e9, "kg/m³")
INERTIA = Range(0.0, 1e21, "kg m²")
FRICTION = Range(0.0, 1e9)
ACCELERATION = Range(1e-6, 1e6, "m/s²")  # gravity, and how fast a support accelerates
TURNING = Range(0.0, 1e6, "rad/s or rad/s²")
FORCE = Range(0.0, 1e15, "N or N m")
STIFFNESS = Range(1e-9, 1e15)
PRESSURE = Range(0.0, 1e12, "Pa")
SCALE = Range(1e-9, 1e9)
EXPONENT = Range(0.0, 1e3)
ANGLE = Range(0.0, 1e4, "degrees")
BETWEEN = Range(0.0, 180.0, "degrees")  # the angle between two directions or two orientations
MOST_SEED = 2**63 - 1  # seeds are whole numbers from 0
MANY = 1_000_000_000  # counts beyond this mean a mistake, too

UNIT = 2.0**-53  # the unit roundoff u of double precision

# Of the absolute terms of a sum: n operations lose at most about n u of them, and no sum that uses this takes 96
SUM = 96 * UNIT

# Relative accuracy to which coordinates are meant: far above what poses and products add, some hundred u, and far below
# single precision, 6e-8, in which many files hold them
COORDINATES = 1e-9
