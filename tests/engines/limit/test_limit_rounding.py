"""Bounds of rounding, against exact rational arithmetic."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from engine_scenes import G0, Array, shipped
from limit_scenes import BEYOND_DOUBLE

import holdfast as hf
from holdfast import Limit
from holdfast.answers import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.engines.answers import Bound
from holdfast.engines.limit.balance import Balance, Equilibrium, _cholesky, _solved_by_cholesky, inner
from holdfast.scene.shipped.blocks import at

SCENES = ["cube", "slope_two", "v_groove"]


def exact(assembly: Assembly, nodes: ContactNodes) -> list[list[Fraction]]:
    """G (6J, 3I) of the points, axes and centres of mass as the numbers that they are."""
    G = [[Fraction(0)] * (3 * len(nodes)) for _ in range(6 * len(assembly.movable))]
    for i in range(len(nodes)):
        for body, sign in ((int(nodes.b[i]), 1), (int(nodes.a[i]), -1)):
            if body < 0:
                continue
            p = [Fraction(float(nodes.points[i, c])) - Fraction(float(assembly.com[body, c])) for c in range(3)]
            for k in range(3):
                f = [sign * Fraction(float(v)) for v in nodes.axes[i, k]]
                torque = [p[1] * f[2] - p[2] * f[1], p[2] * f[0] - p[0] * f[2], p[0] * f[1] - p[1] * f[0]]
                for row, value in enumerate([*f, *torque]):
                    G[6 * body + row][3 * i + k] = value
    return G


def product(rows: list[list[Fraction]], vector: Array) -> list[Fraction]:
    numbers = [Fraction(float(v)) for v in vector]
    return [sum((a * b for a, b in zip(row, numbers, strict=True)), Fraction(0)) for row in rows]


def spread(rng: np.random.Generator, count: int) -> Array:
    """Numbers of very different sizes."""
    return rng.standard_normal(count) * 10.0 ** rng.uniform(-8, 8, count)


@pytest.mark.parametrize("name", SCENES)
def test_errors_of_products_are_within_their_bounds(name: str) -> None:
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    G, equilibrium = exact(assembly, nodes), Equilibrium.of(assembly, nodes)
    columns = [list(column) for column in zip(*G, strict=True)]
    rng = np.random.default_rng(0)
    seen = 0.0
    for _ in range(5):
        motion, forces = spread(rng, len(G)), spread(rng, len(columns))
        wrench, load, factor = spread(rng, len(G)), spread(rng, len(G)), spread(rng, 1)
        found, unknown = equilibrium.velocities(motion[:, None])
        for value, bound, truth in zip(found[:, 0], unknown[:, 0], product(columns, motion), strict=True):
            assert abs(Fraction(float(value)) - truth) <= Fraction(float(bound))
            seen = max(seen, float(abs(Fraction(float(value)) - truth)) / bound)
        found, unknown = equilibrium.imbalance(forces[:, None], wrench, load[:, None], factor)
        pushed = product(
            [[Fraction(float(w)), Fraction(float(e))] for w, e in zip(wrench, load, strict=True)], [1, factor[0]]
        )
        for value, bound, truth, more in zip(found[:, 0], unknown[:, 0], product(G, forces), pushed, strict=True):
            assert abs(Fraction(float(value)) - truth - more) <= Fraction(float(bound))
        value, bound = inner(motion[:, None], wrench[:, None])
        truth = product([[Fraction(float(v)) for v in motion]], wrench)[0]
        assert abs(Fraction(float(value[0])) - truth) <= Fraction(float(bound[0]))
    assert seen > 0.003, "the bounds are of the order of what they bound"


@pytest.mark.skipif(not BEYOND_DOUBLE, reason="numpy has no precision beyond double here")
@pytest.mark.parametrize("name", SCENES)
def test_errors_in_extended_precision_are_within_smaller_bounds(name: str) -> None:
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    G, equilibrium = exact(assembly, nodes), Equilibrium.of(assembly, nodes)
    columns = [list(column) for column in zip(*G, strict=True)]
    motion = spread(np.random.default_rng(1), len(G))
    coarse = equilibrium.velocities(motion[:, None])[1]
    found, unknown = equilibrium.velocities(motion.astype(np.longdouble)[:, None])
    assert (unknown < 1e-2 * coarse).all()
    for value, bound, truth in zip(found[:, 0], unknown[:, 0], product(columns, motion), strict=True):
        high = float(value)
        number = Fraction(high) + Fraction(float(value - high))
        assert abs(number - truth) <= Fraction(float(bound)) * (1 + Fraction(1, 10**15))


@pytest.mark.parametrize("name", [*SCENES, "wall2x2"])
def test_no_entry_of_the_operator_is_above_its_magnitude(name: str) -> None:
    """Which is made of the same products without their signs, and is zero only where the entry is zero exactly."""
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    entries = np.array(exact(assembly, nodes), dtype=np.float64)
    size = np.asarray(Equilibrium.of(assembly, nodes).magnitude)
    assert (np.abs(entries) <= size * (1 + 1e-15)).all()
    assert size.max() < 2.0


def positive(matrix: list[list[Fraction]]) -> bool:
    """Whether all eigenvalues of a symmetric matrix are above 0: by exact elimination."""
    left = [list(row) for row in matrix]
    for k in range(len(left)):
        if not left[k][k] > 0:
            return False
        for i in range(k + 1, len(left)):
            share = left[i][k] / left[k][k]
            left[i] = [a - share * b for a, b in zip(left[i], left[k], strict=True)]
    return True


def squared(balance: Balance, G: list[list[Fraction]], shift: Fraction) -> list[list[Fraction]]:
    """A Aᵀ less ``shift`` on its diagonal, of an exact G, with its equations combined as they are."""
    scale, share = ([Fraction(float(v)) for v in numbers] for numbers in (balance.scale, balance.share))
    A = [[s * g * t for g, t in zip(row, scale, strict=True)] for s, row in zip(share, G, strict=True) if s]
    if balance.combined is not None:
        turn = [[Fraction(float(v)) for v in row] for row in balance.combined.resisted.toarray()]
        columns = list(zip(*A, strict=True))
        A = [
            [sum((a * b for a, b in zip(row, column, strict=True)), Fraction(0)) for column in columns] for row in turn
        ]
    square = [[sum((a * b for a, b in zip(one, two, strict=True)), Fraction(0)) for two in A] for one in A]
    return [[value - shift * (i == j) for j, value in enumerate(row)] for i, row in enumerate(square)]


@pytest.mark.parametrize("name", SCENES)
def test_the_smallest_singular_value_is_as_large_as_it_says(name: str) -> None:
    """A Aᵀ less σ² on the diagonal has no eigenvalue below 0, exactly; less 2.1 σ² it has one."""
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, np.ones(len(nodes)))
    assert balance is not None
    assert balance.rows.all()
    G = exact(assembly, nodes)
    assert positive(squared(balance, G, Fraction(balance.least) ** 2))
    assert not positive(squared(balance, G, Fraction(21, 10) * Fraction(balance.least) ** 2))


@pytest.mark.parametrize("mu", [0.3, 1.5])
def test_corrections_change_the_room_of_no_node_by_more_than_is_said(mu: float) -> None:
    """Imbalances of all sizes, and those that need most."""
    assembly = shipped("stack").with_friction(dict.fromkeys((i.bodies for i in shipped("stack").interfaces), mu))
    nodes = Limit().prepare(assembly).rest.nodes
    rng = np.random.default_rng(4)
    tau = 10 ** rng.uniform(-1, 1, len(nodes))
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, tau)
    assert balance is not None
    worst = np.linalg.eigh(balance.scaled @ balance.scaled.T)[1][:, :1] / balance.share[:, None]
    wrench = np.hstack([worst, rng.standard_normal((len(balance.share), 200)) / balance.share[:, None]])
    forces = balance.forces_for(wrench)
    assert np.allclose(balance.equilibrium.G @ forces, wrench, atol=1e-9 * np.abs(wrench).max())
    room = np.abs(forces[::3]) + np.hypot(forces[1::3], forces[2::3]) / mu
    said = balance.change(np.abs(wrench))
    assert (room <= said).all()
    assert (room / said).max() > 0.1
    spent = np.abs(wrench).T @ balance.slope(3 * tau)
    assert (room.max(1) <= 3 * tau * spent.max()).all()
    assert (room <= 3 * tau[:, None] * spent).all()


def test_what_rounding_hides_is_not_claimed() -> None:
    """Four nodes closer and closer to one line, about which they hold less and less: down to what no digit tells.

    There the cube is only balanced.
    """
    assembly = shipped("cube")
    nodes = Limit().prepare(assembly).rest.nodes
    proved = []
    for apart in 10.0 ** np.arange(0, -11, -1):
        points = nodes.points.copy()
        points[:, 1] = points[:, 1].mean() + apart * (points[:, 1] - points[:, 1].mean())
        near = replace(nodes, points=points)
        balance = Balance.of(Equilibrium.of(assembly, near), near.mu, np.ones(len(near)))
        assert balance is None or positive(squared(balance, exact(assembly, near), Fraction(balance.least) ** 2))
        proved.append(balance is not None and not balance.loose.any())
    assert proved[0]
    assert balance is not None
    assert balance.loose.all()
    assert not proved[-1]
    assert sum(proved) >= 3


@pytest.mark.parametrize("name", SCENES)
def test_a_wrong_guess_of_the_smallest_singular_value_is_not_believed(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a step of inverse iteration the guess is that of no eigenvector."""
    monkeypatch.setattr("holdfast.engines.limit.balance.GUESSES", 0)
    assembly = shipped(name)
    nodes = Limit().prepare(assembly).rest.nodes
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, np.ones(len(nodes)))
    assert balance is None or positive(squared(balance, exact(assembly, nodes), Fraction(balance.least) ** 2))


