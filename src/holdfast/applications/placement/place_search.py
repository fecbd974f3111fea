"""The state of a search for a place: its clock, and the attempts so far."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from holdfast.applications.placement.refusals import STAGES
from holdfast.applications.placement.result import Candidate
from holdfast.assembly.assembly import Assembly

# shares of the time limit after which each stage of a plan must end
SHARES: Mapping[str, float] = MappingProxyType(
    {"map": 0.2, "coarse map": 0.25, "search": 0.55, "compare": 0.7, "refine": 0.8, "end": 0.92}
)


@dataclass(frozen=True)
class Clock:
    """A time limit of ``seconds`` (None: no limit) from ``start`` [s] of ``time.perf_counter`` on."""

    start: float
    seconds: float | None

    @classmethod
    def started(cls, seconds: float | None) -> Clock:
        """Return a clock that begins now."""
        return cls(time.perf_counter(), seconds)

    @property
    def elapsed(self) -> float:
        """The time since the start [s]."""
        return time.perf_counter() - self.start

    def by(self, stage: str, share: float = 1.0) -> float:
        """Return the time [s of perf_counter] by which a stage must end, or a ``share`` of the time up to its end."""
        return np.inf if self.seconds is None else self.start + share * SHARES[stage] * self.seconds


@dataclass(eq=False)
class Trials:
    """The state of a search.

    ``found`` holds the stable poses on flat faces, and ``rolling`` those in which the object balances on one facet of a
    round side, each with the assembly after the placement. ``tried`` counts the attempts, and ``faults`` counts the
    failed ones by their fault; ``nearest`` is the failed attempt that passed the most checks. ``first`` [s] is the time
    until the first stable pose. ``out_of_time`` is True if the search ended at the time limit.
    """

    found: list[tuple[Candidate, Assembly]] = field(default_factory=list)
    rolling: list[tuple[Candidate, Assembly]] = field(default_factory=list)
    tried: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    nearest: Candidate | None = None
    first: float | None = None
    out_of_time: bool = False

    def failed(self, candidate: Candidate) -> None:
        """Count an attempt that failed."""
        self.faults[candidate.fault] += 1
        if self.nearest is None or STAGES.index(candidate.fault) > STAGES.index(self.nearest.fault):
            self.nearest = candidate

    @property
    def stable(self) -> list[tuple[Candidate, Assembly]]:
        """The stable poses on flat faces or, if there are none, those from which the object would roll."""
        return self.found or self.rolling
