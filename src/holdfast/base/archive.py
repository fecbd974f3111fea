"""Saving and loading of values without loss and without pickle, as JSON text or as .npz files for large values.

A file holds the registered name of each class and the contents of its fields, so files stay valid when modules move. An
object that several parts share is written once, and is shared again after loading. If a class has the method
``checked_after_load``, it is called after loading, and raises HoldfastError if the contents cannot be right.

A file may hold anything, and a value that was built is trusted everywhere, so its fields are checked once, here: types
against the annotations, array shapes as declared.
"""

from __future__ import annotations

import base64
import io
import json
import math
import os
import sys
import types
import typing
from collections.abc import Iterable, Mapping
from dataclasses import fields
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any, TypeVar
from zipfile import ZipFile, ZipInfo

import numpy as np

from holdfast.base.errors import HoldfastError, located, message
from holdfast.base.files import check_ordinary, checked_path, read_ordinary, write_atomically
from holdfast.base.values import Table, Value, items_of, sealed

FORMAT = "holdfast-saved/1"
EARLIER = "holdfast-answer/1"  # the name of the same layout up to 1.0.0rc1; now that of the envelope of --json
SUFFIXES = (".json", ".npz")
MAX_BYTES = 4_000_000_000  # size of the largest answer that is read, after unpacking
SMALL = 64  # arrays of at most this many numbers are written into the JSON text of a .npz file, unless OPEN applies
MOST_PACKED = 1100  # bytes to which one byte of an archive may unpack; no compression does better
# Fields that earlier versions saved, of answers that were interpolated between others; files that have them are read
GONE = {"Answers": {"solved", "error"}, "MapPoint": {"solved", "error"}}
NEW = {"Step": {"found"}, "Constraint": {"above", "above_by"}}  # fields that older files lack: they have their default
LARGEST = 1e100  # largest finite number that a value may hold; no force, length or mass is larger
OPEN = 2  # arrays at most this many levels deep are entries of the .npz file, so that other programs can read them

C = TypeVar("C", bound=type)

_CLASSES: dict[str, type] = {}
_HINTS = cache(typing.get_type_hints)


def archived(cls: C) -> C:
    """Register a class, a ``Value`` or an ``Enum``, so that its objects can be saved (class decorator).

    Files hold the name of the class. Raises HoldfastError if a class of another module has the same name.
    """
    known = _CLASSES.setdefault(cls.__name__, cls)
    if known is not cls and known.__module__ != cls.__module__:
        raise HoldfastError(message("archive", f"two classes are named {cls.__name__!r}", "names are unique"))
    _CLASSES[cls.__name__] = cls
    return cls


def save(value: Value, path: str | os.PathLike[str]) -> None:
    """Write ``value`` to a .json or .npz file, from which ``load`` reads it without loss.

    Raises HoldfastError if the suffix is another, a part cannot be saved, or the file cannot be written.
    """
    suffix = _suffix(path)
    if suffix == ".json":
        write_atomically(path, (text_of(value) + "\n").encode())
        return
    arrays: dict[str, Any] = {}
    text = text_of(value, arrays)
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, value=np.array(text), **arrays)
    write_atomically(path, stream.getvalue())


def text_of(value: Value, arrays: dict[str, Any] | None = None) -> str:
    """Return ``value`` as JSON text; if ``arrays`` is given, the larger arrays are put there instead.

    Raises HoldfastError if a part cannot be saved.
    """
    return json.dumps({"format": FORMAT, "value": _Writer(arrays).plain(value)}, allow_nan=False)


def load(path: str | os.PathLike[str]) -> Any:  # noqa: ANN401 - whatever was saved
    """Read the value that ``save`` wrote; raise HoldfastError for any other file."""
    suffix = _suffix(path)
    with located(str(path)):
        try:
            if suffix == ".npz":
                data, arrays = _npz(Path(path))
            else:
                text = read_ordinary(
                    Path(path), "answer file", most=MAX_BYTES, error=HoldfastError, too_large="save it as .npz"
                )
                data, arrays = json.loads(text.decode("utf-8-sig")), {}
            if not isinstance(data, dict) or data.get("format") not in {FORMAT, EARLIER}:
                shown = data.get("format") if isinstance(data, dict) else type(data).__name__
                remedy = f"needs {FORMAT!r}, as answer.save(path) writes it; what --json prints is for other programs"
                raise HoldfastError(message("answer", f"is of format {shown!r:.60}", remedy))
            return _Reader(arrays).value(data["value"])
        except OSError as cause:
            raise HoldfastError(
                message("answer", f"cannot be read: {cause.strerror or cause}", "name a file")
            ) from cause
        except HoldfastError:
            raise
        except Exception as cause:  # the libraries that read numbers, archives and texts may raise anything
            problem = f"is damaged ({type(cause).__name__}: {cause!s:.80})"
            raise HoldfastError(message("answer", problem, "needs a file that an answer's save wrote")) from cause


