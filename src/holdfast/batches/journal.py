"""Journals: answered scenes, one line each, until their shard is written.

A line holds all rows of a scene. It is written without buffering, so that it survives the process; about once a second
it is also synced to the disk. A damaged or incomplete line is dropped.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import check_ordinary
from holdfast.batches.schema import TABLES, Tables
from holdfast.batches.tables import check_row, completed, line_of

SYNCED = 1.0  # [s] time between two syncs to the disk

Record = Tables  # all rows of one scene, of which the table "scenes" has one


def name_of(record: Record) -> str:
    """Return the name of the scene of a record."""
    return str(record["scenes"][0]["scene"])


class Journal:
    """The journal at ``path``: records are appended, and read back by the names of scenes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream: IO[bytes] | None = None
        self._synced = 0.0
        self.places: dict[str, int] = {}  # where the line of each scene begins
        self._end = 0
        if path.exists():
            self._index()

    def append(self, record: Record) -> None:
        """Append the rows of a scene; raise HoldfastError if there is no room for them."""
        line = line_of(record).encode()
        try:
            if self._stream is None:
                self._stream = self.path.open("ab", buffering=0)
                self._stream.truncate(self._end)  # an incomplete line may follow
            written = 0
            while written < len(line):
                written += self._stream.write(line[written:]) or 0
            if time.monotonic() - self._synced > SYNCED:
                self.sync()
        except OSError as cause:
            problem = f"cannot be written: {cause.strerror or cause}"
            remedy = "make room, and ask again: what is finished is kept"
            raise HoldfastError(message(str(self.path), problem, remedy)) from cause
        self.places[name_of(record)] = self._end
        self._end += len(line)

    def sync(self) -> None:
        """Sync all that was appended to the disk."""
        if self._stream is not None:
            os.fsync(self._stream.fileno())
        self._synced = time.monotonic()

    def record(self, name: str) -> Record:
        """Return the rows of the scene with this name, from its last line."""
        with self.path.open("rb") as stream:
            stream.seek(self.places[name])
            return _record(stream.readline())

    def records(self) -> Iterator[Record]:
        """Yield the rows of all scenes, in the order in which they were appended."""
        for name in list(self.places):
            yield self.record(name)

    def close(self) -> None:
        """Close the file."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def remove(self) -> None:
        """Remove the journal, once its rows are in a shard."""
        self.close()
        self.path.unlink(missing_ok=True)
        self.places, self._end = {}, 0

    def _index(self) -> None:
        """Find the beginnings of all complete and valid lines; the journal ends after the last of them."""
        check_ordinary(self.path, "journal", error=HoldfastError, remedy="remove it: its scenes are computed again")
        place = 0
        with self.path.open("rb") as stream:
            for line in stream:
                begin, place = place, place + len(line)
                try:
                    name = name_of(_record(line))
                except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
                    continue  # for example blocks of zeros after a power failure
                if line.endswith(b"\n"):
                    self.places[name], self._end = begin, place


def _record(line: bytes) -> Record:
    data = json.loads(line)
    found = {table: [completed(table, row) for row in data.get(table, [])] for table in TABLES}
    for table, rows in found.items():
        for row in rows:
            check_row(table, row)
    return found
