"""The tables of a batch: their columns, and rows as files, in shards (Parquet, or JSON lines) and journals until then.

The columns are the source of the Parquet schema, of schema.json and of the docs. A line of a journal holds all rows of
a scene. It is written without buffering, so that it survives the process; about once a second it is also synced to the
disk. A damaged or incomplete line is dropped.
"""

from __future__ import annotations

import importlib.util
import io
import json
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple

from holdfast.base.archive import to_dict
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.text import one_line, quoted

VERSION = "holdfast-batch/1"
MOST_BYTES = 20_000_000_000  # largest size of a shard's file
AGAIN = "run the same batch again, which computes the content of the file again"
LONGEST_CAUSE = 200  # largest number of characters of a library's message on a damaged file
GONE = frozenset({"solved", "error"})  # columns that 1.0.0rc1 wrote; they are read over
INFINITE = {"inf": math.inf, "-inf": -math.inf}  # texts for infinity in JSON lines
SYNCED = 1.0  # [s] time between two syncs to the disk

Kind = Literal["text", "texts", "number", "whole", "flag"]
Row = dict[str, Any]  # one value for each column of a table, plain data
Tables = dict[str, list[Row]]  # rows by the name of their table
Record = Tables  # all rows of one scene, of which the table "scenes" has one


class Column(NamedTuple):
    """A column: its name, the kind of its values, their unit ("" if none) and its meaning.

    Values may be missing (null) in every column. ``reproducible`` is False where two runs of one scene may differ.
    """

    name: str
    kind: Kind
    unit: str
    meaning: str
    reproducible: bool = True


_WHERE = (
    Column("number", "whole", "", "place of the scene among the inputs, from 0"),
    Column("scene", "text", "", "name of the scene: its path as it was given, or the name it was given"),
)
_PLACE = (
    Column("x", "number", "m", "where the push acts, in the world"),
    Column("y", "number", "m", ""),
    Column("z", "number", "m", ""),
    Column("dx", "number", "", "unit direction of the push, in the world"),
    Column("dy", "number", "", ""),
    Column("dz", "number", "", ""),
)


def _answered(name: str, unit: str, what: str) -> tuple[Column, ...]:
    """Return the columns of answers: the amount, its bounds, its status and what gives way."""
    return (
        Column(name, "number", unit, f"the largest {what} before anything moves; inf if none moves anything"),
        Column("lower", "number", unit, "lower bound of the true answer, as far as the engine promises one"),
        Column("upper", "number", unit, "upper bound of the true answer, as far as the engine promises one"),
        Column("status", "text", "", "finite, infinite, unstable or undecided: if undecided, 0 is no answer"),
        Column("mode", "text", "", "slip, topple, mixed, roll, crush or none"),
        Column("moving", "texts", "", "names of the bodies that begin to move"),
    )


