"""Tiny cone programs with answers by hand, one for each way a solve can end."""

from types import SimpleNamespace

import clarabel
import numpy as np
import pytest
from scipy import sparse

from holdfast.conic.solve import ConeKind, ConeProgram, Outcome, Prepared, solve, violation

Cones = tuple[tuple[ConeKind, int], ...]


def program(A: object, b: object, q: object, cones: Cones, P: object = None) -> ConeProgram:
    A = sparse.csc_matrix(np.array(A, dtype=float))
    P = np.zeros((A.shape[1],) * 2) if P is None else np.array(P, dtype=float)
    return ConeProgram(sparse.csc_matrix(P), np.array(q, dtype=float), A, np.array(b, dtype=float), cones)


DISC = program(  # min -x - y, |(x, y)| <= 1
    [[0, 0], [-1, 0], [0, -1]], [1, 0, 0], [-1, -1], (("second_order", 3),)
)
LINE = program([[1.0, 1], [-1, 0], [0, -1]], [2, 0, 0], [1, 3], (("zero", 1), ("nonnegative", 2)))  # x + y = 2, x + 3 y
NEAREST = program([[1.0, 1]], [2], [0, 0], (("zero", 1),), P=np.eye(2))  # the point of the line nearest to 0
CLASH = program([[1.0], [-1]], [-1, -1], [0], (("nonnegative", 2),))  # x <= -1 and x >= 1
CONE_CLASH = program(  # |(y, 2)| <= 1
    [[0.0], [-1], [0]], [1, 0, 2], [0], (("second_order", 3),)
)
FREE = program([[-1.0, 0], [0, 1]], [0, 1], [-1, 0], (("nonnegative", 2),))  # min -x, x >= 0, y <= 1


@pytest.mark.parametrize(
    ("given", "x", "z"),
    [
        (DISC, np.sqrt([0.5, 0.5]), [np.sqrt(2), -1, -1]),
        (LINE, [2, 0], [-1, 0, 2]),
        (NEAREST, [1, 1], [-1]),
    ],
)
def test_solved(given: ConeProgram, x: list[float], z: list[float]) -> None:
    answer = solve(given)
    assert answer.outcome is Outcome.SOLVED
    np.testing.assert_allclose(answer.x, x, atol=1e-8)
    np.testing.assert_allclose(answer.z, z, atol=1e-7)
    assert answer.residual < 1e-8
    assert answer.residual == violation(given, answer.x)
    # stationarity and equal objectives
    np.testing.assert_allclose(given.P @ answer.x + given.q + given.A.T @ answer.z, 0, atol=1e-7)
    curve = answer.x @ (given.P @ answer.x)
    assert given.q @ answer.x + curve == pytest.approx(-given.b @ answer.z, abs=1e-7)


@pytest.mark.parametrize("given", [CLASH, CONE_CLASH])
def test_infeasible_with_a_certificate(given: ConeProgram) -> None:
    answer = solve(given)
    assert answer.outcome is Outcome.INFEASIBLE
    z = answer.z
    np.testing.assert_allclose(given.A.T @ z, 0, atol=1e-7 * np.abs(z).max())
    assert given.b @ z < 0
    if given is CLASH:
        assert (z > 0).all()
    else:
        assert z[0] >= np.linalg.norm(z[1:]) - 1e-7 * z[0]  # the cone is its own dual
        assert z[2] < 0


def test_unbounded_with_a_ray() -> None:
    answer = solve(FREE)
    assert answer.outcome is Outcome.UNBOUNDED
    assert FREE.q @ answer.x < 0
    direction = -FREE.A @ answer.x / np.abs(answer.x).max()
    assert direction.min() >= -1e-7
    assert answer.x[0] > 0


def test_iteration_limit_is_no_answer() -> None:
    answer = solve(DISC, max_iterations=1)
    assert answer.outcome is Outcome.LIMIT
    assert answer.iterations <= 1
    assert "no answer" in Outcome.LIMIT.value


def test_a_looser_tolerance_takes_fewer_iterations() -> None:
    assert solve(DISC, tolerance=1e-2).iterations < solve(DISC, tolerance=1e-10).iterations


def test_every_kind_of_cone_at_once() -> None:
    """min t - u with x = 3, |(x, 4)| <= t, u <= 7: t = 5."""
    A = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0], [-1, 0, 0], [0, 0, 0]], dtype=float)
    mixed = program(A, [3, 7, 0, 0, 4], [0, 1, -1], (("zero", 1), ("nonnegative", 1), ("second_order", 3)))
    answer = solve(mixed)
    assert answer.outcome is Outcome.SOLVED
    np.testing.assert_allclose(answer.x, [3, 5, 7], atol=1e-7)


def test_a_prepared_program_that_was_changed_equals_a_fresh_one() -> None:
    rng = np.random.default_rng(3)
    prepared = Prepared(LINE)
    for _ in range(5):
        slope = rng.uniform(0.5, 3, 2)
        entries = np.array([0, 2])  # row 0 of both columns: A.data runs down the columns
        np.testing.assert_array_equal(LINE.A.data[entries], [1, 1])
        prepared.change(entries, slope)
        fresh = solve(program([slope, [-1, 0], [0, -1]], [2, 0, 0], [1, 3], LINE.cones))
        again = prepared.solve()
        assert again.outcome is fresh.outcome is Outcome.SOLVED
        np.testing.assert_allclose(again.x, fresh.x, atol=1e-8)
        np.testing.assert_allclose(again.z, fresh.z, atol=1e-7)
        by_hand = [2 / slope[0], 0] if 1 / slope[0] < 3 / slope[1] else [0, 2 / slope[1]]
        np.testing.assert_allclose(again.x, by_hand, atol=1e-7)
        assert again.residual < 1e-8  # measured on the changed program
    np.testing.assert_array_equal(LINE.A.data[[0, 2]], [1, 1])  # the program given is a value


