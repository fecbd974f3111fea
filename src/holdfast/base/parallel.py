"""Work in threads that report progress and can be stopped: for compiled code, which holds no lock of Python's."""

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
Memory = TypeVar("Memory")

OFTEN = 0.1  # [s] between two progress reports, and the longest wait before a stop is noticed

_shared: ContextVar[bool] = ContextVar("holdfast_threads_shared", default=False)  # whether other threads are at work


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def free_threads() -> int:
    """Return how many threads work may be shared among: one for each core, and one in all within a thread."""
    return 1 if _shared.get() else cores()


def in_parallel(
    stage: str, run: Callable[[Iterable[int], Memory], None], memories: Sequence[Memory], count: int, total: int
) -> None:
    """Let threads with a memory each run over ``count`` rows, each taking the next row; report how far they are.

    Reports are of the ``total`` that is in all rows, in equal parts. Whatever is raised, here or in a thread, stops
    all of them after the rows that they are at. What is done for a row has no threads of its own, and its reports are
    not heard.
    """
    ahead, done, stop = iter(range(count)), [0] * len(memories), Event()

    def rows(number: int) -> Iterator[int]:
        for row in ahead:  # Python's global lock lets one thread at a time take a row
            if stop.is_set():
                return
            yield row
            done[number] += 1

    def work(number: int) -> None:
        _shared.set(True)
        with unheard():
            run(rows(number), memories[number])

    report(stage, 0, total)
    calls = [_Call(work, number) for number in range(len(memories))]
    try:
        for call in calls:
            while (result := call.ended(OFTEN)) is None:
                report(stage, total * sum(done) // count, total)
            result()
        report(stage, total, total)
    finally:
        stop.set()


def answers_in_parallel(stage: str, ask: Callable[[int], R], threads: int, count: int, total: int) -> list[R]:
    """Return what ``ask`` answers for each number below ``count``, asked in so many threads.

    Reports and errors are those of ``in_parallel``.
    """
    found: dict[int, R] = {}

    def run(numbers: Iterable[int], memory: None) -> None:
        for number in numbers:
            found[number] = ask(number)

    in_parallel(stage, run, [None] * threads, count, total)
    return [found[number] for number in range(count)]


def left_if_stopped(function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
    """Call a function in a thread and return its result; if the user stops the program, it is left to itself."""
    call = _Call(function, *args, **kwargs)
    while (result := call.ended(OFTEN)) is None:
        pass
    return result()


def begin(function: Callable[[], object]) -> None:
    """Call a function in a thread that nobody waits for: it makes early what others will ask for, and keeps it.

    It has no threads of its own, and its reports are not heard. What it raises is raised again where others ask for the
    same.
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
        """What returns its result, or raises what it raised, once it has ended; None if that takes longer."""
        try:
            return self._answer.get(timeout=seconds)
        except Empty:
            return None


def _again(error: BaseException) -> NoReturn:
    raise error
