"""A bounded, thread-safe cache of results that may be needed again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from threading import Lock, RLock
from typing import Any, TypeVar

T = TypeVar("T")


class Same:
    """A part of a key that compares an object by identity, whatever it holds, and keeps it alive."""

    __slots__ = ("item",)

    def __init__(self, item: object) -> None:
        self.item = item

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.item is other.item

    def __hash__(self) -> int:
        return id(self.item)


@dataclass(eq=False)
class _Entry:
    """One cached result. The first thread that asks computes it, while the others wait."""

    cost: int
    made: bool = False
    content: Any = None
    making: RLock = field(default_factory=RLock)


class Memory:
    """A cache of results by key, whose costs add up to at most ``most``; the least recently used are dropped first.

    The result that was asked for last always stays. A result is computed once, however many threads ask for it. If the
    computation raises, nothing is cached.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._entries: OrderedDict[Hashable, _Entry] = OrderedDict()
        self._cost = 0
        self._lock = Lock()

    def recalled(self, key: Hashable, cost: int, make: Callable[[], T], valid: Callable[[T], bool] | None = None) -> T:
        """Return the result for ``key``; call ``make`` if it is not cached, or if ``valid`` is given and rejects it.

        ``cost`` is what the result counts against the bound.
        """
        with self._lock:
            entry = self._entries.get(key)
            if entry is None:
                entry = self._entries[key] = _Entry(cost)
                self._cost += cost
            self._entries.move_to_end(key)
            while self._cost > self.most and len(self._entries) > 1:
                self._cost -= self._entries.popitem(last=False)[1].cost
        with entry.making:
            if not entry.made or (valid is not None and not valid(entry.content)):
                try:
                    entry.content = make()
                except BaseException:
                    self.forget(key)
                    raise
                entry.made = True
            content: T = entry.content
        return content

    def forget(self, key: Hashable) -> None:
        """Drop the result for ``key``, if there is one."""
        with self._lock:
            gone = self._entries.pop(key, None)
            self._cost -= 0 if gone is None else gone.cost

    def __len__(self) -> int:
        return len(self._entries)
