"""Stand-ins for what workers call: the name of a scene says what becomes of it, and how long that takes."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

from holdfast.batches.job import Digests, key_of_files

TRACE = "HOLDFAST_DRILL_TRACE"  # environment variable: a file to which the names of all scenes asked are appended


def answered(job: Any, tell: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows with the text of the scene file, after what its name says."""
    trace = os.environ.get(TRACE)
    if trace:
        with Path(trace).open("a") as stream:
            stream.write(f"{job.name}\n")
    text = Path(job.place).read_text()
    files = [Path(job.place).name]
    known = {"key": key_of_files(job, files, Digests()), "files": files}
    scene = {"number": job.number, "scene": job.name, "path": job.path} | known
    tables = {"scenes": [scene], "bodies": [], "interfaces": [], "pushes": [], "transports": []}
    tell(tables)
    done(text.split()[0] if text.split() else "")
    scene |= {"outcome": "answered", "reason": text}
    pushes = [
        {"number": job.number, "scene": job.name, "body": f"{job.name} {k}", "force": float("inf"), "lower": 0.1 * k}
        for k in range(3)
    ]
    return tables | {"pushes": pushes}


def done(word: str) -> None:
    """Do what a word says."""
    match word:
        case "hang":
            time.sleep(600)
        case "spin":
            while True:
                pass
        case "eat":
            assert len([bytearray(100_000_000) for _ in range(1000)]) == 1000
        case "exit":
            os._exit(7)
        case "segfault":
            os.kill(os.getpid(), signal.SIGSEGV)
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "raise":
            raise ValueError("a defect")
        case "print":
            os.write(1, b"what libraries print\n" * 1000)
        case "slow":
            time.sleep(0.05)


def drilled(item: tuple[str, Any], tell: Any) -> Any:
    """Do what a word says, and return the rest, told first."""
    tell(item[1])
    done(item[0])
    return item[1]
