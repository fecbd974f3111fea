"""A process that answers one item after the other: ``python -P -m holdfast.batches.worker MODULE:FUNCTION MB SECONDS``.

Its keeper (keeper.py) is at the other end of its stdin and stdout. First comes what ``warm`` of the module is called
with, then the items. For each, ``function(item, tell)`` is called, and what it returns is sent back, as is all that it
tells meanwhile. It may take that much memory more than it has when it is ready; what it takes beyond is a MemoryError.
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

from holdfast.batches.words import CRASH, DONE, MEGABYTE, MEMORY, PART, READY

STATUS = Path("/proc/self/status")
PATIENCE = 2.0  # times its seconds, and half a minute more, after which a worker without keeper ends of itself
LINES = 6  # frames of a traceback that are told


def main(function: str, megabytes: float, seconds: float) -> None:
    """Answer items until the keeper closes its end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the keeper
    items, answers = _ends()
    module, _, name = function.partition(":")
    home = importlib.import_module(module)
    asked = getattr(home, name)
    setup = items.recv()
    getattr(home, "warm", _nothing)(setup)
    _limit(megabytes)
    answers.send((READY, None))
    while True:
        try:
            item = items.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_REAL, PATIENCE * seconds + 30)  # whose default is the end of the process
        faulthandler.dump_traceback_later(0.9 * seconds)
        answers.send(_answer(asked, item, lambda part: answers.send((PART, part))))
        faulthandler.cancel_dump_traceback_later()
        signal.setitimer(signal.ITIMER_REAL, 0)


def taken(entry: str) -> int:
    """Return the memory of this process [bytes]: VmSize, VmRSS or its peak VmHWM; 0 where the system does not say."""
    try:
        lines = STATUS.read_text().splitlines()
    except OSError:
        return 0
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(f"{entry}:"))


def _ends() -> tuple[Connection, Connection]:
    """Take stdin and stdout for the keeper alone: what libraries print is no answer."""
    items, answers = Connection(os.dup(0), writable=False), Connection(os.dup(1), readable=False)
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    return items, answers


def _answer(asked: Callable[..., Any], item: Any, tell: Callable[[Any], None]) -> tuple[str, Any]:  # noqa: ANN401
    """Return DONE, MEMORY or CRASH with the answer or the error as a text, the seconds and the peak [MB]."""
    _forget_peak()
    start = time.perf_counter()
    try:
        kind, found = DONE, asked(item, tell)
    except MemoryError as error:
        kind, found = MEMORY, repr(error)
    except Exception as error:  # a defect of holdfast: the scene is told, the others go on
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


def _forget_peak() -> None:
    """Let VmHWM begin anew."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _nothing(setup: Any) -> None:  # noqa: ANN401
    """Warm nothing up."""


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
