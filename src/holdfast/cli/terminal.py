"""Progress on the terminal: bars, or lines where stderr is a file."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from holdfast.base.progress import listening
from holdfast.cli.output import err

EVERY = 30.0  # [s] time between two lines


@contextmanager
def progress() -> Iterator[None]:
    """Show a progress bar for each stage that reports its progress, if the output is a terminal."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    left = (TextColumn("left"), TimeRemainingColumn())
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), *left)
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bars:
        tasks: dict[str, Any] = {}

        def listener(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        with listening(listener):
            yield


@contextmanager
def lines() -> Iterator[None]:
    """Without a terminal, print the progress, the rate and the remaining time every 30 s."""
    if err.is_terminal:
        yield
        return
    start, first, last = time.monotonic(), 0, 0.0

    def listener(stage: str, done: int, total: int) -> None:
        nonlocal start, first, last
        now = time.monotonic()
        if last == 0.0:
            start, first, last = now, done, now  # items that were done before do not count for the rate
        elif now - last > EVERY and done > first:
            last = now
            err.say(f"{done:,} of {total:,} {stage}, {pace(done - first, total - done, now - start)}")

    with listening(listener):
        yield


def pace(done: int, left: int, seconds: float) -> str:
    """Return the rate and the remaining time, in words."""
    rate = done / seconds
    rest = left / rate
    minutes = f"{rest / 60:.0f} min" if rest > 90 else f"{rest:.0f} s"
    return f"{rate:.3g} a second, {minutes} left"
