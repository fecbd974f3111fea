"""Elimination front by front against dense solving, on models at random: every way that a matrix may take."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from elastic_blocks import twist_matrices
from numpy.typing import NDArray

from holdfast.elastic.model import Elastic, Runs
from holdfast.elastic.system import EliminationFronts, fronts_of
from holdfast.native import core

Array = NDArray[np.float64]

NEAR = 0.35  # bodies in a cube of side one are joined up to this distance
DRAG, CORNER, HOLD = 0.1, 0.7, 1e-5  # of a hold: too little for a pivot


def turned(rng: np.random.Generator, count: int) -> Array:
    return np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]


def model_at_random(seed: int, bodies: int) -> Elastic:
    """Bodies at random in a cube, some of them joined to the ground, in more than one group where few are near."""
    rng = np.random.default_rng(seed)
    at = rng.uniform(size=(bodies, 3))
    pairs = [(a, b) for b in range(bodies) for a in range(b) if np.linalg.norm(at[a] - at[b]) < NEAR]
    grounded = [(-1, b) for b in range(bodies) if rng.uniform() < 0.5]
    ends = rng.permutation(np.array([*pairs, *grounded, (0, -1)]))
    n, count = 6 * bodies, len(ends)
    half = rng.normal(size=(count, 6, 6))
    none, starts = np.zeros(0), np.zeros(count + 1, dtype=np.int64)
    return Elastic(
        first=starts,
        x=none,
        y=none,
        k=none,
        apart=none,
        mu=np.full(count, 0.5),
        rho=1.0,
        a=np.ascontiguousarray(ends[:, 0]),
        b=np.ascontiguousarray(ends[:, 1]),
        axes=turned(rng, count),
        arm_a=rng.normal(size=(count, 3)),
        arm_b=rng.normal(size=(count, 3)),
        wrench=np.zeros(n),
        scale=np.ones(n),
        bonded=half @ half.transpose(0, 2, 1),
        unit=rng.uniform(0.5, 2.0, n),
        runs=Runs.of(starts, none, none, none),
        hold=rng.uniform(0.0, HOLD, n),
        still=rng.uniform(0.0, HOLD, n),
    )


class Case(NamedTuple):
    """A model, its fronts, and the matrix (n + 1, n + 1) and the right-hand sides (n + 1, 2) of a system."""

    m: Elastic
    fronts: EliminationFronts
    K: Array
    w: Array
    c: Array
    A: Array
    rhs: Array


def case(seed: int, bodies: int, *, rank: int = 6, drag: float = DRAG) -> Case:
    """A system whose sheets have stiffnesses of a rank: with a small one, bodies have too few pivots of their own."""
    m = model_at_random(seed, bodies)
    rng = np.random.default_rng(seed)
    n, count = len(m.wrench), len(m.a)
    K = rng.normal(size=(count, 6, rank)) @ rng.normal(size=(count, rank, 6))
    w, c, rhs = rng.normal(size=n), rng.normal(size=n), rng.normal(size=(n + 1, 2))
    A = np.diag(np.append(m.hold + drag * m.still, CORNER))
    from_a, from_b = twist_matrices(m)
    for p in range(count):
        T = np.zeros((6, n))
        for body, twist, sign in ((m.b[p], from_b[p], 1), (m.a[p], from_a[p], -1)):
            if body >= 0:
                T[:, 6 * body : 6 * body + 6] += sign * twist
        A[:n, :n] += T.T @ (K[p] + drag * m.bonded[p]) @ T
    A[:n, n], A[n, :n] = -w, c
    return Case(m, fronts_of(m), K, w, c, A, rhs)


def filled(work: core.Work, each: Case) -> core.Work:
    """The system in memory that holds no numbers, as another system or another thread may leave it."""
    work.fill(np.nan)
    work.K[:], work.w[:], work.c[:], work.rhs[:] = each.K, each.w, each.c, each.rhs
    return work


def error(solution: Array, A: Array, rhs: Array) -> float:
    exact = np.linalg.solve(A, rhs)
    return float(np.abs(solution - exact).max() / np.abs(exact).max())


def test_the_force_of_drag_is_that_of_the_matrix() -> None:
    """Its part on the world, which bodies on ice have, included: r = -ε D (q - anchor)."""
    dragged, free = case(3, 20, drag=1.0), case(3, 20, drag=0.0)
    n, rng = len(free.w), np.random.default_rng(0)
    q, anchor = rng.normal(size=(2, n))
    work = core.Work(free.m, free.fronts)
    work.r[:] = 0.0
    core.add_drag(free.m, work, 0.3, q, anchor)
    D = (dragged.A - free.A)[:n, :n]
    np.testing.assert_allclose(work.r, -0.3 * D @ (q - anchor), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("rank", [6, 4, 3])
@pytest.mark.parametrize(("seed", "bodies"), [(0, 1), (1, 2), (2, 7), (3, 20), (4, 20), (5, 45), (6, 70), (7, 110)])
def test_solutions_are_those_of_dense_elimination(seed: int, bodies: int, rank: int) -> None:
    each = case(seed, bodies, rank=rank)
    work = filled(core.Work(each.m, each.fronts), each)
    sign = core.solve(each.m, work, DRAG, CORNER, each.fronts)
    assert error(work.rhs, each.A, each.rhs) < 1e-8
    assert sign == np.linalg.slogdet(each.A)[0]


@pytest.mark.parametrize("seed", range(6))
def test_pivots_wait_wherever_they_may(seed: int) -> None:
    """In fronts whose rest is passed on at once and in others, and more of them than there is memory for at first."""
    each = case(seed, 60, rank=1, drag=0.0)
    work = filled(core.Work(each.m, each.fronts), each)
    sign = core.solve(each.m, work, 0.0, CORNER, each.fronts)
    assert error(work.rhs, each.A, each.rhs) < 1e-6
    assert sign == np.linalg.slogdet(each.A)[0]
    at_once = np.array([core.passes_on(each.fronts, k) for k in range(len(work.waits))])
    assert max(work.waits[at_once]) > 5
    assert max(work.waits[~at_once]) > 5


def test_a_body_that_nothing_holds_makes_a_system_singular() -> None:
    each = case(9, 30, drag=0.0)
    m = each.m._replace(hold=np.zeros_like(each.m.hold), still=np.zeros_like(each.m.still))
    K = each.K * ((m.a != 4) & (m.b != 4))[:, None, None]
    each = each._replace(m=m, K=K)
    dense, sparse = filled(core.Work(m, None), each), filled(core.Work(m, each.fronts), each)
    assert core.solve(m, dense, 0.0, 0.0, None, 1e-12) == 0
    assert core.solve(m, sparse, 0.0, 0.0, each.fronts, 1e-12) == 0


@pytest.mark.parametrize(("seed", "bodies"), [(0, 1), (3, 20), (5, 45)])
def test_a_front_comes_right_after_the_last_one_that_it_takes_from(seed: int, bodies: int) -> None:
    """And takes all bodies that are left of each, in one order."""
    e = case(seed, bodies).fronts
    parent = np.full(len(e.owned), -1)
    for k in range(len(e.owned)):
        children = e.child[e.begin[k] : e.begin[k + 1]]
        assert (np.diff(children) > 0).all()
        assert len(children) == 0 or children[-1] == k - 1
        parent[children] = k
    assert (parent[:-1] >= 0).all()
    for k, up in enumerate(parent[:-1]):
        left = slice(e.first[k] + e.owned[k], e.first[k + 1])
        assert (np.diff(e.onward[left]) > 0).all()
        np.testing.assert_array_equal(e.body[e.first[up] + e.onward[left]], e.body[left])
