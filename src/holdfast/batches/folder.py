"""The folder of a batch: its question, its tables in shards, a lock against a second driver, and earlier answers."""

from __future__ import annotations

import fcntl
import json
import os
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, TypeVar

from holdfast import __version__
from holdfast.base.errors import HoldfastError, message, warn
from holdfast.base.files import checked_path, read_ordinary, write_atomically
from holdfast.base.text import quoted
from holdfast.batches import tables
from holdfast.batches.inputs import MOST_BYTES
from holdfast.batches.job import BatchQuestion, Digests, Job, key_of_files
from holdfast.batches.tables import TABLES, VERSION, DamagedError, Journal, Record, Row, described, name_of

ABOUT, SCHEMA, JOURNAL, LOCK = "batch.json", "schema.json", "journal", "lock"
ABOUT_HOLDS: dict[str, tuple[type, Callable[[Any], bool]]] = {  # type and validity of each entry of batch.json
    "version": (str, bool),
    "ask": (list, lambda value: all(isinstance(each, str) for each in value)),
    "options": (dict, lambda value: all(isinstance(each, dict) for each in value.values())),
    "shard_size": (int, lambda value: value > 0),
    "storage": (str, lambda value: value in tables.STORAGES),
}
LAST = "scenes"  # the table that is written last: a shard is complete if its file of this table exists
T = TypeVar("T")
CACHED = 3  # number of shards whose rows are in memory: moved inputs usually come from neighbouring shards


@dataclass(frozen=True)
class ShardShare:
    """The share of the shards that one driver computes: those whose number modulo ``of`` is ``number``."""

    number: int = 0
    of: int = 1

    @property
    def text(self) -> str:
        """The share as text: ``number/of``."""
        return f"{self.number}/{self.of}"

    def has(self, shard: int) -> bool:
        """Return whether a shard is in this share."""
        return shard % self.of == self.number


@dataclass
class Folder:
    """An open folder: its path, the number of scenes in a shard, the storage of rows, and this driver's share."""

    path: Path
    shard_size: int
    storage: tables.Storage
    part: ShardShare = field(default_factory=ShardShare)

    def file(self, table: str, shard: int) -> Path:
        """Return the path of the file with the rows of a shard."""
        return self.path / table / f"{shard:06d}{self.storage.suffix}"

    def journal(self, shard: int) -> Journal:
        """Return the journal of a shard."""
        return Journal(self.path / JOURNAL / f"{shard:06d}.jsonl")

    def displaced(self) -> Journal:
        """Return the journal of rows that are no longer in their shards because inputs moved."""
        return Journal(self.path / JOURNAL / f"displaced-{self.part.number}-{self.part.of}.jsonl")

    def journals(self) -> Iterator[Journal]:
        """Yield all journals of all drivers."""
        for path in sorted((self.path / JOURNAL).glob("*.jsonl")):
            yield Journal(path)

    def shards(self) -> list[int]:
        """Return the numbers of the shards that are complete."""
        return sorted(self._numbers(LAST))

    def lost(self) -> list[int]:
        """Return the numbers of incomplete shards: those before the last one, or with files of other tables."""
        there = self._numbers(LAST)
        known = {shard for table in TABLES for shard in self._numbers(table)} | set(range(max(there, default=0)))
        return sorted(known - there)

    def _numbers(self, table: str) -> set[int]:
        found = (self.path / table).glob(f"*{self.storage.suffix}")
        numbers = {int(path.stem): path.name for path in found if path.stem.isdecimal()}
        return {number for number, name in numbers.items() if self.file(table, number).name == name}

    def rows(self, table: str, shard: int, columns: Sequence[str] | None = None) -> list[Row]:
        """Return the rows of a table in a shard; raise DamagedError, which names the file, if it is damaged."""
        found = self.storage.rows(table, self.file(table, shard), columns)
        if table == LAST and not found:
            raise tables.DamagedError(message(str(self.file(LAST, shard)), "is damaged: it is empty", tables.AGAIN))
        return found

    def names(self, shard: int) -> list[str]:
        """Return the names of the scenes in a shard; raise DamagedError if their file is damaged."""
        return [str(row["scene"]) for row in self.rows(LAST, shard, ["scene"])]

    def records(self, shard: int) -> dict[str, Record]:
        """Return the rows of all scenes of a shard by name; raise DamagedError if one of its files is damaged."""
        found: dict[str, Record] = {}
        for row in self.rows(LAST, shard):
            found[row["scene"]] = {table: [] for table in TABLES} | {LAST: [row]}
        for table in TABLES:
            if table != LAST:
                for row in self.rows(table, shard):
                    if row["scene"] not in found:
                        problem = f"has rows of {quoted(row['scene'])}, which is not in the table {LAST}"
                        raise tables.DamagedError(message(str(self.file(table, shard)), problem, tables.AGAIN))
                    found[row["scene"]][table].append(row)
        return found

    def write(self, shard: int, records: Sequence[Record]) -> None:
        """Write a shard in place of its old content. The rows are in journals until then."""
        for table in TABLES:
            _make_folder(self.path / table)
        self.remove(shard)
        for table in (*(table for table in TABLES if table != LAST), LAST):
            rows = [row for record in records for row in record[table]]
            write_atomically(self.file(table, shard), self.storage.bytes_of(table, rows))

    def remove(self, shard: int) -> None:
        """Remove a shard, beginning with the file that marks it as complete."""
        for table in (LAST, *(table for table in TABLES if table != LAST)):
            path = self.file(table, shard)
            try:
                path.unlink(missing_ok=True)
            except OSError as cause:
                raise HoldfastError(message(str(path), f"cannot be removed: {cause.strerror}", "remove it")) from cause


