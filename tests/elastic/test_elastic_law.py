"""The contact law, its Jacobian, and the linear systems of a path."""

import numpy as np
import pytest
from elastic_blocks import block, twist_matrices

import holdfast as hf
from holdfast.assembly.contact_nodes import contact_nodes, equilibrium_operator
from holdfast.elastic.model import Runs
from holdfast.elastic.system import fronts_of
from holdfast.engines.compliant.elastic_model import Places, elastic_model, world_rows
from holdfast.engines.mechanism import relative_velocity
from holdfast.native import core
from holdfast.scene.shipped import shipped_scene

SCENES = ["cube", "table", "arch", "v_groove", "tabletop"]


def model(name: str, ratio: float = 1.0) -> tuple:
    assembly = hf.assemble(shipped_scene(name))
    nodes = contact_nodes(assembly, 49, "quadrature")
    return assembly, nodes, elastic_model(Places.at(assembly, nodes), assembly.weight_wrench(), ratio)


def rough(m, seed: int):
    """The model with clearances at random, some of them negative, as of faces that are pulled together."""
    apart = np.random.default_rng([seed, 7]).uniform(-0.5, 0.5, len(m.k))
    return m._replace(apart=apart, runs=Runs.of(m.first, m.x, m.y, apart))


def unbalance(m, q: np.ndarray, K: np.ndarray | None = None) -> np.ndarray:
    r = np.zeros(len(q))
    core.evaluate(m, 1.0, q, r, np.zeros_like(m.bonded) if K is None else K)
    return r


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_forces_follow_the_law_at_every_node(name: str, ratio: float) -> None:
    assembly, nodes, flat = model(name, ratio)
    seen = set()
    for seed in range(20):
        m = rough(flat, seed) if seed % 2 else flat
        q = np.random.default_rng(seed).normal(size=len(m.wrench))
        f = np.zeros((len(nodes), 3))
        core.node_forces(m, q, f)
        u = relative_velocity(nodes, assembly.com, world_rows(assembly, q[None]).reshape(-1, 6))
        normal = m.k * np.maximum(0, -u[:, 0] - m.apart)
        trial = -ratio * m.k[:, None] * u[:, 1:]
        share = np.minimum(1, nodes.mu * normal / np.linalg.norm(trial, axis=1))
        np.testing.assert_allclose(f, np.column_stack([normal, share[:, None] * trial]), rtol=1e-5, atol=1e-9)
        seen |= set(np.where(normal == 0, "open", np.where(share == 1, "stuck", "slides")))
    assert seen == {"open", "stuck", "slides"}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_the_unbalance_is_that_of_the_equilibrium_operator(name: str, ratio: float) -> None:
    """Of nodes that are open, stuck, sliding, or all but sliding."""
    assembly, nodes, flat = model(name, ratio)
    for seed in range(1, 7):
        m = rough(flat, seed) if seed % 2 else flat
        q = np.random.default_rng(seed).normal(size=len(m.wrench))
        f = np.zeros((len(nodes), 3))
        core.node_forces(m, q, f)
        along_the_world = assembly.levers * (equilibrium_operator(assembly, nodes) @ f.ravel())
        expected = (along_the_world.reshape(-1, 3) @ assembly.axes.T).ravel() + m.wrench
        # the model is rounded to nine digits
        np.testing.assert_allclose(unbalance(m, q), expected, rtol=1e-7, atol=1e-8)


