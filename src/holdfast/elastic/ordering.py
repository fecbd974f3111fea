"""The order in which the bodies of a large model are eliminated, and the fronts that follow."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Int

MOST_OWNED = 6  # largest number of bodies that one front eliminates
WASTE = 0.3  # share of its blocks that may be zero in a front made of two
SMALL = 5  # two fronts that together have no more bodies are always joined
MANY = 100  # number of bodies from which several orders are tried
TRIES, SEED = 8, 0  # number of orders tried, with ties broken at random, and the seed
# Largest number of bodies that all tries together order: the time for one try grows faster than its bodies
MOST_TRIED = 2500


class Fronts(NamedTuple):
    """The fronts of a model in the order of elimination, children first, and all of its sheets, each in one front.

    Front k holds bodies ``body[first[k]:first[k + 1]]``, of which it eliminates the first ``owned[k]``, the last front
    none; ``onward`` is each body's place in the front that takes what is left, where the bodies are not eliminated
    before. It takes what is left of the fronts ``child[begin[k]:begin[k + 1]]``, of which the last is front k - 1, and
    the sheets ``sheet[since[k]:since[k + 1]]``, whose bodies have the places ``at_a`` and ``at_b`` in it (-1: fixed).
    """

    first: Int
    body: Int
    owned: Int
    onward: Int
    begin: Int
    child: Int
    since: Int
    sheet: Int
    at_a: Int
    at_b: Int

    @classmethod
    def of(cls, count: int, a: Int, b: Int) -> Fronts:
        """Order ``count`` bodies whose sheets are between bodies ``a`` and ``b`` (P,), -1 for fixed ones."""
        later, order = _least_work(count, a, b)
        fronts = _merged(later, order)
        place = {body: k for k, (own, _) in enumerate(fronts) for body in own}
        parent = [min((place[body] for body in rest), default=len(fronts)) for _, rest in fronts]
        fronts.append(([], set()))
        rank = np.empty(count, dtype=np.int64)
        rank[[body for own, _ in fronts for body in own]] = np.arange(count)
        slots = [
            {body: j for j, body in enumerate([*own, *sorted(rest, key=rank.__getitem__)])} for own, rest in fronts
        ]
        onward = [slots[up].get(body, -1) for slot, up in zip(slots, [*parent, -1], strict=True) for body in slot]
        children: list[list[int]] = [[] for _ in fronts]
        for k, up in enumerate(parent):
            children[up].append(k)
        sheets: list[list[tuple[int, int, int]]] = [[] for _ in fronts]
        for p, ends in enumerate(zip(a.tolist(), b.tolist(), strict=True)):
            free = [place[end] for end in ends if end >= 0]
            if free:
                slot = slots[min(free)]
                sheets[min(free)].append((p, slot.get(ends[0], -1), slot.get(ends[1], -1)))
        rows = np.array([row for own in sheets for row in own], dtype=np.int64).reshape(-1, 3)
        bodies = np.array([body for slot in slots for body in slot], dtype=np.int64)
        return cls(
            _ends(slots),
            bodies,
            np.array([len(own) for own, _ in fronts], dtype=np.int64),
            np.array(onward, dtype=np.int64),
            _ends(children),
            np.array([k for own in children for k in own], dtype=np.int64),
            _ends(sheets),
            *(np.ascontiguousarray(column) for column in rows.T),
        )


def _ends(lists: list) -> Int:  # type: ignore[type-arg]  # of any kind
    return np.concatenate([[0], np.cumsum([len(each) for each in lists])]).astype(np.int64)


def _least_work(count: int, a: Int, b: Int) -> tuple[list[set[int]], list[int]]:
    """For every body those that are eliminated later and that it is joined to by then; and the order.

    Next comes the body with the fewest neighbours, or the one that joins the fewest others, per neighbour: neither way
    is better for all models. Which of equals comes first matters as much: of eight tries on 300 boxes the best takes a
    fifth fewer products than the order of their numbers.
    """
    near: list[set[int]] = [set() for _ in range(count)]
    for one, two in zip(a.tolist(), b.tolist(), strict=True):
        if one >= 0 and two >= 0 and one != two:
            near[one].add(two)
            near[two].add(one)
    rng, ranks = np.random.default_rng(SEED), [np.arange(count)]
    tries = min(TRIES, MOST_TRIED // count) if count >= MANY else 0
    ranks += [rng.permutation(count) for _ in range(tries)]
    found = [_fewest_neighbours([set(each) for each in near])]
    found += [_least_fill([set(each) for each in near], rank.tolist()) for rank in ranks]
    return min(found, key=lambda each: sum((1 + len(later)) ** 2 for later in each[0]))


def _fewest_neighbours(near: list[set[int]]) -> tuple[list[set[int]], list[int]]:
    """One of both ways; ``near`` are all that each body is joined to, and those that come later when it returns."""
    left, order = set(range(len(near))), []
    while left:
        body = min(left, key=lambda each: (len(near[each]), each))
        left.remove(body)
        order.append(body)
        for other in near[body]:
            near[other] |= near[body]
            near[other] -= {other, body}
    return near, order


def _least_fill(near: list[set[int]], rank: list[int]) -> tuple[list[set[int]], list[int]]:
    """The other way, with the same arguments and results; ``rank`` tells which of equals comes first."""
    apart = [sum(len(own - near[other]) - 1 for other in own) // 2 for own in near]  # pairs of neighbours not joined
    price = [(apart[body] / (1 + len(near[body])), rank[body]) for body in range(len(near))]
    left, order = set(range(len(near))), []
    while left:
        body = min(left, key=price.__getitem__)
        left.remove(body)
        order.append(body)
        around = sorted(near[body])
        changed = set(around)
        for one, two in combinations(around, 2):
            if two not in near[one]:
                shared = near[one] & near[two]
                for each in shared:
                    apart[each] -= 1
                changed |= shared
                apart[one] += len(near[one]) - len(shared)
                apart[two] += len(near[two]) - len(shared)
                near[one].add(two)
                near[two].add(one)
        for other in around:
            apart[other] -= len(near[other]) - len(around)
            near[other].remove(body)
        for each in changed:
            price[each] = (apart[each] / (1 + len(near[each])), rank[each])
    return near, order


def _merged(later: list[set[int]], order: list[int]) -> list[tuple[list[int], set[int]]]:
    """Fronts of bodies that are eliminated together, with the bodies that come later, children before their parents."""
    rank = {body: k for k, body in enumerate(order)}
    parent = {body: min(later[body], key=rank.__getitem__) for body in order if later[body]}
    holds = {body: [body] for body in order}  # by the body that is eliminated last in a front
    rest = {body: set(later[body]) for body in order}
    for body in order:
        up = parent.get(body)
        if up is None or len(holds[body]) + len(holds[up]) > MOST_OWNED:
            continue
        size = len(holds[body]) + len(holds[up]) + len(rest[up])
        zero = size - len(holds[body]) - len(rest[body])
        if size <= SMALL or zero * len(holds[body]) <= WASTE * size:
            holds[up] = [*holds[body], *holds[up]]
            rest.pop(body)
    heads: dict[int, list[int]] = {}
    into = {body: head for head in rest for body in holds[head]}
    for head in rest:
        up = parent.get(head)
        heads.setdefault(-1 if up is None else into[up], []).append(head)
    found: list[tuple[list[int], set[int]]] = []
    stack = [(head, False) for head in reversed(heads.get(-1, []))]
    while stack:
        head, ready = stack.pop()
        if ready:
            found.append((holds[head], rest[head]))
        else:
            stack.append((head, True))
            stack.extend((child, False) for child in reversed(heads.get(head, [])))
    return found
