"""A planner's constraint: never above single solves, close to them, with a derivative, and the same everywhere."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.scenes.shelf import shelf
from holdfast.engines.groups import prepared
from holdfast.engines.limit_engine import Limit
from holdfast.queries.constraint import inward_pushes
from holdfast.queries.request import engine_of
from holdfast.queries.sets import wrench_columns
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor

G = 9.81


@pytest.fixture(scope="module")
def cube() -> hf.answers.Constraint:
    return hf.sets.constraint(shipped_scene("cube"), "cube", exists=True, solves=400)


@pytest.fixture(scope="module", params=[("cube", "cube"), ("table", "slab"), ("arch", "v3")])
def asked(request: pytest.FixtureRequest) -> tuple[hf.answers.Assembly, hf.answers.Constraint]:
    name, body = request.param
    assembly = hf.assemble(shipped_scene(name))
    return assembly, hf.sets.constraint(assembly, body, exists=True, solves=500)


def drawn(found: hf.answers.Constraint, count: int, seed: int = 7) -> np.ndarray:
    """Wrenches (n, 6) anywhere, of the sizes that the body can take along the axes."""
    factors = np.minimum(np.asarray(found.value(np.eye(6))), found.box)
    return np.asarray(np.random.default_rng(seed).normal(size=(count, 6)) * factors)


def true(assembly: hf.answers.Assembly, body: str, wrenches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors (n,) and upper bounds (n,) by one solve each, on the whole assembly."""
    W = np.zeros((6 * len(assembly.movable), len(wrenches)))
    first = 6 * assembly.index[body]
    W[first : first + 6] = wrenches.T
    found = Limit().prepare(assembly).load_factor(W)
    return found.force, found.upper


def test_it_is_never_above_single_solves_and_mostly_close(
    asked: tuple[hf.answers.Assembly, hf.answers.Constraint],
) -> None:
    assembly, found = asked
    wrenches = drawn(found, 60)
    value = np.asarray(found.value(wrenches))
    factor, upper = true(assembly, found.body, wrenches)
    assert (value <= upper * (1 + 1e-12)).all()
    assert (value <= factor * (1 + 1e-6)).all()
    finite = np.isfinite(factor)
    assert np.median(1 - value[finite] / factor[finite]) < 0.12


def test_the_cut_is_a_row_that_bounds_every_usage_from_below(
    asked: tuple[hf.answers.Assembly, hf.answers.Constraint],
) -> None:
    _, found = asked
    wrenches = drawn(found, 30)
    usage, cut = np.asarray(found.usage(wrenches)), found.cut(wrenches)
    np.testing.assert_allclose((cut * wrenches).sum(1), usage, rtol=1e-8, atol=1e-10)
    assert (wrenches @ cut.T <= usage[:, None] + 1e-8).all()


def test_the_gradient_is_that_of_differences(asked: tuple[hf.answers.Assembly, hf.answers.Constraint]) -> None:
    _, found = asked
    step = 1e-7
    for w in drawn(found, 12):
        towards = drawn(found, 1, seed=3)[0]
        ahead, behind = (float(found.value(w + sign * step * towards)) for sign in (1, -1))
        middle = float(found.value(w))
        if not np.isclose(ahead - middle, middle - behind, rtol=1e-3, atol=0):
            continue  # a kink within the step
        assert (ahead - behind) / (2 * step) == pytest.approx(found.gradient(w) @ towards, rel=1e-4)


def test_the_usage_is_a_gauge(cube: hf.answers.Constraint) -> None:
    """Homogeneous and convex, as the true one: the middle of two wrenches uses at most the mean."""
    a, b = drawn(cube, 50), drawn(cube, 50, seed=8)
    np.testing.assert_allclose(cube.usage(3 * a), 3 * np.asarray(cube.usage(a)), rtol=1e-9)
    assert (np.asarray(cube.usage((a + b) / 2)) <= (np.asarray(cube.usage(a)) + cube.usage(b)) / 2 + 1e-9).all()


@pytest.mark.parametrize(
    ("wrench", "force"),
    [
        ((1, 0, 0, 0, 0, 0), 0.6 * G),  # slides: at the centre it would tip at m g
        ((0, 0, 1, 0, 0, 0), G),  # lifts off
        ((0, 0, 0, 0, 1, 0), G * 0.05),  # tips about an edge
        ((1, 0, 0, 0, 0.05, 0), G / 2),  # pushed at the upper edge: tips
    ],
)
def test_closed_forms_of_a_cube(cube: hf.answers.Constraint, wrench: tuple[float, ...], force: float) -> None:
    assert force * 0.98 <= float(cube.value(wrench)) <= force * (1 + 1e-9)


