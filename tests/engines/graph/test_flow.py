"""Slip through the assembly: maximum flow, minimum cut, series and parallel (eq. 21-22, Fig. 7)."""

import networkx as nx
import numpy as np
import pytest
from engine_scenes import X, Z, block, floor
from graph_scenes import pair_friction, push

from holdfast import Scene, assemble, robustness
from holdfast.native import core
from holdfast.scene.shipped import shipped_scene


def random_network(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    count, arcs = int(rng.integers(2, 9)), int(rng.integers(1, 18))
    tails = rng.integers(count, size=arcs)
    heads = (tails + rng.integers(1, count, size=arcs)) % count
    capacity = rng.uniform(0, 10, size=(arcs, 2))
    kind = rng.uniform(size=(arcs, 2))
    capacity[kind < 0.2] = np.inf
    capacity[kind > 0.85] = 0
    return tails, heads, capacity, count


def flow_by_networkx(tails: np.ndarray, heads: np.ndarray, capacity: np.ndarray, count: int) -> float:
    graph = nx.DiGraph()
    graph.add_nodes_from(range(count))
    for tail, head, (there, back) in zip(tails.tolist(), heads.tolist(), capacity.tolist(), strict=True):
        for a, b, room in ((tail, head, there), (head, tail, back)):
            total = graph.get_edge_data(a, b, {"capacity": 0.0})["capacity"] + room
            graph.add_edge(a, b, capacity=total)
    for _, _, data in graph.edges(data=True):
        if np.isinf(data["capacity"]):
            del data["capacity"]
    try:
        return float(nx.maximum_flow_value(graph, 0, count - 1))
    except nx.NetworkXUnbounded:
        return float("inf")


def test_flow_and_minimum_cut_of_random_networks() -> None:
    rng = np.random.default_rng(22)
    infinite = 0
    for _ in range(400):
        tails, heads, capacity, count = random_network(rng)
        side = np.zeros(count, dtype=bool)
        flow = core.max_flow(tails, heads, capacity, 0, count - 1, count, side)
        assert flow == pytest.approx(flow_by_networkx(tails, heads, capacity, count), rel=1e-9, abs=1e-9)
        if np.isinf(flow):
            infinite += 1
            continue
        assert side[0]
        assert not side[-1]
        leaving = capacity[side[tails] & ~side[heads], 0].sum() + capacity[side[heads] & ~side[tails], 1].sum()
        assert leaving == pytest.approx(flow, rel=1e-9, abs=1e-9)
    assert 40 < infinite < 360


def test_a_flow_sent_the_short_way_is_taken_back() -> None:
    """The shortest path 0-1-2-7 blocks two longer ones; they need part of it reversed."""
    arcs = [(0, 1), (1, 2), (2, 7), (1, 3), (3, 4), (4, 7), (0, 5), (5, 6), (6, 2)]
    tails, heads = np.array(arcs).T
    capacity = np.column_stack([np.ones(len(arcs)), np.zeros(len(arcs))])
    side = np.zeros(8, dtype=bool)
    assert core.max_flow(np.ascontiguousarray(tails), np.ascontiguousarray(heads), capacity, 0, 7, 8, side) == 2


@pytest.mark.parametrize("body", ["cube1", "cube2", "cube3"])
def test_pressing_on_a_cube_of_a_stack_is_infinite(body: str) -> None:
    """On undirected edges the cube's own pull-off force of 9.81 N would cap it."""
    top = {"cube1": 0.1, "cube2": 0.2, "cube3": 0.3}[body]
    assert push(assemble(shipped_scene("stack")), body, (0.01, 0, top), -Z) == np.inf


def test_interfaces_in_series_take_the_weakest() -> None:
    """Fig. 7a: tile3 (1 kg) on tile2 (2 kg) on tile1 (4 kg)."""
    mu = {("tile2", "tile3"): 0.9, ("tile1", "tile2"): 0.2, ("floor", "tile1"): 0.5}
    tiles = [block(f"tile{k + 1}", (0.2, 0.2, 0.01), (0, 0, 0.005 + 0.01 * k), m) for k, m in enumerate((4, 2, 1))]
    assembly = assemble(Scene([floor(), *tiles], pair_friction(mu)))
    weakest_below = {3: min(0.9 * 1, 0.2 * 3, 0.5 * 7), 2: min(0.2 * 3, 0.5 * 7), 1: 0.5 * 7}
    for k, expected in weakest_below.items():
        assert push(assembly, f"tile{k}", (0.1, 0, 0.01 * k - 0.005), -X) == pytest.approx(9.81 * expected)


def test_interfaces_in_parallel_add_up() -> None:
    """Fig. 7b: a slab on two fixed legs of different friction carries mu1 N/2 + mu2 N/2."""
    legs = [block(name, (0.1, 0.2, 0.1), (x, 0, 0.05), fixed=True) for name, x in (("left", -0.3), ("right", 0.3))]
    slab = block("slab", (0.7, 0.2, 0.02), (0, 0, 0.11), 3)
    assembly = assemble(Scene([*legs, slab], pair_friction({("left", "slab"): 0.2, ("right", "slab"): 0.8})))
    assert push(assembly, "slab", (-0.35, 0, 0.11), X) == pytest.approx(3 * 9.81 * (0.2 + 0.8) / 2)


def test_who_slides_is_told() -> None:
    assembly = assemble(shipped_scene("table"))
    answer = robustness(assembly, "slab", (-0.25, 0, 0.225), X, engine="graph")
    assert (answer.moving[0], answer.mode[0]) == (("slab",), "slip")
    # a leg's friction on the floor and that under the slab act in parallel
    assert push(assembly, "leg_left", (-0.2, 0, 0.001), X) == pytest.approx(0.5 * 9.81 * (1 + 1) + 0.5 * 9.81 * 1)
