"""Keep a worker alive for trials: hand it inputs, and make an outcome of every way in which one may end."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

from fuzz.outcome import Ending, Outcome
from holdfast.base.borders import supervisor
from holdfast.base.borders.worker import DONE, TIME

SECONDS = 20.0  # the longest trial
MEGABYTES = 2000  # the most memory that a trial may take
RENEWED = 4000  # inputs after which a worker is replaced, so that what it keeps does not add up
TESTS = Path(__file__).parents[1]


class Keeper:
    """A worker and its limits, as a context."""

    def __init__(
        self, function: str = "fuzz.trials:tried", seconds: float = SECONDS, megabytes: int = MEGABYTES
    ) -> None:
        limits, setup = supervisor.Limits(seconds, megabytes), (function, megabytes)
        self._worker = supervisor.Supervisor("fuzz.worker:answered", setup, limits, (str(TESTS),), RENEWED)

    def __enter__(self) -> Keeper:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._worker.close()

    @property
    def process(self) -> subprocess.Popen[bytes] | None:
        """The worker, if there is one now."""
        return self._worker.process

    @property
    def started(self) -> int:
        """The number of workers so far."""
        return self._worker.started

    def tried(self, item: dict[str, Any]) -> Outcome:
        """Have one input tried; a worker that is silent for too long or dies is an outcome too."""
        reply = self._worker.ask(item)
        if reply.outcome == DONE:
            found: Outcome = reply.value
            return replace(found, seconds=reply.seconds, peak=reply.peak)
        if reply.outcome == TIME:
            return Outcome(Ending.HANG, supervisor.innermost(reply.value) or "outside", reply.value, reply.seconds)
        return Outcome(Ending.CRASH, f"process ended with {reply.code}", reply.problem, reply.seconds)