SCENES = (
    *_WHERE,
    Column("path", "text", "", "path of the scene file; null for a scene that was given as a value"),
    Column("key", "text", "", "SHA-256 of the scene with all its files, the question, its options and the version"),
    Column("files", "texts", "", "the files that were read, relative to the folder of the scene file"),
    Column("outcome", "text", "", "answered, error, time, memory or crash"),
    Column("problem", "text", "", "what went wrong, if the outcome is not answered"),
    Column("status", "text", "", "stable, unstable or undecided; null if it was not asked or not answered"),
    Column("reason", "text", "", "the reason for the verdict, in words"),
    Column("equilibrium_exists", "flag", "", "true or false with evidence; null if it is not known"),
    Column("moving", "texts", "", "names of the bodies that move in a scene that does not stand"),
    Column("crushed", "texts", "", "names of the bodies that bear more than they may, the most crushed first"),
    Column("engine", "text", "", "the engine of the verdict"),
    Column("settled", "text", "", "stable, unstable or undecided once it settled; null if it was not asked"),
    Column("settled_reason", "text", "", "the reason for that, in words, or why it cannot settle"),
    Column("moved", "number", "m", "how far settle moves the body that goes farthest; 0 where it need not settle"),
    Column("bodies", "whole", "", "number of movable bodies"),
    Column("fixed", "whole", "", "number of fixed bodies"),
    Column("interfaces", "whole", "", "number of contact interfaces"),
    Column("groups", "whole", "", "number of groups of movable bodies that touch each other"),
    Column("overlaps", "whole", "", "number of pairs of bodies that overlap"),
    Column("mass", "number", "kg", "total mass of the movable bodies"),
    Column("weakest", "number", "N", "the smallest decided force of all pushes and map points; null without one"),
    Column("weakest_lower", "number", "N", "the smallest lower bound of all pushes and map points"),
    Column("weakest_body", "text", "", "the body at which the smallest decided force acts"),
    Column("weakest_mode", "text", "", "what the contacts do then: slip, topple ..."),
    Column("weakest_moving", "texts", "", "names of the bodies that move then, not always the pushed one"),
    Column("undecided", "whole", "", "number of pushes, map points and accelerations without an answer"),
    Column("acceleration", "number", "m/s²", "the smallest decided acceleration of the carrier; null without one"),
    Column("acceleration_lower", "number", "m/s²", "the smallest lower bound of the accelerations"),
    Column("notes", "texts", "", "simplifications on which the verdict depends"),
    Column("warnings", "texts", "", "warnings of holdfast"),
    Column("seconds", "number", "s", "time that the scene took in its process", reproducible=False),
    Column("peak_mb", "number", "MB", "largest resident memory of its process meanwhile", reproducible=False),
)
BODIES = (
    *_WHERE,
    Column("body", "text", "", "name of the body"),
    Column("fixed", "flag", "", "whether the body never moves"),
    Column("mass", "number", "kg", "mass; null for a fixed body without one"),
    Column("x", "number", "m", "position of the body's frame in the world"),
    Column("y", "number", "m", ""),
    Column("z", "number", "m", ""),
    Column("qx", "number", "", "rotation from the body's frame to the world, as a unit quaternion with qw >= 0"),
    Column("qy", "number", "", ""),
    Column("qz", "number", "", ""),
    Column("qw", "number", "", ""),
    Column("group", "whole", "", "number of its group of bodies that touch each other; null for a fixed body"),
    Column("status", "text", "", "verdict on its group; null if it was not asked"),
    Column("bearing", "number", "", "what it bears over what it may bear, above 1: crushed; null without a limit"),
    Column("weakest", "number", "N", "the smallest decided force of all pushes and map points on it"),
    Column("hovers", "number", "m", "height above what is below its group, which touches nothing; else null"),
    Column("above", "text", "", "what is below then; null if nothing is, and hovers inf"),
    Column("sinks", "number", "m", "how deep it overlaps another body by more than the tolerance; else null"),
    Column("into", "text", "", "the body that it overlaps most deeply"),
    Column("moved", "number", "m", "how far settle moves it; null if it need not settle"),
    Column("turned_degrees", "number", "deg", "by how much settle turns it"),
    Column("settled_reason", "text", "", "why settle moves it, in words"),
    Column("rest_x", "number", "m", "where it comes to rest, as x to qw say where it is; null if it does not move"),
    Column("rest_y", "number", "m", ""),
    Column("rest_z", "number", "m", ""),
    Column("rest_qx", "number", "", ""),
    Column("rest_qy", "number", "", ""),
    Column("rest_qz", "number", "", ""),
    Column("rest_qw", "number", "", ""),
)
INTERFACES = (
    *_WHERE,
    Column("a", "text", "", "first body"),
    Column("b", "text", "", "second body, into which the normals point"),
    Column("status", "text", "", "touching or penetrating"),
    Column("certain", "flag", "", "false if the two bodies may not touch at all"),
    Column("flags", "texts", "", "how the contact depends on a tolerance, a pose or a mesh"),
    Column("mu", "number", "", "coefficient of friction"),
    Column("patches", "whole", "", "number of contact patches"),
    Column("area", "number", "m²", "total area of the patches"),
    Column("separation", "number", "m", "smallest distance at a patch, negative where bodies overlap"),
    Column("normal_force", "number", "N", "sum of the normal forces at rest; null unless the scene stands"),
    Column("usage", "number", "", "largest share of the friction limit that a node uses at rest"),
)
PUSHES = (
    *_WHERE,
    Column("source", "text", "", "map, or push for one that was asked by name"),
    Column("body", "text", "", "name of the body that is pushed"),
    *_PLACE,
    *_answered("force", "N", "push"),
)
TRANSPORTS = (
    *_WHERE,
    Column("dx", "number", "", "unit direction in which the carrier accelerates, in the axes of the scene"),
    Column("dy", "number", "", ""),
    Column("dz", "number", "", ""),
    *_answered("acceleration", "m/s²", "acceleration of the carrier"),
)
TABLES: Mapping[str, tuple[Column, ...]] = {
    "scenes": SCENES,
    "bodies": BODIES,
    "interfaces": INTERFACES,
    "pushes": PUSHES,
    "transports": TRANSPORTS,
}
_NAMES = {table: frozenset(column.name for column in columns) for table, columns in TABLES.items()}


