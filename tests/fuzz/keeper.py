"""Keep a worker alive: hand it inputs, wait no longer than the limit, start another one where it dies."""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from fuzz.outcome import Ending, Outcome

SECONDS = 20.0  # the longest trial
MEGABYTES = 2000  # the most memory that a trial may take
STARTING = 300.0  # [s] a worker may take to start: it imports, and may compile
RENEWED = 4000  # inputs after which a worker is replaced, so that what it keeps does not add up
TESTS = Path(__file__).parents[1]


class Keeper:
    """A worker and its limits, as a context."""

    def __init__(
        self, function: str = "fuzz.trials:tried", seconds: float = SECONDS, megabytes: int = MEGABYTES
    ) -> None:
        self.function, self.seconds, self.megabytes = function, seconds, megabytes
        self.process: subprocess.Popen[bytes] | None = None
        self.started = 0  # workers so far
        self.given = 0
        self._rest = b""
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 - closed where the context ends

    def __enter__(self) -> Keeper:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()
        self._log.close()

    def tried(self, item: dict[str, Any]) -> Outcome:
        """Have one input tried; a worker that is silent for too long or dies is an outcome too."""
        if self.process is None or self.given >= RENEWED:
            self._start()
        assert self.process is not None
        assert self.process.stdin is not None
        self.given += 1
        self._log.seek(0)
        self._log.truncate()
        start = time.perf_counter()
        try:
            self.process.stdin.write(json.dumps(item).encode() + b"\n")
            self.process.stdin.flush()
            line = self._line(self.seconds)
        except BrokenPipeError:
            line = b""
        if line:
            return Outcome.of(json.loads(line))
        seconds = time.perf_counter() - start
        if line is None:
            self._end()
            return Outcome(Ending.HANG, _innermost(self._told()), self._told()[-1500:], seconds)
        code = self.process.wait()
        self._end()
        return Outcome(Ending.CRASH, f"process ended with {code}", self._told()[-1500:], seconds)

    def _start(self) -> None:
        self._end()
        path = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fuzz.worker", self.function, str(self.megabytes), str(0.9 * self.seconds)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        self.started, self.given, self._rest = self.started + 1, 0, b""
        if not self._line(STARTING):
            raise RuntimeError(f"a worker does not start: {self._told()}")

    def _line(self, seconds: float) -> bytes | None:
        """The next line of the worker; None where it does not come in time, nothing where it died."""
        assert self.process is not None
        assert self.process.stdout is not None
        until, handle = time.monotonic() + seconds, self.process.stdout.fileno()
        while b"\n" not in self._rest:
            if not select.select([handle], [], [], max(until - time.monotonic(), 0))[0]:
                return None
            more = os.read(handle, 1 << 20)
            if not more:
                return b""
            self._rest += more
        line, self._rest = self._rest.split(b"\n", 1)
        return line

    def _told(self) -> str:
        """What the worker wrote to stderr."""
        self._log.seek(0)
        return self._log.read().decode(errors="replace")

    def _end(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            for stream in (self.process.stdin, self.process.stdout):
                if stream is not None:
                    with contextlib.suppress(BrokenPipeError):
                        stream.close()
            self.process = None


def _innermost(text: str) -> str:
    """The innermost function of holdfast in a traceback of faulthandler."""
    for line in text.splitlines():
        if "/holdfast/" in line and " in " in line:
            place, function = line.split(" in ")
            return f"{place.split('/holdfast/')[-1].split('.py')[0].replace('/', '.')}:{function}"
    return "outside"
