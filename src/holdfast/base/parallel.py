"""Work in threads that report progress and can be stopped: for compiled code, which holds no lock of Python's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import copy_context
from functools import partial
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import Generic, NoReturn, ParamSpec, TypeVar

from holdfast.base.progress import report

P = ParamSpec("P")
R = TypeVar("R")
Memory = TypeVar("Memory")

OFTEN = 0.1  # [s] between two progress reports, and the longest wait before a stop is noticed


def in_parallel(
    stage: str,
    run: Callable[[Iterable[int], Memory], None],
    parts: Sequence[tuple[range, Memory]],
    count: int,
) -> None:
    """Let each thread run over the rows of one part with its own memory; report how many of ``count`` rows are done.

    Whatever is raised, here or in a thread, stops all of them after the rows that they are at.
    """
    done, stop = [0] * len(parts), Event()

    def rows(part: int) -> Iterator[int]:
        for row in parts[part][0]:
            if stop.is_set():
                return
            yield row
            done[part] += 1

    def work(part: int) -> None:
        run(rows(part), parts[part][1])

    report(stage, 0, count)
    calls = [_Call(work, part) for part in range(len(parts))]
    try:
        for call in calls:
            while (result := call.ended(OFTEN)) is None:
                report(stage, sum(done), count)
            result()
        report(stage, count, count)
    finally:
        stop.set()


def left_if_stopped(function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
    """Call a function in a thread and return its result; if the user stops the program, it is left to itself."""
    call = _Call(function, *args, **kwargs)
    while (result := call.ended(OFTEN)) is None:
        pass
    return result()


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