def test_forces_that_are_off_are_brought_into_balance() -> None:
    """All but what rounding leaves is taken away, under a load, too."""
    assembly = shipped("wall2x2")
    state = Limit().prepare(assembly)
    nodes, rng = state.rest.nodes, np.random.default_rng(6)
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, np.ones(len(nodes)))
    assert balance is not None
    forces, loads = rng.standard_normal((3 * len(nodes), 5)), rng.standard_normal((len(state.wrench), 5))
    factors = rng.uniform(1, 2, 5)
    found, change = balance.balanced(forces, state.wrench, loads, factors)
    left = balance.equilibrium.G @ found + state.wrench[:, None] + factors * loads
    assert np.abs(left).max() <= 1e-12 * np.abs(state.wrench).max()
    assert change.max() <= 1e-9


BALLS = [
    hf.Body("table", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True),
    hf.Body("box", hf.Box((0.2, 0.2, 0.1)), mass=1.0, pose=at(0, 0, 0.05)),
    hf.Body("other", hf.Box((0.1, 0.1, 0.1)), mass=0.5, pose=at(0.04, 0, 0.15)),
]


def with_ball(x: float) -> hf.answers.Assembly:
    """A ball on the lower of two boxes, at ``x`` [m]."""
    return hf.assemble(hf.Scene([*BALLS, hf.Body("ball", hf.Sphere(0.04), mass=0.2, pose=at(x, 0, 0.14))], 0.5))