def bordered(m, K: np.ndarray, w: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The dense matrix of the system, sheet by sheet, by its definition."""
    n = len(w)
    A = np.zeros((n + 1, n + 1))
    from_a, from_b = twist_matrices(m)
    for p in range(len(m.a)):
        T = np.zeros((6, n))
        if m.b[p] >= 0:
            T[:, 6 * m.b[p] : 6 * m.b[p] + 6] += from_b[p]
        if m.a[p] >= 0:
            T[:, 6 * m.a[p] : 6 * m.a[p] + 6] -= from_a[p]
        A[:n, :n] += T.T @ K[p] @ T
    A[:n, n], A[n, :n] = -w, c
    return A


@pytest.mark.parametrize("name", SCENES)
def test_units_bring_the_bonded_stiffness_of_every_displacement_to_one(name: str) -> None:
    """Of contacts whose turns and shifts are coupled, as those of nodes about any other point than their middle are."""
    _, _, m = model(name)
    n, some = len(m.wrench), np.random.default_rng(3).normal(size=m.bonded.shape)
    m = m._replace(bonded=some @ some.transpose(0, 2, 1), unit=np.empty(n), hold=np.zeros(n))
    core.set_units(m, m.unit)
    stiff = np.diag(bordered(m, m.bonded, np.zeros(n), np.zeros(n)))[:n]
    np.testing.assert_allclose(m.unit**2 * stiff, 1.0)
    m = m._replace(bonded=np.zeros_like(m.bonded), hold=np.array([0.0, 4.0] * (n // 2)))
    core.set_units(m, m.unit)
    assert m.unit.tolist() == [1.0, 0.5] * (n // 2)


@pytest.mark.parametrize("name", SCENES)
def test_the_entries_of_the_stiffness_are_those_of_the_matrix_by_its_definition(name: str) -> None:
    """Rows are not mistaken for columns: sliding makes a stiffness unsymmetric, and only its motions are asked for."""
    _, _, m = model(name)
    n, some = len(m.wrench), np.random.default_rng(4)
    m, K = m._replace(unit=some.uniform(0.5, 2, n)), some.normal(size=m.bonded.shape)
    (rows, columns), values = np.empty((2, 144 * len(m.a)), dtype=np.int64), np.empty(144 * len(m.a))
    count = core.write_entries(m, K, rows, columns, values)
    A = np.zeros((n, n))
    np.add.at(A, (rows[:count], columns[:count]), values[:count])
    expected = bordered(m, K, np.zeros(n), np.zeros(n))[:n, :n] * np.outer(m.unit, m.unit)
    np.testing.assert_allclose(A, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_the_jacobian_is_the_derivative(name: str, ratio: float) -> None:
    _, _, m = model(name, ratio)
    n = len(m.wrench)
    q = np.random.default_rng(2).normal(size=n)
    K = np.zeros_like(m.bonded)
    unbalance(m, q, K)
    A = bordered(m, K, np.zeros(n), np.zeros(n))[:n, :n]
    h = 1e-7
    change = np.array([unbalance(m, q + h * e) - unbalance(m, q - h * e) for e in np.eye(n)]).T / (2 * h)
    np.testing.assert_allclose(-change, A, atol=1e-6)
    assert np.abs(A - A.T).max() > 1e-3  # sliding makes it unsymmetric


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("corner", [0.0, 0.7])
def test_dense_and_sparse_solutions_and_the_sign_of_the_determinant(name: str, corner: float) -> None:
    _, _, m = model(name)
    n = len(m.wrench)
    rng = np.random.default_rng(3)
    for _ in range(4):
        fronts = fronts_of(m)
        works = [core.Work(m, None), core.Work(m, fronts)]
        q, w, c, rhs = rng.normal(size=n), rng.normal(size=n), rng.normal(size=n), rng.normal(size=(n + 1, 2))
        for work in works:
            unbalance(m, q, work.K)
            work.w[:], work.c[:], work.rhs[:] = w, c, rhs
        A = bordered(m, works[0].K + 0.1 * m.bonded, w, c)
        A[n, n] = corner
        signs = [core.solve(m, works[0], 0.1, corner, None), core.solve(m, works[1], 0.1, corner, fronts)]
        for work, sign in zip(works, signs, strict=True):
            np.testing.assert_allclose(A @ work.rhs, rhs, atol=1e-7)
            assert sign == np.linalg.slogdet(A)[0]


@pytest.mark.parametrize("seed", range(8))
def test_a_body_on_one_point_has_no_unique_direction(seed: int) -> None:
    """It may tip and turn about it: what rounding leaves of its stiffness is no resistance, a faint hold is."""
    rng = np.random.default_rng(seed)
    turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    m = block(0.5)
    m = m._replace(axes=m.axes @ turned, arm_b=m.arm_b @ turned)
    arm = np.array([m.x[0], m.y[0]])
    B = np.column_stack([np.eye(3), [[0, arm[1], -arm[0]], [-arm[1], 0, 0], [arm[0], 0, 0]]])
    K, w, c, rhs = B.T @ B, rng.normal(size=6), rng.normal(size=6), rng.normal(size=(7, 2))
    for hold in (0.0, 1e-11):
        held = m._replace(hold=np.full(6, hold))
        for way in (None, fronts_of(held)):
            work = core.Work(held, way)
            work.K[:], work.w[:], work.c[:], work.rhs[:] = K, w, c, rhs
            sign = core.solve(held, work, 0.0, 0.0, way, 1e-14)
            assert (sign == 0) == (hold == 0.0)


@pytest.mark.parametrize(("size", "full"), [(31, 17), (19, 12), (8, 3), (14, 14)])
def test_what_is_left_of_a_front_is_its_schur_complement(size: int, full: int) -> None:
    F = np.random.default_rng(5).normal(size=(size, size + 2))
    F[np.arange(size), np.arange(size)] += 6.0  # so that no pivot waits
    A = F.copy()
    P, X = np.empty((full, size)), np.empty((full, size + 2 - full))
    done, sign = core.eliminate(F, P, np.arange(size), full, 0.0)
    assert done == full
    core.finish(F, P, X, full)
    core.apply_pivots(F, P, X)
    assert sign == np.linalg.slogdet(A[:full, :full])[0]
    left = A[full:, full:] - A[full:, :full] @ np.linalg.solve(A[:full, :full], A[:full, full:])
    np.testing.assert_allclose(F[full:, full:], left, atol=1e-12)


@pytest.mark.parametrize("name", [*SCENES, "rough"])
def test_runs_of_open_nodes_are_passed_over_and_no_others(name: str) -> None:
    _, _, m = model("table" if name == "rough" else name)
    rng = np.random.default_rng(7)
    m = rough(m, 7) if name == "rough" else m
    box = np.tile([-1e9, 1e9, -1e9, 1e9, -1e9], (len(m.runs.box), 1))
    every = m._replace(runs=m.runs._replace(box=box))
    assert m.runs.node[-1] == len(m.k)
    passed = 0
    for _ in range(20):
        q = rng.normal(size=len(m.wrench))
        K, other = np.zeros_like(m.bonded), np.zeros_like(m.bonded)
        np.testing.assert_array_equal(unbalance(m, q, K), unbalance(every, q, other))
        np.testing.assert_array_equal(K, other)
        v = np.zeros(6)
        for p in range(len(m.a)):
            core.sheet_twist(m, p, q, v)
            passed += sum(core.nearest(m.runs, k, v, 1.0) <= 0 for k in range(m.runs.first[p], m.runs.first[p + 1]))
    assert 0 < passed < 20 * len(m.runs.box)


@pytest.mark.parametrize("name", SCENES)
def test_the_law_is_homogeneous(name: str) -> None:
    _, _, m = model(name)
    q = np.random.default_rng(4).normal(size=len(m.wrench))
    for factor in (1e-3, 1e5):
        np.testing.assert_allclose(
            unbalance(m, factor * q) - m.wrench, factor * (unbalance(m, q) - m.wrench), rtol=1e-9
        )


@pytest.mark.parametrize("name", SCENES)
def test_nothing_changes_its_state_before_the_next_change(name: str) -> None:
    _, nodes, m = model(name)
    rng = np.random.default_rng(5)
    q, t = rng.normal(size=(2, len(m.wrench)))

    def states(at: np.ndarray) -> np.ndarray:
        f = np.zeros((len(nodes), 3))
        core.node_forces(m, at, f)
        sliding = np.linalg.norm(f[:, 1:], axis=1) > (1 - 1e-12) * nodes.mu * f[:, 0]
        return np.where(f[:, 0] <= 0, 0, np.where(sliding, 2, 1))

    h = core.next_change(m, q, t)
    assert np.isfinite(h)
    assert (states(q) == states(q + 0.999 * h * t)).all()
    assert (states(q) != states(q + (h + 1e-9) * t)).any()
