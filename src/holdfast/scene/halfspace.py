"""The half space below a plane, of which a scene models a block as large as its bodies need."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import NoReturn

import numpy as np

from holdfast.base.arrays import Float, checked_number
from holdfast.base.errors import GeometryError, message
from holdfast.base.public import Record
from holdfast.base.ranges import LENGTH
from holdfast.geometry.surface import Surface

UNKNOWN = 1.0  # [m] half size of the block of a half space that is not in a scene yet


class HalfSpace(Record):
    """The unbounded half space below the plane z = 0 of its frame; only for fixed bodies.

    Contacts, maps and pictures use a block of it. ``reach`` [m] is how far the block extends from the origin to every
    side and down. A scene overrides it so that all of its bodies lie over the block; it takes no part in comparisons.
    Raises GeometryError if ``reach`` is not positive.
    """

    reach: float = field(default=UNKNOWN, compare=False)

    def __post_init__(self) -> None:
        reach = checked_number(self.reach, "HalfSpace: reach", within=LENGTH, above=0, error=GeometryError)
        object.__setattr__(self, "reach", reach)

    @cached_property
    def surface(self) -> Surface:
        """The surface of the block."""
        size = np.array([2 * self.reach, 2 * self.reach, self.reach])
        return Surface.of_box(size, np.array([0.0, 0.0, -self.reach / 2]))

    @property
    def mass_properties(self) -> NoReturn:
        """Raises GeometryError: a half space has neither volume nor centre of mass."""
        raise GeometryError(message("HalfSpace", "has no end, so no mass", "needs fixed=True"))

    def over(self, points: Float) -> HalfSpace:
        """Return the half space with a block so large that points (n, 3) [m] of its frame lie well over it.

        ``reach`` is then a power of two, so that it seldom changes as bodies move.
        """
        farthest = float(np.abs(points).max(initial=UNKNOWN / 4))
        return HalfSpace(float(2.0 ** (np.ceil(np.log2(farthest)) + 1)))