def test_pressing_down_is_free_as_far_as_the_box(cube: hf.answers.Constraint) -> None:
    assert float(cube.value((0, 0, -1, 0, 0, 0))) >= cube.box[2]
    assert float(cube.value(np.zeros(6))) == np.inf
    assert not cube.gradient(np.zeros(6)).any()


def test_wrenches_of_forces_at_points_are_those_of_pushes(cube: hf.answers.Constraint) -> None:
    """A push on the left face at (x, y, z) along x: torque (0, z F, -y F) about the centre."""
    found = cube.wrenches([(-0.05, 0.02, 0.08), (-0.05, 0.02, 0.02)], (2.0, 0, 0))
    np.testing.assert_allclose(found, [(2, 0, 0, 0, 0.06, -0.04), (2, 0, 0, 0, -0.06, -0.04)], atol=1e-15)
    push = hf.robustness(shipped_scene("cube"), "cube", (-0.05, 0.02, 0.08), (1, 0, 0), engine="limit")
    assert 0.95 * push.force[0] <= float(cube.value(found[0] / 2)) <= push.upper[0]


def test_wrenches_near_those_asked_for_are_closer() -> None:
    scene = shipped_scene("arch")
    blind = hf.sets.constraint(scene, "v3", exists=True, solves=120)
    near = drawn(blind, 5, seed=11)
    told = hf.sets.constraint(scene, "v3", exists=True, solves=120, near=near)
    assert np.median(np.asarray(told.value(near)) / blind.value(near)) > 1.02


def test_unless_told_it_is_close_to_inward_pushes_on_the_surface() -> None:
    """Of a pyramid's surface √2 / (1 + √2) slants: pushes there lead down, those on its base up; they lean somewhat."""
    corners = np.array([(x, y, 0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)] + [(0, 0, 0.1)])
    faces = [(0, 1, 3), (0, 3, 2), (0, 2, 4), (2, 3, 4), (3, 1, 4), (1, 0, 4)]
    pyramid = hf.Body("pyramid", hf.Mesh(corners, np.array(faces)), mass=1.0)
    assembly = hf.assemble(hf.Scene([floor(), pyramid], 0.6))
    pushes = inward_pushes(assembly, "pyramid", assembly.com[0])
    assert (pushes[:, 2] < 0).mean() == pytest.approx(2**0.5 / (1 + 2**0.5), abs=0.06)
    assert np.linalg.norm(pushes[:, :3], axis=1).mean() == pytest.approx(1.09, abs=0.05)
    asked = {"exists": True, "solves": 40}
    usual, told = (hf.sets.constraint(assembly, "pyramid", near=near, **asked) for near in (None, pushes))
    np.testing.assert_array_equal(usual.known, told.known)


def test_the_gap_is_that_of_single_solves() -> None:
    """Measured by cuts, without further solves, it bounds what half and nine in ten wrenches of its kinds miss."""
    assembly = hf.assemble(shipped_scene("table"))
    found = hf.sets.constraint(assembly, "slab", exists=True, solves=150)
    wrenches = drawn(found, 120)
    short = 1 - np.asarray(found.value(wrenches)) / true(assembly, "slab", wrenches)[0]
    assert 0.25 * found.accuracy < np.median(short) < 1.5 * found.accuracy
    assert 0.25 * found.accuracy_of_most < np.quantile(short, 0.9) < 1.5 * found.accuracy_of_most
    closer = hf.sets.constraint(assembly, "slab", exists=True, accuracy=2 * found.accuracy)
    assert closer.accuracy <= 2 * found.accuracy
    assert closer.accuracy_of_most <= 6 * found.accuracy
    assert closer.solves < found.solves


def test_standing_loads_count(cube: hf.answers.Constraint) -> None:
    """Pressed down by its own weight again, the cube takes twice as much from the side."""
    pressed = hf.Load("cube", (0, 0, 0.1), force=(0, 0, -G))
    found = hf.sets.constraint(shipped_scene("cube"), "cube", exists=True, solves=400, standing=[pressed])
    w = (1, 0, 0, 0, 0, 0)
    assert float(found.value(w)) == pytest.approx(2 * float(cube.value(w)), rel=0.02)


