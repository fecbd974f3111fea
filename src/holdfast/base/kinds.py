"""Checks of values that are read from files: types against the annotations of the fields, array shapes as declared.

A file may hold anything, and a value that was built is trusted everywhere, so its fields are checked once, here.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from functools import cache
from typing import Any, TypeVar

import numpy as np

C = TypeVar("C", bound=type)

LARGEST = 1e100  # largest finite number that a value may hold; no force, length or mass is larger

_SHAPED: dict[type, dict[str, Mapping[str, Any]]] = {}


def shaped(**shapes: str) -> Callable[[C], C]:
    """Declare the shapes of the fields of a class that is no record (class decorator), as ``public.column`` does."""

    def declare(cls: C) -> C:
        _SHAPED[cls] = {name: {"shape": shape, "of": None} for name, shape in shapes.items()}
        return cls

    return declare


def misfit(cls: type, state: Mapping[str, Any]) -> str:
    """Return a description of the first field of ``state`` that a ``cls`` cannot have; "" if all fit.

    A letter in the shape of a column stands for the same number in all fields of one value. The shape of a tuple or
    list is its length.
    """
    for name, wanted in _annotations(cls).items():
        if name in state and not fits(state[name], wanted):
            return f"{cls.__name__}.{name} is a {type(state[name]).__name__}, which it cannot be"
    numbers: dict[str, int] = {}
    columns: dict[str, Mapping[str, Any]] = {entry.name: entry.metadata for entry in fields(cls) if entry.metadata}
    for name, column in (columns | _SHAPED.get(cls, {})).items():
        item, shape, kind = state[name], column["shape"].split(), column["of"]
        found = item.shape if isinstance(item, np.ndarray) else (len(item),)
        if len(found) != len(shape) or any(
            numbers.setdefault(mark, size) != size if mark.isalpha() else int(mark) != size
            for mark, size in zip(shape, found, strict=True)
        ):
            return f"{cls.__name__}.{name} has shape {found}, not ({', '.join(shape)})"
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
        return isinstance(item, np.ndarray) and _holds(item, typing.get_args(inner[1])[0])
    if origin is tuple:
        return isinstance(item, tuple) and _each(item, inner)
    if origin is not None:  # a mapping or another generic class
        return isinstance(item, origin) and _pairs(item, inner)
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


def _holds(array: np.ndarray[Any, Any], kind: type[np.generic]) -> bool:
    return array.dtype == np.dtype(kind) and (array.dtype.kind != "f" or _sane(array))


def _sane(numbers: np.ndarray[Any, Any]) -> bool:
    """Tell whether all numbers are at most LARGEST or infinite; NaN is neither."""
    size = np.abs(numbers)
    return bool(((size <= LARGEST) | (size == np.inf)).all())


def _each(items: tuple[Any, ...], wanted: tuple[Any, ...]) -> bool:
    if len(wanted) == 2 and wanted[1] is Ellipsis:
        return all(fits(item, wanted[0]) for item in items)
    return len(items) == len(wanted) and all(map(fits, items, wanted))


def _pairs(items: Any, wanted: tuple[Any, ...]) -> bool:  # noqa: ANN401
    if not isinstance(items, Mapping):
        return True
    pairs: Iterable[tuple[Any, Any]] = items.items()
    return all(fits(key, wanted[0]) and fits(part, wanted[1]) for key, part in pairs)


@cache
def _annotations(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)
