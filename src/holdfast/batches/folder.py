"""The folder of a batch: what is asked there, its tables in shards, and the lock that keeps a second driver out."""

from __future__ import annotations

import fcntl
import json
import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from holdfast import __version__
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.files import checked_path, read_ordinary, write_atomically
from holdfast.base.text import quoted
from holdfast.batches import tables
from holdfast.batches.job import Question
from holdfast.batches.journal import Journal, Record
from holdfast.batches.schema import TABLES, VERSION, described

ABOUT, SCHEMA, JOURNAL, LOCK = "batch.json", "schema.json", "journal", "lock"
MOST_BYTES = 1_000_000_000
LAST = "scenes"  # the table that is written last: a shard is there when this file of it is


@dataclass(frozen=True)
class Part:
    """The share of the shards that one driver does: those whose number leaves ``number`` when divided by ``of``."""

    number: int = 0
    of: int = 1

    @property
    def text(self) -> str:
        """The share as it is given: ``number/of``."""
        return f"{self.number}/{self.of}"

    def has(self, shard: int) -> bool:
        """Say whether a shard is in this share."""
        return shard % self.of == self.number


@dataclass
class Folder:
    """An open folder: ``path``, the number of scenes in a shard, how rows are stored, and this driver's share."""

    path: Path
    shard_size: int
    storage: tables.Storage
    part: Part = field(default_factory=Part)

    def file(self, table: str, shard: int) -> Path:
        """Return where the rows of a shard are."""
        return self.path / table / f"{shard:06d}{self.storage.suffix}"

    def journal(self, shard: int) -> Journal:
        """Return the journal of a shard."""
        return Journal(self.path / JOURNAL / f"{shard:06d}.jsonl")

    def displaced(self) -> Journal:
        """Return the journal of rows that shards lost because inputs moved."""
        return Journal(self.path / JOURNAL / f"displaced-{self.part.number}-{self.part.of}.jsonl")

    def journals(self) -> Iterator[Journal]:
        """Yield all journals of all drivers."""
        for path in sorted((self.path / JOURNAL).glob("*.jsonl")):
            yield Journal(path)

    def shards(self) -> list[int]:
        """Return the numbers of the shards that are complete."""
        found = (self.path / LAST).glob(f"*{self.storage.suffix}")
        return sorted(int(path.stem) for path in found if path.stem.isdecimal())

    def names(self, shard: int) -> list[str]:
        """Return the names of the scenes in a shard."""
        rows = self.storage.rows_in(LAST, self.file(LAST, shard), ["scene"])
        return [str(row["scene"]) for row in rows]

    def records(self, shard: int) -> dict[str, Record]:
        """Return the rows of all scenes of a shard by their names."""
        found: dict[str, Record] = {}
        for row in self.storage.rows_in(LAST, self.file(LAST, shard), None):
            found[row["scene"]] = {table: [] for table in TABLES} | {LAST: [row]}
        for table in TABLES:
            if table != LAST:
                for row in self.storage.rows_in(table, self.file(table, shard), None):
                    found[row["scene"]][table].append(row)
        return found

    def write(self, shard: int, records: Sequence[Record]) -> None:
        """Write a shard. Its rows stand in journals meanwhile; what it held before is gone first."""
        for table in TABLES:
            (self.path / table).mkdir(exist_ok=True)
        self.remove(shard)
        for table in (*(table for table in TABLES if table != LAST), LAST):
            rows = [row for record in records for row in record[table]]
            self.storage.write(table, self.file(table, shard), rows)

    def remove(self, shard: int) -> None:
        """Remove a shard, beginning with what says that it is there."""
        for table in (LAST, *(table for table in TABLES if table != LAST)):
            self.file(table, shard).unlink(missing_ok=True)


