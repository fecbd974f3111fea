"""Feasible cuts: every connected set with a connected complement, once (Sec. V-C1)."""

import itertools
import time

import networkx as nx
import numpy as np
import pytest

from holdfast import Graph, assemble, robustness
from holdfast.engines.graph.cuts import feasible_cuts
from holdfast.errors import SolverError
from holdfast.scene.shipped import shipped_scene


def by_brute_force(count: int, edges: list[tuple[int, int]]) -> list[int]:
    graph = nx.Graph(edges)
    graph.add_nodes_from(range(count))
    sets = itertools.chain.from_iterable(itertools.combinations(range(count - 1), k) for k in range(1, count))
    return sorted(
        sum(1 << k for k in chosen)
        for chosen in sets
        if nx.is_connected(graph.subgraph(chosen)) and nx.is_connected(graph.subgraph(set(graph) - set(chosen)))
    )


def random_connected(rng: np.random.Generator, count: int) -> list[tuple[int, int]]:
    label = rng.permutation(count)
    tree = [(int(label[k]), int(label[rng.integers(k)])) for k in range(1, count)]
    pairs = list(itertools.combinations(range(count), 2))
    more = rng.integers(len(pairs), size=int(rng.integers(0, 2 * count)))
    return tree + [pairs[k] for k in more]


@pytest.mark.parametrize("count", range(2, 10))
def test_each_cut_of_a_random_graph_exactly_once(count: int) -> None:
    rng = np.random.default_rng(count)
    for _ in range(12):
        edges = random_connected(rng, count)
        assert sorted(feasible_cuts(count, edges, limit=10_000)) == by_brute_force(count, edges), edges


def test_the_limit_is_inclusive() -> None:
    complete = list(itertools.combinations(range(5), 2))
    assert len(feasible_cuts(5, complete, limit=15)) == 15
    with pytest.raises(SolverError):
        feasible_cuts(5, complete, limit=14)


def test_too_many_cuts_fail_quickly_with_a_remedy() -> None:
    assembly = assemble(shipped_scene("bonded_wall"))
    started = time.perf_counter()
    with pytest.raises(SolverError, match=r"50 movable bodies.*2,000 feasible cuts.*immobile_above.*max_cuts"):
        robustness(assembly, "b0_0", (-0.5, 0, 0.05), (1, 0, 0), engine=Graph(max_cuts=2000))
    assert time.perf_counter() - started < 5
