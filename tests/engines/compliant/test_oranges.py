"""A ball on some of the boxes: what is said of the others is what was said without it."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import grid_of

import holdfast as hf
from bench.scenes.dense_pallet import pallet
from bench.scenes.random_pushes import columns, random_pushes
from holdfast.elastic.system import RestOutcome
from holdfast.engines.groups import prepared
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at

RADIUS, MASS = 0.04, 1e-3  # light enough that its weight changes nothing else


def with_orange(assembly: hf.answers.Assembly, under: str) -> hf.answers.Assembly:
    """The assembly with a ball on the middle of a body's top."""
    low, high = assembly.scene.body(under).box
    x, y = (low + high)[:2] / 2
    orange = hf.Body("orange", hf.Sphere(RADIUS), mass=MASS, pose=at(x, y, high[2] + RADIUS))
    return assembly.with_body(orange)


def test_pushes_on_a_pallet_are_as_hard_with_an_orange_on_it() -> None:
    """With a hold of all bodies, one in ten of such paths was lost at once and others ended where the hold carried."""
    plain = hf.assemble(pallet(4, 3, 2))
    orange = with_orange(plain, plain.movable[-1].name)
    assert orange.movable[-1].name == "orange"
    W = columns(plain, random_pushes(plain, np.random.default_rng(1), 40))
    found = prepared(hf.Compliant(), plain).load_factor(W)
    beside = prepared(hf.Compliant(), orange).load_factor(np.vstack([W, np.zeros((6, 40))]))
    assert list(beside.status) == list(found.status)
    ends = np.isfinite(found.force)
    assert 10 < ends.sum() < 40
    assert beside.force[ends] == pytest.approx(found.force[ends], rel=0.01)
    known = ends & (beside.lower > 1e-6) & (found.lower > 1e-6)  # [N] one path in 100 is lost
    assert (ends & ~known).sum() <= 2
    assert beside.lower[known] == pytest.approx(found.lower[known], rel=0.05)


def test_only_the_orange_is_held() -> None:
    assembly = with_orange(hf.assemble(shipped_scene("stack")), "cube3")
    grid = grid_of(assembly)
    assert grid.hold is not None
    assert [body.name for body, held in zip(assembly.movable, grid.hold, strict=True) if held] == ["orange"]
    held = grid.system.model.hold.reshape(-1, 6) > 0
    assert (held == grid.hold[:, None]).all()
    finer = grid.finer
    assert finer.hold is not None
    assert (finer.hold == grid.hold).all()
    loads = np.eye(6 * len(assembly.movable))
    assert (grid.loads_held(loads) == np.repeat(grid.hold, 6)).all()


def test_all_bodies_are_held_where_those_named_are_not_enough() -> None:
    assembly = with_orange(hf.assemble(shipped_scene("stack")), "cube3")
    grid = grid_of(assembly)
    assert grid.hold is not None
    wrong = grid.holding(~grid.hold)
    assert wrong.hold is not None
    assert wrong.hold.all()
    assert wrong.settled.outcome is RestOutcome.RESTS


def test_a_hold_counts_where_no_contact_resists() -> None:
    """A ball turns on its point: there the pivot of elimination is the hold's, and must not look like rounding."""
    grid = grid_of(with_orange(hf.assemble(shipped_scene("stack")), "cube3"))
    model = grid.system.model
    ball = slice(-6, None)
    pivots = (model.hold * model.unit**2)[ball]
    assert pivots.max() == pytest.approx(1.0)
    assert pivots.min() > 1e-11  # a thousand times what counts as rounding


def test_what_others_withstand_is_not_asked_of_limit_analysis_for_an_orange() -> None:
    """And loads that they hold are told by paths that go no farther than the load."""
    assembly = with_orange(hf.assemble(shipped_scene("stack")), "cube3")
    W = columns(assembly, random_pushes(assembly, np.random.default_rng(3), 30))
    grid = grid_of(assembly)
    state = hf.Compliant().prepare(assembly)
    found = state.load_factor(W)
    of_orange = grid.loads_held(W)
    assert 0 < of_orange.sum() < 30
    finite = np.isfinite(found.force) & (found.force > 0) & ~of_orange
    assert np.isinf(found.upper[finite]).all()
    held = state.held(W[:, finite] * 0.5 * found.lower[finite])
    assert held.mean() > 0.5
    assert not state.held(W[:, finite] * 1.001 * found.force[finite]).any()
