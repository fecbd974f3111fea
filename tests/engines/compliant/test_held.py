"""Which loads are held, told by paths that go no farther than the load: never what full answers deny."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.groups import prepared
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize(("name", "body"), [("stack", "cube2"), ("table", "slab"), ("cantilever", "B")])
def test_what_is_held_is_below_the_full_answer_and_most_below_it_is_held(name: str, body: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    cells = exposed_cells(assembly, body, 0.03)[0]
    W = push_columns(assembly, assembly.index[body], cells.points, -cells.normals)
    asked = prepared(hf.Compliant(), assembly)
    found = asked.load_factor(W)
    finite = np.flatnonzero(np.isfinite(found.force) & (found.force > 0))
    W, force, lower = W[:, finite], found.force[finite], found.lower[finite]
    assert not asked.held(W * force * 1.001).any()
    assert asked.held(W * lower * 0.5).mean() > 0.5
    assert asked.held(0 * W).all()