def about(folder: Path) -> dict[str, Any]:
    """Return the content of batch.json in a folder; raise HoldfastError if it is not the folder of a batch."""
    path = folder / ABOUT
    content = read_ordinary(path, "folder of a batch", most=MOST_BYTES, error=HoldfastError)
    try:
        data = json.loads(content)
        if data["format"] != VERSION:
            raise ValueError(f"its format is {quoted(data['format'])}")
        for key, (kind, known) in ABOUT_HOLDS.items():
            if type(data[key]) is not kind or not known(data[key]):
                raise ValueError(f"{key} is {quoted(data[key])}")
    except (ValueError, LookupError, TypeError, RecursionError) as cause:
        problem = f"is damaged: {'it lacks ' if isinstance(cause, KeyError) else ''}{cause}"
        raise HoldfastError(message(str(path), problem, f"needs {VERSION}: another folder")) from cause
    return dict(data)


def reading(folder: object) -> Folder:
    """Open a folder to read its tables."""
    path = checked_path(folder, "folder of a batch")
    facts = about(path)
    found = Folder(path, facts["shard_size"], tables.storage_named(facts["storage"]))
    lost = [str(found.file(LAST, shard)) for shard in found.lost()]
    if lost:
        what = f"{lost[0]}{f' and {len(lost) - 1:,} more' if len(lost) > 1 else ''}"
        text = message(what, "is missing: the batch was not finished, or the file was lost", tables.AGAIN)
        warn(text)
    return found


def opened(path: Path, question: BatchQuestion, shard_size: int, part: ShardShare, stack: ExitStack) -> Folder:
    """Open a folder for writing until the stack closes; create it if it does not exist.

    Raises HoldfastError if the folder holds answers to another question, or if another driver writes to it.
    """
    _make_folder(path / JOURNAL)
    _lock(path, part, stack)
    storage = tables.PARQUET if tables.has_pyarrow() else tables.LINES
    asked = {"plugins": {}} | json.loads(question.text)
    new = {"format": VERSION, "version": __version__, **asked, "shard_size": shard_size}
    if (path / ABOUT).exists():
        old = {"plugins": {}} | about(path)
        storage = tables.storage_named(old["storage"])
        for key, value in new.items():
            if old.get(key) != value:
                problem = f"holds answers for {key} = {quoted(old.get(key), 120)}, not {quoted(value, 120)}"
                raise HoldfastError(message(str(path), problem, "give another folder, or ask the same"))
    else:
        strange = sorted(entry.name for entry in path.iterdir() if entry.name != JOURNAL)
        if strange:
            problem = f"is not empty: it holds {quoted(strange[0])}"
            raise HoldfastError(message(str(path), problem, "name an empty folder, or that of the same batch"))
        write_atomically(path / SCHEMA, (json.dumps(described(), indent=1, ensure_ascii=False) + "\n").encode())
        text = json.dumps(new | {"storage": storage.name}, indent=1)
        write_atomically(path / ABOUT, (text + "\n").encode())
    return Folder(path, shard_size, storage, part)