@pytest.mark.parametrize("x", [-0.06, -0.07])
def test_what_a_ball_does_not_resist_is_told_apart_and_all_else_is_proved(x: float) -> None:
    """The proved bounds of a box with a ball on it: closed form, that of sliding; the ball's own are 0 sideways."""
    assembly = with_ball(x)
    low = hf.robustness(assembly, "box", (-0.1, 0, 0.02), (1.0, 0, 0), engine="limit")
    assert low.lower_bound is Bound.PROVED
    assert low.lower == pytest.approx(0.5 * (1.0 + 0.5 + 0.2) * G0, rel=1e-5)
    assert low.upper == pytest.approx(low.lower, rel=1e-5)
    assert any("only balanced" in note and "ball" in note for note in low.notes)
    aside = hf.robustness(assembly, "ball", (x - 0.04, 0, 0.14), (1.0, 0, 0), engine="limit")
    assert aside.lower == 0
    lifted = hf.robustness(assembly, "ball", (x, 0, 0.18), (0, 0, 1.0), engine="limit")
    assert lifted.lower <= 0.2 * G0 * (1 + 1e-9)
    assert lifted.upper >= 0.2 * G0 * (1 - 1e-9)
    alone = hf.robustness(hf.assemble(hf.Scene(BALLS, 0.5)), "box", (-0.1, 0, 0.02), (1.0, 0, 0), engine="limit")
    assert not alone.notes


