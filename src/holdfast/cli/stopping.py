"""Stopping by Ctrl-C: one line, exit code 130, no traceback, whatever was going on."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

STOPPED = 130  # exit code of a command that was stopped: 128 and the number of the signal


@contextmanager
def stoppable() -> Iterator[None]:
    """Turn Ctrl-C within this block into one line on stderr and the exit code STOPPED.

    Libraries may catch the interrupt and fail in another way, for example while they are imported. An error that comes
    after an interrupt is therefore taken for it.
    """
    noted: list[bool] = []

    def note(number: int, frame: FrameType | None) -> None:
        noted.append(True)
        signal.default_int_handler(number, frame)

    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else somebody else stops, or nobody does
    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield
    except KeyboardInterrupt:
        _stop()
    except BaseException:
        if not noted:
            raise
        _stop()
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _stop() -> None:
    if sys.stderr is not None:
        sys.stderr.write("stopped: by the user\n")
    raise SystemExit(STOPPED) from None
