"""Progress reports of long computations: whatever may take seconds reports, and the command line shows it.

What a listener raises stops the computation, which leaves nothing half done behind: that is how it is cancelled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")
Listener = Callable[[str, int, int], None]

_listener: ContextVar[Listener | None] = ContextVar("holdfast_progress", default=None)


def report(stage: str, done: int, total: int) -> None:
    """Tell the listener, if any, that ``done`` of ``total`` steps of ``stage`` are finished."""
    listener = _listener.get()
    if listener is not None:
        listener(stage, done, total)


def reported(stage: str, items: Sequence[T]) -> Iterator[T]:
    """Yield the items, and report each one that is done with."""
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
