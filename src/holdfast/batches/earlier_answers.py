"""The answers of earlier runs: rows by the names of their scenes, wherever in the folder they are."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator
from typing import TypeVar

from holdfast.base.errors import warn
from holdfast.batches.folder import Folder
from holdfast.batches.job import Digests, Job, key_of_files
from holdfast.batches.tables import DamagedError, Journal, Record, name_of

T = TypeVar("T")

CACHED = 3  # number of shards whose rows are in memory: moved inputs usually come from neighbouring shards


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