def test_a_change_may_turn_the_outcome_and_back() -> None:
    """min -x with a x <= 1, x >= 0: 1 / a, or endless for a < 0."""
    base = program([[1.0], [-1]], [1, 0], [-1], (("nonnegative", 2),))
    prepared = Prepared(base)
    found = []
    for a in (2.0, -1.0, 4.0):
        prepared.change(np.array([0]), np.array([a]))
        answer = prepared.solve()
        found.append((answer.outcome, answer.x[0] if a > 0 else np.inf))
    assert [o for o, _ in found] == [Outcome.SOLVED, Outcome.UNBOUNDED, Outcome.SOLVED]
    assert found[0][1] == pytest.approx(0.5)
    assert found[2][1] == pytest.approx(0.25)


def test_violation_by_hand() -> None:
    cones: Cones = (("zero", 2), ("nonnegative", 2), ("second_order", 3), ("second_order", 3), ("second_order", 4))

    def of(*slack: float) -> float:
        return violation(program(np.zeros((14, 1)), slack, [0], cones), np.zeros(1))

    fine = [0, 0, 1, 0, 5, 3, 4, 1, 0, -1, 2, 1, 1, -1]
    assert of(*fine) == 0
    for row, value, expected in (
        (1, -0.5, 0.5),  # zero: either sign
        (0, 0.25, 0.25),
        (3, -2, 2),  # nonnegative
        (4, 4.5, 0.5),  # |(3, 4)| - 4.5
        (8, np.sqrt(3), 1),  # the second of two alike: |(√3, -1)| - 1
        (10, -2, 2 + np.sqrt(3)),  # a cone turned over
    ):
        slack = list(fine)
        slack[row] = value
        assert of(*slack) == pytest.approx(expected)


def test_violation_takes_x_into_account_and_no_rows_are_no_violation() -> None:
    assert violation(LINE, np.array([1.0, 0.5])) == pytest.approx(0.5)
    assert violation(LINE, np.array([3.0, -1.0])) == pytest.approx(1)
    empty = program(np.zeros((0, 1)), np.zeros(0), [0], ())
    assert violation(empty, np.ones(1)) == 0


def test_certificates_of_any_length_are_numbers_whose_products_are_still_numbers() -> None:
    """However long the solver's ray is, what is computed of it does not overflow; solutions are left as they are."""
    prepared = Prepared(LINE)
    real = prepared._solver

    ray = SimpleNamespace(status="PrimalInfeasible", x=[1e200, -3e199], z=[2e150, 1.0, 0.0], iterations=3)
    prepared._solver = SimpleNamespace(solve=lambda: ray)
    found = prepared.solve()
    assert found.outcome is Outcome.INFEASIBLE
    assert found.x.tolist() == pytest.approx([1e100, -3e99])
    assert np.abs(found.z).max() == 1e100
    assert np.isfinite(found.residual)
    prepared._solver = real
    assert prepared.solve().x.tolist() == solve(LINE).x.tolist()


@pytest.mark.parametrize("status", sorted(name for name in dir(clarabel.SolverStatus) if name[0].isupper()))
def test_every_end_of_the_solver_is_told_as_what_it_is(status: str) -> None:
    """By the solver's own names: full accuracy is claimed for one of them, and proofs for no more than two each."""
    expected = {
        "Solved": "SOLVED",
        "AlmostSolved": "ALMOST_SOLVED",
        "PrimalInfeasible": "INFEASIBLE",
        "AlmostPrimalInfeasible": "INFEASIBLE",
        "DualInfeasible": "UNBOUNDED",
        "AlmostDualInfeasible": "UNBOUNDED",
        "MaxIterations": "LIMIT",
        "MaxTime": "LIMIT",
    }
    ended = SimpleNamespace(status=getattr(clarabel.SolverStatus, status), x=[2.0, 0], z=[-1.0, 0, 2], iterations=3)
    prepared = Prepared(LINE)
    prepared._solver = SimpleNamespace(solve=lambda: ended)
    assert prepared.solve().outcome.name == expected.get(status, "TROUBLE")


def test_violation_is_the_way_back_into_the_cones() -> None:
    """Adding a violation to the slack, along each cone's axis, is just enough to be inside; random cones and points."""
    rng = np.random.default_rng(8)
    for _ in range(50):
        slack, x, A = rng.normal(size=9), rng.normal(size=4), rng.normal(size=(9, 4))
        cones: Cones = (("zero", 1), ("second_order", 3), ("nonnegative", 2), ("second_order", 3))
        off = violation(program(A, slack + A @ x, np.zeros(4), cones), x)

        def inside(more: float, slack: np.ndarray = slack) -> bool:
            zero, first, second = abs(slack[0]), slack[1:4], slack[6:9]
            round_ones = all(np.linalg.norm(cone[1:]) <= cone[0] + more for cone in (first, second))
            return bool(zero <= more and round_ones and (slack[4:6] >= -more).all())

        assert inside(off + 1e-9)
        assert not inside(off - 1e-9)
