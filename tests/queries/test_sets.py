"""Admissible wrenches and sustainable accelerations: closed forms, and every promise checked by direct solves."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.limit.engine import Limit, LimitState
from holdfast.queries.request import push_columns
from holdfast.queries.sets import BUDGET, ConvexSet, admissible_wrenches, sustainable_accelerations
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81


def assembly_of(name: str) -> hf.Assembly:
    return hf.assemble(shipped_scene(name))


@pytest.fixture(scope="module")
def cube_accelerations() -> ConvexSet:
    return sustainable_accelerations(assembly_of("cube"))


@pytest.fixture(scope="module")
def cube_wrenches() -> ConvexSet:
    return admissible_wrenches(assembly_of("cube"), "cube")


@pytest.fixture(scope="module")
def table_wrenches() -> ConvexSet:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(BUDGET, 6, 100)  # the promises hold at any number of solves
        return admissible_wrenches(assembly_of("table"), "slab")


def factor(state: LimitState, columns: np.ndarray, x: np.ndarray) -> Any:
    return state.solve(columns @ x)


def column_for(assembly: hf.Assembly, body: str | None) -> np.ndarray:
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


def check_against_direct_solves(found: ConvexSet, assembly: hf.Assembly, body: str | None, count: int = 200) -> None:
    """Random points near the boundary: True stands, False moves, None lies between the bounds."""
    state, columns = Limit().prepare(assembly), column_for(assembly, body)
    rng = np.random.default_rng(1)
    seen = set()
    for _ in range(count):
        way = rng.normal(size=len(found.bound)) * found.bound
        exact = factor(state, columns, way)
        box_end = float((found.bound / np.abs(way)).min())
        reach = min(exact.factor, box_end)
        x = reach * rng.choice([0.3, 0.9, 0.97, 1.03, 1.3]) * way
        answer = found.contains(x)
        seen.add(answer)
        share = float(np.max(found.inner[0] @ (reach * way)))
        assert (1 - found.gap) * (1 - 1e-6) <= 1 / share <= 1 + 1e-6, "the inner reach lies between 1 - gap and 1"
        if answer is True:
            assert exact.upper * way @ way >= x @ way * (1 - 1e-9)
            assert (np.abs(x) <= found.bound * (1 + 1e-6)).all()
        if answer is False:
            assert exact.lower * way @ way <= x @ way * (1 + 1e-9)
    assert True in seen


def test_a_cube_slips_at_mu_times_what_presses_it(cube_accelerations: ConvexSet) -> None:
    mu, wanted = 0.6, cube_accelerations.gap
    assert wanted <= 0.02
    rng = np.random.default_rng(3)
    for _ in range(200):
        rise, angle = rng.uniform(-G, 4 * G), rng.uniform(0, 2 * np.pi)
        most = mu * (G + rise)
        for share in (0.4, 0.97, 1.001, 1.2):
            a = np.array([share * most * np.cos(angle), share * most * np.sin(angle), rise])
            answer = cube_accelerations.contains(a)
            assert answer is not (share > 1), (a, share)
            if (np.abs(a) > cube_accelerations.bound).any():
                assert answer is not True
    assert cube_accelerations.contains([0, 0, -G - 1e-3]) is False
    assert cube_accelerations.contains([0, 0, -G + 1e-3]) is True
    assert cube_accelerations.contains(np.zeros(3)) is True


def test_a_tall_block_topples_at_g_times_base_over_height() -> None:
    block = hf.Scene([floor(), box("tall", (0.1, 0.2, 0.4), 1, (0, 0, 0.2))], 0.9)
    found = sustainable_accelerations(hf.assemble(block), gap=0.01)
    along_x, along_y = G * 0.1 / 0.4, G * 0.2 / 0.4
    for axis, most in ((0, along_x), (1, along_y)):
        for sign in (1, -1):
            a = np.zeros(3)
            a[axis] = sign * most * (1 - 1e-5)
            assert found.contains(a) is True
            a[axis] = sign * most * (1 + 1e-5)
            assert found.contains(a) is False
    # rising doubles what presses it, a pyramid with its tip at free fall
    assert found.contains([1.9 * along_x, 0, G]) is True
    assert found.contains([2.1 * along_x, 0, G]) is False
    assert found.gap == pytest.approx(0, abs=1e-5), "four planes and the box: found exactly"


def test_a_force_at_the_centre_of_mass_may_fill_the_translated_friction_cone(cube_wrenches: ConvexSet) -> None:
    weight, mu = G, 0.6
    rng = np.random.default_rng(5)
    certain = 0
    for _ in range(200):
        lift, angle = rng.uniform(-4 * weight, 0.99 * weight), rng.uniform(0, 2 * np.pi)
        inside = rng.choice([True, False])
        pull = mu * (weight - lift) * (rng.uniform(0, 0.999) if inside else rng.uniform(1.001, 1.5))
        answer = cube_wrenches.contains([pull * np.cos(angle), pull * np.sin(angle), lift, 0, 0, 0])
        assert answer is not (not inside)
        certain += answer is not None
    assert certain > 120
    assert cube_wrenches.contains([0, 0, 0.999999 * weight, 0, 0, 0]) is True
    assert cube_wrenches.contains([0, 0, 1.0001 * weight, 0, 0, 0]) is False
    assert cube_wrenches.contains([0, 0, 0, 0, 0.9999 * weight * 0.05, 0]) is True  # tilts about its edge
    assert cube_wrenches.contains([0, 0, 0, 0, 1.0001 * weight * 0.05, 0]) is False


@pytest.mark.parametrize("name", ["cube", "stack", "table", "arch", "slope", "cantilever", "tabletop"])
def test_accelerations_agree_with_direct_solves(name: str) -> None:
    assembly = assembly_of(name)
    found = sustainable_accelerations(assembly)
    assert found.gap <= found.gap_wanted == 0.02
    check_against_direct_solves(found, assembly, None, count=60)


def test_wrenches_agree_with_direct_solves(cube_wrenches: ConvexSet, table_wrenches: ConvexSet) -> None:
    check_against_direct_solves(cube_wrenches, assembly_of("cube"), "cube")
    check_against_direct_solves(table_wrenches, assembly_of("table"), "slab")


def test_the_polyhedra_are_nested_and_the_vertices_stand(
    cube_accelerations: ConvexSet, cube_wrenches: ConvexSet, table_wrenches: ConvexSet
) -> None:
    for found in (cube_accelerations, cube_wrenches, table_wrenches):
        for A, b in (found.inner, found.outer):
            assert A.shape == (len(b), len(found.bound))
            np.testing.assert_array_equal(b, 1)
        assert (found.vertices @ found.outer[0].T).max() <= 1 + 1e-9
        assert (found.vertices @ found.inner[0].T).max() <= 1 + 1e-7
        assert (np.abs(found.vertices) <= found.bound * (1 + 1e-9)).all()
        assert not any(a.flags.writeable for a in (*found.inner, *found.outer, found.vertices, found.bound))
        middle = (found.vertices[:-1] + found.vertices[1:]) / 2 * (1 - 1e-6)
        assert set(found.contains(middle)) == {True}
    slab, columns = assembly_of("table"), column_for(assembly_of("table"), "slab")
    state = Limit().prepare(slab)
    for vertex in table_wrenches.vertices[::10]:
        assert factor(state, columns, vertex).upper >= 1 - 1e-6


def test_the_inner_support_never_exceeds_the_outer_one(cube_accelerations: ConvexSet) -> None:
    """h(c) = max c·x over the set: of the cone a_h <= mu (g + a_z), within the box, known in closed form."""
    mu, top, least = 0.6, cube_accelerations.bound[2], 1 - cube_accelerations.gap
    for angle in np.linspace(0, 2 * np.pi, 17):
        level = np.array([np.cos(angle), np.sin(angle), 0])
        rim = float((cube_accelerations.vertices @ level).max())
        tip = float((cube_accelerations.vertices @ (level - [0, 0, 1])).max())
        assert least * mu * (G + top) <= rim <= mu * (G + top) * (1 + 1e-9)
        assert G * (1 - 1e-5) <= tip <= G * (1 + 1e-9), "mu < 1: the tip is furthest"


def test_two_runs_are_equal_to_the_last_digit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BUDGET, 6, 80)
    first, again = (admissible_wrenches(assembly_of("arch"), "v3") for _ in range(2))
    for one, two in ((first.inner, again.inner), (first.outer, again.outer)):
        np.testing.assert_array_equal(one[0], two[0])
    np.testing.assert_array_equal(first.vertices, again.vertices)
    assert first.gap == again.gap


def test_the_gap_in_six_dimensions_is_reported_as_it_is(
    cube_wrenches: ConvexSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cube_wrenches.gap_wanted == 0.05
    assert 0.05 < cube_wrenches.gap < 1
    assert cube_wrenches.solves == 240
    monkeypatch.setitem(BUDGET, 6, 140)
    near = admissible_wrenches(assembly_of("cube"), "cube", bound=(3 * G, 3 * G * 0.1))
    assert near.gap < 0.8 * cube_wrenches.gap, "a box closer to the set leaves less between the bounds"
    np.testing.assert_allclose(near.bound, np.repeat([3 * G, 0.3 * G], 3))


def test_standing_loads_move_the_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BUDGET, 6, 60)
    assembly = assembly_of("cube")
    pressed = sustainable_accelerations(assembly, standing=[hf.Load("cube", (0, 0, 0.1), force=(0, 0, -G))])
    assert pressed.contains([1.9 * 0.6 * G, 0, 0]) is not False
    assert pressed.contains([1.5 * 0.6 * G, 0, 0]) is not False
    assert pressed.contains([1.01 * G, 0, 0]) is True
    assert pressed.contains([0, 0, -1.9 * G]) is True
    shifted = admissible_wrenches(assembly, "cube", standing=[hf.Load("cube", (0, 0, 0.05), force=(2, 0, 0))])
    assert shifted.contains([0.6 * G - 2.001, 0, 0, 0, 0, 0]) is not False
    assert shifted.contains([0.6 * G - 1.999, 0, 0, 0, 0, 0]) is False
    assert shifted.contains([-0.6 * G - 1.999, 0, 0, 0, 0, 0]) is True


def test_a_set_without_end_stops_at_the_box_and_says_so() -> None:
    found = sustainable_accelerations(assembly_of("wedged"), bound=20)
    assert found.claim is hf.Claim.EXISTS
    assert found.contains([19.9, -19.9, 19.9]) is True
    assert found.contains([21, 0, 0]) is None, "nothing was proved beyond the box"
    assert len(found.outer[1]) == 0
    assert any("pressed together" in note or "self-stress" in note for note in found.notes)


def test_a_light_body_beside_a_heavy_one_needs_its_own_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BUDGET, 6, 100)
    bodies = [
        floor(),
        box("light", (0.1, 0.1, 0.1), 1e-3, (0, 0, 0.05)),
        box("heavy", (0.1, 0.1, 0.1), 1e3, (0.3, 0, 0.05)),
    ]
    assembly = hf.assemble(hf.Scene(bodies, 0.6))
    with pytest.raises(hf.HoldfastError, match="give a smaller bound"):
        admissible_wrenches(assembly, "light")
    weight = 1e-3 * G
    found = admissible_wrenches(assembly, "light", bound=(3 * weight, 0.3 * weight))
    assert found.contains([0.99 * 0.6 * weight, 0, 0, 0, 0, 0]) is not False
    assert found.contains([0, 0, 0.99 * weight, 0, 0, 0]) is True
    assert found.contains([0.7 * weight, 0, 0, 0, 0, 0]) is False
    assert found.contains([0, 0, 1.05 * weight, 0, 0, 0]) is False


def test_a_polygon_inside_the_cone_gives_a_smaller_set() -> None:
    assembly = assembly_of("cube")
    inside = sustainable_accelerations(assembly, engine=hf.Limit(cone="inscribed", sides=6))
    exact = sustainable_accelerations(assembly)
    assert (inside.vertices @ exact.outer[0].T).max() <= 1 + 1e-9
    assert any("inscribed" in note for note in inside.notes)


def test_what_has_no_set_raises() -> None:
    falling = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.6))
    with pytest.raises(hf.HoldfastError, match=r"sustainable accelerations: the assembly is unstable; unsupported"):
        sustainable_accelerations(falling)
    with pytest.raises(hf.SceneError, match="the body is fixed"):
        admissible_wrenches(assembly_of("cube"), "floor")
    with pytest.raises(hf.SceneError, match="no body named"):
        admissible_wrenches(assembly_of("cube"), "cub")
    with pytest.raises(hf.HoldfastError, match="use engine='limit'"):
        sustainable_accelerations(assembly_of("cube"), engine="graph")
    with pytest.raises(hf.SceneError, match="needs positive numbers"):
        admissible_wrenches(assembly_of("cube"), "cube", bound=(1, 0))
    with pytest.raises(hf.SceneError, match="gap"):
        sustainable_accelerations(assembly_of("cube"), gap=0)
    icy = hf.assemble(hf.Scene(cube().bodies, 0.0))
    with pytest.raises(hf.HoldfastError, match=r"0 is not inside the set: .*along \(1, 0, 0\)"):
        sustainable_accelerations(icy)


def test_points_are_checked(cube_accelerations: ConvexSet) -> None:
    answers = cube_accelerations.contains(np.array([[0, 0, 0], [0, 0, -20.0]]))
    assert list(answers) == [True, False]
    assert list(cube_accelerations.contains(np.empty((0, 3)))) == []
    with pytest.raises(hf.SceneError, match="needs shape"):
        cube_accelerations.contains([1, 2])
    with pytest.raises(hf.SceneError, match="needs finite"):
        cube_accelerations.contains([1, 2, np.nan])


def test_a_push_through_the_wrench_set_is_the_push_of_a_query(table_wrenches: ConvexSet) -> None:
    """The racking push of method.md section 8, 7.3575 N, seen as a wrench on the slab."""
    assembly = assembly_of("table")
    column = push_columns(assembly, assembly.index["slab"], np.array([[-0.25, 0, 0.225]]), np.array([[1.0, 0, 0]]))
    k = 6 * assembly.index["slab"]
    wrench = column[k : k + 6, 0]
    assert table_wrenches.contains(7.3574 * wrench) is not False
    assert table_wrenches.contains(7.3576 * wrench) is not True


def test_the_documentation_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).parents[2] / "docs" / "sets.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(code, {})
    promised = re.findall(r"print\(.*\)\s+# (.*)", code)
    assert len(promised) == 3
    assert capsys.readouterr().out.splitlines() == promised
