"""A process that answers items: ``python -P -m holdfast.base.borders.worker MODULE:FUNCTION MB SECONDS``.

Its supervisor (supervisor.py) is at the other end of its stdin and stdout. The first message is the argument of the
module's ``warm``; the others are items. For each item, ``function(item, tell)`` is called. Its result is sent back, and
so are the partial results that it passes to ``tell``. If an item needs more than MB of memory above that of the ready
worker, a MemoryError is raised.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

READY, PART, DONE = "ready", "part", "done"  # messages of a worker, beside the outcomes below
ANSWERED, ERROR, TIME, MEMORY, CRASH = "answered", "error", "time", "memory", "crash"  # outcomes of a scene
OUTCOMES = (ANSWERED, ERROR, TIME, MEMORY, CRASH)
MEGABYTE = 1 << 20  # bytes

PATIENCE = 2.0  # a worker ends itself after this multiple of SECONDS, plus 30 s, in case its supervisor is gone
LIMITED = "HOLDFAST_LIMITED"  # a variable of the environment that workers have
LINES = 6  # number of lines at the end of a traceback that are reported


def main(function: str, megabytes: float, seconds: float) -> None:
    """Answer items until the supervisor closes the connection."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the supervisor
    items, answers = Connection(os.dup(0), writable=False), Connection(os.dup(1), readable=False)
    nowhere = os.open(os.devnull, os.O_RDWR)  # for what libraries print
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    module, _, name = function.partition(":")
    home = importlib.import_module(module)
    answer_item = getattr(home, name)
    setup = items.recv()
    if hasattr(home, "warm"):
        home.warm(setup)
    _limit(megabytes)
    os.environ[LIMITED] = "1"
    answers.send((READY, None))
    while True:
        try:
            item = items.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_REAL, PATIENCE * seconds + 30)  # SIGALRM ends the process by default
        faulthandler.dump_traceback_later(0.9 * seconds)
        answers.send(_answer(answer_item, item, lambda part: answers.send((PART, part))))
        faulthandler.cancel_dump_traceback_later()
        signal.setitimer(signal.ITIMER_REAL, 0)


def is_limited() -> bool:
    """Tell whether this process is a worker, which has limits of memory and time."""
    return LIMITED in os.environ


def taken(entry: str) -> int:
    """Return the memory of this process [bytes], VmSize, VmRSS or the peak VmHWM; 0 if the system does not say."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return 0
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(f"{entry}:"))


def _answer(function: Callable[..., Any], item: Any, tell: Callable[[Any], None]) -> tuple[str, Any]:  # noqa: ANN401
    """Return DONE, MEMORY or CRASH with the answer or the error as a text, the seconds and the peak [MB]."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")  # resets the peak of memory, VmHWM
    start = time.perf_counter()
    try:
        kind, found = DONE, function(item, tell)
    except MemoryError as error:
        kind, found = MEMORY, repr(error)
    except Exception as error:  # a defect of holdfast: this scene gets a report, and the batch continues
        kind, found = CRASH, "".join(traceback.format_exception(error)[-LINES:])
    return kind, (found, time.perf_counter() - start, taken("VmHWM") / MEGABYTE)


def _limit(megabytes: float) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    size = taken("VmSize")
    if size:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        most = size + int(megabytes * MEGABYTE)
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
