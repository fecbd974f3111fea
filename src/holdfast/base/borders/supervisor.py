"""Supervise a worker process: give it items, enforce the time limit, and start another one if it dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import TracebackType
from typing import Any

from holdfast.base.borders.worker import CRASH, DONE, MEMORY, PART, READY, TIME
from holdfast.base.errors import HoldfastError, message

STARTING = 600.0  # [s] time limit for the start of a worker, which imports
RENEWED = 2000  # number of items after which a worker is replaced, in case its memory grows
TRIES = 3  # number of times that an item is tried if its worker is killed from outside
OUTSIDE = (-signal.SIGKILL, -signal.SIGTERM)  # exit codes of a worker that was killed from outside
PACKAGE = f"{Path(__file__).parents[2]}{os.sep}"  # not every folder that is called holdfast, as a checkout may be
NO_MEMORY = ("bad_alloc", "memory allocation of", "MemoryError", "Cannot allocate memory")  # messages of libraries
THREADS = ("OPENBLAS", "OMP", "MKL")  # libraries that are limited to one native thread in a worker
LAST = 1500  # number of characters at the end of a worker's stderr that are reported


@dataclass(frozen=True)
class Limits:
    """The limits of an item: ``seconds``, and ``megabytes`` of memory above that of the ready worker."""

    seconds: float = 60.0
    megabytes: float = 4000.0


@dataclass(frozen=True)
class Reply:
    """The result of an item: DONE with its ``value``, or TIME, MEMORY or CRASH with the ``problem``.

    ``parts`` are the partial results that the worker sent. ``seconds`` is the time and ``peak`` [MB] the largest memory
    of the item. ``code`` is the exit code of a worker that died, minus the number of the signal if one killed it; None
    if it lives.
    """

    outcome: str
    value: Any = None
    problem: str = ""
    parts: tuple[Any, ...] = ()
    seconds: float = 0.0
    peak: float = 0.0
    code: int | None = None


@dataclass(eq=False)
class Supervisor:
    """Supervises a worker that calls ``function`` (module:name) for every item; see worker.py.

    ``setup`` is the argument of the worker's warm-up. ``folders`` are searched for modules before all others; the
    current folder is not searched, because its files may be from anyone. A worker is replaced after ``renewed`` items.
    """

    function: str
    setup: Any = None
    limits: Limits = Limits()
    folders: Sequence[str] = ()
    renewed: int = RENEWED
    started: int = 0  # number of workers so far
    process: subprocess.Popen[bytes] | None = None
    item: Any = None
    _given: int = 0
    _tries: int = 0
    _began: float = 0.0
    _until: float = 0.0
    _ready: bool = False
    _parts: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the supervisor

    def __enter__(self) -> Supervisor:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Kill the worker."""
        self._end()
        self._log.close()

    @property
    def left(self) -> float:
        """The time [s] that the worker has left."""
        return max(self._until - time.monotonic(), 0.0)

    def ask(self, item: Any) -> Reply:  # noqa: ANN401 - the argument of the function
        """Give the worker an item, and wait for the reply."""
        self.give(item)
        while True:
            wait([self.answers], self.left)
            reply = self.take()
            if reply is not None:
                return reply

    def give(self, item: Any) -> None:  # noqa: ANN401
        """Give the worker an item; ``take`` returns the reply."""
        self.item, self._tries = item, 0
        self._give()

    def take(self) -> Reply | None:
        """Return the reply to the item, or None if there is none yet."""
        try:
            while self.answers.poll():
                reply = self._heard(*self.answers.recv())
                if reply is not None:
                    return reply
        except (EOFError, OSError):
            return self._died()
        return None if self.left else self._late()

    def _give(self) -> None:
        self._tries += 1
        self._parts = []
        if self.process is None or self._given >= self.renewed:
            self._start()
        self._given += 1
        self._began = time.monotonic()
        if self._ready:
            self._until = self._began + self.limits.seconds
            self._log.seek(0)
            self._log.truncate()
        try:
            self._items.send(self.item)
        except OSError:
            return  # it died while idle; ``take`` will notice

    def _heard(self, kind: str, content: Any) -> Reply | None:  # noqa: ANN401
        """Handle one message of the worker, and return the reply if it is the last."""
        if kind == READY:
            self._ready, self._began = True, time.monotonic()
            self._until = self._began + self.limits.seconds
        elif kind == PART:
            self._parts.append(content)
        else:
            value, seconds, peak = content
            problem = "" if kind == DONE else str(value)
            return Reply(kind, None if problem else value, problem, tuple(self._parts), seconds, peak)
        return None

    def _died(self) -> Reply | None:
        """Return the reply for a worker that died, or None if the item was given to another worker."""
        assert self.process is not None
        code = self.process.wait()
        said, ready = self._said(), self._ready
        self._end()
        if code in OUTSIDE and self._tries < TRIES:
            self._give()
            return None
        if not ready:
            raise HoldfastError(message("batch", f"a worker does not start: {said[-400:]}", "correct this error"))
        seconds = time.monotonic() - self._began
        if code in OUTSIDE:
            problem = f"its process was killed {TRIES} times (signal {-code}): the system may have run out of memory"
            return Reply(CRASH, None, problem, tuple(self._parts), seconds, code=code)
        outcome = MEMORY if any(words in said for words in NO_MEMORY) else CRASH
        ended = f"signal {-code} ({signal.strsignal(-code)})" if code < 0 else f"exit code {code}"
        problem = f"its process ended with {ended}" + (f": {said}" if said else "")
        return Reply(outcome, None, problem, tuple(self._parts), seconds, code=code)

    def _late(self) -> Reply:
        """Kill a worker that did not answer in time, and return the reply."""
        ready, parts = self._ready, tuple(self._parts)
        self._end()
        if not ready:
            raise HoldfastError(message("batch", f"a worker is not ready after {STARTING:g} s", "ask again"))
        said = self._said()
        where = innermost(said)
        problem = f"no answer within {self.limits.seconds:g} s" + (f"; it was in {where}" if where else "")
        return Reply(TIME, said, problem, parts, self.limits.seconds)

    def _start(self) -> None:
        self._end()
        self._log.seek(0)
        self._log.truncate()
        limits = (str(self.limits.megabytes), str(self.limits.seconds))
        named = os.environ.get("PYTHONPATH", "").split(os.pathsep)  # an empty entry would mean the current folder
        path = os.pathsep.join([*self.folders, *filter(None, named)])
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "holdfast.base.borders.worker", self.function, *limits],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            bufsize=0,
            env={**os.environ, **{f"{name}_NUM_THREADS": "1" for name in THREADS}, "PYTHONPATH": path},
        )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        with self.process.stdin as items, self.process.stdout as answers:
            self._items = Connection(os.dup(items.fileno()), readable=False)
            self.answers = Connection(os.dup(answers.fileno()), writable=False)  # on which answers arrive
        self.started, self._given, self._ready = self.started + 1, 0, False
        self._until = time.monotonic() + STARTING
        try:
            self._items.send(self.setup)
        except OSError:
            return  # it died; ``take`` will notice

    def _said(self) -> str:
        """Return the end of what the worker wrote to stderr."""
        self._log.seek(0)
        return self._log.read().decode(errors="replace").strip()[-LAST:]

    def _end(self) -> None:
        """Kill the worker, if there is one, without waiting for its answer."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self._items.close()
            self.answers.close()
            self.process = None


def innermost(text: str) -> str:
    """Return the innermost function of holdfast in a traceback of faulthandler as module:function; "" if there is none.

    Such a traceback says "most recent call first", so it is the first one that is found. The functions of worker.py,
    which every traceback contains, do not count.
    """
    for line in text.splitlines():
        if PACKAGE in line and " in " in line and "/base/borders/worker.py" not in line:
            place, function = line.strip().split(" in ")[:2]
            module = place.split(PACKAGE)[-1].split(".py")[0].replace(os.sep, ".")
            return f"{module}:{function}"
    return ""
