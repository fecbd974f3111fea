"""A process that tries one input after the other: a line of JSON in, a line of JSON out.

``python -m fuzz.worker MODULE:FUNCTION MEGABYTES`` calls the function for each input. It may take that much memory more
than it has when it is ready; what it takes beyond is a MemoryError.
"""

from __future__ import annotations

import faulthandler
import importlib
import json
import os
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TextIO

from fuzz.outcome import Ending, Outcome

MEGABYTE = 1 << 20
READY = "ready"


def main(function: str, megabytes: int, told_after: float) -> None:
    """Answer inputs until there are no more; where a trial hangs is told on stderr after so many seconds."""
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # so that what is printed is no answer
    module, name = function.split(":")
    home = importlib.import_module(module)
    tried: Callable[[dict[str, Any]], Outcome] = getattr(home, name)
    getattr(home, "warm", int)()  # what is compiled and imported once is no part of a trial
    limit = taken("VmSize") + megabytes * MEGABYTE
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answer(out, {READY: True})
    for line in sys.stdin:
        faulthandler.dump_traceback_later(told_after)
        answer(out, measured(tried, json.loads(line), megabytes).plain())
        faulthandler.cancel_dump_traceback_later()


def measured(tried: Callable[[dict[str, Any]], Outcome], item: dict[str, Any], megabytes: int) -> Outcome:
    """Try one input; note the time and the peak of the memory."""
    forget_peak()
    before, start = taken("VmRSS"), time.perf_counter()
    found = tried(item)
    seconds, peak = time.perf_counter() - start, taken("VmHWM")
    if found.good and peak - before > megabytes * MEGABYTE / 2:
        found = Outcome(Ending.MEMORY, "took much", f"{(peak - before) / MEGABYTE:.0f} MB; {found.detail}")
    return replace(found, seconds=seconds, peak=peak / MEGABYTE)


def taken(entry: str) -> int:
    """Memory of this process [bytes]: VmSize, VmRSS or its peak VmHWM."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(f"{entry}:"))


def forget_peak() -> None:
    """Let VmHWM begin anew."""
    Path("/proc/self/clear_refs").write_text("5")


def answer(out: TextIO, data: dict[str, Any]) -> None:
    out.write(json.dumps(data) + "\n")
    out.flush()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
