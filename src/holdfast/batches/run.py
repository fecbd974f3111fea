"""Answer one question about many scenes: the question, checked, and the driver, which alone writes to the folder."""

from __future__ import annotations

import inspect
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from holdfast.applications.settled import settle
from holdfast.applications.transport import transport_limits
from holdfast.assembly.assembly import assemble
from holdfast.base.arrays import checked_items, checked_mapping, checked_number, checked_whole
from holdfast.base.borders.supervisor import Limits, Reply
from holdfast.base.borders.worker import DONE, OUTCOMES
from holdfast.base.errors import HoldfastError, hinting, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.plugins import LOADED
from holdfast.base.progress import cores, lines, report
from holdfast.base.text import quoted
from holdfast.base.values import Value
from holdfast.batches.folder import EarlierAnswers, Folder, ShardShare, opened
from holdfast.batches.inputs import Input, Inputs, Scenes, as_text, csv_rows, inputs_of
from holdfast.batches.job import BatchQuestion, Digests, Job, Push, key_of_files, key_of_value
from holdfast.batches.result import BatchReport, counted
from holdfast.batches.states import ModelStates, states_of
from holdfast.batches.tables import TABLES, Journal, Record, Row, name_of
from holdfast.batches.workers import answered_here, answered_there
from holdfast.queries.map import robustness_map
from holdfast.queries.push import robustness
from holdfast.queries.stability import stability

if TYPE_CHECKING:
    from distributed import Client


VERBS = ("stability", "settle", "map", "transport", "push")
ASKED: Mapping[str, Callable[..., Any]] = {
    "assemble": assemble,
    "stability": stability,
    "settle": settle,
    "push": robustness,
    "map": robustness_map,
    "transport": transport_limits,
}
# Arguments that are not options: the batch supplies them, or they cannot be written to a file. The directions of
# transport are an option.
GIVEN = ("assembly", "scene", "body", "points", "directions", "standing", "loads", "imperfect", "interfaces")
ENGINE = "engine"
KNOWN = "needs stability, settle, map, transport or push:FILE"
MOST_BYTES = 500_000_000  # largest size of a file of pushes
PUSH_COLUMNS = ("body", "x", "y", "z", "dx", "dy", "dz")
MOST_IN_SHARD = 1_000_000  # more scenes for one process mean a mistake
MOST_WORKERS, MOST_PARTS = 4096, 1_000_000  # more processes or parts of a batch mean a mistake


def question(ask: str | Iterable[str], options: Mapping[str, Any] | None) -> BatchQuestion:
    """Return the question for the arguments ``ask`` and ``options`` of a batch.

    ``ask`` is one of stability, settle, map, transport and push:FILE, or several of them. ``options`` maps "load",
    "assemble" and verbs to keyword arguments, and "engine" to the engine of all verbs. Raises HoldfastError if a verb
    or an option is unknown.
    """
    words = [ask] if isinstance(ask, str) else checked_items(ask, "ask", KNOWN.removeprefix("needs "))
    pushes: tuple[Push, ...] = ()
    verbs = []
    for word in words:
        verb, colon, file = word.partition(":") if isinstance(word, str) else ("", "", "")
        if verb not in VERBS or bool(colon) != (verb == "push"):
            remedy = KNOWN
            raise HoldfastError(message("ask", f"{quoted(word)} is unknown", remedy))
        if verb == "push":
            pushes += read_pushes(Path(file))
        verbs.append(verb)
    if not verbs:
        raise HoldfastError(message("ask", "is empty", KNOWN))
    given = {} if options is None else options
    return BatchQuestion(tuple(verb for verb in VERBS if verb in verbs), _options(given), pushes, dict(LOADED))


