"""All arrays that can be reached from a value, through its fields, properties and what these hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from functools import cached_property

import numpy as np

import holdfast as hf


def parts(value: object) -> Iterator[tuple[str, object]]:
    """What can be reached from a value in one step: items, fields and properties, those that are computed too."""
    if isinstance(value, Mapping):
        yield from ((f"[{key!r}]", item) for key, item in value.items())
    elif isinstance(value, tuple | list) or (isinstance(value, np.ndarray) and value.dtype == object):
        yield from ((f"[{k}]", item) for k, item in enumerate(value))
    elif is_dataclass(value) and type(value).__module__.startswith("holdfast."):
        names = set(value.__dataclass_fields__) | {
            name
            for cls in type(value).__mro__
            for name, member in vars(cls).items()
            if isinstance(member, property | cached_property)
        }
        for name in sorted(name for name in names if not name.startswith("_")):
            try:
                yield f".{name}", getattr(value, name)
            except hf.HoldfastError:  # the mass of an open mesh
                continue


def arrays(value: object, where: str) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays that can be reached from a value, each with the way to it."""
    waiting, seen = [(where, value)], {}
    while waiting:
        path, item = waiting.pop()
        if isinstance(item, np.ndarray):
            yield path, item
        if isinstance(item, np.ndarray) and item.dtype != object:
            continue
        if id(item) not in seen:
            seen[id(item)] = item  # kept alive, so that no other object gets its number
            # a reduced surface has a reduced one again, and so on: no step is taken twice in a row
            waiting += [(path + step, part) for step, part in parts(item) if not path.endswith(step)]


def writable(value: object, where: str) -> list[str]:
    """The ways to all arrays that can be written to."""
    return sorted({path for path, array in arrays(value, where) if array.flags.writeable})