def _make_folder(folder: Path) -> None:
    """Create a folder unless it exists; raise HoldfastError if that is impossible."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        remedy = "name a folder that can be made"
        raise HoldfastError(message(str(folder), f"cannot be made: {cause.strerror}", remedy)) from cause


def _lock(path: Path, part: ShardShare, stack: ExitStack) -> None:
    """Lock the shards of this driver.

    The drivers of an array of jobs share one lock file, which holds the number of parts, and each has a lock file of
    its own. A driver of all shards locks the first file exclusively.
    """
    shared = stack.enter_context(_lock_file(path / JOURNAL / LOCK))
    if part.of == 1:
        if not _could_lock(shared, fcntl.LOCK_EX):
            raise _busy(path)
        return
    if _could_lock(shared, fcntl.LOCK_EX):
        shared.truncate(0)
        shared.write(str(part.of))
        shared.flush()
    if not _could_lock(shared, fcntl.LOCK_SH):
        raise _busy(path)
    shared.seek(0)
    divided = shared.read()
    if divided != str(part.of):
        problem = f"other drivers divide its shards by {divided}, not by {part.of}"
        raise HoldfastError(message(str(path), problem, "wait for them, or divide as they do"))
    own = stack.enter_context(_lock_file(path / JOURNAL / f"{LOCK}-{part.number}-{part.of}"))
    if not _could_lock(own, fcntl.LOCK_EX):
        raise _busy(path)


def _lock_file(path: Path) -> IO[str]:
    try:
        return path.open("a+", errors="replace")
    except OSError as cause:
        raise HoldfastError(message(str(path), f"cannot be opened: {cause.strerror}", "remove it")) from cause


def _could_lock(stream: IO[str], kind: int) -> bool:
    """Return whether a lock could be taken; on a file system without locks, warn and return True."""
    try:
        fcntl.flock(stream, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as cause:
        text = f"{os.path.dirname(stream.name)} cannot be locked ({cause.strerror}): let no other batch write there"
        warn(text)
    return True


def _busy(path: Path) -> HoldfastError:
    problem = "another batch writes to it"
    return HoldfastError(message(str(path), problem, "wait for it, or divide the shards, as in shard='0/2'"))


class EarlierAnswers:
    """The rows of earlier runs, which can be reused unless their outcome is in ``retry``."""

    def __init__(self, folder: Folder, retry: Collection[str]) -> None:
        self.folder, self.retry = folder, retry
        self.displaced = folder.displaced()
        self._digests = Digests()
        self.damaged: set[int] = set()  # shards with a damaged or missing file: their scenes are computed again
        self._shards: dict[str, int] = {}
        for shard in folder.shards():
            none: list[str] = []
            self._shards |= dict.fromkeys(self._read(shard, folder.names, none), shard)
        self._journals: dict[str, list[Journal]] = {}
        for journal in [*folder.journals(), self.displaced]:
            for name in journal.places:
                self._journals.setdefault(name, []).append(journal)
        self._unplaced = set(self.displaced.places)  # displaced rows that are in no shard yet
        self._cache: OrderedDict[int, dict[str, Record]] = OrderedDict()

    def record(self, job: Job) -> Record | None:
        """Return the rows of a job if its scene, all its files and the question are unchanged, else None."""
        for record in self._known(job.name):
            row = record["scenes"][0]
            if row["outcome"] in self.retry or not row["key"]:
                continue
            key = job.key if job.scene is not None else key_of_files(job, row["files"] or (), self._digests)
            if row["key"] == key:
                self._unplaced.discard(job.name)
                return renumbered(record, job)
        return None

    def displace(self, shard: int, staying: Collection[str]) -> None:
        """Move the rows of a shard that is about to be replaced into a journal, except those of scenes that stay."""
        for name, record in self._rows(shard).items():
            if name not in staying:
                self.displaced.append(record)
                self._journals.setdefault(name, []).append(self.displaced)
                self._unplaced.add(name)
        self.displaced.sync()

    def close(self, *, finished: bool) -> None:
        """Close the journal of displaced rows, and delete it if the batch is finished and all rows are in shards."""
        if finished and not self._unplaced:
            self.displaced.remove()
        self.displaced.close()

    def _known(self, name: str) -> Iterator[Record]:
        for journal in reversed(self._journals.get(name, ())):
            if journal.path.exists():  # otherwise its shard has been written
                yield journal.record(name)
        if name in self._shards:
            found = self._rows(self._shards[name]).get(name)
            if found is not None:
                yield found

    def _rows(self, shard: int) -> dict[str, Record]:
        """Return the rows of a shard, from a cache."""
        if shard not in self._cache:
            there = self.folder.file("scenes", shard).exists()  # another driver may be replacing it
            self._cache[shard] = self._read(shard, self.folder.records, {}) if there else {}
            while len(self._cache) > CACHED:
                self._cache.popitem(last=False)
        return self._cache[shard]

    def _read(self, shard: int, read: Callable[[int], T], nothing: T) -> T:
        """Return what ``read`` finds in a shard; if it is damaged, warn once and return ``nothing``."""
        if shard in self.damaged:
            return nothing
        try:
            return read(shard)
        except DamagedError as cause:
            self.damaged.add(shard)
            if self.folder.part.has(shard):
                warn(str(cause))
            return nothing


def renumbered(record: Record, job: Job) -> Record:
    """Return the rows of a scene with the number and the path of ``job``."""
    found = {table: [{**row, "number": job.number} for row in rows] for table, rows in record.items()}
    found["scenes"][0]["path"] = job.path
    assert name_of(found) == job.name
    return found
