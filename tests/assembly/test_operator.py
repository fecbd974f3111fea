"""The equilibrium operator, whole, dense and without a matrix."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.contact_nodes import (
    by_bodies,
    contact_nodes,
    dense_by_bodies,
    equilibrium_blocks,
    equilibrium_operator,
    wrenches_of,
)
from holdfast.engines.compliant.places import Places
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize("name", ["wall2x2", "arch", "v_groove"])
def test_all_ways_to_apply_the_operator_agree(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    nodes = contact_nodes(assembly, 9, "quadrature")
    G, blocks = equilibrium_operator(assembly, nodes), equilibrium_blocks(assembly, nodes)
    count = len(assembly.movable)
    assert np.array_equal(dense_by_bodies(count, nodes, blocks), G.toarray())
    assert np.array_equal(by_bodies(count, nodes, blocks).toarray(), G.toarray())
    rng = np.random.default_rng(2)
    forces = rng.standard_normal((len(nodes), 3))
    assert np.allclose(wrenches_of(assembly, nodes, forces), G @ forces.ravel(), rtol=0, atol=1e-12)
    twists = rng.standard_normal((8, 6 * count))
    places = Places.at(assembly, nodes)
    expected = (G.T @ twists.T).T.reshape(8, len(nodes), 3)
    for some in (twists, twists[:-1]):
        assert np.allclose(places.velocities(some), expected[: len(some)], rtol=0, atol=1e-12)
