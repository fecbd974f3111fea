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
from holdfast.engines.compliant.elastic_model import Places
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


@pytest.mark.parametrize("name", ["wall2x2", "arch", "v_groove"])
def test_a_force_acts_on_the_second_body_and_its_reaction_on_the_first(name: str) -> None:
    """By hand, force by force: torques are arm x force about the centres of mass."""
    assembly = hf.assemble(shipped_scene(name))
    nodes = contact_nodes(assembly, 4, "corners")
    G, rng = equilibrium_operator(assembly, nodes), np.random.default_rng(5)
    names = [None if body.fixed else body.name for body in assembly.bodies]
    for k in rng.integers(len(nodes), size=12):
        local = rng.standard_normal(3)
        forces = np.zeros((len(nodes), 3))
        forces[k] = local
        world = local @ nodes.axes[k]
        wrenches = {body: np.zeros(6) for body in names if body}
        first, second = assembly.interfaces[nodes.interface[k]].bodies
        for body, sign in ((first, -1.0), (second, 1.0)):
            if body in wrenches:
                arm = nodes.points[k] - assembly.scene.body(body).com_world
                wrenches[body] += sign * np.concatenate([world, np.cross(arm, world)])
        expected = np.concatenate([wrenches[body.name] for body in assembly.movable])
        np.testing.assert_allclose(G @ forces.ravel(), expected, atol=1e-12)
