"""Which loads are held, told by paths that go no farther than the load: never what full answers deny."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import grid_of
from engine_scenes import by_paths

import holdfast as hf
from bench.scenes.dense_pallet import pallet
from bench.scenes.random_pushes import columns, random_pushes
from holdfast.engines.groups import prepared
from holdfast.queries.map import exposed_cells
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize(("name", "body"), [("stack", "cube2"), ("table", "slab"), ("cantilever", "B")])
def test_what_is_held_is_below_the_full_answer_and_most_below_it_is_held(name: str, body: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    cells = exposed_cells(assembly, body, 0.03)[0]
    W = push_columns(assembly, assembly.index[body], cells.points, -cells.normals)
    asked = prepared(by_paths(assembly), assembly)
    found = asked.load_factor(W)
    finite = np.flatnonzero(np.isfinite(found.force) & (found.force > 0))
    W, force, lower = W[:, finite], found.force[finite], found.lower[finite]
    assert not asked.held(W * force * 1.001).any()
    assert asked.held(W * lower * 0.5).mean() > 0.5
    doubtful = lower < 0.96 * force  # a path leads to these loads, and a finer grid tells that it leads too far
    assert name == "stack" or doubtful.sum() > 3
    assert not asked.held(W * (lower + force / 1.03) / 2)[doubtful].any()
    assert asked.held(0 * W).all()


def test_loads_are_held_where_forces_have_gathered_on_few_nodes() -> None:
    """As under most boxes of a pallet once they are pushed: more nodes at those contacts tell what they hold."""
    assembly = hf.assemble(pallet(4, 3, 2))
    W = columns(assembly, random_pushes(assembly, np.random.default_rng(4), 60, slant=30))
    asked = prepared(by_paths(assembly), assembly)
    found = asked.load_factor(W)
    finite = np.isfinite(found.force) & (found.force > 0)
    W, force, lower = W[:, finite], found.force[finite], found.lower[finite]
    grid = grid_of(assembly)
    reached = grid.paths(W * 0.5 * lower, most=1.0)
    gathered = grid.concentrated(reached.q).any(1)
    assert gathered.sum() > 5
    assert asked.held(W * 0.5 * lower)[gathered].mean() > 0.5
    assert not asked.held(W * force * 1.001).any()
