"""Checks of values that are read from files: types against the annotations of the fields, array shapes as declared.

A file may hold anything, and a value that was built is trusted everywhere, so its fields are checked once, here.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from typing import Any, TypeVar

import numpy as np

LARGEST = 1e100  # largest finite number that a value may hold; no force, length or mass is larger


def misfit(cls: type, state: Mapping[str, Any]) -> str:
    """Return a description of the first field of ``state`` that a ``cls`` cannot have; "" if all fit.

    A letter in the shape of a column stands for the same number in all fields of one value. The shape of a tuple or
    list is its length.
    """
    for name, wanted in _annotations(cls).items():
        if name in state and not fits(state[name], wanted):
            return f"{cls.__name__}.{name} is a {type(state[name]).__name__}, which it cannot be"
    numbers: dict[str, int] = {}
    columns = {entry.name: entry.metadata for entry in fields(cls) if entry.metadata}
    for name, column in columns.items():
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


@cache
def _annotations(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)