def test_it_turns_with_the_scene() -> None:
    """Turned and moved, bound and wrenches along, a constraint from enough solves is as close to the same truth."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec((0.3, -0.5, 0.8)).as_matrix()
    turn[:3, 3] = 1, 2, 3
    scene = shipped_scene("cube")
    turned = hf.Scene(
        [b.moved(turn @ (np.eye(4) if b.pose is None else b.pose)) for b in scene.bodies],
        scene.friction,
        gravity=turn[:3, :3] @ scene.gravity,
    )
    here, there = (hf.sets.constraint(one, "cube", exists=True, solves=400) for one in (scene, turned))
    wrenches = drawn(here, 40)
    R = turn[:3, :3]
    moved = np.hstack([wrenches[:, :3] @ R.T, wrenches[:, 3:] @ R.T])
    np.testing.assert_allclose(np.median(np.asarray(there.value(moved)) / here.value(wrenches)), 1, atol=0.02)


def test_the_same_question_has_the_same_answer_to_the_last_digit(cube: hf.answers.Constraint) -> None:
    assert hf.sets.constraint(shipped_scene("cube"), "cube", exists=True, solves=400) == cube


@pytest.fixture(scope="module", params=["cube", "tin"])
def firm(request: pytest.FixtureRequest) -> tuple[hf.answers.Assembly, hf.answers.Constraint]:
    """Of ``compliant``: a cube on a plane, and a tin under another on a shelf of eight things with an orange."""
    assembly = hf.assemble(shipped_scene("cube") if request.param == "cube" else shelf())
    return assembly, hf.sets.constraint(assembly, request.param, solves=512)


def test_where_compliant_was_asked_its_lower_is_kept(
    firm: tuple[hf.answers.Assembly, hf.answers.Constraint],
) -> None:
    """Known wrenches are as they were asked, whatever combination of others is cheaper."""
    assembly, found = firm
    wrenches = found.known[:: len(found.known) // 60]
    W = wrench_columns(assembly, found.body, "known") @ wrenches.T
    lower = prepared(engine_of("compliant"), assembly).load_factor(W).lower
    assert (np.asarray(found.value(wrenches)) <= lower * (1 + 1e-6)).all()  # a path of another scale differs by so much


def test_the_share_above_lower_in_between_is_told(firm: tuple[hf.answers.Assembly, hf.answers.Constraint]) -> None:
    assembly, found = firm
    wrenches = np.vstack([drawn(found, 100), inward_pushes(assembly, found.body, found.com)[::40]])
    W = wrench_columns(assembly, found.body, "drawn") @ wrenches.T
    lower = prepared(engine_of("compliant"), assembly).load_factor(W).lower
    share = float((np.asarray(found.value(wrenches)) > lower).mean())
    assert 0 < found.above < 0.12
    assert share < 2 * found.above + 0.02
    assert str(found.claim) == "holds"


def test_closed_forms_of_a_cube_that_rests() -> None:
    """With pushes near those asked for, the least of sliding and tipping, from below, as ``compliant`` gives them."""
    near = [(1, 0, 0, 0, 0.05 * k / 10, 0) for k in range(-10, 11)]
    found = hf.sets.constraint(shipped_scene("cube"), "cube", solves=300, near=near)
    for w, force in [((1, 0, 0, 0, 0, 0), 0.6 * G), ((0, 0, 1, 0, 0, 0), G), ((1, 0, 0, 0, 0.05, 0), G / 2)]:
        assert 0.85 * force <= float(found.value(w)) <= force * (1 + 1e-9)


def test_what_cannot_be_constrained_is_refused() -> None:
    ball = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0, 0, 0.04))
    with pytest.raises(hf.HoldfastError, match="constraint on 'orange': 0 is not inside the set"):
        hf.sets.constraint(hf.Scene([floor(), ball], 0.5), "orange")
    hanging = box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))
    with pytest.raises(hf.HoldfastError, match="constraint on 'cube': the assembly is unstable"):
        hf.sets.constraint(hf.Scene([floor(), hanging], 0.5), "cube")
    with pytest.raises(hf.errors.SceneError, match="the body is fixed"):
        hf.sets.constraint(shipped_scene("cube"), "floor")
    with pytest.raises(hf.HoldfastError, match="constraint on 'orange': 0 is not inside the set"):
        hf.sets.constraint(hf.Scene([floor(), ball], 0.5), "orange", exists=True)
    found = hf.sets.constraint(shipped_scene("cube"), "cube", solves=20)
    with pytest.raises(hf.HoldfastError, match="2 points and 3 forces"):
        found.wrenches(np.zeros((2, 3)), np.ones((3, 3)))
