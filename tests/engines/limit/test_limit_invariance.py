"""What must not change the answer, and which way friction moves it."""

import numpy as np
import pytest
from engine_scenes import X, Y, Z, block, cube, floor, moved, pose, rescaled, shipped
from limit_scenes import push_wrench, random_pushes, strength
from scipy.spatial.transform import Rotation

from holdfast import Limit, Load, Scene, assemble, load_factor
from holdfast.answers import Assembly, Interface, Patch

NAMES = ["table", "slope", "arch", "v_groove", "wall2x2"]
CLOSE = 1e-6


def answers(assembly: Assembly, queries: list) -> np.ndarray:
    W = np.column_stack([push_wrench(assembly, *query) for query in queries])
    return Limit().prepare(assembly).load_factor(W).force


def close(a: np.ndarray, b: np.ndarray) -> None:
    assert np.isfinite(b).sum() >= 3
    np.testing.assert_allclose(a, b, rtol=CLOSE)


@pytest.mark.parametrize("name", NAMES)
def test_rigid_motion_new_order_and_new_names(name: str) -> None:
    rng = np.random.default_rng(7)
    assembly = shipped(name)
    queries = random_pushes(assembly, 10, 6)
    before = answers(assembly, queries)
    motion = pose(rng.normal(size=3), Rotation.random(random_state=7).as_matrix())
    turned = [("z_" + b, motion[:3, :3] @ p + motion[:3, 3], motion[:3, :3] @ e) for b, p, e in queries]
    order = rng.permutation(len(assembly.bodies))
    close(answers(assemble(moved(assembly.scene, motion, order=order, prefix="z_")), turned), before)


@pytest.mark.parametrize("name", NAMES)
def test_interfaces_given_in_another_order_and_from_the_other_body(name: str) -> None:
    assembly = shipped(name)
    queries = random_pushes(assembly, 10, 8)
    swapped = [
        Interface(i.bodies[::-1], patches=tuple(p.flipped() for p in i.patches)) for i in assembly.interfaces[::-1]
    ]
    close(answers(assemble(assembly.scene, interfaces=swapped), queries), answers(assembly, queries))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("length", "mass"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e3), (1e3, 1e-3)])
def test_units(name: str, length: float, mass: float) -> None:
    assembly = shipped(name)
    queries = random_pushes(assembly, 6, 9)
    other = assemble(rescaled(assembly.scene, length, mass), allow_large=True)
    scaled = answers(other, [(body, length * p, e) for body, p, e in queries])
    close(scaled / mass, answers(assembly, queries))


@pytest.mark.parametrize("name", ["table", "v_groove", "wall2x2", "cube"])
def test_friction_never_harms(name: str) -> None:
    scene = shipped(name).scene
    queries = random_pushes(shipped(name), 10, 10)
    previous = np.zeros(10)
    for mu in (0.3, 0.5, 0.8, 1.2):
        now = answers(assemble(Scene(scene.bodies, mu)), queries)
        assert (now >= previous * (1 - CLOSE)).all()
        assert mu > 0.6 or np.isfinite(now).any()
        previous = now


def square(x0: float, x1: float) -> np.ndarray:
    return np.array([[x0, -0.05, 0], [x1, -0.05, 0], [x1, 0.05, 0], [x0, 0.05, 0]])


def test_splitting_a_patch_changes_nothing() -> None:
    """Corners within the hull of the patch carry nothing that its corners could not."""
    scene = cube().scene
    whole = [Interface(("floor", "cube"), square(-0.05, 0.05), Z)]
    halves = (Patch(square(-0.05, 0.01), Z), Patch(square(0.01, 0.05), Z))
    split = [Interface(("floor", "cube"), patches=halves)]
    queries = random_pushes(cube(), 20, 11)
    close(answers(assemble(scene, interfaces=split), queries), answers(assemble(scene, interfaces=whole), queries))


def test_corners_inside_the_hull_change_nothing_and_corners_lost_do() -> None:
    scene = cube().scene
    whole = square(-0.05, 0.05)
    dented = np.insert(whole, 2, [0.02, 0, 0], axis=0)
    cut = whole * (0.8, 1, 1)
    full, same, less = (assemble(scene, interfaces=[Interface(("floor", "cube"), c, Z)]) for c in (whole, dented, cut))
    queries = random_pushes(cube(), 20, 12)
    close(answers(same, queries), answers(full, queries))
    assert (answers(less, queries) <= answers(full, queries) * (1 + CLOSE)).all()
    assert strength(less, "cube", (-0.05, 0, 0.1), X) == pytest.approx(0.8 * 4.905, rel=CLOSE)


def test_a_push_may_be_split_into_wrenches_and_moved_along_its_line() -> None:
    assembly = shipped("table")
    one = [Load("slab", (0.2, -0.1, 0.225), Y)]
    two = [Load("slab", (0.2, 0.1, 0.225), 0.25 * Y), Load("slab", (0.2, 0, 0.225), 0.75 * Y)]
    com = [Load("slab", (0, 0, 0.225), Y, 0.2 * Z)]
    expected = load_factor(assembly, one, engine="limit").factor
    for loads in (two, com):
        assert load_factor(assembly, loads, engine="limit").factor == pytest.approx(expected, rel=CLOSE)


def test_bodies_that_stand_apart_do_not_feel_each_other() -> None:
    alone = answers(cube(), queries := random_pushes(cube(), 8, 13))
    beside = assemble(Scene([floor(), block("cube", (0.1, 0.1, 0.1), (0, 0, 0.05)), *others()], 0.6))
    close(answers(beside, queries), alone)


def others() -> list:
    return [
        block(f"other{k}", (0.2, 0.1, 0.1 * (k + 1)), (0.4 * (k + 1) - 0.9, 0.4, 0.05 * (k + 1)), 5) for k in range(3)
    ]
