"""A registry of things known by name, to which users can add their own: engines and formats of scene files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import quoted

V = TypeVar("V")


class Registry(Mapping[str, V]):
    """A mapping from names to registered values; ``kind`` says in error messages what the values are."""

    def __init__(self, kind: str, known: Mapping[str, V] | None = None) -> None:
        self._kind = kind
        self._known = dict(known or {})

    def __getitem__(self, name: str) -> V:
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def add(self, name: str, value: V) -> Callable[[], None]:
        """Register ``value`` after all others and return a function that removes it again.

        Raises HoldfastError if the name is taken or is not a text.
        """
        if not isinstance(name, str) or name in self._known:
            problem = f"there is one named {quoted(name)}" if isinstance(name, str) else f"the name is {quoted(name)}"
            raise HoldfastError(message(self._kind, problem, "give it another name"))
        self._known[name] = value

        def take_back() -> None:
            if self._known.get(name) is value:
                del self._known[name]

        return take_back
