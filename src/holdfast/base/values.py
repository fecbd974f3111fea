"""Values: immutable objects that can be pickled, copied, compared and hashed."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cache
from typing import Any, Literal, TypeVar, cast

import numpy as np

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
T = TypeVar("T")

LONGEST = 900  # largest number of characters of the fields in the repr of a value
SHOWN = 9  # largest number of entries of an array, a list or a table that a repr writes out


class Value:
    """Base class of the frozen dataclasses of holdfast, which are declared with ``eq=False, repr=False``.

    Pickling and ``copy.deepcopy`` take the fields alone, without cached properties, and arrays come back read-only. Two
    values are equal if they are of the same class and all their fields are equal, arrays element by element. Equal
    values have equal hashes. ``repr`` stays below 1,000 characters whatever the value holds. Fields declared with
    ``compare=False`` are left out of comparisons, and fields declared with ``repr=False`` out of ``repr``.
    """

    def __getstate__(self) -> dict[str, Any]:
        return dict(items_of(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, item in state.items():
            object.__setattr__(self, name, sealed(item))

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return all(alike(getattr(self, name), getattr(other, name)) for name in _names_of(self, "compare"))

    def __hash__(self) -> int:
        return hash((type(self).__name__, tuple(_key(getattr(self, name)) for name in _names_of(self, "compare"))))

    def __repr__(self) -> str:
        text = ", ".join(f"{name}={shown(getattr(self, name))}" for name in _names_of(self, "repr"))
        return f"{type(self).__name__}({shortened(text, LONGEST)})"


class Table(Mapping[K, V]):
    """An immutable mapping. It is pickled, copied, compared and hashed by its items."""

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[K, V] | Iterable[tuple[K, V]] = ()) -> None:
        self._items = dict(items)

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset((key, _key(item)) for key, item in self._items.items()))

    def __reduce__(self) -> tuple[type[Table[K, V]], tuple[dict[K, V]]]:
        return type(self), (self._items,)

    def __repr__(self) -> str:
        return shown(self._items)


def items_of(value: object) -> Iterator[tuple[str, Any]]:
    """Yield the names and contents of the fields of a dataclass, in order."""
    for name in _names_of(value):
        yield name, getattr(value, name)


def altered(value: T, **items: object) -> T:
    """Return a value like this dataclass with other contents of some fields, which are not checked.

    Cached properties are not taken over.
    """
    other, own = object.__new__(type(value)), value.__dict__
    other.__dict__.update({name: own[name] for name in _names_of(value)}, **items)
    return other


def made(kind: type[T], **items: object) -> T:
    """Return a dataclass with these contents of all its fields, which are not checked, and of cached properties.

    Arrays have to be read-only. For what is made by the thousand: it takes a tenth of the time.
    """
    value = object.__new__(kind)
    value.__dict__.update(items)
    return value


def _names_of(value: object, role: Literal["all", "compare", "repr"] = "all") -> tuple[str, ...]:
    """Return the names of the fields of a dataclass, those that take part in comparisons, or those in ``repr``."""
    return _names(cast(Hashable, type(value)), role)


@cache
def _names(kind: Any, role: str) -> tuple[str, ...]:  # noqa: ANN401 - any dataclass
    return tuple(entry.name for entry in fields(kind) if role == "all" or getattr(entry, role))


def sealed(item: T) -> T:
    """Make all arrays in ``item`` read-only, in place, and return it."""
    if isinstance(item, np.ndarray):
        item.setflags(write=False)
    elif item is None or isinstance(item, str | int | float):  # most fields hold these, and the check is quick
        return item
    elif isinstance(item, tuple | list):
        for part in item:
            sealed(part)
    elif isinstance(item, Mapping):
        for part in item.values():
            sealed(part)
    return item


def seal(value: object) -> None:
    """Make the arrays in the fields of a dataclass read-only, in place. Nobody else may own these arrays."""
    for _, item in items_of(value):
        sealed(item)


def alike(a: Any, b: Any) -> bool:  # noqa: ANN401 - anything that values hold
    """Say whether the contents of two fields are equal, arrays element by element."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        same = isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and a.shape == b.shape and a.dtype == b.dtype
        if not same or a.dtype != object:
            return same and bool((a == b).all())
        return all(alike(x, y) for x, y in zip(a.flat, b.flat, strict=True))
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return type(a) is type(b) and len(a) == len(b) and all(alike(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(alike(item, b[key]) for key, item in a.items())
    return bool(a == b)


def _key(item: Any) -> Hashable:  # noqa: ANN401
    """Return a hashable key that is the same for items that compare equal."""
    if isinstance(item, np.ndarray):
        if item.dtype == object:
            return item.shape, tuple(_key(part) for part in item.flat)
        positive = item + 0.0 if item.dtype.kind == "f" else item  # -0.0 and 0.0 are equal
        return item.shape, positive.tobytes()
    if isinstance(item, tuple | list):
        return tuple(_key(part) for part in item)
    if isinstance(item, Mapping):
        return frozenset((key, _key(part)) for key, part in item.items())
    return cast(Hashable, item)


def shown(item: Any) -> str:  # noqa: ANN401
    """Return a short text for the content of a field."""
    if isinstance(item, np.ndarray):
        if item.size > SHOWN or item.dtype == object:
            return f"<array {item.shape}>"
        positive = item + 0.0 if item.dtype.kind == "f" else item  # nobody wants to read -0.0
        return np.array2string(positive, precision=6, separator=", ").replace("\n", "")
    if isinstance(item, Value):
        name = getattr(item, "name", None)
        return f"<{type(item).__name__}{f' {shortened(repr(name), 60)}' if isinstance(name, str) else ''}>"
    if isinstance(item, tuple | list):
        inner = ", ".join(shown(part) for part in item[:SHOWN])
        more = f", ... {len(item) - SHOWN} more" if len(item) > SHOWN else ""
        return f"({inner}{more})"
    if isinstance(item, Mapping):
        pairs = [f"{shortened(repr(key), 60)}: {shown(part)}" for key, part in list(item.items())[:SHOWN]]
        pairs += [f"... {len(item) - SHOWN} more"] if len(item) > SHOWN else []
        return "{" + ", ".join(pairs) + "}"
    return shortened(repr(item + 0.0 if isinstance(item, float) else item), 200)


def shortened(text: str, most: int) -> str:
    """Return ``text`` with at most ``most`` characters, ending in dots if it was longer."""
    return text if len(text) <= most else text[: most - 3] + "..."