def to_dict(value: Any) -> Any:  # noqa: ANN401 - anything that a value holds
    """Return plain data for JSON: arrays as lists, infinity as the text "inf", values as dicts of their fields."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float):
        if math.isnan(value):
            raise ValueError("an answer holds NaN: a defect in holdfast")
        return value if math.isfinite(value) else str(value)
    if isinstance(value, tuple | list):
        return [to_dict(item) for item in value]
    if isinstance(value, Mapping):
        return {key if isinstance(key, str) else "-".join(map(str, key)): to_dict(item) for key, item in value.items()}
    if isinstance(value, Value):
        own = getattr(value, "to_dict", None)
        return own() if own is not None else {name: to_dict(item) for name, item in items_of(value)}
    return value if value is None or isinstance(value, str | int) else str(value)


class _Writer:
    """Converts values to plain data. An object that is not plain becomes a dict whose first key begins with $.

    For a .npz file, arrays go into ``arrays``. Their names say where they belong in the value: ``inner.0`` is the first
    part of ``inner``.
    """

    def __init__(self, arrays: dict[str, Any] | None) -> None:
        self.arrays = arrays
        self.seen: dict[int, int] = {}
        self.place: list[str] = []  # the path to the current part of the value: names of fields, numbers of parts
        self.alive: list[Any] = []  # keeps the objects in ``seen`` alive, so that their ids are not used again

    def plain(self, item: Any) -> Any:  # noqa: ANN401
        if isinstance(item, np.generic):
            item = item.item()
        if isinstance(item, Enum):
            return {"$enum": [type(item).__name__, item.value]}
        if item is None or isinstance(item, str | int):
            return item
        if isinstance(item, float):
            return item if math.isfinite(item) else {"$float": str(item)}
        if isinstance(item, Path):
            return {"$path": str(item)}
        if isinstance(item, tuple):
            return {"$tuple": self.parts(item)}
        if isinstance(item, list):
            return self.parts(item)
        if isinstance(item, Mapping):
            kind = "$table" if isinstance(item, Table) else "$map"
            # each key is converted before its part, in the order in which they are read
            pairs = enumerate(item.items())
            return {kind: [[self.plain(key), self.at(str(k), part)] for k, (key, part) in pairs]}
        return self.shared(item)

    def parts(self, items: Iterable[Any]) -> list[Any]:
        """Convert each part to plain data; its name is its number."""
        return [self.at(str(k), part) for k, part in enumerate(items)]

    def at(self, name: str, item: Any) -> Any:  # noqa: ANN401
        """Convert the part with this name to plain data, keeping track of its place in the value."""
        self.place.append(name)
        data = self.plain(item)
        self.place.pop()
        return data

    def shared(self, item: Any) -> Any:  # noqa: ANN401
        """Convert an array or a value, or refer to it if it was already written."""
        if id(item) in self.seen:
            return {"$same": self.seen[id(item)]}
        self.seen[id(item)] = len(self.alive)
        self.alive.append(item)
        if isinstance(item, np.ndarray):
            return self.array(item)
        if isinstance(item, Value) and _CLASSES.get(type(item).__name__) is type(item):
            return {
                "$value": type(item).__name__,
                "fields": {name: self.at(name, part) for name, part in items_of(item)},
            }
        problem = f"a {type(item).__name__} cannot be saved"
        raise HoldfastError(message("save", problem, "only values of holdfast's own classes can"))

    def array(self, item: np.ndarray[Any, Any]) -> Any:  # noqa: ANN401
        if item.dtype == object:
            return {"$objects": self.parts(item.flat), "shape": list(item.shape)}
        kind = item.dtype.str
        if self.arrays is not None and (item.size > SMALL or len(self.place) <= OPEN):
            name = ".".join(self.place)
            self.arrays[name] = item
            return {"$array": name}
        if item.dtype.kind == "f":
            numbers = [x if math.isfinite(x) else str(x) for x in item.ravel().tolist()]
        elif item.dtype.kind in "biu":
            numbers = item.ravel().tolist()
        else:
            return {"$bytes": base64.b64encode(item.tobytes()).decode(), "dtype": kind, "shape": list(item.shape)}
        return {"$numbers": numbers, "dtype": kind, "shape": list(item.shape)}


class _Reader:
    """Restores values from plain data."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self.arrays = arrays
        self.known: list[Any] = []

    def value(self, data: Any) -> Any:  # noqa: ANN401
        if isinstance(data, list):
            return [self.value(part) for part in data]
        if not isinstance(data, dict):
            return data
        tag, content = next(iter(data.items()))
        match tag:
            case "$float":
                return float(content)
            case "$path":
                return Path(content)
            case "$tuple":
                return tuple(self.value(part) for part in content)
            case "$map":
                return {self.value(key): self.value(part) for key, part in content}
            case "$table":
                return Table({self.value(key): self.value(part) for key, part in content})
            case "$enum":
                return _class(content[0], Enum)(content[1])
            case "$same":
                return self.known[content]
        place = len(self.known)
        self.known.append(None)
        self.known[place] = self.shared(tag, content, data)
        return self.known[place]

    def shared(self, tag: str, content: Any, data: dict[str, Any]) -> Any:  # noqa: ANN401
        match tag:
            case "$array":
                return sealed(np.array(self.arrays[content]))
            case "$numbers":
                kind = np.dtype(data["dtype"])
                numbers = [float(x) for x in content] if kind.kind == "f" else content
                return sealed(np.array(numbers, dtype=kind).reshape(data["shape"]))
            case "$bytes":
                kind = np.dtype(data["dtype"])
                return sealed(np.frombuffer(base64.b64decode(content), dtype=kind).reshape(data["shape"]).copy())
            case "$objects":
                array = np.empty(len(content), dtype=object)
                for k, part in enumerate(content):
                    array[k] = self.value(part)
                return sealed(array.reshape(data["shape"]))
            case "$value":
                return self.built(_class(content, Value), data["fields"])
        raise ValueError(f"unknown tag {tag!r:.40}")

    def built(self, cls: type, data: Mapping[str, Any]) -> Any:  # noqa: ANN401
        parts = {name: self.value(part) for name, part in data.items()}  # of all, for later ones may refer to them
        new = NEW.get(cls.__name__, set())
        older = {entry.name: entry.default for entry in fields(cls) if entry.name in new}
        state = older | {entry.name: parts.pop(entry.name) for entry in fields(cls) if entry.name in parts}
        if len(state) < len(fields(cls)) or parts.keys() - GONE.get(cls.__name__, set()):
            raise ValueError(f"{cls.__name__} has other fields than {sorted(data)}")
        wrong = first_misfit(cls, state)
        if wrong:
            raise ValueError(wrong)
        result: Any = object.__new__(cls)
        result.__setstate__(state)
        check = getattr(result, "checked_after_load", None)
        if check is not None:
            check()
        return result


