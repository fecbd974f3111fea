"""What limit analysis proves of an assembly, for the load paths on all of its grids."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.limit.engine import Limit, LimitState


@dataclass(frozen=True, eq=False)
class Certain:
    """Limit analysis of an assembly under ``wrench`` (6J,) [N, N m]: above which load bodies are proved to move."""

    assembly: Assembly
    wrench: Float
    _highest: dict[bytes, float] = field(default_factory=dict, init=False, repr=False)
    _preparing: Lock = field(default_factory=Lock, init=False, repr=False)

    @cached_property
    def state(self) -> LimitState:
        """Engine ``limit`` prepared for the assembly."""
        return Limit().on(self.assembly, self.wrench)

    def highest(self, column: Float) -> float:
        """Return the factor of a load ``column`` (6J,) above which bodies are proved to move; inf where none is.

        It is solved once a question, for the paths on all grids.
        """
        key = column.tobytes()
        with self._preparing:
            if key not in self._highest:
                self._highest[key] = self._proved(column)
            return self._highest[key]

    def forget(self) -> None:
        """Begin a new question."""
        with self._preparing:
            self._highest.clear()

    def _proved(self, column: Float) -> float:
        if not self.state.verdict().equilibrium_exists:
            return float(np.inf)
        return float(self.state.solve(column).upper)
