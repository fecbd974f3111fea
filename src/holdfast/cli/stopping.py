"""Stop by Ctrl-C with one line, exit code 130 and no traceback."""

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
PATIENCE = 0.2  # [s] time for the main thread to end by itself; compiled code does not react to signals
NOTICE = "stopped: by the user\n"
SHOW_CURSOR = "\r\x1b[2K\x1b[?25h"  # for a terminal: clears the line of a progress bar and shows the cursor again

_noted: list[bool] = []  # interrupts since the outermost block was entered
_leaving = Lock()  # acquired by the thread that ends the process, and never released


@contextmanager
def stoppable(*, process: bool = False) -> Iterator[None]:
    """Turn Ctrl-C within this block into one line on stderr and the exit code STOPPED.

    Libraries may catch the interrupt and raise another error, for example during import. So any error after an
    interrupt counts as the interrupt.

    With ``process``, this block is the whole work of the process. The process then ends at most PATIENCE after Ctrl-C,
    even if the main thread is in compiled code, and no file is left half written. After the block, Ctrl-C is ignored
    while Python shuts down, and the exit code is that of the block.
    """

    def note(number: int, frame: FrameType | None) -> None:
        _noted.append(True)
        signal.default_int_handler(number, frame)

    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # otherwise another handler is in charge
    stop = _leave if ours and process else _stop
    if ours:
        _noted.clear()
        signal.signal(signal.SIGINT, note)
        if process:
            _watch()
    complain = sys.unraisablehook

    def unraisable(lost: sys.UnraisableHookArgs) -> None:
        """Ignore an interrupt that cannot be raised, for example in a callback of a library; _watch handles it."""
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
        stop(announced=isinstance(error, SystemExit) and error.code == STOPPED)  # by a block within this one
    finally:
        sys.unraisablehook = complain
        if ours:
            _noted.clear()
            signal.signal(signal.SIGINT, signal.SIG_IGN if process else signal.default_int_handler)


def interrupted() -> bool:
    """Return whether Ctrl-C was pressed within the outermost block."""
    return bool(_noted)


def _stop(*, announced: bool = False) -> None:
    if sys.stderr is not None and not announced:
        sys.stderr.write(NOTICE)
    raise SystemExit(STOPPED) from None


def _watch() -> None:
    """Start a thread that ends the process on Ctrl-C, even if the main thread is in compiled code."""
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    signal.set_wakeup_fd(sender.detach(), warn_on_full_buffer=False)

    def wait() -> None:
        while (signals := receiver.recv(64)) and signal.SIGINT not in signals:
            pass
        time.sleep(PATIENCE)
        _leave()

    Thread(target=wait, name="holdfast stops", daemon=True).start()


def _leave(*, announced: bool = False) -> None:
    """Print that the command is stopped and end the process, without waiting for any of its threads.

    A normal exit of Python would wait for compiled code, or free memory that it still uses.
    """
    if not _leaving.acquire(blocking=False):
        time.sleep(60)  # another thread is ending the process
    remove_unfinished()
    with suppress(OSError, ValueError, AttributeError):
        handle = sys.stderr.fileno()  # another thread may hold the lock of Python's stream, in a blocked write
        if not announced:
            os.write(handle, (SHOW_CURSOR + NOTICE if os.isatty(handle) else NOTICE).encode())
    os._exit(STOPPED)