def described() -> dict[str, Any]:
    """Return the schema as plain data, the content of schema.json."""
    return {
        "format": VERSION,
        "tables": {name: [column._asdict() for column in columns] for name, columns in TABLES.items()},
    }


class DamagedError(HoldfastError):
    """A file of a batch folder, which the message names, is missing or damaged."""


@dataclass(frozen=True)
class Storage:
    """A file format for rows: its ``name``, the ``suffix``, and functions that write rows to bytes and read a file."""

    name: str
    suffix: str
    bytes_of: Callable[[str, Sequence[Row]], bytes]
    rows_in: Callable[[str, Path, Sequence[str] | None], list[Row]]

    def rows(self, table: str, path: Path, columns: Sequence[str] | None = None) -> list[Row]:
        """Return the rows of a table from a file, with all or some columns; raise DamagedError if it is damaged."""
        check_ordinary(path, "shard", error=DamagedError, remedy=AGAIN)
        try:
            found = self.rows_in(table, path, columns)
            for row in found:
                check_row(table, row)
        except Exception as cause:  # a reader of damaged bytes may raise any exception
            problem = f"is damaged: {one_line(str(cause), LONGEST_CAUSE) or type(cause).__name__}"
            raise DamagedError(message(str(path), problem, AGAIN)) from cause
        return found


def has_pyarrow() -> bool:
    """Return whether pyarrow is installed."""
    try:
        return importlib.util.find_spec("pyarrow") is not None
    except ValueError:  # raised for a module that is set to None in sys.modules
        return False


def storage_named(name: str) -> Storage:
    """Return the storage with this name; raise HoldfastError if it needs pyarrow and that is missing."""
    if name == PARQUET.name and not has_pyarrow():
        remedy = f"{installing('tables')}, or give another folder, which is then written as JSON lines"
        raise HoldfastError(message("batch", "its tables are Parquet files, and pyarrow is not installed", remedy))
    return STORAGES[name]


def check_row(table: str, row: Row) -> None:
    """Raise ValueError unless the values of a row fit the columns of its table, and it names a scene."""
    _check_names(table, row)
    for column in TABLES[table]:
        value = row.get(column.name)
        if value is not None and not _fits(column.kind, value):
            raise ValueError(f"{column.name} is {quoted(value)}, no {column.kind}")
    if row.get("scene") is None:
        raise ValueError("a row names no scene")


def _check_names(table: str, row: Row) -> None:
    strange = row.keys() - _NAMES[table] - GONE
    if strange:
        raise ValueError(f"{quoted(min(strange))} is no column of the table {table}")


