"""Admissible wrenches and sustainable accelerations: closed forms, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.limit.load_sets import BUDGET
from holdfast.queries.sets import ConvexSet, admissible_wrenches, sustainable_accelerations
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81


def assembly_of(name: str) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(name))


@pytest.fixture(scope="module")
def cube_accelerations() -> ConvexSet:
    return sustainable_accelerations(assembly_of("cube"))


@pytest.fixture(scope="module")
def cube_wrenches() -> ConvexSet:
    return admissible_wrenches(assembly_of("cube"), "cube")


def test_a_cube_slips_at_mu_times_what_presses_it(cube_accelerations: ConvexSet) -> None:
    mu, wanted = 0.6, cube_accelerations.accuracy
    assert wanted <= 0.02
    rng = np.random.default_rng(3)
    for _ in range(200):
        rise, angle = rng.uniform(-G, 4 * G), rng.uniform(0, 2 * np.pi)
        most = mu * (G + rise)
        for share in (0.4, 0.97, 1.001, 1.2):
            a = np.array([share * most * np.cos(angle), share * most * np.sin(angle), rise])
            answer = cube_accelerations.contains(a)
            assert answer is not (share > 1), (a, share)
            if (np.abs(a) > cube_accelerations.box).any():
                assert answer is not True
    assert cube_accelerations.contains([0, 0, -G - 1e-3]) is False
    assert cube_accelerations.contains([0, 0, -G + 1e-3]) is True
    assert cube_accelerations.contains(np.zeros(3)) is True


def test_a_tall_block_topples_at_g_times_base_over_height() -> None:
    block = hf.Scene([floor(), box("tall", (0.1, 0.2, 0.4), 1, (0, 0, 0.2))], 0.9)
    found = sustainable_accelerations(hf.assemble(block), accuracy=0.01)
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
    assert found.accuracy == pytest.approx(0, abs=1e-5), "four planes and the box: found exactly"


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


@pytest.mark.parametrize("dimension", [3, 6])
def test_the_inner_part_lies_within_what_was_solved(
    dimension: int, cube_accelerations: ConvexSet, cube_wrenches: ConvexSet
) -> None:
    """Each of its facets goes through as many solved points as there are dimensions, or runs inside of them."""
    found = cube_accelerations if dimension == 3 else cube_wrenches
    A, b = found.inner
    reach = np.sort(A @ found.vertices.T / b[:, None], axis=1)[:, -dimension]
    assert (reach >= 1 - 1e-14).all()
    assert reach.max() <= 1 + 1e-4


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
    found = sustainable_accelerations(assembly_of("wedged"), box=20)
    assert found.claim is hf.answers.Claim.EXISTS
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
    found = admissible_wrenches(assembly, "light", box=(3 * weight, 0.3 * weight))
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
    with pytest.raises(hf.errors.SceneError, match="the body is fixed"):
        admissible_wrenches(assembly_of("cube"), "floor")
    with pytest.raises(hf.errors.SceneError, match="no body named"):
        admissible_wrenches(assembly_of("cube"), "cub")
    with pytest.raises(hf.HoldfastError, match="use engine='limit'"):
        sustainable_accelerations(assembly_of("cube"), engine="graph")
    with pytest.raises(hf.errors.SceneError, match="needs positive numbers"):
        admissible_wrenches(assembly_of("cube"), "cube", box=(1, 0))
    with pytest.raises(hf.errors.SceneError, match="accuracy"):
        sustainable_accelerations(assembly_of("cube"), accuracy=0)
    icy = hf.assemble(hf.Scene(cube().bodies, 0.0))
    with pytest.raises(hf.HoldfastError, match=r"0 is not inside the set: .*along \(1, 0, 0\)"):
        sustainable_accelerations(icy)


def test_points_are_checked(cube_accelerations: ConvexSet) -> None:
    answers = cube_accelerations.contains(np.array([[0, 0, 0], [0, 0, -20.0]]))
    assert list(answers) == [True, False]
    assert list(cube_accelerations.contains(np.empty((0, 3)))) == []
    with pytest.raises(hf.errors.SceneError, match="needs shape"):
        cube_accelerations.contains([1, 2])
    with pytest.raises(hf.errors.SceneError, match="needs finite"):
        cube_accelerations.contains([1, 2, np.nan])


def test_usage_is_the_share_of_the_reach(cube_accelerations: ConvexSet) -> None:
    found = cube_accelerations
    x = np.array([[2.0, 0, 0], [0, -3.0, 0], [0, 0, 0]])
    used = found.usage(x)
    assert used == pytest.approx(np.array([2, 3, 0]) / (0.6 * 9.81), rel=0.021)
    assert (used[:2] >= np.array([2, 3]) / (0.6 * 9.81)).all()
    assert found.usage(x[0]) == used[0]
    assert found.usage(2 * x) == pytest.approx(2 * used)
