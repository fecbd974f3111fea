"""Stopping by Ctrl-C: one line, exit code 130, no traceback, whatever was going on."""

from __future__ import annotations

import os
import signal
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Lock, Thread
from types import FrameType

from holdfast.base.files import remove_unfinished

STOPPED = 130  # exit code of a command that was stopped: 128 and the number of the signal
PATIENCE = 0.2  # [s] that the main thread has to end by itself; it may be in compiled code, which hears nothing
TELL = "stopped: by the user\n"
SHOW_CURSOR = "\r\x1b[2K\x1b[?25h"  # to a terminal: a progress bar hides it, and its line is not complete

_noted: list[bool] = []  # interrupts since the outermost block was entered
_leaving = Lock()  # taken by the thread that ends the process, and never given back


@contextmanager
def stoppable(*, process: bool = False) -> Iterator[None]:
    """Turn Ctrl-C within this block into one line on stderr and the exit code STOPPED.

    Libraries may catch the interrupt and fail in another way, for example while they are imported. An error that comes
    after an interrupt is therefore taken for it.

    ``process``: this block is all that the process is for. Then the process ends at once, PATIENCE after Ctrl-C at the
    latest, even if the main thread is deep in compiled code. No file is left half written. After the block all is done,
    and Ctrl-C does nothing while Python clears up: the exit code is that of the block.
    """

    def note(number: int, frame: FrameType | None) -> None:
        _noted.append(True)
        signal.default_int_handler(number, frame)

    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else somebody else stops, or nobody does
    stop = _leave if ours and process else _stop
    if ours:
        _noted.clear()
        signal.signal(signal.SIGINT, note)
        if process:
            _watch()
    complain = sys.unraisablehook

    def unraisable(lost: sys.UnraisableHookArgs) -> None:
        """Say nothing of an interrupt that cannot be raised, as in a callback of the compiler: _watch hears it."""
        if not isinstance(lost.exc_value, KeyboardInterrupt):
            complain(lost)

    sys.unraisablehook = unraisable
    try:
        yield
    except KeyboardInterrupt:
        stop()
    except BaseException as error:
        if not interrupted():
            raise
        stop(told=isinstance(error, SystemExit) and error.code == STOPPED)  # by a block within this one
    finally:
        sys.unraisablehook = complain
        if ours:
            _noted.clear()
            signal.signal(signal.SIGINT, signal.SIG_IGN if process else signal.default_int_handler)


def interrupted() -> bool:
    """Tell whether Ctrl-C came within the outermost block, whatever became of it."""
    return bool(_noted)


def _stop(*, told: bool = False) -> None:
    if sys.stderr is not None and not told:
        sys.stderr.write(TELL)
    raise SystemExit(STOPPED) from None


def _watch() -> None:
    """Start a thread that hears of signals though the main thread is in compiled code, and then ends the process."""
    hears, told = socket.socketpair()
    told.setblocking(False)
    signal.set_wakeup_fd(told.detach(), warn_on_full_buffer=False)

    def wait() -> None:
        while (signals := hears.recv(64)) and signal.SIGINT not in signals:
            pass
        time.sleep(PATIENCE)
        _leave()

    Thread(target=wait, name="holdfast stops", daemon=True).start()


def _leave(*, told: bool = False) -> None:
    """Say that the command is stopped and end the process, without waiting for any of its threads.

    Python's own way out would wait for compiled code to end, or take what it runs on from under it.
    """
    if not _leaving.acquire(blocking=False):
        time.sleep(60)  # another thread does it
    remove_unfinished()
    with suppress(OSError, ValueError, AttributeError):
        handle = sys.stderr.fileno()  # not by Python's stream: another thread may hold its lock, in a write that waits
        if not told:
            os.write(handle, (SHOW_CURSOR + TELL if os.isatty(handle) else TELL).encode())
    os._exit(STOPPED)
