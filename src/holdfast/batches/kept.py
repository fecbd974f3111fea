"""What earlier runs answered: rows by the names of their scenes, wherever in the folder they are."""

from __future__ import annotations

import warnings
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator
from typing import TypeVar

from holdfast.base.errors import HoldfastWarning
from holdfast.batches.folder import Folder
from holdfast.batches.job import Job
from holdfast.batches.journal import Journal, Record, name_of
from holdfast.batches.keys import Digests, key_of_files
from holdfast.batches.tables import DamagedError

T = TypeVar("T")

REMEMBERED = 3  # shards whose rows are kept in memory: inputs that moved come from neighbouring ones


class Kept:
    """Rows that need not be asked for again. ``retry`` are outcomes that are asked again all the same."""

    def __init__(self, folder: Folder, retry: Collection[str]) -> None:
        self.folder, self.retry = folder, retry
        self.displaced = folder.displaced()
        self._digests = Digests()
        self.damaged: set[int] = set()  # shards of which a file is damaged or missing: their scenes are asked anew
        self._shards: dict[str, int] = {}
        for shard in folder.shards():
            none: list[str] = []
            self._shards |= dict.fromkeys(self._looked_at(shard, folder.names, none), shard)
        self._journals: dict[str, list[Journal]] = {}
        for journal in [*folder.journals(), self.displaced]:
            for name in journal.places:
                self._journals.setdefault(name, []).append(journal)
        self._homeless = set(self.displaced.places)  # displaced rows that no shard has yet
        self._remembered: OrderedDict[int, dict[str, Record]] = OrderedDict()

    def record(self, job: Job) -> Record | None:
        """Return the rows of a job if its scene, all its files and the question are what they were, else None."""
        for record in self._known(job.name):
            row = record["scenes"][0]
            if row["outcome"] not in self.retry and row["key"] and row["key"] == self._key(job, row["files"] or ()):
                self._homeless.discard(job.name)
                return renumbered(record, job)
        return None

    def displace(self, shard: int, staying: Collection[str]) -> None:
        """Bring the rows of a shard to safety that are about to be replaced, but for those that stay."""
        for name, record in self._rows(shard).items():
            if name not in staying:
                self.displaced.append(record)
                self._journals.setdefault(name, []).append(self.displaced)
                self._homeless.add(name)
        self.displaced.sync()

    def close(self, *, finished: bool) -> None:
        """Close what is open; once all is finished, forget the displaced rows if every one has a shard again."""
        if finished and not self._homeless:
            self.displaced.remove()
        self.displaced.close()

    def _key(self, job: Job, files: Collection[str]) -> str:
        return job.key if job.scene is not None else key_of_files(job, files, self._digests)

    def _known(self, name: str) -> Iterator[Record]:
        for journal in reversed(self._journals.get(name, ())):
            if journal.path.exists():  # else its shard is written
                yield journal.record(name)
        if name in self._shards:
            found = self._rows(self._shards[name]).get(name)
            if found is not None:
                yield found

    def _rows(self, shard: int) -> dict[str, Record]:
        """Return the rows of a shard as they were at the first look."""
        if shard not in self._remembered:
            there = self.folder.file("scenes", shard).exists()  # another driver may be replacing it
            self._remembered[shard] = self._looked_at(shard, self.folder.records, {}) if there else {}
            while len(self._remembered) > REMEMBERED:
                self._remembered.popitem(last=False)
        return self._remembered[shard]

    def _looked_at(self, shard: int, look: Callable[[int], T], nothing: T) -> T:
        """Return what is found in a shard; if it is damaged, ``nothing``, with one warning that names the file."""
        if shard in self.damaged:
            return nothing
        try:
            return look(shard)
        except DamagedError as cause:
            self.damaged.add(shard)
            if self.folder.part.has(shard):
                warnings.warn(f"{cause}", HoldfastWarning, stacklevel=4)
            return nothing


def renumbered(record: Record, job: Job) -> Record:
    """Return the rows of a scene with the number and the path that it has now."""
    found = {table: [{**row, "number": job.number} for row in rows] for table, rows in record.items()}
    found["scenes"][0]["path"] = job.path
    assert name_of(found) == job.name
    return found
