"""Parts that the text formats of meshes share."""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Iterator, Sequence

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.text import quoted

BLOCK = 50_000  # rows that are converted at a time, because texts need several times the memory of numbers


def rows_of(content: bytes, comment: str = "#") -> Iterator[tuple[int, list[str]]]:
    """Yield the number of every line, from 1, with its words, leaving out empty lines and comments.

    Raises ValueError if the content is not text. A backslash at the end of a line continues it.
    """
    body = content.removeprefix(BOM_UTF8)
    if b"\0" in body:
        raise ValueError("neither text nor a complete binary file")
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError:
        text = body.decode("latin-1")  # for names and comments of older programs
    before: list[str] = []
    ends = "\n" if "\n" in text else "\r"
    for number, line in enumerate(text.split(ends), 1):
        words = line.split(comment, 1)[0].split()
        if words and words[-1] == "\\":
            before += words[:-1]
        elif before or words:
            yield number, before + words
            before = []


def numbers(words: Sequence[str], number: int, least: int) -> list[float]:
    """Return the first ``least`` words of a row as numbers; raise ValueError, with the line's number, otherwise."""
    try:
        found = [float(word) for word in words[:least]]
    except ValueError:
        found = []
    if len(found) < least:
        raise ValueError(f"line {number}: needs {least} numbers, got {quoted(' '.join(words))}")
    return found


def fan(corners: Sequence[int]) -> list[tuple[int, int, int]]:
    """Split a polygon into triangles that share its first corner."""
    return [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]


class Rows:
    """A growing table of rows of three numbers, stored as arrays of BLOCK rows."""

    def __init__(self) -> None:
        self._full: list[Float] = []
        self._open: list[Sequence[float]] = []

    def __len__(self) -> int:
        return BLOCK * len(self._full) + len(self._open)

    def add(self, row: Sequence[float]) -> None:
        """Add one row of three numbers."""
        self._open.append(row)
        if len(self._open) == BLOCK:
            self._close()

    def array(self) -> Float:
        """All rows (n, 3)."""
        return np.concatenate([*self._full, np.array(self._open, dtype=np.float64).reshape(-1, 3)])

    def _close(self) -> None:
        self._full.append(np.array(self._open, dtype=np.float64))
        self._open = []
