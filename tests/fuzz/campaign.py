"""A whole run: inputs in turn, tallies, and what shows a defect made small and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from fuzz.draw import Rng, rng_of
from fuzz.files import file
from fuzz.keeper import Keeper
from fuzz.names import name
from fuzz.outcome import Ending, Outcome
from fuzz.scenes import scene
from fuzz.shrink import smallest
from fuzz.store import Store

Data = dict[str, Any]
MAKE: dict[str, Callable[[Rng], Data]] = {"scene": scene, "file": file, "name": name}
SHARES = {"scene": 2, "file": 10, "name": 1}  # of each kind among the inputs in turn
TWICE, GRAPH = 5, 3  # one scene in so many is asked again from the file on, and asked of engine graph as well
SAVED = 200  # trials after which the state is written
FEW_HANGS = 12  # trials to make smaller what takes so long


def item_of(seed: int, kind: str, number: int) -> Data:
    """Make the input with this number; the same numbers give the same input."""
    item = {"kind": kind, **MAKE[kind](rng_of(seed, kind, number))}
    if kind == "scene":
        item |= {"twice": True} if number % TWICE == 0 else {}
        item["pushes"] = [push | {"graph": True} if number % GRAPH == 0 else push for push in item["pushes"]]
    return item


def in_turn(kinds: list[str], count: int) -> Iterator[str]:
    """Kinds of ``count`` inputs, mixed by their shares."""
    order = [kind for kind in kinds for _ in range(SHARES[kind])]
    for k in range(count):
        yield order[k % len(order)]


def campaign(store: Store, kinds: list[str], count: int, report: Callable[[str], None], keeper: Keeper) -> int:
    """Try ``count`` more inputs after those that the store knows; return how many showed a defect."""
    bad = 0
    try:
        for k, kind in enumerate(in_turn(kinds, count)):
            tally = store.tally(kind)
            number, item = tally.next, item_of(store.seed, kind, tally.next)
            found = keeper.tried(item)
            tally.add(number, found)
            if not found.good:
                bad += 1
                if not store.known(kind, found):
                    report(f"{kind} {number}: {found.ending}: {found.sign}")
                    store.keep(small(item, found, keeper), found, number)
            if k % SAVED == SAVED - 1:
                store.save()
                report(summary(store))
    finally:
        store.save()
    return bad


def small(item: Data, found: Outcome, keeper: Keeper) -> Data:
    """The smallest input with the same ending for the same reason."""
    slow = found.ending in (Ending.HANG, Ending.MEMORY)
    return smallest(item, lambda other: keeper.tried(other).like(found), **({"most": FEW_HANGS} if slow else {}))


def summary(store: Store) -> str:
    """Counts, times and memory of each kind, one line each."""
    lines = []
    for kind, tally in store.tallies.items():
        counts = ", ".join(f"{number:,} {ending}" for ending, number in sorted(tally.counts.items()))
        mean = 1e3 * tally.seconds / max(tally.next, 1)
        longest = tally.slowest[-1] if tally.slowest else (0.0, 0)
        lines.append(
            f"{kind}: {tally.next:,} tried: {counts}; {mean:.0f} ms each, {longest[0]:.1f} s at most "
            f"(number {longest[1]}), peak {tally.peak:.0f} MB"
        )
    return "\n".join(lines)