def _class(name: str, base: type) -> Any:  # noqa: ANN401
    cls = _CLASSES.get(name)
    if cls is None or not issubclass(cls, base):
        raise ValueError(f"holds a {name!r:.40}, which is not known")
    return cls


def _npz(path: Path) -> tuple[Any, Mapping[str, Any]]:
    check_ordinary(path, "answer file", error=HoldfastError)
    with ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
        if size > MAX_BYTES:
            raise HoldfastError(message("answer", f"unpacks to {size:,} bytes", f"the limit is {MAX_BYTES:,}"))
        for entry in archive.infolist():
            _check_size(archive, entry)
    with np.load(path, allow_pickle=False) as members:
        arrays = {name: members[name] for name in members.files}
    return json.loads(_text(arrays.pop("value"))), arrays


def _text(array: np.ndarray[Any, Any]) -> str:
    """Return the text in an array of one text; raise ValueError if one of its code points is not a character.

    NumPy would make a broken text of it.
    """
    numbers = np.frombuffer(array.tobytes(), np.dtype("u4").newbyteorder(array.dtype.byteorder))
    if array.dtype.kind != "U" or int(numbers.max(initial=0)) > sys.maxunicode:
        raise ValueError("holds no text")
    return str(array)


def _check_size(archive: ZipFile, entry: ZipInfo) -> None:
    """Raise ValueError if an entry claims more data than its bytes can hold, before memory is allocated for it."""
    if entry.file_size > MOST_PACKED * max(entry.compress_size, 1):
        raise ValueError(f"{entry.filename!r:.40} cannot hold {entry.file_size:,} bytes")
    with archive.open(entry) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, kind = read(stream)
        promised = math.prod(shape) * kind.itemsize
        if promised != entry.file_size - stream.tell():
            raise ValueError(f"{entry.filename!r:.40} promises {promised:,} bytes and holds others")


