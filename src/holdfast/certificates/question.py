"""What a certificate answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.values import sealed
from holdfast.engines.verdict import Status


class Question(NamedTuple):
    """What a certificate proves: an assembly under ``standing`` wrenches (6J,), and ``loads`` (6J, n), if any.

    ``acceleration`` (3,) [m/s²] is that of the support, along the world axes. ``points`` (n, 3) [m] are where the loads
    act, if each of them is one force on one body.
    """

    assembly: Assembly
    standing: Float
    acceleration: Float | None = None
    loads: Float | None = None
    points: Float | None = None

    @classmethod
    def of(cls, assembly: Assembly, loads: Float | None = None, points: Float | None = None) -> Question:
        """Return what is asked of an assembly on which nothing but weight acts at rest."""
        return sealed(cls(assembly, np.zeros(6 * len(assembly.movable)), loads=loads, points=points))


class Answered(NamedTuple):
    """What an answer says that is to be proved: by which ``engine``, the ``status`` of rest, and the ``force`` (n,)."""

    engine: str
    status: Status
    force: Float

    def entry(self, answer: str) -> dict[str, dict[str, str]]:
        """Return the entry of an answer in a proof."""
        return {"answered": {"engine": self.engine, "answer": answer}}

    def value(self, row: int) -> str:
        """Return the answer of a row as a certificate has it."""
        return repr(float(self.force[row])) if np.isfinite(self.force[row]) else "unlimited"
