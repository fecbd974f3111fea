"""Threads that report progress and can be stopped; for compiled code, which releases Python's global lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import ContextVar, copy_context
from functools import partial
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import Generic, NoReturn, ParamSpec, TypeVar

from holdfast.base.progress import report, unheard

P = ParamSpec("P")
R = TypeVar("R")
Scratch = TypeVar("Scratch")

OFTEN = 0.1  # [s] between two progress reports, and the longest wait before a stop is noticed

_shared: ContextVar[bool] = ContextVar("holdfast_threads_shared", default=False)  # whether other threads are at work


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def free_threads() -> int:
    """Return how many threads may be started: one for each core, but only one inside a thread that is started here."""
    return 1 if _shared.get() else cores()


def in_parallel(
    stage: str, run: Callable[[Iterable[int], Scratch], None], scratch: Sequence[Scratch], count: int, total: int
) -> None:
    """Process ``count`` rows in as many threads as there are items in ``scratch``, and report progress.

    Each thread calls ``run(rows, own)`` once, with its own item of ``scratch`` and an iterator that hands out the next
    row that no thread has taken. Progress is reported in shares of ``total``, to which all rows contribute equally. An
    error in this thread or another one stops all of them after their current rows. Code in the threads starts no
    further threads, and its progress reports are suppressed.
    """
    ahead, done, stop = iter(range(count)), [0] * len(scratch), Event()

    def rows(number: int) -> Iterator[int]:
        for row in ahead:  # Python's global lock lets one thread at a time take a row
            if stop.is_set():
                return
            yield row
            done[number] += 1

    def work(number: int) -> None:
        _shared.set(True)
        with unheard():
            run(rows(number), scratch[number])

    report(stage, 0, total)
    calls = [_Call(work, number) for number in range(len(scratch))]
    try:
        for call in calls:
            while (result := call.ended(OFTEN)) is None:
                report(stage, total * sum(done) // count, total)
            result()
        report(stage, total, total)
    finally:
        stop.set()


def answers_in_parallel(stage: str, ask: Callable[[int], R], threads: int, count: int, total: int) -> list[R]:
    """Return ``[ask(0), ..., ask(count - 1)]``, computed in ``threads`` threads.

    Progress reports and errors are those of ``in_parallel``.
    """
    found: dict[int, R] = {}

    def run(numbers: Iterable[int], _: None) -> None:
        for number in numbers:
            found[number] = ask(number)

    in_parallel(stage, run, [None] * threads, count, total)
    return [found[number] for number in range(count)]


def left_if_stopped(function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
    """Call a function in a thread and return its result; if the user interrupts the program, do not wait for it."""
    call = _Call(function, *args, **kwargs)
    while (result := call.ended(OFTEN)) is None:
        pass
    return result()


def begin(function: Callable[[], object]) -> None:
    """Start a function in a thread that nobody waits for, to fill a cache before its content is needed.

    The function starts no further threads, its progress reports are suppressed, and its errors are dropped: whoever
    needs the same content later meets the same error.
    """

    def run() -> None:
        _shared.set(True)
        with unheard():
            function()

    _Call(run)


class _Call(Generic[R]):
    """A call in a thread that does not outlive the program."""

    def __init__(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> None:
        self._answer: SimpleQueue[Callable[[], R]] = SimpleQueue()
        context = copy_context()

        def run() -> None:
            try:
                value = context.run(function, *args, **kwargs)
            except BaseException as error:
                self._answer.put(partial(_again, error))
            else:
                self._answer.put(lambda: value)

        Thread(target=run, daemon=True).start()

    def ended(self, seconds: float) -> Callable[[], R] | None:
        """Wait for at most ``seconds`` [s]; return None if the call has not ended.

        Otherwise return a function that returns its result or raises its error.
        """
        try:
            return self._answer.get(timeout=seconds)
        except Empty:
            return None


def _again(error: BaseException) -> NoReturn:
    raise error
