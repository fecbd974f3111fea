"""Admissible wrenches and sustainable accelerations: closed forms, what holds of what exists, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.fitted import rails, row, tote
from holdfast.queries.sets import ConvexSet, admissible_wrenches, sustainable_accelerations
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81


def assembly_of(name: str) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(name))


@pytest.fixture(scope="module")
def cube_accelerations() -> ConvexSet:
    return sustainable_accelerations(assembly_of("cube"), exists=True)


@pytest.fixture(scope="module")
def cube_wrenches() -> ConvexSet:
    return admissible_wrenches(assembly_of("cube"), "cube", exists=True)


def test_a_cube_slips_at_mu_times_what_presses_it(cube_accelerations: ConvexSet) -> None:
    mu, wanted = 0.6, cube_accelerations.accuracy
    assert wanted <= 0.02
    rng = np.random.default_rng(3)
    for _ in range(200):
        rise, angle = rng.uniform(-G, 4 * G), rng.uniform(0, 2 * np.pi)
        most = mu * (G + rise)
        for share in (0.4, 0.97, 1.001, 1.2):
            a = np.array([share * most * np.cos(angle), share * most * np.sin(angle), rise])
            answer = cube_accelerations.exists(a)
            assert answer is not (share > 1), (a, share)
            if (np.abs(a) > cube_accelerations.box).any():
                assert answer is not True
    assert cube_accelerations.exists([0, 0, -G - 1e-3]) is False
    assert cube_accelerations.exists([0, 0, -G + 1e-3]) is True
    assert cube_accelerations.exists(np.zeros(3)) is True


def test_a_tall_block_topples_at_g_times_base_over_height() -> None:
    block = hf.Scene([floor(), box("tall", (0.1, 0.2, 0.4), 1, (0, 0, 0.2))], 0.9)
    found = sustainable_accelerations(hf.assemble(block), exists=True, accuracy=0.01)
    along_x, along_y = G * 0.1 / 0.4, G * 0.2 / 0.4
    for axis, most in ((0, along_x), (1, along_y)):
        for sign in (1, -1):
            a = np.zeros(3)
            a[axis] = sign * most * (1 - 1e-5)
            assert found.exists(a) is True
            a[axis] = sign * most * (1 + 1e-5)
            assert found.exists(a) is False
    # rising doubles what presses it, a pyramid with its tip at free fall
    assert found.exists([1.9 * along_x, 0, G]) is True
    assert found.exists([2.1 * along_x, 0, G]) is False
    assert found.accuracy == pytest.approx(0, abs=1e-5), "four planes and the box: found exactly"


def test_a_force_at_the_centre_of_mass_may_fill_the_translated_friction_cone(cube_wrenches: ConvexSet) -> None:
    weight, mu = G, 0.6
    rng = np.random.default_rng(5)
    certain = 0
    for _ in range(200):
        lift, angle = rng.uniform(-4 * weight, 0.99 * weight), rng.uniform(0, 2 * np.pi)
        inside = rng.choice([True, False])
        pull = mu * (weight - lift) * (rng.uniform(0, 0.999) if inside else rng.uniform(1.001, 1.5))
        answer = cube_wrenches.exists([pull * np.cos(angle), pull * np.sin(angle), lift, 0, 0, 0])
        assert answer is not (not inside)
        certain += answer is not None
    assert certain > 120
    assert cube_wrenches.exists([0, 0, 0.999999 * weight, 0, 0, 0]) is True
    assert cube_wrenches.exists([0, 0, 1.0001 * weight, 0, 0, 0]) is False
    assert cube_wrenches.exists([0, 0, 0, 0, 0.9999 * weight * 0.05, 0]) is True  # tilts about its edge
    assert cube_wrenches.exists([0, 0, 0, 0, 1.0001 * weight * 0.05, 0]) is False


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


def test_standing_loads_move_the_set() -> None:
    assembly = assembly_of("cube")
    press, push = hf.Load("cube", (0, 0, 0.1), force=(0, 0, -G)), hf.Load("cube", (0, 0, 0.05), force=(2, 0, 0))
    pressed = sustainable_accelerations(assembly, exists=True, standing=[press])
    assert pressed.exists([1.9 * 0.6 * G, 0, 0]) is not False
    assert pressed.exists([1.5 * 0.6 * G, 0, 0]) is not False
    assert pressed.exists([1.01 * G, 0, 0]) is True
    assert pressed.exists([0, 0, -1.9 * G]) is True
    shifted = admissible_wrenches(assembly, "cube", exists=True, standing=[push], solves=60)
    assert shifted.exists([0.6 * G - 2.001, 0, 0, 0, 0, 0]) is not False
    assert shifted.exists([0.6 * G - 1.999, 0, 0, 0, 0, 0]) is False
    assert shifted.exists([-0.6 * G - 1.999, 0, 0, 0, 0, 0]) is True


def test_a_set_without_end_stops_at_the_box_and_says_so() -> None:
    found = sustainable_accelerations(assembly_of("wedged"), exists=True, box=20)
    assert found.claim is hf.answers.Claim.EXISTS
    assert found.exists([19.9, -19.9, 19.9]) is True
    assert found.exists([21, 0, 0]) is None, "nothing was proved beyond the box"
    assert len(found.outer[1]) == 0
    assert any("pressed together" in note or "self-stress" in note for note in found.notes)


def test_a_light_body_beside_a_heavy_one_needs_its_own_bound() -> None:
    bodies = [
        floor(),
        box("light", (0.1, 0.1, 0.1), 1e-3, (0, 0, 0.05)),
        box("heavy", (0.1, 0.1, 0.1), 1e3, (0.3, 0, 0.05)),
    ]
    assembly = hf.assemble(hf.Scene(bodies, 0.6))
    with pytest.raises(hf.HoldfastError, match="give a smaller bound"):
        admissible_wrenches(assembly, "light", exists=True)
    weight = 1e-3 * G
    found = admissible_wrenches(assembly, "light", exists=True, box=(3 * weight, 0.3 * weight), solves=100)
    assert found.exists([0.99 * 0.6 * weight, 0, 0, 0, 0, 0]) is not False
    assert found.exists([0, 0, 0.99 * weight, 0, 0, 0]) is True
    assert found.exists([0.7 * weight, 0, 0, 0, 0, 0]) is False
    assert found.exists([0, 0, 1.05 * weight, 0, 0, 0]) is False


def test_what_has_no_set_raises() -> None:
    falling = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.6))
    with pytest.raises(hf.HoldfastError, match=r"sustainable accelerations: the assembly is unstable; unsupported"):
        sustainable_accelerations(falling, exists=True)
    with pytest.raises(hf.errors.SceneError, match="the body is fixed"):
        admissible_wrenches(assembly_of("cube"), "floor", exists=True)
    with pytest.raises(hf.errors.SceneError, match="needs True or False"):
        sustainable_accelerations(assembly_of("cube"), exists="yes")  # type: ignore[arg-type]
    with pytest.raises(hf.HoldfastError, match=r"sustainable accelerations: the assembly is unstable; unsupported"):
        sustainable_accelerations(falling)
    with pytest.raises(hf.HoldfastError, match="0 is not inside the set: nothing surely holds along"):
        sustainable_accelerations(hf.assemble(hf.Scene(cube().bodies, 0.0)))
    icy = hf.assemble(hf.Scene(cube().bodies, 0.0))
    with pytest.raises(hf.HoldfastError, match=r"0 is not inside the set: .*along \(1, 0, 0\)"):
        sustainable_accelerations(icy, exists=True)


def test_several_points_are_answered_one_by_one(cube_accelerations: ConvexSet) -> None:
    answers = cube_accelerations.exists(np.array([[0, 0, 0], [0, 0, -20.0]]))
    assert list(answers) == [True, False]
    assert list(cube_accelerations.exists(np.empty((0, 3)))) == []


def test_usage_is_the_share_of_the_reach(cube_accelerations: ConvexSet) -> None:
    found = cube_accelerations
    x = np.array([[2.0, 0, 0], [0, -3.0, 0], [0, 0, 0]])
    used = found.usage(x)
    assert used == pytest.approx(np.array([2, 3, 0]) / (0.6 * 9.81), rel=0.021)
    assert (used[:2] >= np.array([2, 3]) / (0.6 * 9.81)).all()
    assert found.usage(x[0]) == used[0]
    assert found.usage(2 * x) == pytest.approx(2 * used)


# ---- what holds


@pytest.fixture(scope="module", params=[0.0, 1e-6, 1e-4, 1e-3])
def between_rails(request: pytest.FixtureRequest) -> hf.answers.ConvexSet:
    return sustainable_accelerations(rails(request.param), solves=120)


def test_a_box_between_rails_slides_at_mu_g_whatever_could_squeeze_it(between_rails: hf.answers.ConvexSet) -> None:
    """Nothing presses the rails: along them friction is that of the tray, μ g."""
    right = 0.4 * G
    assert between_rails.claim is hf.answers.Claim.HOLDS
    for sign in (1, -1):
        assert between_rails.contains([sign * 0.85 * right, 0, 0]) is True
        for beyond in (1.001, 2.3, 250.0):
            assert between_rails.contains([sign * beyond * right, 0, 0]) is not True
    assert "checked, not proved: of 60 accelerations asked in between" in " ".join(between_rails.notes)


def test_what_exists_is_not_sold_as_safe() -> None:
    found = sustainable_accelerations(rails(), exists=True)
    assert found.claim is hf.answers.Claim.EXISTS
    assert found.exists([9.0, 0, 0]) is True
    with pytest.raises(hf.HoldfastError, match=r"need not hold; ask \.exists"):
        found.contains([9.0, 0, 0])
    assert "where an equilibrium exists" in repr(found)
    with pytest.raises(hf.HoldfastError, match="this is a set of what holds"):
        sustainable_accelerations(assembly_of("cube"), solves=20).exists([0, 0, 0])


@pytest.mark.parametrize("name", ["cube", "table", "arch", "tote", "row"])
def test_what_holds_is_within_lower(name: str) -> None:
    """At the border of the set, along directions that it was not asked: most are within ``lower``, all within force."""
    scene = {"tote": tote(5e-5), "row": row(2, 1e-4)}.get(name) or shipped_scene(name)
    found = sustainable_accelerations(scene, solves=120)
    ways = np.random.default_rng(8).normal(size=(40, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    truth = hf.transport_limits(scene, ways)
    reach = 1 / found.usage(ways)
    decided = truth.answers.decided & (truth.lower > 0)
    assert (reach[decided] <= truth.acceleration[decided] * (1 + 1e-6)).all()
    assert (reach > truth.lower * (1 + 1e-6)).mean() <= 0.1
    inside = 0.5 * (reach * ways.T).T
    assert set(found.contains(inside)) == {True}


def test_wrenches_that_hold_are_within_those_for_which_an_equilibrium_exists() -> None:
    found = admissible_wrenches(assembly_of("cube"), "cube", solves=60)
    exists = admissible_wrenches(assembly_of("cube"), "cube", solves=60, exists=True)
    assert (found.vertices @ exists.outer[0].T).max() <= 1 + 1e-6
    assert found.contains([0, 0, 1.0001 * G, 0, 0, 0]) is False
    assert found.contains([0, 0, 0.9 * G, 0, 0, 0]) is True