def _suffix(path: str | os.PathLike[str]) -> str:
    suffix = checked_path(path, "answer file").suffix.lower()
    if suffix not in SUFFIXES:
        raise HoldfastError(
            message(str(path), f"suffix {suffix!r}", f"name a file that ends in {' or '.join(SUFFIXES)}")
        )
    return suffix


def first_misfit(cls: type, state: Mapping[str, Any]) -> str:
    """Say what is wrong with the first value in ``state``, by field, that a ``cls`` cannot hold; "" if all fit.

    A value has to match the annotation of its field and, in a ``column``, the shape that it declares. A letter in that
    shape stands for the same number in all fields of one ``cls``. The shape of a tuple or list is its length.
    """
    for name, wanted in _HINTS(cls).items():
        if name in state and not fits(state[name], wanted):
            return f"{cls.__name__}.{name} is a {type(state[name]).__name__}, which it cannot be"
    numbers: dict[str, int] = {}
    columns = {entry.name: entry.metadata for entry in fields(cls) if entry.metadata}
    for name, column in columns.items():
        item, shape, kind = state[name], column["shape"].split(), column["of"]
        actual = item.shape if isinstance(item, np.ndarray) else (len(item),)
        if len(actual) != len(shape) or any(
            numbers.setdefault(mark, size) != size if mark.isalpha() else int(mark) != size
            for mark, size in zip(shape, actual, strict=True)
        ):
            return f"{cls.__name__}.{name} has shape {actual}, not ({', '.join(shape)})"
        if kind is not None and not all(fits(each, kind) for each in item.flat):
            return f"{cls.__name__}.{name} holds what it cannot hold"
    return ""


def fits(item: Any, wanted: Any) -> bool:  # noqa: ANN401 - anything that a file may hold, and any annotation
    """Tell whether ``item`` matches the annotation ``wanted``. NaN and finite numbers beyond LARGEST never do."""
    origin, inner = typing.get_origin(wanted), typing.get_args(wanted)
    if wanted is Any or isinstance(wanted, TypeVar):
        return True
    if origin in (typing.Union, types.UnionType):
        return any(fits(item, each) for each in inner)
    if origin is typing.Literal:
        return isinstance(item, str | int) and item in inner
    if origin is np.ndarray:
        if not isinstance(item, np.ndarray) or item.dtype != np.dtype(typing.get_args(inner[1])[0]):
            return False
        size = np.abs(item) if item.dtype.kind == "f" else np.zeros(0)
        return bool(((size <= LARGEST) | (size == np.inf)).all())
    if origin is tuple:
        if not isinstance(item, tuple):
            return False
        each = inner[:1] * len(item) if inner[1:] == (Ellipsis,) else inner
        return len(item) == len(each) and all(map(fits, item, each))
    if origin is not None:  # a mapping or another generic class
        pairs = item.items() if isinstance(item, Mapping) else ()
        return isinstance(item, origin) and all(fits(key, inner[0]) and fits(part, inner[1]) for key, part in pairs)
    if wanted is float:
        return (
            isinstance(item, float | int)
            and not isinstance(item, bool)
            and (abs(item) <= LARGEST or abs(item) == np.inf)
        )
    if wanted is int:
        return isinstance(item, int) and not isinstance(item, bool)
    if typing.Protocol in getattr(wanted, "__bases__", ()):
        return all(hasattr(item, name) for name in vars(wanted) if not name.startswith("_"))
    return item is None if wanted in (None, type(None)) else isinstance(item, wanted)