def test_a_ball_over_the_edge_of_its_contact_is_not_taken_for_balanced() -> None:
    """A wrench along what no contact resists is balanced by nothing, however small the rest of it."""
    assembly = with_ball(-0.06)
    rest = Limit().prepare(assembly).rest
    nodes = rest.nodes
    balance = Balance.of(Equilibrium.of(assembly, nodes), nodes.mu, np.ones(len(nodes)))
    assert balance is not None
    assert [body.name for body, one in zip(assembly.movable, balance.loose, strict=True) if one] == ["ball"]
    rows = slice(6 * assembly.index["ball"], 6 * assembly.index["ball"] + 6)
    forces, wrench = np.zeros((3 * len(nodes), 1)), np.zeros(len(balance.share))
    for roll, held in (((0, 0, -1, 0, 0, 0), True), ((0, 0, -1, 1e-6, 0, 0), False), ((0, 0, -1, 0, 0, 1e-6), False)):
        wrench[rows] = roll
        change = balance.balanced(forces, wrench, np.zeros((len(wrench), 1)), np.zeros(1))[1]
        assert np.isfinite(change).all() == held
        forward = Limit().prepare(assembly).proofs.carried(rest.forces.reshape(-1, 1), wrench[:, None])
        assert (forward[0] > 0) == held, "no forces carry what nothing resists, whatever a solver says"
    slope = balance.slope(np.ones(len(nodes)))
    assert np.isinf(slope[rows][[0, 1, 3, 4]]).all()  # along the table and about axes in it
    assert np.isfinite(np.delete(slope, range(rows.start, rows.stop))).all()
    corrected = balance.forces_for(np.where(np.arange(len(wrench)) < rows.start, 1.0, 0.0)[:, None])
    assert np.allclose((balance.equilibrium.G @ corrected)[: rows.start], 1.0)


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
def test_a_shift_beyond_the_smallest_eigenvalue_is_found_by_elimination(order: list[int]) -> None:
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    values = np.array([1.0, 4.0, 9.0])[order]
    for square in (np.diag(values), turn @ np.diag(values) @ turn.T):
        for shift, definite in ((0.0, True), (0.9, True), (1.1, False), (3.0, False)):
            factor = _cholesky(square, shift)
            assert (factor is not None) == definite, shift
            if factor is not None:
                np.testing.assert_allclose(factor @ factor.T, square - shift * np.eye(3), atol=1e-14)
                asked = np.array([[1.0, 0.0], [2.0, -1.0], [0.5, 3.0]])
                np.testing.assert_allclose(
                    (square - shift * np.eye(3)) @ _solved_by_cholesky(factor, asked), asked, atol=1e-12
                )
