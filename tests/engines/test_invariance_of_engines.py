"""What must not change the answer, and which way friction moves it."""

import numpy as np
import pytest
from engine_scenes import X, Y, Z, cube, moved, pose, push_wrench, random_pushes, rescaled, shipped
from scipy.spatial.transform import Rotation

from holdfast import Graph, Limit, Load, Scene, assemble, load_factor
from holdfast.answers import Assembly, Interface, Patch
from holdfast.plugins import Engine

NAMES = ["table", "slope", "arch", "v_groove", "wall2x2"]
CLOSE = 1e-6
LIMIT, CORNERS = Limit(), Graph(sampling="corners")  # at corners, the placing of nodes has no part in answers
both = pytest.mark.parametrize("engine", [LIMIT, CORNERS], ids=["limit", "graph"])


def answers(assembly: Assembly, queries: list, engine: Engine = LIMIT) -> np.ndarray:
    W = np.column_stack([push_wrench(assembly, *query) for query in queries])
    return engine.prepare(assembly).load_factor(W).force


def close(a: np.ndarray, b: np.ndarray, engine: Engine = LIMIT) -> None:
    """Slip by ``graph`` feels the root of what separates the solver's forces from the cone."""
    assert np.isfinite(b).sum() >= 3
    np.testing.assert_allclose(a, b, rtol=CLOSE if engine is LIMIT else 1e-5, atol=0 if engine is LIMIT else 1e-6)


@both
@pytest.mark.parametrize("name", NAMES)
def test_rigid_motion_new_order_and_new_names(name: str, engine: Engine) -> None:
    rng = np.random.default_rng(7)
    assembly = shipped(name)
    queries = random_pushes(assembly, 10, 6)
    before = answers(assembly, queries, engine)
    motion = pose(rng.normal(size=3), Rotation.random(random_state=7).as_matrix())
    turned = [("z_" + b, motion[:3, :3] @ p + motion[:3, 3], motion[:3, :3] @ e) for b, p, e in queries]
    order = rng.permutation(len(assembly.bodies))
    found = answers(assemble(moved(assembly.scene, motion, order=order, prefix="z_")), turned, engine)
    close(found, before, engine)


@both
@pytest.mark.parametrize("name", NAMES)
def test_interfaces_given_in_another_order_and_from_the_other_body(name: str, engine: Engine) -> None:
    assembly = shipped(name)
    queries = random_pushes(assembly, 10, 8)
    swapped = [
        Interface(i.bodies[::-1], patches=tuple(p.flipped() for p in i.patches)) for i in assembly.interfaces[::-1]
    ]
    found = answers(assemble(assembly.scene, interfaces=swapped), queries, engine)
    close(found, answers(assembly, queries, engine), engine)


@both
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("length", "mass"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e3), (1e3, 1e-3)])
def test_units(name: str, length: float, mass: float, engine: Engine) -> None:
    assembly = shipped(name)
    queries = random_pushes(assembly, 6, 9)
    other = assemble(rescaled(assembly.scene, length, mass), allow_large=True)
    scaled = answers(other, [(body, length * p, e) for body, p, e in queries], engine)
    close(scaled / mass, answers(assembly, queries, engine), engine)


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
    assert answers(less, [("cube", np.array([-0.05, 0, 0.1]), X)])[0] == pytest.approx(0.8 * 4.905, rel=CLOSE)


def test_a_push_may_be_split_into_wrenches_and_moved_along_its_line() -> None:
    assembly = shipped("table")
    one = [Load("slab", (0.2, -0.1, 0.225), Y)]
    two = [Load("slab", (0.2, 0.1, 0.225), 0.25 * Y), Load("slab", (0.2, 0, 0.225), 0.75 * Y)]
    com = [Load("slab", (0, 0, 0.225), Y, 0.2 * Z)]
    expected = load_factor(assembly, one, engine="limit").factor
    for loads in (two, com):
        assert load_factor(assembly, loads, engine="limit").factor == pytest.approx(expected, rel=CLOSE)