def _fits(kind: str, value: Any) -> bool:  # noqa: ANN401 - checked here
    if kind == "texts":
        return isinstance(value, list) and all(isinstance(each, str) for each in value)
    return type(value) in {"text": (str,), "number": (float,), "whole": (int,), "flag": (bool,)}[kind]


def line_of(data: Any) -> str:  # noqa: ANN401 - plain data
    """Return plain data as one line of strict JSON, with infinity as the text "inf"."""
    return json.dumps(to_dict(data), allow_nan=False) + "\n"


def completed(table: str, row: Row) -> Row:
    """Return a row with all columns of its table, in their order, and infinities as numbers.

    Raises ValueError for a column that the table does not have.
    """
    _check_names(table, row)

    def value(column: Column) -> Any:  # noqa: ANN401 - anything that a column holds
        content = row.get(column.name)
        if column.kind == "number" and content is not None:
            return INFINITE[content] if isinstance(content, str) else float(content)
        return content

    return {column.name: value(column) for column in TABLES[table]}


def arrow_schema(table: str) -> Any:  # noqa: ANN401 - pyarrow has no types
    """Return the Arrow schema of a table, with the version, units and meanings in its metadata."""
    import pyarrow as pa

    kinds = {
        "text": pa.string(),
        "texts": pa.list_(pa.string()),
        "number": pa.float64(),
        "whole": pa.int64(),
        "flag": pa.bool_(),
    }
    fields = [
        pa.field(each.name, kinds[each.kind], metadata={"unit": each.unit, "meaning": each.meaning})
        for each in TABLES[table]
    ]
    return pa.schema(fields, metadata={"format": VERSION, "table": table})


def _parquet_of(table: str, rows: Sequence[Row]) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    stream = io.BytesIO()
    whole = pa.Table.from_pylist([completed(table, row) for row in rows], schema=arrow_schema(table))
    parquet.write_table(whole, stream, compression="zstd", write_page_checksum=True)
    return stream.getvalue()


def _rows_in_parquet(table: str, path: Path, columns: Sequence[str] | None) -> list[Row]:
    from pyarrow import parquet

    with path.open("rb") as stream:  # Arrow's threads are off, because they can block the end of a process
        file = parquet.ParquetFile(stream, pre_buffer=False, page_checksum_verification=True)
        rows: list[Row] = file.read(columns=columns, use_threads=False).to_pylist()
    return rows


def _lines_of(table: str, rows: Sequence[Row]) -> bytes:
    return "".join(line_of(completed(table, row)) for row in rows).encode()


def _rows_in_lines(table: str, path: Path, columns: Sequence[str] | None) -> list[Row]:
    text = read_ordinary(path, "shard", most=MOST_BYTES, error=HoldfastError).decode()
    rows = [
        completed(table, json.loads(line)) for line in text.splitlines()
    ]  # json.dumps escapes all other line breaks
    return rows if columns is None else [{name: row[name] for name in columns} for row in rows]


PARQUET = Storage("parquet", ".parquet", _parquet_of, _rows_in_parquet)
LINES = Storage("json lines", ".jsonl", _lines_of, _rows_in_lines)
STORAGES = {each.name: each for each in (PARQUET, LINES)}


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
            check_ordinary(self.path, "journal", error=HoldfastError, remedy="remove it: its scenes are computed again")
            place = 0  # the journal ends after the last complete and valid line
            with self.path.open("rb") as stream:
                for line in stream:
                    begin, place = place, place + len(line)
                    try:
                        name = name_of(_record(line))
                    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
                        continue  # for example blocks of zeros after a power failure
                    if line.endswith(b"\n"):
                        self.places[name], self._end = begin, place

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


def _record(line: bytes) -> Record:
    data = json.loads(line)
    found = {table: [completed(table, row) for row in data.get(table, [])] for table in TABLES}
    for table, rows in found.items():
        for row in rows:
            check_row(table, row)
    return found
