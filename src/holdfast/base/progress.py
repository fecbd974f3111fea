"""Progress reports of long computations. Everything that may take seconds reports; bars or lines of text show it.

A listener cancels a computation by raising an exception, which leaves nothing half done behind. A deadline stops it the
same way. Compiled code releases Python's global lock and runs in threads, which report and can be stopped too.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from dataclasses import dataclass
from threading import Event, Thread
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
Scratch = TypeVar("Scratch")
Listener = Callable[[str, int, int], None]

EVERY = 10.0  # [s] between two lines
OFTEN = 0.1  # [s] between two progress reports of threads, and the longest wait before a stop is noticed

_listener: ContextVar[Listener | None] = ContextVar("holdfast_progress", default=None)
_deadline: ContextVar[float] = ContextVar("holdfast_deadline", default=float("inf"))
_shared: ContextVar[bool] = ContextVar("holdfast_threads_shared", default=False)  # whether other threads are at work


class OutOfTimeError(Exception):
    """The deadline set by ``until`` has passed; whoever set it catches this."""


def report(stage: str, done: int, total: int) -> None:
    """Tell the listener, if any, that ``done`` of ``total`` steps of ``stage`` are finished; total 0: nobody knows."""
    keep_to_time()
    listener = _listener.get()
    if listener is not None:
        listener(stage, done, total)


def keep_to_time() -> None:
    """Raise OutOfTimeError if a deadline has passed; for work that makes no progress reports of its own."""
    if time.perf_counter() > _deadline.get():
        raise OutOfTimeError


@contextmanager
def until(deadline: float) -> Iterator[None]:
    """Let the next report or ``keep_to_time`` raise OutOfTimeError once ``time.perf_counter()`` passes ``deadline``.

    Within another such block the earlier deadline holds.
    """
    token = _deadline.set(min(deadline, _deadline.get()))
    try:
        yield
    finally:
        _deadline.reset(token)


def reported(stage: str, items: Sequence[T]) -> Iterator[T]:
    """Yield the items, and report progress before each one and after the last."""
    for number, item in enumerate(items):
        report(stage, number, len(items))
        yield item
    report(stage, len(items), len(items))


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Call ``listener(stage, done, total)`` for every progress report made within this block."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@dataclass(frozen=True)
class _Stage:
    """The stage that was reported last: when it began and with how many steps, and how many are done."""

    name: str
    began: float
    first: int
    done: int
    total: int

    def line(self) -> str:
        """How far the stage is, with the rate and the time that is left, as far as the number of steps is known."""
        seconds, steps = time.monotonic() - self.began, self.done - self.first
        pace = f"after {seconds:.0f} s"
        if not self.total:
            return f"{self.name}: {self.done:,}, {pace}"
        if steps and seconds:
            rate = steps / seconds
            left = (self.total - self.done) / rate
            pace = f"{rate:.3g} a second, {f'{left / 60:.0f} min' if left > 90 else f'{left:.0f} s'} left"
        return f"{self.name}: {self.done:,} of {self.total:,}, {pace}"


@contextmanager
def lines(say: Callable[[str], None]) -> Iterator[None]:
    """Call ``say(line)`` about every ten seconds within this block, with how far it is; not if somebody listens."""
    if _listener.get() is not None:
        yield
        return
    stage: _Stage | None = None
    ended = Event()

    def listener(name: str, done: int, total: int) -> None:
        nonlocal stage
        same = stage is not None and stage.name == name and stage.done <= done
        began, first = (stage.began, stage.first) if stage is not None and same else (time.monotonic(), done)
        stage = _Stage(name, began, first, done, total)

    def tell() -> None:
        while not ended.wait(EVERY):
            if stage is not None:
                say(stage.line())

    teller = Thread(target=tell, daemon=True)
    teller.start()
    try:
        with listening(listener):
            yield
    finally:
        ended.set()
        teller.join()


@contextmanager
def unheard() -> Iterator[None]:
    """Suppress the progress reports made in this block; a deadline still holds."""
    token = _listener.set(None)
    try:
        yield
    finally:
        _listener.reset(token)


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
    calls = [_started(work, number) for number in range(len(scratch))]
    try:
        for call in calls:
            while not wait([call], OFTEN).done:
                report(stage, total * sum(done) // count, total)
            call.result()
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
    call = _started(function, *args, **kwargs)
    while not wait([call], OFTEN).done:
        pass
    return call.result()


def begin(function: Callable[[], object]) -> None:
    """Start a function in a thread that nobody waits for, to fill a cache before its content is needed.

    The function starts no further threads, its progress reports are suppressed, and its errors are dropped: whoever
    needs the same content later meets the same error.
    """

    def run() -> None:
        _shared.set(True)
        with unheard():
            function()

    _started(run)


def _started(function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> Future[R]:
    """Call a function in a thread that does not outlive the program; the future holds its result or its error."""
    future: Future[R] = Future()
    context = copy_context()

    def run() -> None:
        try:
            future.set_result(context.run(function, *args, **kwargs))
        except BaseException as error:
            future.set_exception(error)

    Thread(target=run, daemon=True).start()
    return future
