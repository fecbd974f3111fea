"""Connected groups of numbered bodies."""

from __future__ import annotations

from collections.abc import Iterable


def components(count: int, ends: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Return the connected groups of the numbers 0..count-1 that no path of edges connects to FIXED.

    ``ends`` holds the edges as pairs of numbers; a negative number is FIXED.
    """
    parent = list(range(count + 1))  # the last one is FIXED

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in ends:
        parent[root(a if a >= 0 else count)] = root(b if b >= 0 else count)
    groups: dict[int, list[int]] = {}
    for k in range(count):
        groups.setdefault(root(k), []).append(k)
    groups.pop(root(count), None)
    return list(groups.values())
