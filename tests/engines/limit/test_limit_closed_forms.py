"""The closed forms of limit analysis, by hand and by a planar linear program of our own."""

import numpy as np
import pytest
from engine_scenes import G0, Array, X, Y, Z, cube, push_wrench, shipped
from limit_scenes import dense_operator, push, strength, transport, weights
from scipy.optimize import linprog

from holdfast import Load, Status, load_factor
from holdfast.answers import Assembly

CLOSE = 1e-6


def near(value: float) -> object:
    return pytest.approx(value, rel=CLOSE)


def planar(assembly: Assembly, load: Array, plane: tuple[Array, Array]) -> float:
    """Largest factor with contact forces in a plane of symmetry only, where friction is exact in a linear program."""
    G, normals, mu = dense_operator(assembly)
    columns = []
    for i, (n, m) in enumerate(zip(normals, mu, strict=True)):
        t = np.cross(np.cross(*plane), n)  # the tangent within the plane; both edges of the cone
        columns += [G[:, 3 * i : 3 * i + 3] @ (n + sign * m * t) for sign in (1, -1)]
    A = np.column_stack([*columns, load])
    cost = np.append(np.zeros(len(columns)), -1)
    answer = linprog(cost, A_eq=A, b_eq=-weights(assembly), method="highs")
    return np.inf if answer.status == 3 else float(-answer.fun)


def test_transport_agrees_with_a_support_that_accelerates() -> None:
    assembly = shipped("slope")
    limit = transport(assembly, Y)
    for share, feasible in ((0.9999, True), (1.0001, False)):
        answer = load_factor(assembly, [Load("cube1", moment=X)], acceleration=share * limit * Y, engine="limit")
        assert (answer.status is not Status.UNSTABLE) == feasible


def test_table() -> None:
    table = shipped("table")
    assert strength(table, "slab", (-0.25, 0, 0.225), X) == near(7.3575)
    assert strength(table, "slab", (0.2, -0.1, 0.225), Y) == near(6.2267738)  # 6.227


def test_the_table_sways_on_both_legs() -> None:
    mechanism = push(shipped("table"), "slab", (-0.25, 0, 0.225), X).mechanism[0]
    assert set(mechanism.moving) == {"slab", "leg_left", "leg_right"}
    slab, left, right = (mechanism.twists[shipped("table").index[b]] for b in ("slab", "leg_left", "leg_right"))
    assert slab[4] == pytest.approx(0, abs=1e-6)  # it stays level
    assert left[4] == pytest.approx(right[4], rel=1e-5)
    assert left[4] > 0.1


def test_off_centre_push_on_a_cube() -> None:
    """4.6366 N: the four corners share slip and twist; by a search over the centre of rotation."""
    got = strength(cube(), "cube", (-0.05, 0.045, 0.02), X)
    assert got == pytest.approx(4.6366, abs=5e-5)
    assert got == near(4.6365969)


@pytest.mark.parametrize(
    ("name", "direction", "expected"),
    [
        ("slope", Y, G0 * (1 - 0.5) / (1 + 0.5)),  # the cube turns over its lower edge
        ("slope", -Y, 1.2 * G0),  # all slides
        ("slope_two", -Y, 1.2 * G0),
        ("slope_two", Y, 4.291875),
    ],
)
def test_fig_15_along_the_slope(name: str, direction: Array, expected: float) -> None:
    assembly = shipped(name)
    assert transport(assembly, direction) == near(expected)
    if name == "slope":  # one body that slides or turns
        assert transport(assembly, direction, "graph") == pytest.approx(expected, rel=1e-4)
    load = np.concatenate([np.r_[-b.mass * direction, 0, 0, 0] for b in assembly.movable])
    assert planar(assembly, load, (Y, Z)) == near(expected)


@pytest.mark.parametrize(("name", "cubes", "published"), [("slope", 1, 5.780), ("slope_two", 2, 5.08)])
def test_fig_15_across_the_slope(name: str, cubes: int, published: float) -> None:
    """Everything turns over the wedge's lower edge: half its width over the height of the common centre of mass."""
    height = (0.05 + cubes * (0.075 + 0.05 / np.hypot(1, 0.5))) / (1 + cubes)
    assert G0 * 0.05 / height == pytest.approx(published, abs=0.005)
    for direction in (X, -X):
        assert transport(shipped(name), direction) == near(G0 * 0.05 / height)
        assert transport(shipped(name), direction, "graph") == pytest.approx(published, rel=5e-3)


@pytest.mark.parametrize(
    ("name", "body", "point", "direction"),
    [
        ("table", "slab", (-0.25, 0, 0.225), X),
        ("table", "slab", (-0.24, 0, 0.25), -Z),
        ("tall_table", "slab", (-0.25, 0, 0.625), X),
        ("stack", "cube2", (-0.05, 0, 0.17), X),
        ("wall2x2", "b1_0", (-0.15, 0, 0.18), X),
        ("arch", "v3", (0, 0, 0.3), Z),
        ("arch", "v2", (-0.15 * np.sqrt(3), 0, 0.15), X),
        ("cantilever", "C", (0.25, 0, 0.37), -Z),
    ],
)
def test_planar_scenes_against_a_linear_program(name: str, body: str, point: tuple, direction: Array) -> None:
    assembly = shipped(name)
    expected = planar(assembly, push_wrench(assembly, body, point, direction), (X, Z))
    load = [Load(body, point, direction)]  # type: ignore[arg-type]
    assert load_factor(assembly, load, engine="limit").factor == near(expected)
