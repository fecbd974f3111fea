"""The inputs of a batch: scenes from files, folders, glob patterns, manifests and values; and rows of CSV files."""

from __future__ import annotations

import csv
import glob
import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sized
from dataclasses import dataclass
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.text import one_line, quoted
from holdfast.scene.formats.registry import readable
from holdfast.scene.scene import Scene

Row = dict[str, str | None]  # values by the names of the columns; None where a line is too short
MANIFESTS = (".csv", ".parquet")
COLUMN, NAMES = "scene", "name"  # columns of a manifest: the paths of scenes, and optionally their names
MOST_BYTES = 1_000_000_000  # largest size of a manifest, and of a file of a batch
MAGIC = frozenset("*?[")


def csv_rows(content: bytes, where: str) -> Iterator[tuple[int, Row]]:
    """Yield the rows of a CSV file, each with the number of its line; the first row has the column names as keys.

    Raises HoldfastError, with ``where`` and the line in its message, for content that is not UTF-8 or not CSV.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        line = content.count(b"\n", 0, cause.start) + 1
        problem = f"has the byte 0x{content[cause.start]:02x}, which is not UTF-8"
        raise HoldfastError(message(f"{where}, line {line}", problem, "save it as UTF-8")) from cause
    lines = csv.reader(io.StringIO(text, newline=""))
    try:
        names = [name.strip() for name in next(lines, [])]
        yield 1, dict.fromkeys(names)
        for values in lines:
            if values:
                yield lines.line_num, dict(zip_longest(names, values[: len(names)]))
    except csv.Error as cause:  # for example a field of more than 131,072 characters
        remedy = "shorten the field, or close the quotation mark that begins it"
        raise HoldfastError(message(f"{where}, line {lines.line_num}", f"is no CSV: {cause}", remedy)) from cause


@dataclass(frozen=True)
class Input:
    """A scene with its ``name``: a file at ``path``, or a ``scene`` that was given as a value.

    ``state`` are the positions (nq,) at which the model in the file is looked at, if these are given.
    """

    name: str
    path: str | None = None
    scene: Scene | None = None
    state: tuple[float, ...] | None = None

    @staticmethod
    def file(path: str, name: str = "") -> Input:
        """Return the input of a file; its name is its path unless ``name`` is given."""
        return Input(name or as_text(path), path)


def as_text(path: str) -> str:
    """Return a path or a name as valid Unicode for the tables, although file names may hold any bytes."""
    try:
        return os.fsencode(path).decode("utf-8", "backslashreplace")
    except UnicodeEncodeError:  # a lone surrogate, which no file name has
        return path.encode("utf-8", "backslashreplace").decode()


@dataclass(frozen=True)
class Inputs:
    """An iterator of inputs, and their number if it is known beforehand."""

    items: Iterator[Input]
    count: int | None


class ManyInputs(Protocol):
    """An object that lists the inputs of a batch itself, such as all states of a model file."""

    def inputs(self) -> Inputs:
        """Return the inputs."""


Named: TypeAlias = "str | os.PathLike[str] | Scene | tuple[str, Any]"
Scenes: TypeAlias = "str | os.PathLike[str] | Iterable[Named] | Mapping[Any, Any] | ManyInputs"


def inputs_of(scenes: Scenes) -> Inputs:
    """Return the inputs for the argument ``scenes`` of a batch.

    A string or a path is a scene file, a folder (all files below it with the suffix of a scene format), a glob pattern
    (``**`` matches folders of any depth) or a manifest (.csv, .parquet) with the column ``scene`` and optionally
    ``name``; paths in it are relative to its folder. Files of folders and patterns are sorted by name. Anything else
    must be an iterable of paths, Scene objects, and pairs of a name and one of them. Raises HoldfastError if there is
    no such file; errors in single scenes become part of their rows.
    """
    if isinstance(scenes, str | os.PathLike):
        found = list(_named(os.fspath(scenes)))
        return Inputs(iter(found), len(found))
    if isinstance(scenes, Scene) or not isinstance(scenes, Iterable) or getattr(scenes, "ndim", 1) == 0:
        remedy = "needs a path, a glob, a folder, a manifest, or a list of paths or scenes"
        raise HoldfastError(message("batch: scenes", f"got {quoted(scenes)}", remedy))
    count = len(scenes) if isinstance(scenes, Sized) else None
    return Inputs(_distinct(_input(number, item) for number, item in enumerate(scenes)), count)


def _named(text: str) -> Iterator[Input]:
    if os.path.isdir(text):
        suffixes = {suffix for each in readable() for suffix in each.suffixes}
        paths = (path for path in Path(text).rglob("*") if path.suffix.lower() in suffixes and path.is_file())
        found = sorted(str(path) for path in paths)
    elif Path(text).suffix.lower() in MANIFESTS and os.path.isfile(text):
        yield from _distinct(_manifest(Path(text)))
        return
    elif os.path.lexists(text):
        found = [text]
    else:
        found = sorted(glob.glob(text, recursive=True)) if MAGIC & set(text) else []
        found = [path for path in found if not os.path.isdir(path)]
    if not found:
        raise HoldfastError(message(text, "names no scene file", "needs a file, a folder, a glob or a manifest"))
    yield from map(Input.file, found)


def _manifest(path: Path) -> Iterator[Input]:
    """Yield the rows of a manifest."""
    if path.suffix.lower() == ".parquet":
        rows = _parquet(path)
    else:
        content = read_ordinary(path, "manifest", most=MOST_BYTES, error=HoldfastError, too_large="divide it")
        rows = (row for _, row in islice(csv_rows(content, str(path)), 1, None))
    for number, row in enumerate(rows):
        place = row.get(COLUMN)
        if not isinstance(place, str) or not place:
            problem = f"row {number + 1} has no text in the column {COLUMN!r}"
            raise HoldfastError(message(str(path), problem, "needs a path of a scene file in every row"))
        name = row.get(NAMES) or as_text(place)
        if not isinstance(name, str):
            problem = f"row {number + 1} has {quoted(name)} in the column {NAMES!r}"
            raise HoldfastError(message(str(path), problem, "needs a text there, or nothing"))
        yield Input.file(str(path.parent / place), name)


def _parquet(path: Path) -> Iterator[dict[str, Any]]:
    try:
        from pyarrow import parquet
    except ImportError as cause:
        remedy = f"{installing('tables')}, or write the manifest as CSV"
        raise HoldfastError(message(str(path), "needs pyarrow, which is not installed", remedy)) from cause
    check_ordinary(path, "manifest", error=HoldfastError)
    try:
        with path.open("rb") as stream:  # Arrow would take the name of a path for UTF-8
            file = parquet.ParquetFile(stream)
            columns = [name for name in (COLUMN, NAMES) if name in file.schema_arrow.names]
            for batch in file.iter_batches(columns=columns, use_threads=False):
                yield from batch.to_pylist()
    except HoldfastError:  # from the consumer of the rows
        raise
    except Exception as cause:  # a reader of damaged bytes may raise any exception
        problem = f"is not a readable Parquet file: {one_line(str(cause), 200) or type(cause).__name__}"
        raise HoldfastError(message(str(path), problem, "write it again, or as CSV")) from cause


def _input(number: int, item: Any) -> Input:  # noqa: ANN401 - checked here
    if isinstance(item, tuple) and len(item) == 2 and isinstance(item[0], str):
        inner = _input(number, item[1])
        return Input(as_text(item[0]), inner.path, inner.scene)
    if isinstance(item, Scene):
        return Input(item.name or f"scene {number}", None, item)
    if isinstance(item, str | os.PathLike):
        return Input.file(str(os.fspath(item)))
    problem = f"number {number} is {quoted(item)}"
    raise HoldfastError(message("batch: scenes", problem, "needs a path, a Scene, or a pair of a name and one of them"))


def _distinct(items: Iterable[Input]) -> Iterator[Input]:
    """Yield the inputs; raise HoldfastError at a name that occurred before."""
    seen: dict[str, int] = {}
    for number, item in enumerate(items):
        if seen.setdefault(item.name, number) != number:
            problem = f"numbers {seen[item.name]} and {number} have the name {quoted(item.name)}"
            raise HoldfastError(message("batch: scenes", problem, "give names of their own, as in (name, scene)"))
        yield item
