"""Pairs of bodies, or of their parts, between which contacts are excluded."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import Bool, checked_items
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.text import quoted
from holdfast.scene.body import Body

End: TypeAlias = str | tuple[str, int]  # the name of a body, or that name and the number of one of its parts, from 0
Excluded: TypeAlias = tuple[End, End]

REMEDY = 'needs two bodies, each as its name, or as its name and the number of a part: [("hand", 2), "cup"]'


def body_of(end: End) -> str:
    """Return the name of the body at one end of a pair."""
    return end if isinstance(end, str) else end[0]


def checked_excluded(given: Iterable[Any], bodies: Iterable[Body]) -> tuple[Excluded, ...]:
    """Return the pairs of bodies or parts, sorted by names and without repetitions.

    The only part of a body is replaced by the body. Raises SceneError for anything but a pair, for two ends on the same
    body, and for an unknown body or part.
    """
    pairs = set()
    known = {body.name: len(body.materials) for body in bodies}
    for pair in checked_items(given, "excluded", "pairs of bodies"):
        both = tuple(pair) if isinstance(pair, tuple | list) else ()
        if len(both) != 2:
            raise SceneError(message(f"excluded: pair {quoted(pair)}", "is no pair", REMEDY))
        a, b = sorted((_checked_end(end, pair, known) for end in both), key=_order)
        if body_of(a) == body_of(b):
            raise SceneError(message(f"excluded: pair {quoted(pair)}", "is of one body", REMEDY))
        pairs.add((a, b))
    return tuple(sorted(pairs, key=lambda pair: (_order(pair[0]), _order(pair[1]))))


def _order(end: End) -> tuple[str, int]:
    return (end, -1) if isinstance(end, str) else end


def _checked_end(end: Any, pair: Any, known: Mapping[str, int]) -> End:  # noqa: ANN401 - anything a caller may pass
    where = f"excluded: pair {quoted(pair)}"
    name, *parts = end if isinstance(end, tuple | list) and len(end) == 2 else (end,)
    if not isinstance(name, str) or not all(isinstance(part, int) and not isinstance(part, bool) for part in parts):
        raise SceneError(message(where, "is no pair", REMEDY))
    if name not in known:
        raise SceneError(message(where, f"unknown name {quoted(name)}", nearest_of(name, sorted(known))))
    for part in parts:
        if not 0 <= part < known[name]:
            problem = f"{quoted(name)} has no part {part}"
            raise SceneError(message(where, problem, f"needs a number from 0 to {known[name] - 1}"))
    return (name, parts[0]) if parts and known[name] > 1 else name


def excluded_among(excluded: Iterable[Excluded], names: Collection[str]) -> tuple[Excluded, ...]:
    """Return the pairs of which both bodies are among these names."""
    return tuple(pair for pair in excluded if all(body_of(end) in names for end in pair))


def excluded_by(a: str, b: str, may: Bool) -> Iterator[Excluded]:
    """Yield what is excluded between two bodies of which part i of ``a`` may touch part j of ``b`` if ``may[i, j]``."""
    if not may.any():
        yield a, b
        return
    rows, columns = np.asarray(may.any(1)), np.asarray(may.any(0))
    yield from (((a, int(i)), b) for i in np.flatnonzero(~rows))
    yield from ((a, (b, int(j))) for j in np.flatnonzero(~columns))
    yield from (((a, i), (b, j)) for i, j in np.argwhere(~may).tolist() if rows[i] and columns[j])


def by_bodies(excluded: Iterable[Excluded]) -> dict[tuple[str, str], list[Excluded]]:
    """Return the excluded pairs by the names of their two bodies, which are in alphabetical order."""
    found: dict[tuple[str, str], list[Excluded]] = {}
    for a, b in excluded:
        found.setdefault((body_of(a), body_of(b)), []).append((a, b))
    return found


def may_touch(a: Body, b: Body, pairs: Iterable[Excluded]) -> Bool:
    """Tell which parts of ``a`` may touch which parts of ``b``, as (parts of a, parts of b).

    ``pairs`` are those of ``by_bodies`` for the two bodies; a body that is no compound has one part.
    """
    may: NDArray[np.bool_] = np.ones((len(a.materials), len(b.materials)), dtype=bool)
    for pair in pairs:
        of = {body_of(end): slice(None) if isinstance(end, str) else end[1] for end in pair}
        may[of[a.name], of[b.name]] = False
    return may


def touching_parts(may: Bool) -> list[tuple[Sequence[int], Sequence[int]]]:
    """Return the sets of parts of two bodies that are searched together; part i may touch part j if ``may[i, j]``.

    Parts of the second body form a set if they may touch the same parts of the first body, which are searched with it.
    So each search is between unions of parts that all may touch each other.
    """
    alike: dict[bytes, list[int]] = {}
    for j, column in enumerate(may.T):
        alike.setdefault(column.tobytes(), []).append(j)
    found = [(np.flatnonzero(may[:, second[0]]).tolist(), second) for second in alike.values()]
    return [(first, second) for first, second in found if first]
