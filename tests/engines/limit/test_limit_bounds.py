"""Bounds, weak duality on every answer, polygons inside and around the cone, and states that are used again."""

import numpy as np
import pytest
from engine_scenes import Array, X, cube, push_wrench, shipped
from limit_scenes import columns, dense_operator, push, weights
from scipy.optimize import linprog

from holdfast import Limit, Status, stability
from holdfast.answers import Assembly
from holdfast.base.rigid import tangents

SCENES = ["cube", "stack", "table", "slope_two", "arch", "v_groove", "wall2x2", "cantilever"]


def feasible(assembly: Assembly, wrench: Array, sides: int = 32) -> bool:
    """Whether forces within a polygon inside the friction cone balance ``wrench``, by a linear program of our own."""
    G, normals, mu = dense_operator(assembly)
    t1, t2 = tangents(normals)
    edges = []
    for i in range(len(mu)):
        for angle in 2 * np.pi * np.arange(sides) / sides:
            force = normals[i] + mu[i] * (np.cos(angle) * t1[i] + np.sin(angle) * t2[i])
            edges.append(G[:, 3 * i : 3 * i + 3] @ force)
    A = np.column_stack(edges)
    scale = np.abs(wrench).max()
    return bool(linprog(np.zeros(A.shape[1]), A_eq=A, b_eq=-wrench / scale, method="highs").status == 0)


@pytest.mark.parametrize("name", SCENES)
def test_bounds_and_weak_duality_on_random_pushes(name: str) -> None:
    """Power of weight and load cancel along every mechanism, which no contact resists; our own G."""
    assembly = shipped(name)
    W = columns(assembly, 24, 1)
    got = Limit().prepare(assembly).load_factor(W)
    G, normals, mu = dense_operator(assembly)
    gravity = weights(assembly)
    assert (got.lower <= got.force).all()
    assert (got.force <= got.upper).all()
    finite = np.array([s is Status.FINITE for s in got.status])
    assert finite.sum() >= 6
    assert (got.upper[finite] - got.lower[finite] <= 1e-5 * got.upper[finite]).all()
    for k in np.flatnonzero(finite):
        mechanism = got.mechanism[k]
        assert mechanism is not None
        q = mechanism.twists.ravel()
        power = q @ W[:, k]
        assert power > 0
        assert -(q @ gravity) / power == pytest.approx(got.force[k], rel=1e-6)
        top = max(abs(q @ gravity), 1e-300)
        assert abs(q @ gravity + got.force[k] * power) <= 1e-7 * top
        u = (G.T @ q).reshape(-1, 3)
        rise = np.einsum("ix,ix->i", u, normals)
        slip = np.linalg.norm(u - rise[:, None] * normals, axis=1)
        assert (rise >= mu * slip - 1e-6).all()
        assert mechanism.moving == got.moving[k]
        assert got.mode[k] in ("slip", "topple", "mixed")


@pytest.mark.parametrize("name", ["cube", "table", "arch", "v_groove", "wall2x2", "wedged_floor"])
def test_answers_are_feasible_just_below_and_infeasible_just_above(name: str) -> None:
    """A 64-sided polygon falls short of the cone by 1.2e-3."""
    assembly = shipped(name)
    W, gravity = columns(assembly, 8, 2), weights(assembly)
    got = Limit().prepare(assembly).load_factor(W)
    assert set(got.status) <= {Status.FINITE, Status.INFINITE}
    for k, status in enumerate(got.status):
        if status is Status.INFINITE:
            assert feasible(assembly, gravity + 1e6 * W[:, k])
        else:
            assert feasible(assembly, gravity + 0.99 * got.force[k] * W[:, k], 64)
            assert not feasible(assembly, gravity + 1.0001 * got.force[k] * W[:, k], 64)


@pytest.mark.parametrize(
    ("name", "body", "point", "direction"),
    [
        ("cube", "cube", (0.03, 0.03, 0.1), (0.1, 0, -1)),
        ("table", "slab", (0.19, 0.09, 0.25), (0, 0, -1)),
        ("v_groove", "cube", (0, 0, 0.1 * np.sqrt(2)), (0, 0, -1)),
        ("wall2x2", "b1_0", (-0.1, 0, 0.2), (0, 0, -1)),
        ("wedged_floor", "cube", (0, 0, 0.1), (0, 0, 1)),  # the walls may press: self-stress has no bound
    ],
)
def test_endless_answers_hold_a_million_newtons(name: str, body: str, point: tuple, direction: tuple) -> None:
    assembly = shipped(name)
    got = push(assembly, body, point, direction)
    assert got.force[0] == np.inf
    assert got.status[0] is Status.INFINITE
    force = 1e6 * np.array(direction) / np.linalg.norm(direction)
    assert feasible(assembly, weights(assembly) + push_wrench(assembly, body, point, force))


