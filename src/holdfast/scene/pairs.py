"""Tables of numbers for pairs of bodies, by the names of bodies or materials."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from holdfast.base.arrays import checked_number
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import Range
from holdfast.base.text import quoted
from holdfast.base.values import Table

Pair = tuple[str, str]


def checked_pairs(
    given: Mapping[Any, Any],
    where: str,
    what: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    within: Range | None = None,
) -> Table[Pair, float]:
    """Return a table of numbers for pairs of names, which are in alphabetical order.

    ``where`` is the owner of the table and ``what`` the meaning of its numbers in error messages. Raises SceneError if
    a key is not a pair of names, a pair occurs twice, or a number is below ``minimum``, not greater than ``above``, or
    out of the range ``within``.
    """
    pairs: dict[Pair, float] = {}
    for key, value in given.items():
        a, b = sorted(checked_pair(key, where))
        if (a, b) in pairs:
            raise SceneError(message(where, f"pair {quoted(key)} stands twice", "give each pair once"))
        pairs[a, b] = checked_number(value, f"{what} of {quoted(key)}", minimum=minimum, above=above, within=within)
    return Table(pairs)


def checked_pair(key: Any, where: str) -> Pair:  # noqa: ANN401 - anything a caller may pass
    """Return a pair of names; raise SceneError for anything else."""
    if not isinstance(key, tuple) or len(key) != 2 or not all(isinstance(part, str) for part in key):
        raise SceneError(message(where, f"pair {quoted(key)}", "needs two body or material names"))
    return key


def number_between(pairs: Mapping[Pair, float], a: str, b: str, materials: Mapping[str, str | None]) -> float | None:
    """Return the number of bodies ``a`` and ``b`` in a table from ``checked_pairs``, or None if it has none.

    It is looked up as ``names_between`` says. If both mixed pairs are given, the smaller number counts, whichever body
    comes first.
    """
    for named in names_between(a, b, materials) if pairs else ():
        found = [pairs[pair] for pair in named if pair in pairs]
        if found:
            return min(found)
    return None


def names_between(a: str, b: str, materials: Mapping[str, str | None]) -> list[list[Pair]]:
    """Return the pairs of names, each in alphabetical order, under which a table may have a number for two bodies.

    First come the names of both bodies, then the name of one body and the material of the other, then both materials.
    ``materials`` maps the name of each body to its material, or None.
    """
    like_a, like_b = materials.get(a), materials.get(b)
    ways = (((a, b),), ((a, like_b), (like_a, b)), ((like_a, like_b),))
    return [[(min(x, y), max(x, y)) for x, y in way if x is not None and y is not None] for way in ways]


def check_known(pairs: Collection[Pair], known: Collection[str], what: str) -> None:
    """Raise SceneError, with the most similar name, if a pair has a name that is not among the ``known`` ones."""
    for key in pairs:
        for name in key:
            if name not in known:
                remedy = nearest_of(name, sorted(known))
                raise SceneError(message(f"{what} of {quoted(key)}", f"unknown name {quoted(name)}", remedy))
