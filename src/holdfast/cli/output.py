"""The output of commands to terminals, files and pipes of any encoding, and their progress."""

from __future__ import annotations

import codecs
import errno
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Annotated, Any

import typer
from rich.console import Console

from holdfast.base.progress import lines, listening
from holdfast.base.text import one_line

AsJson = Annotated[bool, typer.Option("--json", help="print JSON, holdfast-answer/1; infinity is the text inf")]

LONGEST = 4000  # largest number of characters of a message, which may hold a long path
# replacements for characters that the encoding of a terminal lacks; all others become escape sequences
LETTERS = {"μ": "u", "²": "2", "³": "3", "°": "deg", "∞": "inf", "·": "-", "−": "-", "…": "...", "┄": "-", "σ": "sigma"}


class OutputLost(Exception):  # noqa: N818 - not an error of the command
    """The output could not be written, because the pipe is closed or the disk full; ``reason`` is an errno."""

    def __init__(self, cause: OSError | None) -> None:
        self.reason = errno.EBADF if cause is None else cause.errno
        super().__init__("it is closed" if cause is None else cause.strerror or str(cause))


class Output(Console):
    """A console that prints text without interpreting markup or emoji codes, and raises OutputLost on failure."""

    def __init__(self, *, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False)

    def print(self, *objects: Any, **options: Any) -> None:  # noqa: ANN401 - those of rich
        """Print as rich does; raise OutputLost where that is not possible."""
        if (sys.stderr if self.stderr else sys.stdout) is None:
            raise OutputLost(None)
        try:
            super().print(*objects, **options)
        except OSError as cause:
            self._buffer.clear()  # otherwise the next print would write it
            raise OutputLost(cause) from cause

    def on_broken_pipe(self) -> None:
        """Raise OutputLost, where rich would exit with code 1."""
        self._buffer.clear()
        raise OutputLost(BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE)))

    def say(self, text: str, *, style: str = "", label: str = "") -> None:
        """Print one line without wrapping, after a ``label`` in this style."""
        if label:
            self.print(label, style=style, end=" ")
        self.print(one_line(text, LONGEST), soft_wrap=True)


out, err = Output(), Output(stderr=True)


def print_json(data: Any, *, indent: int | None = None) -> None:  # noqa: ANN401 - any JSON value
    """Print strict JSON: it has no NaN, and infinity is a text."""
    write(json.dumps(data, allow_nan=False, indent=indent) + "\n")


@contextmanager
def progress() -> Iterator[None]:
    """Show a progress bar for each stage that reports its progress, or a line now and then if there is no terminal."""
    if not err.is_terminal:
        with lines(_say):
            yield
        return
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
    with Progress(*columns, console=err, transient=True) as bars:
        tasks: dict[str, Any] = {}

        def listener(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total or None)
            bars.update(tasks[stage], completed=done, total=total or None)

        with listening(listener):
            yield


def _say(line: str) -> None:
    with suppress(OutputLost):  # the answer does not depend on it
        err.say(line)


def write(text: str) -> None:
    """Write a text to stdout as it is; raise OutputLost where that is not possible."""
    if sys.stdout is None:
        raise OutputLost(None)
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as cause:
        raise OutputLost(cause) from cause


def make_writable() -> None:
    """Let stdout and stderr accept every character, whatever their encoding."""
    codecs.register_error("holdfast", _spelled)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="holdfast")


def abandon() -> None:
    """Redirect the remaining output to nowhere, so that Python reports no further error at its end."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
    except (OSError, ValueError, AttributeError):  # stdout has no file descriptor
        return


def _spelled(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    wrong = error.object[error.start : error.end]
    return "".join(LETTERS.get(c) or c.encode("ascii", "backslashreplace").decode() for c in wrong), error.end
