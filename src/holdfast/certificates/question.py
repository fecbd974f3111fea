"""What a certificate answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.values import sealed


class Question(NamedTuple):
    """What a certificate proves: an assembly under ``standing`` wrenches (6J,), and ``loads`` (6J, n), if any.

    ``acceleration`` (3,) [m/s²] is that of the support, along the world axes.
    """

    assembly: Assembly
    standing: Float
    acceleration: Float | None = None
    loads: Float | None = None

    @classmethod
    def of(cls, assembly: Assembly, loads: Float | None = None) -> Question:
        """Return what is asked of an assembly on which nothing but weight acts at rest."""
        return sealed(cls(assembly, np.zeros(6 * len(assembly.movable)), loads=loads))
