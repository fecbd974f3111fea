"""R_k of one contact (eq. 14-20) and of one interface (eq. 21)."""

import numpy as np
import pytest
from engine_scenes import X, Z, cube_scene
from graph_scenes import given, push

from holdfast import assemble
from holdfast.native import core

CASES = 3000


def excess(f: np.ndarray, e: np.ndarray, mu: float, s: float) -> float:
    """How far f + s e is inside the cone; components (n, t1, t2)."""
    g = f + s * e
    return float(mu * g[0] - np.hypot(g[1], g[2]))


def largest_push(f: np.ndarray, e: np.ndarray, mu: float) -> float:
    """By doubling and bisection: the cone is convex, so what lies inside it along the ray is one interval."""
    step = 1e-6
    while excess(f, e, mu, step) >= 0:
        step *= 2
        if step > 1e9:
            return np.inf
    low, high = 0.0, step
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(f, e, mu, middle) >= 0 else (low, middle)
    return low


def random_case(rng: np.random.Generator, share: float) -> tuple[np.ndarray, np.ndarray, float]:
    """A force with |f_t| = ``share`` of the limit, a unit push, mu."""
    mu, fn, angle = rng.uniform(0.05, 1.5), rng.uniform(0.01, 20), rng.uniform(0, 2 * np.pi)
    f = np.array([fn, share * mu * fn * np.cos(angle), share * mu * fn * np.sin(angle)])
    e = rng.normal(size=3)
    return f, e / np.linalg.norm(e), mu


def slip(f: np.ndarray, e: np.ndarray, mu: float) -> float:
    return core.node_slip(*f.tolist(), mu, *e.tolist())


def test_inside_the_cone_it_is_the_largest_push_that_keeps_within() -> None:
    rng = np.random.default_rng(14)
    infinite = 0
    for _ in range(CASES):
        f, e, mu = random_case(rng, rng.uniform(0, 0.999))
        expected = largest_push(f, e, mu)
        infinite += np.isinf(expected)
        assert slip(f, e, mu) == pytest.approx(expected, rel=1e-7, abs=1e-9), (f, e, mu)
    assert 0.05 * CASES < infinite < 0.95 * CASES


@pytest.mark.parametrize("share", [1.0, 1.0 + 1e-12])
def test_on_the_cone_and_a_hair_outside_the_answer_is_a_boundary_point(share: float) -> None:
    rng = np.random.default_rng(15)
    for _ in range(CASES):
        f, e, mu = random_case(rng, share)
        s = slip(f, e, mu)
        if np.isinf(s):
            assert mu * e[0] >= np.hypot(e[1], e[2]) - 1e-8
            continue
        assert s >= 0
        assert excess(f, e, mu, s) == pytest.approx(0, abs=1e-8)
        assert excess(f, e, mu, 1.001 * s + 1e-3) < 0


def test_without_force_only_pushes_inside_the_cone_are_resisted() -> None:
    rng = np.random.default_rng(16)
    for _ in range(CASES):
        _, e, mu = random_case(rng, 0)
        assert slip(np.zeros(3), e, mu) == (np.inf if mu * e[0] > np.hypot(e[1], e[2]) else 0)


@pytest.mark.parametrize(
    ("force", "mu", "way", "expected"),
    [
        ((10.0, 3.0), 0.5, (0.0, 1.0), 2),  # 6a, every push worsens: 5 = 3 + s
        ((10.0, 0.0), 0.5, (-0.8, 0.6), 5),  # 0.5 (10 - 0.8 s) = 0.6 s
        ((10.0, -3.0), 0.5, (0.0, 1.0), 8),  # 6b, first better, then worse: 5 = s - 3
        ((10.0, 0.0), 0.5, (0.6, 0.8), 10),  # 0.5 (10 + 0.6 s) = 0.8 s
        ((10.0, 3.0), 0.5, (1.0, 0.0), np.inf),  # 6c, held for ever inside the cone
        ((10.0, 5.0), 0.5, (0.96, 0.28), np.inf),  # from its boundary
        ((10.0, 3.0), 0.5, (-1.0, 0.0), 4),  # 6d, inside the opposed cone it lifts off: 0.5 (10 - s) = 3
        ((10.0, 0.0), 1.0, (-0.8, 0.6), 50 / 7),  # 10 - 0.8 s = 0.6 s
    ],
)
def test_fig_6(force: tuple[float, float], mu: float, way: tuple[float, float], expected: float) -> None:
    assert core.node_slip(*force, 0.0, mu, *way, 0.0) == pytest.approx(expected)


@pytest.mark.parametrize("noise", [0.0, 1e-13, -1e-13, 1e-16])
def test_pushes_along_the_side_of_the_cone(noise: float) -> None:
    """D = 0: mu |e_n| = |e_t|, exactly and up to rounding."""
    tangential = 0.6 + noise
    assert core.node_slip(10.0, 0.0, 0.0, 0.75, 0.8, tangential, 0.0) == pytest.approx(np.inf)
    # 0.75 (10 - 0.8 s) = 0.6 s
    assert core.node_slip(10.0, 0.0, 0.0, 0.75, -0.8, tangential, 0.0) == pytest.approx(6.25)
    assert core.node_slip(10.0, 3.0, 0.0, 0.75, -0.8, tangential, 0.0) == pytest.approx(3.75)  # ... = 3 + 0.6 s


def test_the_absolute_values_printed_in_eq_19_would_be_wrong() -> None:
    mu, fn, en = 0.75, 10.0, -0.8
    printed = -((mu * fn) ** 2) / (2 * mu**2 * abs(en) * abs(fn))
    assert printed < 0  # by eq. 20 no push would ever slip
    assert core.node_slip(fn, 0.0, 0.0, mu, en, 0.6, 0.0) == pytest.approx(6.25)


@pytest.mark.parametrize("noise", [1e-9, 1e-12])
def test_solver_noise_does_not_make_an_outward_push_infinite(noise: float) -> None:
    for e in ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (-0.8, 0.6, 0.0), (0.1, 0.995, 0.0)):
        assert core.node_slip(10.0, 5.0 + noise, 0.0, 0.5, *e) == 0
    assert core.node_slip(-noise, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0) == 0
    assert core.node_slip(-noise, 0.0, 0.0, 0.5, -1.0, 0.0, 0.0) == 0


def test_without_friction() -> None:
    assert core.node_slip(10.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0) == pytest.approx(10)
    assert core.node_slip(10.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0) == np.inf
    for e in ((0.0, 1.0, 0.0), (0.8, 0.6, 0.0), (-0.8, 0.0, 0.6), (0.999, 0.0, 0.0447)):
        assert core.node_slip(10.0, 0.0, 0.0, 0.0, *e) == 0


@pytest.mark.parametrize("ends", [("floor", "cube"), ("cube", "floor")])
def test_slip_does_not_depend_on_the_order_of_the_pair(ends: tuple[str, str]) -> None:
    """Gravity leans by 1 m/s2 along x: 0.6 · 9.81 = 5.886 N of friction, 1 N in use."""
    assembly = assemble(cube_scene(gravity=(1, 0, -9.81)), interfaces=[given(*ends, Z if ends[1] == "cube" else -Z)])
    assert push(assembly, "cube", (-0.05, 0, 0.01), X) == pytest.approx(4.886)
    assert push(assembly, "cube", (0.05, 0, 0.01), -X) == pytest.approx(6.886)
    assert push(assembly, "cube", (0, 0, 0.1), Z) == pytest.approx(9.81 - 1 / 0.6)  # 0.6 (9.81 - s) = 1
    assert push(assembly, "cube", (0.02, 0, 0.1), -Z) == np.inf
