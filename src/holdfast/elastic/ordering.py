"""The order in which the bodies of a large model are eliminated, and the fronts that follow; they are kept."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Int
from holdfast.base.memory import Memory
from holdfast.elastic.model import Elastic
from holdfast.native import core

MANY = 100  # number of bodies from which several orders are tried
TRIES, SEED = 8, 0  # number of orders tried, with ties broken at random, and the seed
# Largest number of bodies that all tries together order: the time for one try grows faster than its bodies
MOST_TRIED = 2500
_KNOWN = Memory(20_000)  # sheets of models whose fronts are kept


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
        """Order ``count`` bodies whose sheets are between bodies ``a`` and ``b`` (P,), -1 for fixed ones.

        Of large models several orders are tried (native/ordering.hpp), and that which takes the fewest products counts.
        """
        rng, ranks = np.random.default_rng(SEED), [np.arange(count)]
        tries = min(TRIES, MOST_TRIED // count) if count >= MANY else 0
        ranks += [rng.permutation(count) for _ in range(tries)]
        return cls(*core.order_fronts(count, a, b, np.array(ranks)))


def fronts_of(m: Elastic) -> Fronts:
    """Order the bodies of a model, and say what each front takes; what was found for other nodes is taken again."""
    count = len(m.wrench) // 6
    return _KNOWN.recalled((count, m.a.tobytes(), m.b.tobytes()), len(m.a), lambda: Fronts.of(count, m.a, m.b))
