"""The output of commands to terminals, files and pipes of any encoding."""

from __future__ import annotations

import codecs
import errno
import json
import os
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console

from holdfast.base.text import one_line

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


def noted(data: dict[str, Any], notes: Sequence[str]) -> dict[str, Any]:
    """Return the plain data of an answer with the notes of its scene before its own notes."""
    return data | {"notes": list(dict.fromkeys((*notes, *data.get("notes", ()))))}


def print_notes(notes: Sequence[str]) -> None:
    """Print the notes of a scene, one line each."""
    for note in notes:
        out.say(note, label="note:", style="yellow")


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