def _options(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return checked options, in which every verb has the common engine unless it has its own."""
    checked_mapping(given, "options", '{"engine": "limit"}')
    engine = {ENGINE: given[ENGINE]} if ENGINE in given else {}
    found: dict[str, dict[str, Any]] = {verb: dict(engine) for verb in VERBS if engine}
    for verb, own in given.items():
        if verb == ENGINE:
            continue
        if verb not in (*ASKED, "load") or not isinstance(own, Mapping):
            remedy = f"needs a dict of options for one of: load, {', '.join(ASKED)}; or an engine for all"
            raise HoldfastError(message("options", f"{quoted(verb)}: {quoted(own)}", remedy))
        for name in own:
            if verb != "load" and name not in _known(verb):
                remedy = nearest_of(name, _known(verb))
                raise HoldfastError(message(f"options of {verb}", f"{quoted(name)} is unknown", remedy))
        found.setdefault(verb, {}).update(own)
    try:
        return dict(json.loads(json.dumps(found, allow_nan=False)))
    except (TypeError, ValueError) as cause:
        remedy = "needs names, numbers, lists and dicts with texts as keys: engines by name"
        raise HoldfastError(message("options", f"cannot be written as JSON: {cause}", remedy)) from cause


def _known(verb: str) -> list[str]:
    given = [name for name in GIVEN if (verb, name) != ("transport", "directions")]
    names = inspect.signature(ASKED[verb]).parameters
    return [name for name in names if name not in given]


def read_pushes(path: Path) -> tuple[Push, ...]:
    """Read pushes from a CSV file with the columns body, x, y, z [m], dx, dy, dz and, if they differ, scene.

    Raises HoldfastError if a column is missing or a value is no number.
    """
    content = read_ordinary(path, "file of pushes", most=MOST_BYTES, error=HoldfastError, too_large="divide it")
    rows = csv_rows(content, str(path))
    _, columns = next(rows)
    missing = [name for name in PUSH_COLUMNS if name not in columns]
    if missing:
        remedy = f"needs {', '.join(PUSH_COLUMNS)} and, if pushes differ between scenes, scene"
        raise HoldfastError(message(str(path), f"has no column {missing[0]}", remedy))
    pushes = []
    for line, row in rows:
        try:
            x, y, z, dx, dy, dz = (float(row[name] or "") for name in PUSH_COLUMNS[1:])
        except ValueError:
            where = f"{path}, line {line}"
            raise HoldfastError(message(where, "holds no six numbers", "needs x, y, z, dx, dy, dz")) from None
        pushes.append(Push(row.get("scene") or "", row["body"] or "", (x, y, z), (dx, dy, dz)))
    return tuple(pushes)


@dataclass(frozen=True, eq=False, repr=False)
class Resources(Value):
    """Where a batch runs, and how its scenes are divided into shards.

    - ``megabytes`` [MB]: the memory limit of a scene.
    - ``scheduler``: the address of a Dask scheduler, or a ``distributed.Client``. The processes then run on its
      workers; by default they run on this machine.
    - ``shard``: "i/n" computes only every n-th shard, beginning with number i, for arrays of jobs that share a folder.
    - ``shard_size``: how many scenes one file of a table holds.

    Raises SceneError for a number out of range.
    """

    megabytes: float = 4000.0
    scheduler: str | Client | None = None
    shard: str | None = None
    shard_size: int = 100

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "megabytes", checked_number(self.megabytes, "Resources: megabytes", above=0))
        set_(self, "shard_size", checked_whole(self.shard_size, "Resources: shard_size", 1, MOST_IN_SHARD))


@hinting(resources=Resources)
def batch(
    scenes: Scenes,
    ask: str | Iterable[str] = ("stability",),
    *,
    out: str | os.PathLike[str],
    workers: int | None = None,
    options: Mapping[str, Any] | None = None,
    seconds: float = 60.0,
    retry: Iterable[str] = (),
    resources: Resources | None = None,
) -> BatchReport:
    """Answer the same question about every scene in worker processes, and write the answers to tables in a folder.

    ``scenes`` is a scene file, a folder, a glob pattern, a manifest (.csv or .parquet with a column ``scene``), or an
    iterable of paths, Scene objects, or pairs of a name and one of them. It is consumed one by one; names must be
    unique.

    ``{model: states}`` asks about many states of one MuJoCo model. Each is a scene of its own, named by its number or
    its demonstration. ``states`` is an array (n, w), or a .npy, .npz, .csv or .hdf5 file, of rows of qpos, of qpos and
    qvel, or of time, qpos and qvel (docs/howto/start_states.md).

    ``ask`` are ``"stability"``, ``"settle"`` (with stability, only scenes that do not stand are brought to rest),
    ``"map"``, ``"transport"`` and ``"push:FILE"``, where the CSV file has the columns body, x, y, z [m], dx, dy, dz
    (world frame) and, if pushes differ between scenes, scene. ``options`` maps ``"load"``, ``"assemble"`` and the names
    of questions to keyword arguments of the functions that they call, and ``"engine"`` to the engine of all. Rows equal
    the answers of single calls, bit for bit.

    ``out`` is the folder for the tables, in shards (docs/howto/batch.md). The same call resumes a batch that was
    stopped for any reason: a scene is computed again only if one of its files, the question or the version has changed,
    or if its outcome is in ``retry``, such as ``("time", "memory")``.

    There are ``workers`` processes with one native thread each, by default one for each core. If a scene takes longer
    than ``seconds`` [s], needs too much memory or crashes its process, its row says so. ``resources`` sets the memory
    limit, the machines and the division into shards, see Resources.

    How many scenes are done, and how long the others will take, is said on stderr about every ten seconds.

    Raises HoldfastError for bad arguments, for a folder that holds answers to another question or that another batch
    writes to, and if the folder cannot be written. Errors in single scenes are reported in their rows.
    """
    batch_question = question(ask, options)
    means = Resources() if resources is None else resources
    if not isinstance(means, Resources):
        raise HoldfastError(message("batch: resources", f"is {quoted(means)}", "needs holdfast.sets.Resources(...)"))
    limits = Limits(checked_number(seconds, "batch: seconds", above=0), means.megabytes)
    count = cores() if workers is None else checked_whole(workers, "batch: workers", 1, MOST_WORKERS)
    names = [retry] if isinstance(retry, str) else checked_items(retry, "batch: retry", "outcomes")
    for name in names:
        if not isinstance(name, str) or name not in OUTCOMES:
            raise HoldfastError(
                message("batch: retry", f"{quoted(name)} is no outcome", f"known: {', '.join(OUTCOMES)}")
            )
    again = frozenset(names)
    part, path = _part(means.shard), checked_path(out, "folder of a batch")
    if isinstance(scenes, Mapping):
        scenes = states_of(list(scenes), next(iter(scenes.values()), ()), batch_question.of("load"))
    given = scenes.inputs() if isinstance(scenes, ModelStates) else inputs_of(scenes)
    start = time.monotonic()
    with ExitStack() as stack, lines(_say):
        folder = opened(path, batch_question, means.shard_size, part, stack)
        driver = stack.enter_context(Driver(folder, batch_question, given, EarlierAnswers(folder, again)))
        jobs = driver.jobs()
        if means.scheduler is None:
            answers = answered_here(jobs, batch_question, limits, count)
        else:
            answers = answered_there(jobs, batch_question, limits, means.scheduler)
        driver.run(answers)
    return replace(counted(folder), asked=driver.asked, kept=driver.reused, seconds=time.monotonic() - start)


@dataclass
class OpenShard:
    """An unfinished shard: the names of its scenes in order, their journal, and the names without an answer yet."""

    names: list[str]
    journal: Journal
    missing: set[str]


@dataclass
class Driver:
    """Draws jobs, writes answers to journals, and writes shards that are complete. A context manager."""

    folder: Folder
    question: BatchQuestion
    inputs: Inputs
    earlier: EarlierAnswers
    asked: int = 0
    reused: int = 0
    finished: bool = False
    _open: dict[int, OpenShard] = field(default_factory=dict)
    _drawn: int = 0
    _shards: int = 0

    def __enter__(self) -> Driver:
        return self

    def __exit__(self, *failure: object) -> None:
        for each in self._open.values():
            each.journal.close()
        self.earlier.close(finished=self.finished)

    def run(self, answers: Iterator[tuple[Job, Reply]]) -> None:
        """Write all answers, and then remove shards that are no longer needed."""
        self._report()
        for job, reply in answers:
            number = job.number // self.folder.shard_size
            shard = self._open[number]
            shard.journal.append(record_of(job, reply))
            shard.missing.remove(job.name)
            if not shard.missing:
                self._commit(number)
            self.asked += 1
            self._report()
        for old in self.folder.shards():  # after the last one: their rows stay in a journal
            if old >= self._shards and self.folder.part.has(old):
                self.earlier.displace(old, ())
                self.folder.remove(old)
        self.finished = True

    def jobs(self) -> Iterator[Job]:
        """Yield the jobs without an answer, shard by shard, as inputs are drawn."""
        while items := list(islice(self.inputs.items, self.folder.shard_size)):
            shard, self._shards = self._shards, self._shards + 1
            if self.folder.part.has(shard):
                first = shard * self.folder.shard_size
                jobs = [self._job(first + k, item) for k, item in enumerate(items)]
                self._drawn += len(jobs)
                yield from self._missing(shard, jobs)

    def _job(self, number: int, item: Input) -> Job:
        """Return the job of one input, with the pushes on its scene alone: workers need not get all of a batch."""
        question, pushes = self.question.bare, self.question.pushes_on(item.name)
        job = Job(number, item.name, question, pushes, scene=item.scene, state=item.state)
        if item.path is None:
            return replace(job, key=key_of_value(job))
        return replace(job, path=as_text(item.path), place=os.path.abspath(item.path))

    def _missing(self, shard: int, jobs: list[Job]) -> Iterator[Job]:
        """Reuse the earlier answers of a shard, and yield the other jobs."""
        records = [self.earlier.record(job) for job in jobs]
        self.reused += sum(record is not None for record in records)
        names = [job.name for job in jobs]
        if None not in records and self._unchanged(shard, names):
            self._report()
            return
        journal = self.folder.journal(shard)
        for record in filter(None, records):
            if name_of(record) not in journal.places or journal.record(name_of(record)) != record:
                journal.append(record)
        missing = [job for job, record in zip(jobs, records, strict=True) if record is None]
        self._open[shard] = OpenShard(names, journal, {job.name for job in missing})
        if not missing:
            self._commit(shard)
        yield from missing

    def _unchanged(self, shard: int, names: list[str]) -> bool:
        """Return whether a shard is complete and holds these scenes in this order, so that it can stay."""
        there = self.folder.file("scenes", shard).exists() and shard not in self.earlier.damaged
        return there and self.folder.names(shard) == names and not self.folder.journal(shard).path.exists()

    def _commit(self, shard: int) -> None:
        """Write a shard whose rows are all in its journal, and then remove the journal."""
        own = self._open.pop(shard)
        if self.folder.file("scenes", shard).exists():
            self.earlier.displace(shard, set(own.names))
        own.journal.sync()
        self.folder.write(shard, [own.journal.record(name) for name in own.names])
        own.journal.remove()

    def _report(self) -> None:
        total = self._drawn
        if self.inputs.count is not None:
            size, part = self.folder.shard_size, self.folder.part
            starts = range(part.number * size, self.inputs.count, part.of * size)
            total = sum(min(size, self.inputs.count - first) for first in starts)
        report("scenes", self.asked + self.reused, total)


def record_of(job: Job, reply: Reply) -> Record:
    """Return the rows of a scene with any outcome; if its worker died, the last rows that it reported."""
    record: Record = reply.value if reply.outcome == DONE else reply.parts[-1] if reply.parts else _unread(job)
    row: Row = record["scenes"][0]
    if reply.outcome != DONE:
        row |= {"outcome": reply.outcome, "problem": reply.problem.encode("utf-8", "backslashreplace").decode()}
    row |= {"seconds": reply.seconds, "peak_mb": reply.peak, "files": [as_text(name) for name in row["files"] or ()]}
    return record


def _unread(job: Job) -> Record:
    """Return the row of a scene whose worker died before it was read; its key covers its own file only."""
    row: Row = {"number": job.number, "scene": job.name, "path": job.path, "key": job.key, "files": []}
    if job.scene is None:
        files = [os.path.basename(job.place)]
        row |= {"key": key_of_files(job, files, Digests()), "files": files}
    return {name: [] for name in TABLES} | {"scenes": [row]}


def _say(line: str) -> None:
    if sys.stderr is not None:
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()


def _part(shard: str | None) -> ShardShare:
    """Return the share of the shards for a text "i/n", counted from 0; None means all."""
    if shard is None:
        return ShardShare()
    number, slash, of = shard.partition("/") if isinstance(shard, str) else ("", "", "")
    if slash and number.isdecimal() and of.isdecimal() and int(number) < int(of) <= MOST_PARTS:
        return ShardShare(int(number), int(of))
    raise HoldfastError(message("batch: shard", f"is {quoted(shard)}", "needs i/n with 0 <= i < n, as in '0/2'"))