def about(folder: Path) -> dict[str, Any]:
    """Return what batch.json says of a folder; raise HoldfastError if that is not the folder of a batch."""
    path = folder / ABOUT
    content = read_ordinary(path, "folder of a batch", most=MOST_BYTES, error=HoldfastError)
    try:
        data = json.loads(content)
        if data["format"] != VERSION or not all(isinstance(data[key], int | str) for key in ("shard_size", "storage")):
            raise ValueError(f"its format is {data['format']!r:.40}")
    except (ValueError, LookupError, TypeError) as cause:
        raise HoldfastError(message(str(path), f"is damaged: {cause}", f"needs {VERSION}: another folder")) from cause
    return dict(data)


def reading(folder: object) -> Folder:
    """Open a folder to read its tables."""
    path = checked_path(folder, "folder of a batch")
    told = about(path)
    return Folder(path, int(told["shard_size"]), tables.storage_named(told["storage"]))


def opened(path: Path, question: Question, shard_size: int, part: Part, stack: ExitStack) -> Folder:
    """Open a folder to write to it until the stack ends, and make it if there is none.

    Raises HoldfastError if the folder holds answers to another question, or another driver writes to it.
    """
    try:
        (path / JOURNAL).mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        remedy = "name a folder that can be made"
        raise HoldfastError(message(str(path), f"cannot be made: {cause.strerror}", remedy)) from cause
    _lock(path, part, stack)
    storage = tables.PARQUET if tables.has_pyarrow() else tables.LINES
    new = {"format": VERSION, "version": __version__, **json.loads(question.text), "shard_size": shard_size}
    if (path / ABOUT).exists():
        old = about(path)
        storage = tables.storage_named(old["storage"])
        _check_same(path, old, new)
    else:
        strange = sorted(entry.name for entry in path.iterdir() if entry.name != JOURNAL)
        if strange:
            problem = f"is not empty: it holds {quoted(strange[0])}"
            raise HoldfastError(message(str(path), problem, "name an empty folder, or that of the same batch"))
        write_atomically(path / SCHEMA, (json.dumps(described(), indent=1, ensure_ascii=False) + "\n").encode())
        text = json.dumps(new | {"storage": storage.name}, indent=1)
        write_atomically(path / ABOUT, (text + "\n").encode())
    return Folder(path, shard_size, storage, part)


def _check_same(path: Path, old: dict[str, Any], new: dict[str, Any]) -> None:
    for key, value in new.items():
        if old.get(key) != value:
            problem = f"{key} was {quoted(old.get(key), 120)}, and is {quoted(value, 120)}"
            raise HoldfastError(message(str(path), problem, "give another folder, or ask the same"))


def _lock(path: Path, part: Part, stack: ExitStack) -> None:
    """Keep others from the shards of this driver.

    Drivers of an array share one lock, in which they write into how many parts the shards are divided, and each holds
    one of its own. A driver that does all shards holds the first alone.
    """
    shared = stack.enter_context((path / JOURNAL / LOCK).open("a+"))
    if part.of == 1:
        if not _held(shared, fcntl.LOCK_EX):
            raise _busy(path)
        return
    if _held(shared, fcntl.LOCK_EX):
        shared.truncate(0)
        shared.write(str(part.of))
        shared.flush()
    if not _held(shared, fcntl.LOCK_SH):
        raise _busy(path)
    shared.seek(0)
    divided = shared.read()
    if divided != str(part.of):
        problem = f"other drivers divide its shards by {divided}, not by {part.of}"
        raise HoldfastError(message(str(path), problem, "wait for them, or divide as they do"))
    own = stack.enter_context((path / JOURNAL / f"{LOCK}-{part.number}-{part.of}").open("a"))
    if not _held(own, fcntl.LOCK_EX):
        raise _busy(path)


def _held(stream: IO[str], kind: int) -> bool:
    """Take a lock if nobody else holds it; of a file system without locks, warn and go on."""
    try:
        fcntl.flock(stream, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as cause:
        text = f"{os.path.dirname(stream.name)} cannot be locked ({cause.strerror}): let no other batch write there"
        warnings.warn(text, HoldfastWarning, stacklevel=6)
    return True


def _busy(path: Path) -> HoldfastError:
    problem = "another batch writes to it"
    return HoldfastError(message(str(path), problem, "wait for it, or divide the shards, as in shard='0/2'"))