@pytest.mark.parametrize("sides", [4, 5, 8])
def test_polygons_on_a_sliding_cube_by_hand(sides: int) -> None:
    """Straight at a corner the inscribed polygon is exact; at the middle of a side it is short by cos(π/N)."""
    least, most = np.inf, 0.0
    for angle in np.linspace(0, 2 * np.pi / sides, 9):
        e = np.array([np.cos(angle), np.sin(angle), 0])
        inner, outer = (
            push(cube(), "cube", (0, 0, 0), e, cone=c, sides=sides).force[0] for c in ("inscribed", "circumscribed")
        )
        assert outer * np.cos(np.pi / sides) == pytest.approx(inner, rel=1e-6)
        least, most = min(least, inner), max(most, inner)
    assert least == pytest.approx(0.6 * 9.81 * np.cos(np.pi / sides), rel=1e-6)
    assert most <= 0.6 * 9.81 * (1 + 1e-6)
    assert most == pytest.approx(0.6 * 9.81, rel=1e-6)


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2"])
@pytest.mark.parametrize("kind", ["inscribed", "circumscribed"])
def test_polygons_by_another_linear_program(name: str, kind: str) -> None:
    """HiGHS on shares of the polygon's corners, with our own G."""
    assembly = shipped(name)
    W = columns(assembly, 8, 6)
    G, normals, mu = dense_operator(assembly)
    t1, t2 = tangents(normals)
    for sides in (4, 8):
        reach = mu[:, None] * (1.0 if kind == "inscribed" else 1 / np.cos(np.pi / sides))
        edges = []
        for angle in np.pi / sides * (1 + 2 * np.arange(sides)):
            force = normals + reach * (np.cos(angle) * t1 + np.sin(angle) * t2)
            edges.append(np.einsum("jix,ix->ji", G.reshape(len(G), -1, 3), force))
        got = Limit(kind, sides).prepare(assembly).load_factor(W)
        for k, column in enumerate(W.T):
            A = np.column_stack([*edges, column])
            cost = np.r_[np.zeros(A.shape[1] - 1), -1.0]
            found = linprog(cost, A_eq=A, b_eq=-weights(assembly), bounds=(0, None), method="highs")
            assert got.status[k] is (Status.INFINITE if found.status == 3 else Status.FINITE)
            if found.status != 3:
                assert got.force[k] == pytest.approx(-found.fun, rel=1e-6)


@pytest.mark.parametrize(("sides", "share"), [(4, 1.2), (8, 1.05)])
def test_a_circumscribed_polygon_holds_what_only_it_can_hold(sides: int, share: float) -> None:
    """On a slope steeper than μ, towards a corner of the polygon: the optimistic choice must say that one exists."""
    angle = np.pi / sides
    lean = 9.81 * np.array([share * 0.6 * np.cos(angle), share * 0.6 * np.sin(angle), -1])
    assembly = cube(0.6, gravity=lean, height=0.02)
    assert stability(assembly, engine="limit").equilibrium_exists is False
    assert stability(assembly, engine=Limit("inscribed", sides)).equilibrium_exists is not True
    assert stability(assembly, engine=Limit("circumscribed", sides)).equilibrium_exists is True


def test_notes_say_which_way_a_polygon_errs() -> None:
    assembly = shipped("cube")
    assert Limit().prepare(assembly).notes == ()
    assert "cautious" in Limit("inscribed", 5).prepare(assembly).notes[0]
    assert "5 sides" in Limit("inscribed", 5).prepare(assembly).notes[0]
    assert "optimistic" in Limit("circumscribed").prepare(assembly).notes[0]


def test_no_loads_and_a_load_of_nothing() -> None:
    assembly = shipped("table")
    state = Limit().prepare(assembly)
    assert state.load_factor(np.zeros((18, 0))).force.shape == (0,)
    nothing = state.load_factor(np.zeros((18, 1)))
    assert nothing.force[0] == np.inf
    on_the_floor = push(assembly, "floor", (0.4, 0, 0), X)
    assert on_the_floor.force[0] == np.inf
