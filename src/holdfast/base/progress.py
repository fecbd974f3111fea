"""Progress reports of long computations. Everything that may take seconds reports; the command line shows the reports.

A listener cancels a computation by raising an exception, which leaves nothing half done behind. A deadline stops it the
same way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")
Listener = Callable[[str, int, int], None]

_listener: ContextVar[Listener | None] = ContextVar("holdfast_progress", default=None)
_deadline: ContextVar[float] = ContextVar("holdfast_deadline", default=float("inf"))


class OutOfTimeError(Exception):
    """The deadline set by ``until`` has passed; whoever set it catches this."""


def report(stage: str, done: int, total: int) -> None:
    """Tell the listener, if any, that ``done`` of ``total`` steps of ``stage`` are finished."""
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


@contextmanager
def unheard() -> Iterator[None]:
    """Suppress the progress reports made in this block; a deadline still holds."""
    token = _listener.set(None)
    try:
        yield
    finally:
        _listener.reset(token)
