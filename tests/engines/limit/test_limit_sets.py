"""Admissible wrenches and sustainable accelerations: every promise of the two polyhedra checked by direct solves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.limit import load_sets
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit_engine import Limit
from holdfast.queries.request import push_columns
from holdfast.queries.sets import ConvexSet, admissible_wrenches, sustainable_accelerations
from holdfast.scene.shipped import shipped_scene

G = 9.81


def assembly_of(name: str) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(name))


@pytest.fixture(scope="module")
def cube_accelerations() -> ConvexSet:
    return sustainable_accelerations(assembly_of("cube"), exists=True)


@pytest.fixture(scope="module")
def cube_wrenches() -> ConvexSet:
    return admissible_wrenches(assembly_of("cube"), "cube", exists=True)


@pytest.fixture(scope="module")
def table_wrenches() -> ConvexSet:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(load_sets.BUDGET, 6, 100)  # the promises hold at any number of solves
        return admissible_wrenches(assembly_of("table"), "slab", exists=True)


def factor(state: LimitState, columns: np.ndarray, x: np.ndarray) -> Any:
    return state.solve(columns @ x)


def column_for(assembly: hf.answers.Assembly, body: str | None) -> np.ndarray:
    """Load columns (6J, d), written down independently of sets.py."""
    count = len(assembly.movable)
    if body is None:
        columns = np.zeros((count, 6, 3))
        for k, mass in enumerate(assembly.mass):
            columns[k, :3] = -mass * np.eye(3)
        return columns.reshape(6 * count, 3)
    columns = np.zeros((count, 6, 6))
    columns[assembly.index[body]] = np.eye(6)
    return columns.reshape(6 * count, 6)


def check_against_direct_solves(
    found: ConvexSet, assembly: hf.answers.Assembly, body: str | None, count: int = 200
) -> None:
    """Random points near the boundary: True stands, False moves, None lies between the bounds."""
    state, columns = Limit().prepare(assembly), column_for(assembly, body)
    rng = np.random.default_rng(1)
    seen = set()
    for _ in range(count):
        way = rng.normal(size=len(found.box)) * found.box
        exact = factor(state, columns, way)
        box_end = float((found.box / np.abs(way)).min())
        reach = min(exact.factor, box_end)
        x = reach * rng.choice([0.3, 0.9, 0.97, 1.03, 1.3]) * way
        answer = found.exists(x)
        seen.add(answer)
        share = float(np.max(found.inner[0] @ (reach * way)))
        assert (1 - found.accuracy) * (1 - 1e-6) <= 1 / share <= 1 + 1e-6, "the inner reach lies between 1 - gap and 1"
        if answer is True:
            assert exact.upper * way @ way >= x @ way * (1 - 1e-9)
            assert (np.abs(x) <= found.box * (1 + 1e-6)).all()
        if answer is False:
            assert exact.lower * way @ way <= x @ way * (1 + 1e-9)
    assert True in seen


@pytest.mark.parametrize("name", ["cube", "stack", "table", "arch", "slope", "cantilever", "tabletop"])
def test_accelerations_agree_with_direct_solves(name: str) -> None:
    assembly = assembly_of(name)
    found = sustainable_accelerations(assembly, exists=True)
    assert found.accuracy <= found.accuracy_wanted == 0.02
    check_against_direct_solves(found, assembly, None, count=60)


def test_wrenches_agree_with_direct_solves(cube_wrenches: ConvexSet, table_wrenches: ConvexSet) -> None:
    check_against_direct_solves(cube_wrenches, assembly_of("cube"), "cube")
    check_against_direct_solves(table_wrenches, assembly_of("table"), "slab")


def test_the_polyhedra_are_nested_and_the_vertices_stand(
    cube_accelerations: ConvexSet, cube_wrenches: ConvexSet, table_wrenches: ConvexSet
) -> None:
    for found in (cube_accelerations, cube_wrenches, table_wrenches):
        for A, b in (found.inner, found.outer):
            assert A.shape == (len(b), len(found.box))
            np.testing.assert_array_equal(b, 1)
        assert (found.vertices @ found.outer[0].T).max() <= 1 + 1e-9
        assert (found.vertices @ found.inner[0].T).max() <= 1 + 1e-7
        assert (np.abs(found.vertices) <= found.box * (1 + 1e-9)).all()
        assert not any(a.flags.writeable for a in (*found.inner, *found.outer, found.vertices, found.box))
        middle = (found.vertices[:-1] + found.vertices[1:]) / 2 * (1 - 1e-6)
        assert set(found.exists(middle)) == {True}
    slab, columns = assembly_of("table"), column_for(assembly_of("table"), "slab")
    state = Limit().prepare(slab)
    for vertex in table_wrenches.vertices[::10]:
        assert factor(state, columns, vertex).upper >= 1 - 1e-6


def test_the_inner_support_never_exceeds_the_outer_one(cube_accelerations: ConvexSet) -> None:
    """h(c) = max c·x over the set: of the cone a_h <= mu (g + a_z), within the box, known in closed form."""
    mu, top, least = 0.6, cube_accelerations.box[2], 1 - cube_accelerations.accuracy
    for angle in np.linspace(0, 2 * np.pi, 17):
        level = np.array([np.cos(angle), np.sin(angle), 0])
        rim = float((cube_accelerations.vertices @ level).max())
        tip = float((cube_accelerations.vertices @ (level - [0, 0, 1])).max())
        assert least * mu * (G + top) <= rim <= mu * (G + top) * (1 + 1e-9)
        assert G * (1 - 1e-5) <= tip <= G * (1 + 1e-9), "mu < 1: the tip is furthest"


def test_the_gap_in_six_dimensions_is_reported_as_it_is(cube_wrenches: ConvexSet) -> None:
    assert f"the inner set is {cube_wrenches.accuracy:.0%} too short along the ray to (" in cube_wrenches.notes[-1]
    assert cube_wrenches.accuracy_wanted == 0.05
    assert 0.05 < cube_wrenches.accuracy < 1
    assert cube_wrenches.solves == 240
    near = admissible_wrenches(assembly_of("cube"), "cube", exists=True, box=(3 * G, 3 * G * 0.1), solves=140)
    assert near.solves == 140
    assert near.accuracy < 0.8 * cube_wrenches.accuracy, "a box closer to the set leaves less between the bounds"
    np.testing.assert_allclose(near.box, np.repeat([3 * G, 0.3 * G], 3))


def test_a_push_through_the_wrench_set_is_the_push_of_a_query(table_wrenches: ConvexSet) -> None:
    """The racking push of method.md section 8, 7.3575 N, seen as a wrench on the slab."""
    assembly = assembly_of("table")
    column = push_columns(assembly, assembly.index["slab"], np.array([[-0.25, 0, 0.225]]), np.array([[1.0, 0, 0]]))
    k = 6 * assembly.index["slab"]
    wrench = column[k : k + 6, 0]
    assert table_wrenches.exists(7.3574 * wrench) is not False
    assert table_wrenches.exists(7.3576 * wrench) is not True
